//! LIDAR specifications.

use cadet_core::lidar::{LidarSpec, PRESETS, ReturnMode};
use cadet_core::material::Pattern;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays;
use crate::beam_table::BeamTable;
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

    /// The names that `preset` knows.
    #[staticmethod]
    fn presets() -> Vec<&'static str> {
        PRESETS.to_vec()
    }

    /// What `returns` may be.
    #[staticmethod]
    fn return_modes() -> Vec<&'static str> {
        ReturnMode::names()
    }

    /// What the materials of a scan's surfaces count.
    #[staticmethod]
    fn materials() -> Vec<&'static str> {
        Pattern::names()
    }

    /// The LIDAR of a table.
    #[staticmethod]
    fn from_table(table: BeamTable) -> Result<Self, BorderError> {
        Ok(Self { spec: table.spec()? })
    }

    /// Puts the origins of all beams at one point.
    fn single_origin(&self) -> Self {
        Self { spec: self.spec.clone().single_origin() }
    }

    /// Returns the LIDAR with its scans taken in this way.
    #[pyo3(signature = (*, rolling, returns, divergence_mrad))]
    fn scanning(&self, rolling: bool, returns: &str, divergence_mrad: f64) -> Result<Self, BorderError> {
        Ok(Self { spec: scanning(self.spec.clone(), rolling, returns, divergence_mrad)? })
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
        self.spec.num_columns()
    }

    /// Every laser and number.
    fn table(&self) -> BeamTable {
        BeamTable::of(&self.spec)
    }

    /// When its turn begins and ends, seconds from the instant of the image; None if nothing moves meanwhile.
    fn span_s(&self) -> Option<[f64; 2]> {
        self.spec.rolling.then(|| self.spec.span_s())
    }

    /// Origins and directions in the LIDAR's frame, ring and column of every beam of the scan at a time.
    #[pyo3(signature = (*, time_s))]
    fn rays<'py>(&self, py: Python<'py>, time_s: f64) -> Rays<'py> {
        let rays = self.spec.clone().at_time(time_s).rays();
        (
            arrays::vectors(py, &rays.origins_velo),
            arrays::vectors(py, &rays.directions_velo),
            PyArray1::from_vec(py, rays.ring),
            PyArray1::from_vec(py, rays.column),
        )
    }
}

/// A sensor that takes its scans in this way.
pub(crate) fn scanning(
    spec: LidarSpec,
    rolling: bool,
    returns: &str,
    divergence_mrad: f64,
) -> cadet_core::Result<LidarSpec> {
    let mut spec = spec.with_divergence(divergence_mrad * 1e-3)?;
    spec.rolling = rolling;
    spec.returns = ReturnMode::from_name(returns)?;
    Ok(spec)
}
