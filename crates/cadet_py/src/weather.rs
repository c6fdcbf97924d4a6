//! Weather: its presets, and weather on recorded scans.

use cadet_core::lidar::{Fate, Receiver, weather_recorded};
use cadet_core::weather::{Weather as CoreWeather, fog_alpha_per_m};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays;
use crate::error::BorderError;
use crate::guard;

/// Rain, fog's visibility, snow, wetness, clouds, and the sun's elevation.
type Numbers = (f64, Option<f64>, f64, f64, f64, f64);
type Weathered<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<i8>>);

/// The presets' names.
#[pyfunction]
pub(crate) fn weather_names() -> Vec<&'static str> {
    CoreWeather::NAMES.to_vec()
}

/// A weather in numbers.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct Weather {
    pub(crate) inner: CoreWeather,
}

#[pymethods]
impl Weather {
    /// Those numbers; the sun is a clear noon's, which scenes vary by their seed, where it is not given.
    #[new]
    #[pyo3(signature = (name, *, rain_mm_h, fog_visibility_m, snow_mm_h, wetness, cloud_cover, wind_mps, sun_elevation_deg, sun_azimuth_deg))]
    fn new(
        name: &str,
        rain_mm_h: f64,
        fog_visibility_m: Option<f64>,
        snow_mm_h: f64,
        wetness: f64,
        cloud_cover: f64,
        wind_mps: f64,
        sun_elevation_deg: Option<f64>,
        sun_azimuth_deg: Option<f64>,
    ) -> Result<Self, BorderError> {
        let noon = CoreWeather::preset("clear_noon")?;
        let inner = CoreWeather {
            name: name.to_owned(),
            sun_elevation_rad: sun_elevation_deg.map_or(noon.sun_elevation_rad, f64::to_radians),
            sun_azimuth_rad: sun_azimuth_deg.map_or(noon.sun_azimuth_rad, f64::to_radians),
            cloudiness: cloud_cover,
            wetness,
            rain_mm_per_h: rain_mm_h,
            snow_mm_per_h: snow_mm_h,
            fog_alpha_per_m: fog_visibility_m.map_or(0.0, fog_alpha_per_m),
            wind_mps,
        };
        inner.check()?;
        Ok(Self { inner })
    }
}

/// The numbers of a preset, as `Weather` takes them.
#[pyfunction]
pub(crate) fn weather_preset(name: &str) -> Result<Numbers, BorderError> {
    let weather = CoreWeather::preset(name)?;
    let alpha = weather.fog_alpha_per_m;
    let visibility_m = (alpha > 0.0).then(|| fog_alpha_per_m(alpha).round());
    let elevation_deg = (weather.sun_elevation_rad.to_degrees() * 1e9).round() / 1e9;
    let CoreWeather { rain_mm_per_h, snow_mm_per_h, wetness, cloudiness, .. } = weather;
    Ok((rain_mm_per_h, visibility_m, snow_mm_per_h, wetness, cloudiness, elevation_deg))
}

/// The points that weather leaves of a recorded scan, and the fate of each of its points.
#[pyfunction]
#[pyo3(signature = (points_velo, *, fog, rain, snow, wetness, sensor_height_m, seed))]
pub(crate) fn weather_recorded_scan<'py>(
    py: Python<'py>,
    points_velo: PyReadonlyArray2<'py, f32>,
    fog: f64,
    rain: f64,
    snow: f64,
    wetness: f64,
    sensor_height_m: f64,
    seed: u64,
) -> Result<Weathered<'py>, BorderError> {
    let weather = CoreWeather::of_air(fog, rain, snow, wetness)?;
    let points = arrays::to_rows("points_velo", &points_velo)?;
    let left =
        guard::detached(py, || weather_recorded(&points, &weather, &Receiver::default(), sensor_height_m, seed))?;
    let fate = left.fate.iter().map(|f: &Fate| *f as i8).collect();
    Ok((arrays::rows(py, left.points_velo), PyArray1::from_vec(py, fate)))
}
