//! Rigs: `cadet.Rig.to_native()` and the calibration on its way back.

use cadet_core::camera::{Calibration, CameraModel};
use cadet_core::frames;
use cadet_core::math::DVec3;
use cadet_core::nalgebra::{Matrix3, Matrix3x4};
use cadet_core::rig::Rig;
use cadet_core::{Error, Result};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::error::BorderError;
use crate::fields::Fields;
use crate::lidar;

/// The rig of a `RigDict`.
pub(crate) fn from_dict(dict: &Bound<'_, PyDict>) -> PyResult<Rig> {
    let mut fields = Fields::new("rig", dict)?;
    let lidar = lidar::spec_from_any(&fields.take::<Bound<'_, PyAny>>("lidar")?)?;
    let lidar = if fields.take("single_origin")? { lidar.single_origin() } else { lidar };
    let (rolling, returns) = (fields.take("rolling")?, fields.take::<String>("returns")?);
    let lidar =
        lidar::scanning(lidar, rolling, &returns, fields.take("divergence_mrad")?).map_err(BorderError::from)?;
    let [x, y, z] = fields.take::<[f64; 3]>("velo_in_ego")?;
    let [roll, pitch, yaw] = fields.take::<[f64; 3]>("velo_roll_pitch_yaw_deg")?.map(f64::to_radians);
    let rig = Rig {
        name: fields.take("name")?,
        lidar,
        camera: camera(&fields.take::<Bound<'_, PyDict>>("camera")?)?,
        ego_from_velo: frames::mounted(DVec3::new(x, y, z), roll, pitch, yaw),
    };
    fields.finish()?;
    Ok(rig)
}

fn camera(dict: &Bound<'_, PyDict>) -> PyResult<CameraModel> {
    let mut fields = Fields::new("camera", dict)?;
    let (width, height) = (fields.take("width")?, fields.take("height")?);
    let mut matrix = |key: &'static str| -> PyResult<Matrix3x4<f64>> {
        let array: PyReadonlyArray2<'_, f64> = fields.take(key)?;
        Ok(matrix_3x4(key, &array).map_err(BorderError::from)?)
    };
    let projections = [matrix("P0")?, matrix("P1")?, matrix("P2")?, matrix("P3")?];
    let (tr_velo_to_cam, tr_imu_to_velo) = (matrix("Tr_velo_to_cam")?, matrix("Tr_imu_to_velo")?);
    let r0: PyReadonlyArray2<'_, f64> = fields.take("R0_rect")?;
    let r0_rect = matrix_3x3("R0_rect", &r0).map_err(BorderError::from)?;
    fields.finish()?;
    let calibration = Calibration { projections, r0_rect, tr_velo_to_cam, tr_imu_to_velo };
    Ok(CameraModel::new(width, height, calibration).map_err(BorderError::from)?)
}

fn matrix_3x4(what: &'static str, array: &PyReadonlyArray2<'_, f64>) -> Result<Matrix3x4<f64>> {
    let view = array.as_array();
    if view.dim() != (3, 4) {
        return Err(Error::Shape { what, got: format!("{:?}", view.dim()), expected: "(3, 4)".to_owned() });
    }
    Ok(Matrix3x4::from_fn(|i, j| view[[i, j]]))
}

fn matrix_3x3(what: &'static str, array: &PyReadonlyArray2<'_, f64>) -> Result<Matrix3<f64>> {
    let view = array.as_array();
    if view.dim() != (3, 3) {
        return Err(Error::Shape { what, got: format!("{:?}", view.dim()), expected: "(3, 3)".to_owned() });
    }
    Ok(Matrix3::from_fn(|i, j| view[[i, j]]))
}

/// The matrices by KITTI's keys.
pub(crate) fn calibration_to_dict<'py>(py: Python<'py>, calibration: &Calibration) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let rows = |m: &Matrix3x4<f64>| {
        arrays::rows(py, (0..3).map(|i| std::array::from_fn::<f64, 4, _>(|j| m[(i, j)])).collect())
    };
    for (key, matrix) in ["P0", "P1", "P2", "P3"].into_iter().zip(&calibration.projections) {
        dict.set_item(key, rows(matrix))?;
    }
    let r0 = &calibration.r0_rect;
    let r0 = (0..3).map(|i| std::array::from_fn::<f64, 3, _>(|j| r0[(i, j)])).collect();
    dict.set_item("R0_rect", arrays::rows(py, r0))?;
    dict.set_item("Tr_velo_to_cam", rows(&calibration.tr_velo_to_cam))?;
    dict.set_item("Tr_imu_to_velo", rows(&calibration.tr_imu_to_velo))?;
    Ok(dict)
}
