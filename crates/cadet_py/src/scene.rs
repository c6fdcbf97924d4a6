//! Scenes.

use cadet_core::actor::ObjectClass;
use cadet_core::rng::StreamKey;
use cadet_core::scene as core;
use cadet_core::weather::Weather;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::assets::Assets;
use crate::error::BorderError;
use crate::frame;
use crate::lidar::Lidar;
use crate::rig;
use crate::settings;

type RayHits<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray2<f64>>);
type Triangles<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<i32>>);

/// A town, its traffic and a rig.
#[pyclass(module = "cadet._cadet")]
pub(crate) struct Scene {
    inner: core::Scene,
}

fn town_source(map_name: Option<String>, map_xodr: Option<String>, default: core::TownSource) -> core::TownSource {
    match map_xodr {
        Some(text) => core::TownSource::OpenDrive { name: map_name.unwrap_or_else(|| "map".to_owned()), text },
        None => default,
    }
}

#[pymethods]
impl Scene {
    #[staticmethod]
    #[pyo3(signature = (seed, episode, attempt, *, map_name, map_xodr, weather, rig, config, assets))]
    fn random(
        py: Python<'_>,
        seed: u64,
        episode: u64,
        attempt: u64,
        map_name: Option<String>,
        map_xodr: Option<String>,
        weather: &str,
        rig: &Bound<'_, PyDict>,
        config: &Bound<'_, PyDict>,
        assets: Option<&Assets>,
    ) -> PyResult<Self> {
        let source = town_source(map_name, map_xodr, core::TownSource::Suburb);
        let weather = Weather::preset(weather).map_err(BorderError::from)?;
        let (rig, config) = (rig::from_dict(rig)?, settings::from_dict(config, assets)?);
        let key = StreamKey { seed, episode, attempt };
        let inner = py.detach(|| core::Scene::random(key, &source, weather, rig, &config));
        Ok(Self { inner: inner.map_err(BorderError::from)? })
    }

    #[staticmethod]
    #[pyo3(signature = (*, map_name, map_xodr, weather, rig, config, assets))]
    fn empty(
        py: Python<'_>,
        map_name: Option<String>,
        map_xodr: Option<String>,
        weather: &str,
        rig: &Bound<'_, PyDict>,
        config: &Bound<'_, PyDict>,
        assets: Option<&Assets>,
    ) -> PyResult<Self> {
        let source = town_source(map_name, map_xodr, core::TownSource::Flat);
        let weather = Weather::preset(weather).map_err(BorderError::from)?;
        let (rig, config) = (rig::from_dict(rig)?, settings::from_dict(config, assets)?);
        let inner = py.detach(|| core::Scene::empty(&source, weather, rig, &config));
        Ok(Self { inner: inner.map_err(BorderError::from)? })
    }

    #[getter]
    fn time_s(&self) -> f64 {
        self.inner.time_s()
    }

    #[getter]
    fn num_triangles(&mut self, py: Python<'_>) -> usize {
        py.detach(|| self.inner.triangles().num_triangles())
    }

    #[getter]
    fn num_actors(&mut self, py: Python<'_>) -> usize {
        py.detach(|| self.inner.snapshot().actors.len())
    }

    fn add(
        &mut self,
        py: Python<'_>,
        kind: &str,
        x: f64,
        y: f64,
        yaw: f64,
        model_seed: u64,
    ) -> Result<i32, BorderError> {
        let class = ObjectClass::from_name(kind)?;
        Ok(py.detach(|| self.inner.add(class, x, y, yaw, model_seed))?)
    }

    fn add_model(
        &mut self,
        py: Python<'_>,
        kind: &str,
        model: &str,
        x: f64,
        y: f64,
        yaw: f64,
    ) -> Result<i32, BorderError> {
        let class = ObjectClass::from_name(kind)?;
        Ok(py.detach(|| self.inner.add_user_vehicle(class, model, x, y, yaw))?)
    }

    fn move_ego(&mut self, py: Python<'_>, x: f64, y: f64, yaw: f64) -> Result<(), BorderError> {
        Ok(py.detach(|| self.inner.move_ego(x, y, yaw))?)
    }

    fn step(&mut self, py: Python<'_>, seconds: f64) -> Result<(), BorderError> {
        Ok(py.detach(|| self.inner.step(seconds))?)
    }

    fn drive(&mut self, py: Python<'_>, distance_m: f64, blocked_s: f64) -> Result<(), BorderError> {
        Ok(py.detach(|| self.inner.drive(distance_m, blocked_s))?)
    }

