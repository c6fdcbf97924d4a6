//! A scene's numbers: `cadet.SceneConfig.to_native()`.

use cadet_core::actor::ObjectClass;
use cadet_core::label::{Boxes, LabelConfig as CoreLabelConfig, OcclusionMethod};
use cadet_core::scene::SceneConfig as CoreSceneConfig;
use cadet_core::world::TrafficConfig;
use pyo3::prelude::*;

use crate::assets::Assets;
use crate::error::{BorderError, CadetError};

/// A number's default, least and greatest value, and whether it counts.
type Limits = (f64, f64, f64, bool);

/// What gets a label.
#[pyclass(frozen, from_py_object, module = "cadet._cadet")]
#[derive(Clone)]
pub(crate) struct LabelConfig {
    config: CoreLabelConfig,
}

#[pymethods]
impl LabelConfig {
    #[new]
    #[pyo3(signature = (
        *, method, boxes, min_height_px, min_visible_fraction, max_depth_m, min_depth_m, max_truncation, min_contrast,
        min_points, dontcare_min_pixels, occlusion_levels, corner_tolerance_m, max_hidden_corners
    ))]
    fn new(
        method: &str,
        boxes: &str,
        min_height_px: f64,
        min_visible_fraction: f64,
        max_depth_m: f64,
        min_depth_m: f64,
        max_truncation: f64,
        min_contrast: f64,
        min_points: usize,
        dontcare_min_pixels: f64,
        occlusion_levels: [f64; 2],
        corner_tolerance_m: f64,
        max_hidden_corners: usize,
    ) -> PyResult<Self> {
        let method = match method {
            "pixels" => OcclusionMethod::Pixels,
            "corners" => OcclusionMethod::Corners,
            _ => return Err(CadetError::new_err(format!("label.method: expected pixels or corners, got {method:?}"))),
        };
        let config = CoreLabelConfig {
            method,
            boxes: Boxes::from_name(boxes).map_err(BorderError::from)?,
            min_height_px,
            min_visible_fraction,
            max_depth_m,
            min_depth_m,
            max_truncation,
            min_contrast,
            min_points,
            dontcare_min_pixels,
            occlusion_levels,
            corner_tolerance_m,
            max_hidden_corners,
        };
        Ok(Self { config: config.validated().map_err(BorderError::from)? })
    }

    /// Of every number by name: the only statement of them.
    #[staticmethod]
    fn settings() -> Vec<(&'static str, Limits)> {
        let of = |s: &cadet_core::label::Setting| (s.name, (s.default, s.least, s.most, s.is_whole));
        CoreLabelConfig::SETTINGS.iter().map(of).collect()
    }

    /// The default of `occlusion_levels`.
    #[staticmethod]
    fn default_occlusion_levels() -> (f64, f64) {
        CoreLabelConfig::OCCLUSION_LEVELS.into()
    }
}

/// How full a scene is, and what gets a label.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct SceneConfig {
    traffic: TrafficConfig,
    label: CoreLabelConfig,
}

#[pymethods]
impl SceneConfig {
    #[new]
    #[pyo3(signature = (*, num_cars, num_pedestrians, parking_occupancy, vehicle_classes, label))]
    fn new(
        num_cars: usize,
        num_pedestrians: usize,
        parking_occupancy: f64,
        vehicle_classes: Vec<String>,
        label: LabelConfig,
    ) -> Result<Self, BorderError> {
        let classes = vehicle_classes.iter().map(|name| ObjectClass::from_name(name));
        let traffic = TrafficConfig {
            num_cars,
            num_pedestrians,
            parking_occupancy,
            vehicle_classes: classes.collect::<Result<_, _>>()?,
            ..TrafficConfig::default()
        };
        Ok(Self { traffic, label: label.config })
    }
}

impl SceneConfig {
    /// The core's, with the user's vehicles.
    pub(crate) fn with(&self, assets: Option<&Assets>) -> CoreSceneConfig {
        CoreSceneConfig {
            traffic: self.traffic.clone(),
            label: self.label.clone(),
            user_vehicles: assets.map_or_else(Default::default, |a| a.vehicles.clone()),
            ..CoreSceneConfig::default()
        }
    }
}
