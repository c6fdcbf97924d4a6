//! The estimated ground plane of a scan.

use cadet_core::Result;
use cadet_core::ground_plane;
use numpy::ndarray::ArrayView2;
use pyo3::prelude::*;

use crate::bev::Points;
use crate::guard;

/// The road's plane (a, b, c, d) in the frame that `cam_from_velo` (rows of 4) leads to.
#[pyfunction]
pub(crate) fn estimate_ground_plane(
    py: Python<'_>,
    points_velo: Points<'_>,
    cam_from_velo: [[f64; 4]; 3],
    seed: u64,
) -> PyResult<[f64; 4]> {
    let plane = match &points_velo {
        Points::Single(points) => {
            let points = points.as_array();
            guard::detached(py, || estimate(&points, |v| f64::from(*v), &cam_from_velo, seed))
        }
        Points::Double(points) => {
            let points = points.as_array();
            guard::detached(py, || estimate(&points, |v| *v, &cam_from_velo, seed))
        }
    };
    Ok(plane?)
}

fn estimate<T>(
    points_velo: &ArrayView2<'_, T>,
    number: impl Fn(&T) -> f64,
    cam_from_velo: &[[f64; 4]; 3],
    seed: u64,
) -> Result<[f64; 4]> {
    let points_cam = points_velo.rows().into_iter().map(|p| {
        let [x, y, z] = [number(&p[0]), number(&p[1]), number(&p[2])];
        cam_from_velo.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3])
    });
    ground_plane::estimate_ground_plane(points_cam, seed)
}
