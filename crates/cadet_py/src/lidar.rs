//! LIDAR specifications.

use cadet_core::Error;
use cadet_core::lidar::{BlindSector, Firing, LidarSpec, PRESETS, Receiver, ReturnMode};
use cadet_core::math::TAU;
use cadet_core::sense::LaserRing;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::error::BorderError;
use crate::fields::Fields;

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

    /// The LIDAR of a `LidarTableDict`.
    #[staticmethod]
    fn from_table(table: &Bound<'_, PyDict>) -> PyResult<Self> {
        Ok(Self { spec: spec_from_table(table)? })
    }

    /// The same beams, all from one point.
    fn single_origin(&self) -> Self {
        Self { spec: self.spec.clone().single_origin() }
    }

    /// The same beams, taken in another way.
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
        self.spec.azimuths_rad().len()
    }

    /// The LIDAR as a `LidarTableDict`, angles rounded to a billionth of a degree.
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let spec = &self.spec;
        let dict = PyDict::new(py);
        dict.set_item("name", spec.name())?;
        dict.set_item("min_range_m", spec.min_range_m)?;
        dict.set_item("max_range_m", spec.max_range_m)?;
        dict.set_item("range_noise_m", spec.receiver().range_noise_m)?;
        let of_rings = |f: &dyn Fn(&LaserRing) -> f64| spec.rings().iter().map(f).collect::<Vec<f64>>();
        dict.set_item("elevation_deg", of_rings(&|r| rounded(r.elevation_rad.to_degrees())))?;
        dict.set_item("height_m", of_rings(&|r| rounded(r.height_m)))?;
        dict.set_item("left_m", of_rings(&|r| rounded(r.left_m)))?;
        let offsets: Vec<f64> = spec.azimuth_offsets_rad().iter().map(|o| rounded(o.to_degrees())).collect();
        dict.set_item("azimuth_offset_deg", offsets)?;
        dict.set_item("gain", spec.laser_gains.iter().map(|g| rounded(*g)).collect::<Vec<f64>>())?;
        let mut blind = vec![Vec::new(); spec.rings().len()];
        for sector in &spec.blind_sectors {
            blind[sector.ring].push([rounded(sector.from_rad.to_degrees()), rounded(sector.to_rad.to_degrees())]);
        }
        dict.set_item("blind_deg", blind)?;
        dict.set_item("firing", firing_to_dict(py, spec.firing())?)?;
        Ok(dict)
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

fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
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

fn spec_from_table(dict: &Bound<'_, PyDict>) -> PyResult<LidarSpec> {
    let mut fields = Fields::new("lidar", dict)?;
    let name: String = fields.take("name")?;
    let elevations_deg: Vec<f64> = fields.take("elevation_deg")?;
    let heights_m: Vec<f64> = fields.take("height_m")?;
    let offsets_deg: Vec<f64> = fields.take("azimuth_offset_deg")?;
    let lefts_m: Vec<f64> = fields.take("left_m")?;
    for (what, values) in [("height_m", &heights_m), ("left_m", &lefts_m)] {
        if values.len() != elevations_deg.len() {
            let (got, expected) = (format!("({},)", values.len()), format!("({},)", elevations_deg.len()));
            return Err(BorderError::from(Error::Shape { what, got, expected }).into());
        }
    }
    let places = elevations_deg.iter().zip(heights_m).zip(lefts_m);
    let ring = |((degrees, height_m), left_m): ((&f64, f64), f64)| LaserRing {
        elevation_rad: degrees.to_radians(),
        height_m,
        left_m,
    };
    let rings = places.map(ring).collect();
    let firing = firing_from_dict(&fields.take::<Bound<'_, PyDict>>("firing")?)?;
    let mut spec = LidarSpec::with_firing(&name, rings, firing)
        .and_then(|spec| spec.staggered(offsets_deg.iter().map(|d| d.to_radians()).collect()))
        .map_err(BorderError::from)?;
    spec.min_range_m = fields.take("min_range_m")?;
    spec.max_range_m = fields.take("max_range_m")?;
    let receiver = Receiver { range_noise_m: fields.take("range_noise_m")?, ..*spec.receiver() };
    spec = spec.with_receiver(receiver).map_err(BorderError::from)?;
    spec.laser_gains = fields.take("gain")?;
    let blind_deg: Vec<Vec<[f64; 2]>> = fields.take("blind_deg")?;
    for (ring, sectors) in blind_deg.into_iter().enumerate() {
        // A whole turn must not end beyond its end by rounding.
        let radians = |degrees: f64| degrees.to_radians().min(TAU);
        spec.blind_sectors.extend(sectors.into_iter().map(|[from, to]| BlindSector {
            ring,
            from_rad: radians(from),
            to_rad: radians(to),
        }));
    }
    fields.finish()?;
    spec.check().map_err(BorderError::from)?;
    Ok(spec)
}

fn firing_from_dict(dict: &Bound<'_, PyDict>) -> PyResult<Firing> {
    let mut fields = Fields::new("firing", dict)?;
    let firing = match fields.take::<String>("pattern")?.as_str() {
        "uniform" => Firing::Uniform { columns: fields.take("columns")? },
        "encoder" => Firing::Encoder {
            ticks_per_turn: fields.take("ticks_per_turn")?,
            ticks_per_firing: fields.take("ticks_per_firing")?,
            phase_ticks: fields.take("phase_ticks")?,
            firings: fields.take("firings")?,
        },
        "listed" => Firing::Listed(fields.take::<Vec<f64>>("azimuths_deg")?.into_iter().map(f64::to_radians).collect()),
        other => {
            let known = "uniform, encoder, listed".to_owned();
            return Err(
                BorderError::from(Error::Unknown { what: "firing pattern", name: other.to_owned(), known }).into()
            );
        }
    };
    fields.finish()?;
    Ok(firing)
}

fn firing_to_dict<'py>(py: Python<'py>, firing: &Firing) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    match firing {
        Firing::Uniform { columns } => {
            dict.set_item("pattern", "uniform")?;
            dict.set_item("columns", columns)?;
        }
        Firing::Encoder { ticks_per_turn, ticks_per_firing, phase_ticks, firings } => {
            dict.set_item("pattern", "encoder")?;
            dict.set_item("ticks_per_turn", ticks_per_turn)?;
            dict.set_item("ticks_per_firing", ticks_per_firing)?;
            dict.set_item("phase_ticks", phase_ticks)?;
            dict.set_item("firings", firings)?;
        }
        Firing::Listed(azimuths_rad) => {
            dict.set_item("pattern", "listed")?;
            let azimuths: Vec<f64> = azimuths_rad.iter().map(|a| rounded(a.to_degrees())).collect();
            dict.set_item("azimuths_deg", azimuths)?;
        }
    }
    Ok(dict)
}
