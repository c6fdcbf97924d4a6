//! Bird's-eye-view maps.

use cadet_core::bev::{BevSpec, Feature, HeightRule, maps};
use cadet_core::{Error, Result};
use numpy::ndarray::ArrayView2;
use numpy::{PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::BorderError;
use crate::guard;

/// Points in either precision, three columns or more.
#[derive(FromPyObject)]
pub(crate) enum Points<'py> {
    Single(PyReadonlyArray2<'py, f32>),
    Double(PyReadonlyArray2<'py, f64>),
}

/// What the maps are: `cadet.bev.BevConfig.to_native()`.
#[pyclass(frozen, module = "cadet._cadet")]
pub(crate) struct BevConfig {
    spec: BevSpec,
}

#[pymethods]
impl BevConfig {
    #[new]
    #[pyo3(signature = (*, slice_maps, cloud_maps, num_slices, height_m, range_cam_m, cell_m, height))]
    fn new(
        slice_maps: Vec<String>,
        cloud_maps: Vec<String>,
        num_slices: usize,
        height_m: [f64; 2],
        range_cam_m: [[f64; 2]; 3],
        cell_m: f64,
        height: &str,
    ) -> std::result::Result<Self, BorderError> {
        let features = |names: &[String]| names.iter().map(|n| feature(n)).collect::<Result<_>>();
        let spec = BevSpec {
            slice_maps: features(&slice_maps)?,
            cloud_maps: features(&cloud_maps)?,
            num_slices,
            height_m,
            range_cam_m,
            cell_m,
            height_rule: height_rule(height)?,
        };
        spec.check()?;
        Ok(Self { spec })
    }
}

fn height_rule(name: &str) -> Result<HeightRule> {
    match name {
        "max" => Ok(HeightRule::Max),
        "reference" => Ok(HeightRule::Reference),
        _ => Err(Error::Unknown { what: "height rule", name: name.to_owned(), known: "max, reference".to_owned() }),
    }
}

fn feature(name: &str) -> Result<Feature> {
    match name {
        "max_height" => Ok(Feature::MaxHeight),
        "min_height" => Ok(Feature::MinHeight),
        "density" => Ok(Feature::Density),
        "density_log64" => Ok(Feature::DensityLog64),
        _ => Err(Error::Unknown {
            what: "BEV map",
            name: name.to_owned(),
            known: "max_height, min_height, density, density_log64".to_owned(),
        }),
    }
}

/// Fills `out` (C, H, W), or a new array, with the maps of `points_cam`.
#[pyfunction]
#[pyo3(signature = (points_cam, plane, config, out=None))]
pub(crate) fn bev_maps<'py>(
    py: Python<'py>,
    points_cam: Points<'py>,
    plane: [f64; 4],
    config: &BevConfig,
    out: Option<Bound<'py, PyArray3<f32>>>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let spec = &config.spec;
    // A new array's zeros come from the system: only cells with points are ever touched.
    let is_new = out.is_none();
    let out = out.unwrap_or_else(|| PyArray3::zeros(py, spec.shape(), false));
    {
        let in_use = "out: another call is writing to it, or it shares memory with the points: give each its own";
        let mut values = out.try_readwrite().map_err(|_| BorderError::Unusable(in_use))?;
        let values = values.as_slice_mut()?;
        let clear = |values: &mut [f32]| {
            if !is_new {
                values.fill(0.0);
            }
        };
        match &points_cam {
            Points::Single(points) => {
                let points = points.as_array();
                guard::detached(py, || {
                    clear(values);
                    fill(&points, |v| f64::from(*v), plane, spec, values)
                })?;
            }
            Points::Double(points) => {
                let points = points.as_array();
                guard::detached(py, || {
                    clear(values);
                    fill(&points, |v| *v, plane, spec, values)
                })?;
            }
        }
    }
    Ok(out)
}

fn fill<T>(
    points: &ArrayView2<'_, T>,
    number: impl Fn(&T) -> f64,
    plane: [f64; 4],
    spec: &BevSpec,
    out: &mut [f32],
) -> Result<()> {
    if points.ncols() < 3 {
        return Err(Error::Shape {
            what: "points_cam",
            got: format!("({}, {})", points.nrows(), points.ncols()),
            expected: "(n, 3) or wider".to_owned(),
        });
    }
    let columns = points.ncols();
    match points.as_slice() {
        Some(flat) => maps(flat.chunks_exact(columns).map(|p| [&p[0], &p[1], &p[2]].map(&number)), plane, spec, out),
        None => maps(points.rows().into_iter().map(|p| [&p[0], &p[1], &p[2]].map(&number)), plane, spec, out),
    }
}
