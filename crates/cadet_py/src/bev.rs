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

/// What the maps are: as in Python's `BevConfig`.
#[derive(FromPyObject)]
pub(crate) struct Settings {
    #[pyo3(item)]
    slice_maps: Vec<String>,
    #[pyo3(item)]
    cloud_maps: Vec<String>,
    #[pyo3(item)]
    num_slices: usize,
    #[pyo3(item)]
    height_m: [f64; 2],
    #[pyo3(item)]
    range_cam_m: [[f64; 2]; 3],
    #[pyo3(item)]
    cell_m: f64,
    #[pyo3(item)]
    height: String,
}

impl Settings {
    fn into_spec(self) -> Result<BevSpec> {
        Ok(BevSpec {
            slice_maps: self.slice_maps.iter().map(|n| feature(n)).collect::<Result<_>>()?,
            cloud_maps: self.cloud_maps.iter().map(|n| feature(n)).collect::<Result<_>>()?,
            num_slices: self.num_slices,
            height_m: self.height_m,
            range_cam_m: self.range_cam_m,
            cell_m: self.cell_m,
            height_rule: if self.height == "reference" { HeightRule::Reference } else { HeightRule::Max },
        })
    }
}

fn feature(name: &str) -> Result<Feature> {
    match name {
        "max_height" => Ok(Feature::MaxHeight),
        "min_height" => Ok(Feature::MinHeight),
        "density" => Ok(Feature::Density),
        _ => Err(Error::Unknown {
            what: "BEV map",
            name: name.to_owned(),
            known: "max_height, min_height, density".to_owned(),
        }),
    }
}

/// Fills `out` (C, H, W), or a new array, with the maps of `points_cam`.
#[pyfunction]
#[pyo3(signature = (points_cam, plane, settings, out=None))]
pub(crate) fn bev_maps<'py>(
    py: Python<'py>,
    points_cam: Points<'py>,
    plane: [f64; 4],
    settings: Settings,
    out: Option<Bound<'py, PyArray3<f32>>>,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let spec = settings.into_spec().map_err(BorderError::from)?;
    spec.check().map_err(BorderError::from)?;
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
                    fill(&points, |v| f64::from(*v), plane, &spec, values)
                })?;
            }
            Points::Double(points) => {
                let points = points.as_array();
                guard::detached(py, || {
                    clear(values);
                    fill(&points, |v| *v, plane, &spec, values)
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
