//! The one place where the core's vectors become NumPy arrays and back.

use cadet_core::math::{DMat3, DPose3, DVec3};
use cadet_core::{Error, Result};
use numpy::ndarray::Array3;
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;

/// Rows of equal length as a matrix, without copying an element twice.
pub(crate) fn rows<'py, T: Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: Vec<[T; N]>,
) -> Bound<'py, PyArray2<T>> {
    let count = rows.len();
    let flat = rows.into_flattened();
    PyArray1::from_vec(py, flat).reshape_rows(count, N)
}

/// A row-major image plane of (height, width).
pub(crate) fn plane<T: Element>(py: Python<'_>, data: Vec<T>, height: usize, width: usize) -> Bound<'_, PyArray2<T>> {
    PyArray1::from_vec(py, data).reshape_rows(height, width)
}

/// A row-major RGB image of (height, width, 3).
pub(crate) fn rgb(py: Python<'_>, data: Vec<u8>, height: usize, width: usize) -> Bound<'_, PyArray3<u8>> {
    let image = Array3::from_shape_vec((height, width, 3), data).expect("three bytes a pixel");
    PyArray3::from_owned_array(py, image)
}

/// A row-major image of (height, width, N).
pub(crate) fn vectors_of_pixels<T: Element + Copy, const N: usize>(
    py: Python<'_>,
    data: Vec<[T; N]>,
    height: usize,
    width: usize,
) -> Bound<'_, PyArray3<T>> {
    let image = Array3::from_shape_vec((height, width, N), data.into_flattened()).expect("a vector a pixel");
    PyArray3::from_owned_array(py, image)
}

/// Vectors as the rows of an (n, 3) array.
pub(crate) fn vectors<'py>(py: Python<'py>, data: &[DVec3]) -> Bound<'py, PyArray2<f64>> {
    rows(py, data.iter().map(|v| [v.x, v.y, v.z]).collect())
}

/// A pose as the rows of a 4 x 4 matrix.
pub(crate) fn pose_rows(pose: &DPose3) -> [[f64; 4]; 4] {
    let r = DMat3::from_quat(pose.rotation);
    let columns = [r.x_axis, r.y_axis, r.z_axis, pose.translation].map(|c| c.to_array());
    let row = |i: usize| std::array::from_fn(|j| columns[j][i]);
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// A pose as a (4, 4) array.
pub(crate) fn pose<'py>(py: Python<'py>, pose: &DPose3) -> Bound<'py, PyArray2<f64>> {
    rows(py, pose_rows(pose).to_vec())
}

/// An (n, 3) array as vectors.
pub(crate) fn to_vectors(what: &'static str, array: &PyReadonlyArray2<'_, f64>) -> Result<Vec<DVec3>> {
    let view = array.as_array();
    if view.ncols() != 3 {
        return Err(Error::Shape {
            what,
            got: format!("({}, {})", view.nrows(), view.ncols()),
            expected: "(n, 3)".to_owned(),
        });
    }
    Ok(view.rows().into_iter().map(|r| DVec3::new(r[0], r[1], r[2])).collect())
}

/// An (n, N) array as rows.
pub(crate) fn to_rows<T: Element + Copy, const N: usize>(
    what: &'static str,
    array: &PyReadonlyArray2<'_, T>,
) -> Result<Vec<[T; N]>> {
    let view = array.as_array();
    if view.ncols() != N {
        return Err(Error::Shape {
            what,
            got: format!("({}, {})", view.nrows(), view.ncols()),
            expected: format!("(n, {N})"),
        });
    }
    Ok(view.rows().into_iter().map(|r| std::array::from_fn(|i| r[i])).collect())
}

trait ReshapeRows<'py, T: Element> {
    fn reshape_rows(self, rows: usize, columns: usize) -> Bound<'py, PyArray2<T>>;
}

impl<'py, T: Element> ReshapeRows<'py, T> for Bound<'py, PyArray1<T>> {
    fn reshape_rows(self, rows: usize, columns: usize) -> Bound<'py, PyArray2<T>> {
        use numpy::PyArrayMethods;
        self.reshape([rows, columns]).expect("the product of the sides is the length")
    }
}