    fn capture<'py>(&mut self, py: Python<'py>, sample: u64, maps: bool) -> PyResult<Bound<'py, PyDict>> {
        let captured = py.detach(|| self.inner.capture(sample, maps)).map_err(BorderError::from)?;
        self.frame_to_dict(py, captured)
    }

    fn capture_labelled<'py>(
        &mut self,
        py: Python<'py>,
        sample: u64,
        maps: bool,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let captured = py.detach(|| self.inner.capture_labelled(sample, maps)).map_err(BorderError::from)?;
        captured.map(|frame| self.frame_to_dict(py, frame)).transpose()
    }

    #[pyo3(signature = (lidar, ideal, sample))]
    fn scan<'py>(
        &mut self,
        py: Python<'py>,
        lidar: Option<&Lidar>,
        ideal: bool,
        sample: u64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let spec = lidar.map(|l| &l.spec);
        let dict = PyDict::new(py);
        let (points, ring, column, actor_id, range_m) = if ideal {
            py.detach(|| {
                let scan = self.inner.ideal_scan(spec);
                let spec = spec.unwrap_or(&self.inner.rig().lidar);
                let (ring, column) = spec.beam_numbers();
                let range_m = scan.range_m.iter().map(|r| f64::from(*r)).collect();
                (scan.points_velo(spec), ring, column, scan.actor_id, range_m)
            })
        } else {
            let s = py.detach(|| self.inner.scan(spec, sample)).map_err(BorderError::from)?;
            (s.points_velo, s.ring, s.column, s.actor_id, s.range_m)
        };
        dict.set_item("points_velo", arrays::rows(py, points))?;
        dict.set_item("ring", PyArray1::from_vec(py, ring))?;
        dict.set_item("column", PyArray1::from_vec(py, column))?;
        dict.set_item("actor_id", PyArray1::from_vec(py, actor_id))?;
        dict.set_item("range_m", PyArray1::from_vec(py, range_m))?;
        Ok(dict)
    }

    fn cast_rays<'py>(
        &mut self,
        py: Python<'py>,
        origins_world: PyReadonlyArray2<'py, f64>,
        directions_world: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<RayHits<'py>> {
        let origins = arrays::to_vectors("origins_world", &origins_world).map_err(BorderError::from)?;
        let directions = arrays::to_vectors("directions_world", &directions_world).map_err(BorderError::from)?;
        if origins.len() != directions.len() {
            return Err(BorderError::from(cadet_core::Error::Shape {
                what: "directions_world",
                got: format!("({}, 3)", directions.len()),
                expected: format!("({}, 3), as origins_world", origins.len()),
            })
            .into());
        }
        let rays: Vec<_> = origins.into_iter().zip(directions).collect();
        let hits = py.detach(|| self.inner.cast_rays(&rays)).map_err(BorderError::from)?;
        let range = hits.iter().map(|h| h.as_ref().map_or(f64::INFINITY, |h| h.range_m)).collect();
        let actor = hits.iter().map(|h| h.as_ref().map_or(-1, |h| h.actor_id)).collect();
        let normals: Vec<_> =
            hits.iter().map(|h| h.as_ref().map_or([f64::NAN; 3], |h| h.normal_world.to_array())).collect();
        Ok((PyArray1::from_vec(py, range), PyArray1::from_vec(py, actor), arrays::rows(py, normals)))
    }

    fn triangles<'py>(&mut self, py: Python<'py>) -> Triangles<'py> {
        let posed = self.inner.triangles();
        let vertices = posed.vertices_world().map(|v| v.to_array()).collect();
        let (mut faces, mut actor_ids) = (Vec::new(), Vec::new());
        for instance in &posed.instances {
            let start = instance.vertices.start as u32;
            faces.extend(instance.mesh.faces.iter().map(|f| f.map(|i| i + start)));
            actor_ids.resize(faces.len(), instance.actor_id);
        }
        (arrays::rows(py, vertices), arrays::rows(py, faces), PyArray1::from_vec(py, actor_ids))
    }

    fn sensor_poses<'py>(&mut self, py: Python<'py>) -> (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>) {
        let (velo, cam) = self.inner.sensor_poses();
        (arrays::pose(py, &velo), arrays::pose(py, &cam))
    }
}

impl Scene {
    fn frame_to_dict<'py>(&self, py: Python<'py>, captured: core::Frame) -> PyResult<Bound<'py, PyDict>> {
        let camera = &self.inner.rig().camera;
        let dict = frame::to_dict(py, captured, camera.width, camera.height)?;
        let meta = dict.get_item("meta")?.expect("a frame has metadata");
        let weather = self.inner.weather();
        meta.set_item("map", self.inner.map_name())?;
        meta.set_item("weather", &weather.name)?;
        meta.set_item("rig", &self.inner.rig().name)?;
        let ego_from_velo = arrays::pose_rows(&self.inner.rig().ego_from_velo);
        meta.set_item("ego_from_velo", ego_from_velo.map(Vec::from).to_vec())?;
        let sun = PyDict::new(py);
        sun.set_item("elevation_rad", weather.sun_elevation_rad)?;
        sun.set_item("azimuth_rad", weather.sun_azimuth_rad)?;
        meta.set_item("sun", sun)?;
        dict.set_item("calib", rig::calibration_to_dict(py, &camera.calibration)?)?;
        Ok(dict)
    }
}
