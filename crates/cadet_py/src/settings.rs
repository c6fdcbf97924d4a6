//! A scene's numbers: `cadet.SceneConfig.to_native()`; and the limits of what calls and sensors take.

use std::collections::BTreeMap;

use cadet_core::actor::ObjectClass;
use cadet_core::assets::imported::UserModels;
use cadet_core::assets::props::OwnProps;
use cadet_core::camera::{
    CURVE_POINTS, MAX_MOTION_BLUR_S, MAX_ROLLING_SHUTTER_S, MOST_EXPOSURE_EV, MOST_NOISE, SIDES_PX,
    WHITE_BALANCE_FACTORS,
};
use cadet_core::label::{Boxes, LabelConfig as CoreLabelConfig, OcclusionMethod};
use cadet_core::lidar::{MAX_COLUMNS, MAX_DIVERGENCE_RAD, MAX_FIRINGS};
use cadet_core::scene::{MAX_STEP_S, SceneConfig as CoreSceneConfig};
use cadet_core::settings::Setting;
use cadet_core::town::{PropConfig as CorePropConfig, SuburbConfig as CoreSuburbConfig};
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

/// Least and greatest value of the numbers that calls and sensors take; those of configurations are their `settings()`.
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
        limits_of(CoreLabelConfig::settings())
    }
}

/// What kind of suburb is generated.
#[pyclass(frozen, from_py_object, module = "cadet._cadet")]
#[derive(Clone)]
pub(crate) struct SuburbConfig {
    config: CoreSuburbConfig,
}

#[pymethods]
impl SuburbConfig {
    #[new]
    #[pyo3(signature = (
        *, blocks, block_m, parking_share, angled_share, main_share, cycle_lane_share, sidewalk_m, signal_share,
        roundabout_share, tram_share, country_share, aisle_share, industrial_share, campus_share, motorway_share,
        hilly_share, max_slope,
    ))]
    fn new(
        blocks: (usize, usize),
        block_m: (f64, f64),
        parking_share: f64,
        angled_share: f64,
        main_share: f64,
        cycle_lane_share: f64,
        sidewalk_m: (f64, f64),
        signal_share: f64,
        roundabout_share: f64,
        tram_share: f64,
        country_share: f64,
        aisle_share: f64,
        industrial_share: f64,
        campus_share: f64,
        motorway_share: f64,
        hilly_share: f64,
        max_slope: f64,
    ) -> Result<Self, BorderError> {
        let config = CoreSuburbConfig {
            blocks,
            block_m,
            parking_share,
            angled_share,
            main_share,
            cycle_lane_share,
            sidewalk_m,
            signal_share,
            roundabout_share,
            tram_share,
            country_share,
            aisle_share,
            industrial_share,
            campus_share,
            motorway_share,
            hilly_share,
            max_slope,
        };
        config.check()?;
        Ok(Self { config })
    }

    /// Of every number by name.
    #[staticmethod]
    fn settings() -> Vec<(&'static str, Limits)> {
        limits_of(CoreSuburbConfig::settings())
    }
}

/// Houses, gardens, and trees along the streets.
#[pyclass(frozen, from_py_object, module = "cadet._cadet")]
#[derive(Clone)]
pub(crate) struct PropConfig {
    config: CorePropConfig,
}

#[pymethods]
impl PropConfig {
    #[new]
    #[pyo3(signature = (
        *, house_shares, greenery, belt_m, clutter, city_share, car_park_share, industrial_share, campus_share,
    ))]
    fn new(
        house_shares: [f64; 6],
        greenery: f64,
        belt_m: f64,
        clutter: f64,
        city_share: f64,
        car_park_share: f64,
        industrial_share: f64,
        campus_share: f64,
    ) -> Result<Self, BorderError> {
        let config = CorePropConfig {
            own: OwnProps::default(),
            house_shares,
            greenery,
            belt_m,
            clutter,
            city_share,
            car_park_share,
            industrial_share,
            campus_share,
        };
        config.check()?;
        Ok(Self { config })
    }

    /// Of every number by name.
    #[staticmethod]
    fn settings() -> Vec<(&'static str, Limits)> {
        limits_of(CorePropConfig::settings())
    }
}

/// How full a scene is, what stands in it, where its sun is, and what gets a label.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct SceneConfig {
    /// All but the user's vehicles and props.
    config: CoreSceneConfig,
}

#[pymethods]
impl SceneConfig {
    #[new]
    #[pyo3(signature = (
        *, num_cars, num_pedestrians, num_cyclists, num_trams, parking_occupancy, car_radius_m, pedestrian_radius_m,
        cyclist_radius_m, parking_radius_m, seat_occupancy,
        vehicle_shares, suburb, props, sun_elevation_deg, sun_azimuth_deg, label
    ))]
    fn new(
        num_cars: usize,
        num_pedestrians: usize,
        num_cyclists: usize,
        num_trams: usize,
        parking_occupancy: f64,
        car_radius_m: f64,
        pedestrian_radius_m: f64,
        cyclist_radius_m: f64,
        parking_radius_m: f64,
        seat_occupancy: f64,
        vehicle_shares: Vec<(String, f64)>,
        suburb: SuburbConfig,
        props: PropConfig,
        sun_elevation_deg: Option<f64>,
        sun_azimuth_deg: Option<f64>,
        label: LabelConfig,
    ) -> Result<Self, BorderError> {
        let shares = vehicle_shares.iter().map(|(name, weight)| Ok((ObjectClass::from_name(name)?, *weight)));
        let traffic = TrafficConfig {
            vehicle_shares: shares.collect::<cadet_core::Result<_>>()?,
            num_cars,
            num_pedestrians,
            num_cyclists,
            num_trams,
            parking_occupancy,
            car_radius_m,
            pedestrian_radius_m,
            cyclist_radius_m,
            parking_radius_m,
            seat_occupancy,
        };
        traffic.check()?;
        let sun = Sun { elevation_deg: sun_elevation_deg, azimuth_deg: sun_azimuth_deg };
        sun.check()?;
        let config = CoreSceneConfig {
            suburb: suburb.config,
            props: props.config,
            traffic,
            label: label.config,
            user_models: UserModels::default(),
            sun,
        };
        Ok(Self { config })
    }

    /// Of every number by name.
    #[staticmethod]
    fn settings() -> Vec<(&'static str, Limits)> {
        limits_of([TrafficConfig::settings(), Sun::settings()].concat())
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
