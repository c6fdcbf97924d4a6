//! PNG encoding.

use cadet_core::camera::png::{encode_gray8, encode_gray16, encode_rgb8};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::guard;

/// Encodes an image as PNG: uint8 (H, W, 3) RGB, uint8 (H, W) or uint16 (H, W), C-contiguous.
#[pyfunction]
pub(crate) fn encode_png<'py>(py: Python<'py>, image: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
    let refused =
        || PyTypeError::new_err("image must be a C-contiguous array: uint8 (H, W, 3), uint8 (H, W) or uint16 (H, W)");
    let bytes = if let Ok(array) = image.extract::<PyReadonlyArrayDyn<'py, u8>>() {
        let data = array.as_slice().map_err(|_| refused())?;
        match *array.shape() {
            [height, width, 3] => guard::detached(py, || encode_rgb8(width as u32, height as u32, data)),
            [height, width] => guard::detached(py, || encode_gray8(width as u32, height as u32, data)),
            _ => return Err(refused()),
        }
    } else if let Ok(array) = image.extract::<PyReadonlyArrayDyn<'py, u16>>() {
        let data = array.as_slice().map_err(|_| refused())?;
        match *array.shape() {
            [height, width] => guard::detached(py, || encode_gray16(width as u32, height as u32, data)),
            _ => return Err(refused()),
        }
    } else {
        return Err(refused());
    };
    Ok(PyBytes::new(py, &bytes?))
}
