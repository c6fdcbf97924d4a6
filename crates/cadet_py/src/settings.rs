//! A scene's numbers: `cadet.SceneConfig.to_native()`.

use cadet_core::actor::ObjectClass;
use cadet_core::label::{Boxes, LabelConfig, OcclusionMethod};
use cadet_core::scene::SceneConfig;
use cadet_core::world::TrafficConfig;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::assets::Assets;
use crate::error::{BorderError, CadetError};
use crate::fields::Fields;

/// The configuration of a flat dictionary with a nested `label`, and the user's vehicles.
pub(crate) fn from_dict(dict: &Bound<'_, PyDict>, assets: Option<&Assets>) -> PyResult<SceneConfig> {
    let mut fields = Fields::new("config", dict)?;
    let traffic = TrafficConfig {
        num_cars: fields.take("num_cars")?,
        num_pedestrians: fields.take("num_pedestrians")?,
        parking_occupancy: fields.take("parking_occupancy")?,
        vehicle_classes: vehicle_classes(&fields.take::<Vec<String>>("vehicle_classes")?)?,
        ..TrafficConfig::default()
    };
    let label = label_config(&fields.take::<Bound<'_, PyDict>>("label")?)?;
    fields.finish()?;
    let user_vehicles = assets.map_or_else(Default::default, |a| a.vehicles.clone());
    Ok(SceneConfig { traffic, label, user_vehicles, ..SceneConfig::default() })
}

fn vehicle_classes(names: &[String]) -> PyResult<Vec<ObjectClass>> {
    Ok(names.iter().map(|name| ObjectClass::from_name(name)).collect::<Result<_, _>>().map_err(BorderError::from)?)
}

fn label_config(dict: &Bound<'_, PyDict>) -> PyResult<LabelConfig> {
    let mut fields = Fields::new("label", dict)?;
    let method = match fields.take::<String>("method")?.as_str() {
        "pixels" => OcclusionMethod::Pixels,
        "corners" => OcclusionMethod::Corners,
        other => return Err(CadetError::new_err(format!("label.method: expected pixels or corners, got {other:?}"))),
    };
    let boxes = Boxes::from_name(&fields.take::<String>("boxes")?).map_err(BorderError::from)?;
    let config = LabelConfig {
        method,
        boxes,
        min_height_px: fields.take("min_height_px")?,
        min_visible_fraction: fields.take("min_visible_fraction")?,
        max_depth_m: fields.take("max_depth_m")?,
        min_depth_m: fields.take("min_depth_m")?,
        max_truncation: fields.take("max_truncation")?,
        min_contrast: fields.take("min_contrast")?,
        min_points: fields.take("min_points")?,
        dontcare_min_pixels: fields.take("dontcare_min_pixels")?,
        occlusion_levels: fields.take("occlusion_levels")?,
        corner_tolerance_m: fields.take("corner_tolerance_m")?,
        max_hidden_corners: fields.take("max_hidden_corners")?,
    };
    fields.finish()?;
    Ok(config.validated().map_err(BorderError::from)?)
}
