//! A user's own vehicles: `cadet.Assets.to_native()`.

use cadet_core::actor::ObjectClass;
use cadet_core::assets::import::MeshSource;
use cadet_core::assets::vehicle::{MaterialRules, Role, UserVehicles, VehicleAsset};
use cadet_core::math::DVec3;
use pyo3::prelude::*;

use crate::error::BorderError;
use crate::guard;

/// A vehicle's mesh, not yet built.
#[pyclass(frozen, from_py_object, module = "cadet._cadet")]
#[derive(Clone)]
pub(crate) struct VehicleMesh {
    asset: VehicleAsset,
}

#[pymethods]
impl VehicleMesh {
    #[new]
    #[pyo3(signature = (*, name, class_name, file, obj, libraries, gltf, buffers, image_colors, scale, yaw_rad, y_up, size_lwh, materials))]
    fn new(
        name: String,
        class_name: &str,
        file: String,
        obj: String,
        libraries: Vec<(String, String)>,
        gltf: Option<Vec<u8>>,
        buffers: Vec<Vec<u8>>,
        image_colors: Vec<Option<[f32; 3]>>,
        scale: f64,
        yaw_rad: f64,
        y_up: bool,
        size_lwh: Option<[f64; 3]>,
        materials: Vec<(String, Vec<String>)>,
    ) -> Result<Self, BorderError> {
        let rules = materials.into_iter().map(|(role, patterns)| Ok((Role::from_name(&role)?, patterns)));
        let asset = VehicleAsset {
            name,
            class: ObjectClass::from_name(class_name)?,
            file,
            source: match gltf {
                Some(document) => MeshSource::Gltf { document, buffers, image_colors },
                None => MeshSource::Obj { text: obj, libraries },
            },
            scale,
            yaw_rad,
            y_up,
            size_lwh: size_lwh.map(DVec3::from_array),
            rules: MaterialRules(rules.collect::<cadet_core::Result<_>>()?),
        };
        Ok(Self { asset })
    }
}

/// Vehicles built from a user's meshes, shared by all scenes that have them.
#[pyclass(module = "cadet._cadet", frozen)]
pub(crate) struct Assets {
    pub(crate) vehicles: UserVehicles,
}

#[pymethods]
impl Assets {
    #[new]
    fn new(py: Python<'_>, share: f64, vehicles: Vec<VehicleMesh>) -> PyResult<Self> {
        let assets: Vec<VehicleAsset> = vehicles.into_iter().map(|vehicle| vehicle.asset).collect();
        let vehicles = guard::detached(py, || UserVehicles::new(share, &assets))?;
        Ok(Self { vehicles })
    }

    /// Name, class and size of each model.
    fn models(&self) -> Vec<(String, &'static str, [f64; 3])> {
        let models = self.vehicles.models().iter();
        models.map(|m| (m.name.clone(), m.class.kitti_name(), m.size_lwh.to_array())).collect()
    }

    /// What was assumed of meshes that say too little of their materials, a line each.
    fn assumptions(&self) -> Vec<String> {
        self.vehicles.assumptions().to_vec()
    }
}
