//! Weather: its presets, and weather on recorded scans.

use cadet_core::lidar::{Fate, Receiver, weather_recorded};
use cadet_core::weather::Weather;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays;
use crate::error::BorderError;
use crate::guard;

type Weathered<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<i8>>);

/// The presets' names.
#[pyfunction]
pub(crate) fn weather_names() -> Vec<&'static str> {
    Weather::NAMES.to_vec()
}

/// Fog, rain, snow and wetness of a preset.
#[pyfunction]
pub(crate) fn weather_air(name: &str) -> Result<(f64, f64, f64, f64), BorderError> {
    let weather = Weather::preset(name)?;
    Ok((weather.fog_alpha_per_m, weather.rain_mm_per_h, weather.snow_mm_per_h, weather.wetness))
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
    let weather = Weather::of_air(fog, rain, snow, wetness)?;
    let points = arrays::to_rows("points_velo", &points_velo)?;
    let left =
        guard::detached(py, || weather_recorded(&points, &weather, &Receiver::default(), sensor_height_m, seed))?;
    let fate = left.fate.iter().map(|f: &Fate| *f as i8).collect();
    Ok((arrays::rows(py, left.points_velo), PyArray1::from_vec(py, fate)))
}
