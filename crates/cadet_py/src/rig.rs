//! Rigs: sensors with their names and places.

use cadet_core::camera::{CameraModel, Development, Distortion, Response};
use cadet_core::frames;
use cadet_core::math::{DPose3, DVec3};
use cadet_core::nalgebra::Matrix3x4;
use cadet_core::rig::{Mount, Mounted, Rig as CoreRig};
use cadet_core::{Error, Result};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays;
use crate::error::BorderError;
use crate::lidar::Lidar;

/// A rigid pose.
#[pyclass(frozen, from_py_object, module = "cadet._cadet")]
#[derive(Clone)]
pub(crate) struct Pose {
    pose: DPose3,
}

#[pymethods]
impl Pose {
    /// Rolled about x (left side up), then pitched about y (nose down), then turned about z.
    #[staticmethod]
    fn mounted(position_m: [f64; 3], roll_pitch_yaw_deg: [f64; 3]) -> Self {
        let [roll, pitch, yaw] = roll_pitch_yaw_deg.map(f64::to_radians);
        Self { pose: frames::mounted(DVec3::from_array(position_m), roll, pitch, yaw) }
    }

    /// The pose of a (3, 4) matrix: a rotation, made orthonormal to the last digit, and a place.
    #[staticmethod]
    fn rigid(matrix: PyReadonlyArray2<'_, f64>) -> std::result::Result<Self, BorderError> {
        let m = matrix_3x4("pose", &matrix)?;
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]));
        Ok(Self { pose: frames::rigid("pose", &rows)? })
    }

    fn inverse(&self) -> Self {
        Self { pose: self.pose.inverse() }
    }

    /// As a (4, 4) array.
    fn matrix<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        arrays::pose(py, &self.pose)
    }
}

fn mount(chain: &[Pose]) -> Mount {
    Mount::new(chain.iter().map(|p| p.pose).collect())
}

/// What a camera makes of light: a name, or points of a curve.
#[derive(FromPyObject)]
pub(crate) enum ResponseCurve {
    Named(String),
    Points(Vec<[f64; 2]>),
}

impl ResponseCurve {
    fn of_core(&self) -> Result<Response> {
        match self {
            Self::Points(points) => Response::through(points),
            Self::Named(name) if name == "linear" => Ok(Response::Linear),
            Self::Named(name) if name == "srgb" => Ok(Response::srgb()),
            Self::Named(name) => Err(Error::OutOfRange {
                what: "response",
                value: name.clone(),
                expected: "linear, srgb, or points".to_owned(),
            }),
        }
    }
}

/// A camera with its name and place.
#[pyclass(frozen, from_py_object, module = "cadet._cadet")]
#[derive(Clone)]
pub(crate) struct Camera {
    mounted: Mounted<CameraModel>,
}

#[pymethods]
impl Camera {
    /// `projection` is (3, 4), `distortion` k1, k2, p1, p2, k3, `rolling_shutter_s` the time from the first row to the last, and `mount` leads
    /// from the ego to the camera's frame. `response` is "linear", "srgb", or points (light, value).
    #[new]
    #[pyo3(signature = (name, *, width, height, is_fisheye, projection, distortion, rolling_shutter_s, motion_blur_s, exposure_ev, noise, white_balance, response, mount))]
    fn new(
        name: String,
        width: usize,
        height: usize,
        is_fisheye: bool,
        projection: PyReadonlyArray2<'_, f64>,
        distortion: [f64; 5],
        rolling_shutter_s: f64,
        motion_blur_s: f64,
        exposure_ev: f64,
        noise: f64,
        white_balance: [f64; 3],
        response: ResponseCurve,
        mount: Vec<Pose>,
    ) -> std::result::Result<Self, BorderError> {
        let projection = matrix_3x4("projection", &projection)?;
        let sensor = if is_fisheye {
            CameraModel::fisheye_of(width, height, projection)?
        } else {
            CameraModel::new(width, height, projection, Distortion::from_opencv(distortion))?
        };
        let sensor = sensor
            .with_rolling_shutter(rolling_shutter_s)?
            .with_motion_blur(motion_blur_s)?
            .with_development(Development::new(exposure_ev, noise, white_balance, response.of_core()?)?);
        Ok(Self { mounted: Mounted { name, sensor, mount: self::mount(&mount) } })
    }
}

/// Cameras and LIDARs on a car.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct Rig {
    pub(crate) rig: CoreRig,
}

#[pymethods]
impl Rig {
    /// `lidars` have a name, a sensor and the poses that lead from the ego to it.
    #[new]
    #[pyo3(signature = (name, *, cameras, lidars))]
    fn new(
        name: String,
        cameras: Vec<Camera>,
        lidars: Vec<(String, PyRef<'_, Lidar>, Vec<Pose>)>,
    ) -> std::result::Result<Self, BorderError> {
        let cameras = cameras.into_iter().map(|c| c.mounted).collect();
        let lidar = |(name, lidar, chain): (String, PyRef<'_, Lidar>, Vec<Pose>)| Mounted {
            name,
            sensor: lidar.spec.clone(),
            mount: mount(&chain),
        };
        Ok(Self { rig: CoreRig::new(name, cameras, lidars.into_iter().map(lidar).collect())? })
    }
}

fn matrix_3x4(what: &'static str, array: &PyReadonlyArray2<'_, f64>) -> Result<Matrix3x4<f64>> {
    let view = array.as_array();
    if view.dim() != (3, 4) {
        return Err(Error::Shape { what, got: format!("{:?}", view.dim()), expected: "(3, 4)".to_owned() });
    }
    Ok(Matrix3x4::from_fn(|i, j| view[[i, j]]))
}
