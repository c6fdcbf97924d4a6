//! Shapes at several levels of detail.

use std::ops::Deref;
use std::sync::{Arc, LazyLock};

use super::mesh::{Bounds, Mesh};
use crate::math::Vec3;

/// A mesh that is made when somebody first looks at it, and then kept; copies share it.
#[derive(Debug, Clone)]
pub struct LazyMesh(Arc<LazyLock<Arc<Mesh>, MakeMesh>>);

type MakeMesh = Box<dyn FnOnce() -> Arc<Mesh> + Send>;

impl LazyMesh {
    /// A mesh that `make` will make.
    #[must_use]
    pub fn new(make: impl FnOnce() -> Mesh + Send + 'static) -> Self {
        Self(Arc::new(LazyLock::new(Box::new(move || Arc::new(make())))))
    }
}

impl Deref for LazyMesh {
    type Target = Arc<Mesh>;

    fn deref(&self) -> &Arc<Mesh> {
        &self.0
    }
}

impl PartialEq for LazyMesh {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

/// One shape at several levels of detail, the finest first.
#[derive(Debug, Clone)]
pub struct LodSet {
    /// Bounds of the finest level.
    pub bounds: Bounds,
    /// (used up to this distance from the ego in metres, mesh); beyond the last limit the shape is left out.
    pub levels: Vec<(f32, LazyMesh)>,
    /// Limits nearer than [`NEAR_M`] move with the scene's detail ([`LodSet::select`]).
    pub is_elastic: bool,
    /// Of the first so many levels the next one casts the shadow: it differs by about a shadow map's texel at most.
    pub coarse_casters: usize,
}

/// Within this distance from the ego triangles are counted, metres.
pub const NEAR_M: f32 = 80.0;

impl LodSet {
    /// A shape with one level.
    #[must_use]
    pub fn single(mesh: Mesh) -> Self {
        let bounds = mesh.bounds;
        Self { bounds, levels: vec![(f32::INFINITY, LazyMesh::new(|| mesh))], is_elastic: false, coarse_casters: 0 }
    }

    /// A shape of which the finest level is there, and the others are made when they are needed.
    #[must_use]
    pub fn new((limit, finest): (f32, Mesh), coarser: impl IntoIterator<Item = (f32, LazyMesh)>) -> Self {
        let bounds = finest.bounds;
        let finest = (limit, LazyMesh::new(|| finest));
        Self { bounds, levels: std::iter::once(finest).chain(coarser).collect(), is_elastic: false, coarse_casters: 0 }
    }

    /// The same shape, longer, wider and higher by factors above 0; its meshes are made when somebody looks at them.
    #[must_use]
    pub fn stretched(&self, scale: Vec3) -> Self {
        let bounds = Bounds { min: self.bounds.min * scale, max: self.bounds.max * scale };
        let level = |(limit, mesh): &(f32, LazyMesh)| {
            let mesh = mesh.clone();
            (*limit, LazyMesh::new(move || mesh.stretched(scale)))
        };
        Self { bounds, levels: self.levels.iter().map(level).collect(), ..*self }
    }

    /// The finest mesh.
    ///
    /// # Panics
    /// If there is no level at all, which is a bug in the asset.
    #[must_use]
    pub fn finest(&self) -> &Arc<Mesh> {
        &self.levels.first().expect("a shape has at least one level").1
    }

    /// The mesh for a distance from the ego; `None` where the shape is too far to matter.
    ///
    /// `detail`: how much further than elsewhere the near levels of what is elastic reach, 1 for their own limits.
    #[must_use]
    pub fn select(&self, distance_m: f32, detail: f32) -> Option<&Arc<Mesh>> {
        self.select_with_caster(distance_m, detail).map(|(mesh, _)| &**mesh)
    }

    /// As [`LodSet::select`], and the mesh that casts the shadow.
    #[must_use]
    pub fn select_with_caster(&self, distance_m: f32, detail: f32) -> Option<(&LazyMesh, &LazyMesh)> {
        let level = self.levels.iter().position(|(limit, _)| distance_m <= self.moved(*limit, detail))?;
        let caster = if level < self.coarse_casters { level + 1 } else { level };
        Some((&self.levels[level].1, &self.levels[caster.min(self.levels.len() - 1)].1))
    }

    fn moved(&self, limit_m: f32, detail: f32) -> f32 {
        if self.is_elastic && limit_m < NEAR_M { (limit_m * detail).min(NEAR_M) } else { limit_m }
    }

    /// The details at which the choice for a distance changes to a finer mesh, from the least on, and these meshes.
    pub fn steps(&self, distance_m: f32) -> impl Iterator<Item = (f32, &LazyMesh)> {
        let moving = self.levels.iter().rev().filter(|(limit, _)| self.is_elastic && *limit < NEAR_M);
        moving.filter(move |_| distance_m <= NEAR_M).map(move |(limit, mesh)| (distance_m / limit, mesh))
    }
}
