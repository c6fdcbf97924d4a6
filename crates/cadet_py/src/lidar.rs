//! LIDAR specifications.

use cadet_core::lidar::LidarSpec;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays;
use crate::error::BorderError;

type Rays<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i32>>);

/// A LIDAR's beams and returns.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct Lidar {
    pub(crate) spec: LidarSpec,
}

#[pymethods]
impl Lidar {
    /// The preset of a name.
    #[staticmethod]
    fn preset(name: &str) -> Result<Self, BorderError> {
        Ok(Self { spec: LidarSpec::preset(name)? })
    }

    /// The same beams, all from one point.
    fn single_origin(&self) -> Self {
        Self { spec: self.spec.clone().single_origin() }
    }

    #[getter]
    fn name(&self) -> &str {
        self.spec.name()
    }

    #[getter]
    fn num_rings(&self) -> usize {
        self.spec.rings().len()
    }

    #[getter]
    fn num_columns(&self) -> usize {
        self.spec.azimuths_rad().len()
    }

    /// Origins and directions in the LIDAR's frame, ring and column of every beam.
    fn rays<'py>(&self, py: Python<'py>) -> Rays<'py> {
        let rays = self.spec.rays();
        (
            arrays::vectors(py, &rays.origins_velo),
            arrays::vectors(py, &rays.directions_velo),
            PyArray1::from_vec(py, rays.ring),
            PyArray1::from_vec(py, rays.column),
        )
    }
}
