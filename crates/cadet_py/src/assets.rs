//! A user's own meshes and props: `cadet.Assets.to_native()`.

use cadet_core::actor::ObjectClass;
use cadet_core::assets::imported::{MaterialRules, MeshAsset, Role, UserModels};
use cadet_core::assets::props::OwnProps;
use cadet_core::assets::source_mesh::{MAX_MATERIALS, MAX_TRIANGLES, SourceMaterial, SourceMesh, SourceTriangle};
use cadet_core::math::{DVec3, Vec3};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::BorderError;
use crate::guard;

/// An actor's mesh, not yet built.
#[pyclass(frozen, from_py_object, module = "cadet._cadet")]
#[derive(Clone)]
pub(crate) struct ActorMesh {
    asset: MeshAsset,
}

#[pymethods]
impl ActorMesh {
    #[classattr]
    const MAX_TRIANGLES: usize = MAX_TRIANGLES;
    #[classattr]
    const MAX_MATERIALS: usize = MAX_MATERIALS;

    #[new]
    #[pyo3(signature = (*, name, class_name, file, corners, material_ids, part_ids, source_materials, parts, scale, yaw_rad, y_up, size_lwh, materials, leave_out))]
    fn new(
        name: String,
        class_name: &str,
        file: String,
        corners: PyReadonlyArray2<'_, f32>,
        material_ids: PyReadonlyArray1<'_, u32>,
        part_ids: PyReadonlyArray1<'_, u32>,
        source_materials: Vec<(String, Option<[f32; 3]>, f32)>,
        parts: Vec<Vec<String>>,
        scale: f64,
        yaw_rad: f64,
        y_up: bool,
        size_lwh: Option<[f64; 3]>,
        materials: Vec<(String, Vec<String>)>,
        leave_out: Option<Vec<String>>,
    ) -> Result<Self, BorderError> {
        let rows = corners.as_array();
        let rows = rows.rows().into_iter().zip(material_ids.as_array()).zip(part_ids.as_array());
        let triangles = rows.map(|((row, material), part)| {
            let at = |i: usize| row.get(i).copied().unwrap_or(f32::NAN);
            let corners = [0, 3, 6].map(|i| Vec3::new(at(i), at(i + 1), at(i + 2)));
            SourceTriangle { corners, material: *material, part: *part }
        });
        let stated = source_materials.into_iter();
        let source = SourceMesh {
            triangles: triangles.collect(),
            materials: stated.map(|(name, albedo, opacity)| SourceMaterial { name, albedo, opacity }).collect(),
            parts,
        };
        let rules = materials.into_iter().map(|(role, patterns)| Ok((Role::from_name(&role)?, patterns)));
        let asset = MeshAsset {
            name,
            class: ObjectClass::from_name(class_name)?,
            file,
            source,
            scale,
            yaw_rad,
            y_up,
            size_lwh: size_lwh.map(DVec3::from_array),
            rules: MaterialRules(rules.collect::<cadet_core::Result<_>>()?),
            leave_out,
        };
        Ok(Self { asset })
    }
}

/// Actors built from a user's meshes, and a user's props, shared by all scenes that have them.
#[pyclass(module = "cadet._cadet", frozen)]
pub(crate) struct Assets {
    pub(crate) actors: UserModels,
    pub(crate) props: OwnProps,
}

#[pymethods]
impl Assets {
    #[new]
    fn new(
        py: Python<'_>,
        share: f64,
        actors: Vec<ActorMesh>,
        props: Vec<(String, String)>,
    ) -> Result<Self, BorderError> {
        let assets: Vec<MeshAsset> = actors.into_iter().map(|actor| actor.asset).collect();
        guard::detached(py, || {
            let actors = if assets.is_empty() { UserModels::default() } else { UserModels::new(share, &assets)? };
            Ok::<_, BorderError>(Self { actors, props: OwnProps::parse(&props)? })
        })
    }

    /// Name, class and size of each model.
    fn models(&self) -> Vec<(String, &'static str, [f64; 3])> {
        let models = self.actors.models();
        models.map(|m| (m.name().to_owned(), m.class().kitti_name(), m.size_lwh().to_array())).collect()
    }

    /// What was assumed of meshes that say too little of their materials, a line each.
    fn assumptions(&self) -> Vec<String> {
        self.actors.assumptions().to_vec()
    }
}

/// Refuses a user's files of props that can't be used.
#[pyfunction]
pub(crate) fn check_props(py: Python<'_>, files: Vec<(String, String)>) -> Result<(), BorderError> {
    guard::detached(py, || OwnProps::parse(&files).map(|_| ()))
}
