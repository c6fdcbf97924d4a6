//! Shapes at several levels of detail.

use std::ops::Deref;
use std::sync::{Arc, LazyLock};

use super::bounds::Bounds;
use super::mesh::Mesh;
use crate::math::Vec3;

/// A mesh that is made when it is first used, and then kept; copies share it.
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
    /// (used up to this distance from the ego in meters by sensors as fine as KITTI's, mesh); beyond the last limit the
    /// shape is left out.
    pub levels: Vec<(f32, LazyMesh)>,
    /// Of the first so many levels the next one casts the shadow: it differs by about a shadow map's texel at most.
    pub coarse_shadow_proxies: usize,
}

impl LodSet {
    /// A shape with one level.
    #[must_use]
    pub fn single(mesh: Mesh) -> Self {
        let bounds = mesh.bounds;
        Self { bounds, levels: vec![(f32::INFINITY, LazyMesh::new(|| mesh))], coarse_shadow_proxies: 0 }
    }

    /// A shape of which the finest level is there, and the others are made when they are needed.
    #[must_use]
    pub fn new((limit, finest): (f32, Mesh), coarser: impl IntoIterator<Item = (f32, LazyMesh)>) -> Self {
        let bounds = finest.bounds;
        let finest = (limit, LazyMesh::new(|| finest));
        Self { bounds, levels: std::iter::once(finest).chain(coarser).collect(), coarse_shadow_proxies: 0 }
    }

    /// Returns this shape, longer, wider and higher by factors above 0; its meshes are made when they are first used.
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
    /// `reach_factor`: how much further than for KITTI's camera each level reaches. The last one reaches no less far with coarse
    /// sensors: it is all that is left of the shape.
    #[must_use]
    pub fn select(&self, distance_m: f32, reach_factor: f32) -> Option<&Arc<Mesh>> {
        self.select_with_shadow_proxy(distance_m, reach_factor).map(|(mesh, _)| &**mesh)
    }

    /// As [`LodSet::select`], and the mesh that casts the shadow.
    #[must_use]
    pub fn select_with_shadow_proxy(&self, distance_m: f32, reach_factor: f32) -> Option<(&LazyMesh, &LazyMesh)> {
        let last = self.levels.len().checked_sub(1)?;
        let reaches = |(level, (limit_m, _)): (usize, &(f32, LazyMesh))| {
            distance_m <= limit_m * if level == last { reach_factor.max(1.0) } else { reach_factor }
        };
        let level = self.levels.iter().enumerate().position(reaches)?;
        let proxy = if level < self.coarse_shadow_proxies { level + 1 } else { level };
        Some((&self.levels[level].1, &self.levels[proxy.min(last)].1))
    }
}
