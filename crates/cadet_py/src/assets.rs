//! A user's own vehicles: `cadet.Assets.to_native()`.

use cadet_core::actor::ObjectClass;
use cadet_core::assets::vehicle::{MaterialRules, Role, UserVehicles, VehicleAsset};
use cadet_core::math::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::BorderError;
use crate::fields::Fields;
use crate::guard;

/// Vehicles built from a user's meshes, shared by all scenes that have them.
#[pyclass(module = "cadet._cadet", frozen)]
pub(crate) struct Assets {
    pub(crate) vehicles: UserVehicles,
}

#[pymethods]
impl Assets {
    #[new]
    fn new(py: Python<'_>, share: f64, vehicles: Vec<Bound<'_, PyDict>>) -> PyResult<Self> {
        let assets = vehicles.iter().map(vehicle).collect::<PyResult<Vec<_>>>()?;
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

fn vehicle(dict: &Bound<'_, PyDict>) -> PyResult<VehicleAsset> {
    let mut fields = Fields::new("vehicle", dict)?;
    let rules = fields.take::<Vec<(String, Vec<String>)>>("materials")?.into_iter();
    let rules = rules.map(|(role, patterns)| Ok((Role::from_name(&role)?, patterns)));
    let asset = VehicleAsset {
        name: fields.take("name")?,
        class: ObjectClass::from_name(&fields.take::<String>("class")?).map_err(BorderError::from)?,
        file: fields.take("file")?,
        obj: fields.take("obj")?,
        libraries: fields.take("libraries")?,
        scale: fields.take("scale")?,
        yaw_rad: fields.take("yaw_rad")?,
        y_up: fields.take("y_up")?,
        size_lwh: fields.take::<Option<[f64; 3]>>("size_lwh")?.map(DVec3::from_array),
        rules: MaterialRules(rules.collect::<Result<_, cadet_core::Error>>().map_err(BorderError::from)?),
    };
    fields.finish()?;
    Ok(asset)
}
