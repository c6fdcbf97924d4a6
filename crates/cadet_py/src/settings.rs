//! A scene's numbers, read from a `cadet.SceneConfig`; and the limits of what calls and sensors take.

use std::collections::BTreeMap;

use cadet_core::actor::ObjectClass;
use cadet_core::assets::imported::UserModels;
use cadet_core::camera::{
    CURVE_POINTS, MAX_MOTION_BLUR_S, MAX_ROLLING_SHUTTER_S, MOST_EXPOSURE_EV, MOST_NOISE, SIDES_PX,
    WHITE_BALANCE_FACTORS,
};
use cadet_core::label::{Boxes, LabelConfig, OcclusionMethod};
use cadet_core::lidar::{MAX_COLUMNS, MAX_DIVERGENCE_RAD, MAX_FIRINGS};
use cadet_core::scene::{MAX_STEP_S, SceneConfig as CoreSceneConfig};
use cadet_core::settings::Setting;
use cadet_core::town::{PropConfig, SuburbConfig};
use cadet_core::weather::Sun;
use cadet_core::world::{FASTEST_VEHICLE_MPS, MAX_LATERAL_M, TrafficConfig};
use pyo3::prelude::*;

use crate::assets::Assets;
use crate::error::{BorderError, CadetError};

/// A field's defaults (none where it is drawn), least and greatest value, and whether it counts.
type Limits = (Vec<f64>, f64, f64, bool);

fn limits_of(settings: Vec<Setting>) -> Vec<(&'static str, Limits)> {
    settings.into_iter().map(|s| (s.name, (s.default, s.least, s.most, s.is_whole))).collect()
}

/// Least and greatest value of the numbers that calls and sensors take; those of configurations are [`settings`].
#[pyfunction]
pub(crate) fn limits() -> BTreeMap<&'static str, (f64, f64)> {
    BTreeMap::from([
        ("columns", (1.0, MAX_COLUMNS as f64)),
        ("divergence_mrad", (0.0, MAX_DIVERGENCE_RAD * 1e3)),
        ("curve_points", (*CURVE_POINTS.start() as f64, *CURVE_POINTS.end() as f64)),
        ("exposure_ev", (-MOST_EXPOSURE_EV, MOST_EXPOSURE_EV)),
        ("firings", (1.0, MAX_FIRINGS as f64)),
        ("image_side_px", (*SIDES_PX.start() as f64, *SIDES_PX.end() as f64)),
        ("lateral_m", (-MAX_LATERAL_M, MAX_LATERAL_M)),
        ("motion_blur_s", (0.0, MAX_MOTION_BLUR_S)),
        ("noise", (0.0, MOST_NOISE)),
        ("rolling_shutter_s", (0.0, MAX_ROLLING_SHUTTER_S)),
        ("speed_mps", (0.0, FASTEST_VEHICLE_MPS)),
        ("step_s", (0.0, MAX_STEP_S)),
        ("white_balance", (*WHITE_BALANCE_FACTORS.start(), *WHITE_BALANCE_FACTORS.end())),
    ])
}

/// Limits of every number of the configurations, by the configuration and by name: the only statement of them.
#[pyfunction]
pub(crate) fn settings() -> BTreeMap<&'static str, Vec<(&'static str, Limits)>> {
    BTreeMap::from([
        ("LabelConfig", limits_of(LabelConfig::settings())),
        ("PropConfig", limits_of(PropConfig::settings())),
        ("SceneConfig", limits_of([TrafficConfig::settings(), Sun::settings()].concat())),
        ("SuburbConfig", limits_of(SuburbConfig::settings())),
    ])
}

/// Reads the numbers of a configuration by their names: one, or several in a sequence.
fn numbers_of(config: &Bound<'_, PyAny>) -> impl FnMut(&'static str) -> Result<Vec<f64>, BorderError> {
    |name| {
        let value = config.getattr(name)?;
        Ok(value.extract::<f64>().map(|number| vec![number]).or_else(|_| value.extract())?)
    }
}

fn label_of(config: &Bound<'_, PyAny>) -> Result<LabelConfig, BorderError> {
    let text = |name| config.getattr(name)?.extract::<String>();
    let method = match text("method")?.as_str() {
        "pixels" => OcclusionMethod::Pixels,
        "corners" => OcclusionMethod::Corners,
        other => {
            let reason = format!("label.method: expected pixels or corners, got {other:?}");
            return Err(CadetError::new_err(reason).into());
        }
    };
    let numbers = LabelConfig::from_numbers(numbers_of(config))?;
    Ok(LabelConfig { method, boxes: Boxes::from_name(&text("boxes")?)?, ..numbers }.validated()?)
}

/// How full a scene is, what stands in it, where its sun is, and what gets a label.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct SceneConfig {
    /// All but the user's vehicles and props.
    config: CoreSceneConfig,
}

#[pymethods]
impl SceneConfig {
    /// Reads a `cadet.SceneConfig`.
    #[new]
    fn new(config: &Bound<'_, PyAny>) -> Result<Self, BorderError> {
        let part = |name| config.getattr(name);
        let shares: Option<BTreeMap<String, f64>> = part("vehicle_shares")?.extract()?;
        let shares = shares.iter().flatten().map(|(name, weight)| Ok((ObjectClass::from_name(name)?, *weight)));
        let traffic = TrafficConfig {
            vehicle_shares: shares.collect::<cadet_core::Result<_>>()?,
            ..TrafficConfig::from_numbers(numbers_of(config))?
        };
        traffic.check()?;
        let suburb = SuburbConfig::from_numbers(numbers_of(&part("suburb")?))?;
        suburb.check()?;
        let props = PropConfig::from_numbers(numbers_of(&part("props")?))?;
        props.check()?;
        let angle = |name| part(name)?.extract();
        let sun = Sun { elevation_deg: angle("sun_elevation_deg")?, azimuth_deg: angle("sun_azimuth_deg")? };
        sun.check()?;
        let (label, user_models) = (label_of(&part("label")?)?, UserModels::default());
        Ok(Self { config: CoreSceneConfig { suburb, props, traffic, label, user_models, sun } })
    }

    /// The classes of vehicles that may drive and park.
    #[staticmethod]
    fn vehicle_classes() -> Vec<&'static str> {
        TrafficConfig::VEHICLE_CLASSES.iter().map(|class| class.kitti_name()).collect()
    }
}

impl SceneConfig {
    /// The core's, with the user's vehicles and props.
    pub(crate) fn with(&self, assets: Option<&Assets>) -> CoreSceneConfig {
        let mut config = self.config.clone();
        if let Some(assets) = assets {
            config.user_models = assets.actors.clone();
            config.props.own = assets.props.clone();
        }
        config
    }
}
