//! Image files: PNG encoding, and decoding of what others write.

use cadet_core::camera::png::{encode_gray8, encode_gray16, encode_rgb8, encode_rgb16, encode_rgba8};
use cadet_core::image_file::{PixelValues, decode};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::guard;

/// Encodes an image as PNG, C-contiguous: uint8 (H, W, 3) RGB or (H, W, 4) RGB and opacity, uint8 (H, W), uint16 (H, W)
/// or (H, W, 3).
#[pyfunction]
pub(crate) fn encode_png<'py>(py: Python<'py>, image: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
    let refused = || {
        PyTypeError::new_err(
            "image must be C-contiguous: uint8 (H, W) or (H, W, 3 or 4), or uint16 (H, W) or (H, W, 3)",
        )
    };
    let bytes = if let Ok(array) = image.extract::<PyReadonlyArrayDyn<'py, u8>>() {
        let data = array.as_slice().map_err(|_| refused())?;
        match *array.shape() {
            [height, width, 3] => guard::detached(py, || encode_rgb8(width as u32, height as u32, data)),
            [height, width, 4] => guard::detached(py, || encode_rgba8(width as u32, height as u32, data)),
            [height, width] => guard::detached(py, || encode_gray8(width as u32, height as u32, data)),
            _ => return Err(refused()),
        }
    } else if let Ok(array) = image.extract::<PyReadonlyArrayDyn<'py, u16>>() {
        let data = array.as_slice().map_err(|_| refused())?;
        match *array.shape() {
            [height, width] => guard::detached(py, || encode_gray16(width as u32, height as u32, data)),
            [height, width, 3] => guard::detached(py, || encode_rgb16(width as u32, height as u32, data)),
            _ => return Err(refused()),
        }
    } else {
        return Err(refused());
    };
    Ok(PyBytes::new(py, &bytes?))
}

/// Decodes PNG, JPEG or WebP of at most `max_pixels`: (height, width, channels) of uint8 or uint16, the format's name,
/// whether it has a palette, and whether it is an animation.
#[pyfunction]
pub(crate) fn decode_image<'py>(
    py: Python<'py>,
    data: &[u8],
    max_pixels: u64,
) -> PyResult<(Bound<'py, PyAny>, &'static str, bool, bool)> {
    let picture = guard::detached(py, || decode(data, max_pixels))?;
    let shape = [picture.height as usize, picture.width as usize, picture.channels];
    let pixels = match picture.samples {
        PixelValues::Eight(samples) => PyArray1::from_vec(py, samples).reshape(shape)?.into_any(),
        PixelValues::Sixteen(samples) => PyArray1::from_vec(py, samples).reshape(shape)?.into_any(),
    };
    Ok((pixels, picture.format, picture.is_palette, picture.is_animation))
}
