//! Scenes.

use std::sync::{Mutex, TryLockError};

use cadet_core::actor::{BrakesFor, ObjectClass};
use cadet_core::frames;
use cadet_core::lidar::Scan;
use cadet_core::math::DVec3;
use cadet_core::rng::StreamKey;
use cadet_core::scene as core;
use cadet_core::world::{Course, EgoCommand, ModelChoice, Overlap, Retouch, Waypoint};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::assets::Assets;
use crate::capture::{Agent, Capture, Request, scan_to_dict};
use crate::error::BorderError;
use crate::guard;
use crate::lidar::Lidar;
use crate::rig::Rig;
use crate::settings::SceneConfig;
use crate::weather::Weather;

type RayHits<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray2<f64>>);
type Poses<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);
type Triangles<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<i32>>);

/// About as many as a tenth of a second takes.
const RAYS_BETWEEN_PAUSES: usize = 1 << 16;

/// A town, its traffic and a rig.
#[pyclass(module = "cadet._cadet", frozen)]
pub(crate) struct Scene {
    /// One thread at a time uses it. A panic on the way leaves it unusable.
    inner: Mutex<core::Scene>,
}

fn town_source(map_name: Option<String>, map_xodr: Option<String>, default: core::TownSource) -> core::TownSource {
    match map_xodr {
        Some(text) => core::TownSource::OpenDrive { name: map_name.unwrap_or_else(|| "map".to_owned()), text },
        None => default,
    }
}

fn overlap(may_overlap: bool) -> Overlap {
    if may_overlap { Overlap::Allow } else { Overlap::Refuse }
}

fn course(
    place: Option<(f64, f64, f64)>,
    speed: Option<f64>,
    path: Option<&PyReadonlyArray2<'_, f64>>,
) -> cadet_core::Result<Course> {
    Ok(match (place, speed, path) {
        (Some((x_m, y_m, yaw_rad)), None, None) => Course::Stand { x_m, y_m, yaw_rad },
        (Some((x_m, y_m, yaw_rad)), Some(speed_mps), None) => Course::Straight { x_m, y_m, yaw_rad, speed_mps },
        (None, None, Some(path)) => {
            let points = arrays::to_vectors("path", path)?;
            Course::Path(points.iter().map(|p| Waypoint { t_s: p.x, x_m: p.y, y_m: p.z }).collect())
        }
        _ => return Err(cadet_core::Error::Scene { reason: "expected a place, or a path alone".to_owned() }),
    })
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
        weather: &Weather,
        rig: &Rig,
        config: &SceneConfig,
        assets: Option<&Assets>,
    ) -> PyResult<Self> {
        let source = town_source(map_name, map_xodr, core::TownSource::Suburb);
        let weather = weather.inner.clone();
        let (rig, config) = (rig.rig.clone(), config.with(assets));
        let key = StreamKey { seed, episode, attempt };
        let inner = guard::detached(py, || core::Scene::random(key, &source, weather, rig, &config))?;
        Ok(Self { inner: Mutex::new(inner) })
    }

    #[staticmethod]
    #[pyo3(signature = (*, map_name, map_xodr, weather, rig, config, assets))]
    fn empty(
        py: Python<'_>,
        map_name: Option<String>,
        map_xodr: Option<String>,
        weather: &Weather,
        rig: &Rig,
        config: &SceneConfig,
        assets: Option<&Assets>,
    ) -> PyResult<Self> {
        let source = town_source(map_name, map_xodr, core::TownSource::Flat);
        let weather = weather.inner.clone();
        let (rig, config) = (rig.rig.clone(), config.with(assets));
        let inner = guard::detached(py, || core::Scene::empty(&source, weather, rig, &config))?;
        Ok(Self { inner: Mutex::new(inner) })
    }

    /// What the map's reader passed over, a line each.
    fn map_warnings(&self, py: Python<'_>) -> Result<Vec<String>, BorderError> {
        self.with(py, |scene| Ok(scene.town().map_warnings.clone()))
    }

    /// Which numbers of the traffic were not met: the field, how many it asks for, and how many found room.
    fn shortfalls(&self, py: Python<'_>) -> Result<Vec<(&'static str, usize, usize)>, BorderError> {
        self.with(py, |scene| Ok(scene.shortfalls().iter().map(|s| (s.setting, s.asked, s.placed)).collect()))
    }

    #[getter]
    fn time_s(&self, py: Python<'_>) -> Result<f64, BorderError> {
        self.with(py, |scene| Ok(scene.time_s()))
    }

    #[getter]
    fn num_triangles(&self, py: Python<'_>) -> Result<usize, BorderError> {
        self.with(py, |scene| Ok(scene.triangles().num_triangles()))
    }

    #[getter]
    fn num_actors(&self, py: Python<'_>) -> Result<usize, BorderError> {
        self.with(py, |scene| Ok(scene.snapshot().actors.len()))
    }

    #[getter]
    fn agents(&self, py: Python<'_>) -> Result<Vec<Agent>, BorderError> {
        self.with(py, |scene| Ok(scene.snapshot().actors.iter().map(|actor| Agent::of(actor, None)).collect()))
    }

    #[pyo3(signature = (kind, model_seed, model, place, speed, path, may_overlap))]
    fn add(
        &self,
        py: Python<'_>,
        kind: &str,
        model_seed: u64,
        model: Option<&str>,
        place: Option<(f64, f64, f64)>,
        speed: Option<f64>,
        path: Option<PyReadonlyArray2<'_, f64>>,
        may_overlap: bool,
    ) -> Result<i32, BorderError> {
        let class = ObjectClass::from_name(kind)?;
        let model = model.map_or(ModelChoice::Seed(model_seed), ModelChoice::Named);
        let course = course(place, speed, path.as_ref())?;
        self.with(py, |scene| scene.add(class, model, &course, overlap(may_overlap)))
    }

    fn move_ego(&self, py: Python<'_>, x: f64, y: f64, yaw: f64, may_overlap: bool) -> Result<(), BorderError> {
        self.with(py, |scene| scene.move_ego(x, y, yaw, overlap(may_overlap)))
    }

    fn hide_actor(&self, py: Python<'_>, actor_id: i32) -> Result<(), BorderError> {
        self.with(py, |scene| scene.retouch(actor_id, Retouch::Absent))
    }

    fn shift_actor(
        &self,
        py: Python<'_>,
        actor_id: i32,
        forward_m: f64,
        left_m: f64,
        yaw_rad: f64,
    ) -> Result<(), BorderError> {
        let box_from_shown = frames::upright(DVec3::new(forward_m, left_m, 0.0), yaw_rad);
        self.with(py, |scene| scene.retouch(actor_id, Retouch::Moved { box_from_shown }))
    }

    #[pyo3(signature = (command))]
    fn command_ego(&self, py: Python<'_>, command: Option<(f64, f64)>) -> Result<(), BorderError> {
        let command = command.map(|(speed_mps, lateral_m)| EgoCommand::new(speed_mps, lateral_m)).transpose()?;
        self.with(py, |scene| scene.command_ego(command))
    }

    #[pyo3(signature = (seconds, ego_returns=false))]
    fn step(&self, py: Python<'_>, seconds: f64, ego_returns: bool) -> Result<(), BorderError> {
        let at_road_end = if ego_returns { core::AtRoadEnd::ComeInElsewhere } else { core::AtRoadEnd::Stand };
        self.with_pauses(py, |scene| scene.step_until(seconds, at_road_end, guard::handle_signals))
    }

    fn drive(&self, py: Python<'_>, distance_m: f64, blocked_s: f64) -> Result<(), BorderError> {
        self.with(py, |scene| scene.drive(distance_m, blocked_s))
    }

    #[getter]
    fn ego_brakes_for(&self, py: Python<'_>) -> Result<Option<(&'static str, Option<i32>)>, BorderError> {
        self.with(py, |scene| Ok(scene.ego_brakes_for().map(BrakesFor::name_and_id)))
    }

    #[getter]
    fn ego_is_at_road_end(&self, py: Python<'_>) -> Result<bool, BorderError> {
        self.with(py, |scene| Ok(scene.ego_is_at_road_end()))
    }

    fn capture(&self, py: Python<'_>, request: &Request) -> Result<Capture, BorderError> {
        self.with(py, |scene| Ok(Capture::new(scene.capture(&request.inner)?, scene)))
    }

    fn capture_labeled(&self, py: Python<'_>, request: &Request) -> Result<Option<Capture>, BorderError> {
        self.with(py, |scene| Ok(scene.capture_labeled(&request.inner)?.map(|frame| Capture::new(frame, scene))))
    }

    #[pyo3(signature = (lidar, *, ideal, surfaces, sample))]
    fn scan<'py>(
        &self,
        py: Python<'py>,
        lidar: Option<&Lidar>,
        ideal: bool,
        surfaces: bool,
        sample: u64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let spec = lidar.map(|l| &l.spec);
        let scan = self.with(py, |scene| {
            if !ideal && surfaces {
                let mut spec = spec.unwrap_or(scene.rig().lidar()).clone();
                spec.records_surfaces = true;
                return scene.scan(Some(&spec), sample);
            }
            if !ideal {
                return scene.scan(spec, sample);
            }
            let spec = spec.unwrap_or(scene.rig().lidar()).clone().at_time(scene.time_s());
            let scan = scene.ideal_scan(Some(&spec));
            let posed = scene.triangles();
            let (ring, column) = spec.beam_numbers();
            Ok(Scan {
                points_velo: scan.points_velo(&spec),
                ring,
                column,
                semantic: scan.semantic(&posed),
                echo: scan.range_m.iter().map(|r| u8::from(r.is_finite())).collect(),
                surface: Vec::new(),
                range_m: scan.range_m.iter().map(|r| f64::from(*r)).collect(),
                actor_id: scan.actor_id,
                firing_times_s: vec![0.0; spec.num_columns()],
            })
        })?;
        scan_to_dict(py, scan)
    }

    fn cast_rays<'py>(
        &self,
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
        let hits = self.with_pauses(py, |scene| {
            let mut hits = Vec::with_capacity(rays.len());
            for part in rays.chunks(RAYS_BETWEEN_PAUSES) {
                hits.extend(scene.cast_rays(part)?);
                guard::handle_signals()?;
            }
            Ok(hits)
        })?;
        let range = hits.iter().map(|h| h.as_ref().map_or(f64::INFINITY, |h| h.range_m)).collect();
        let actor = hits.iter().map(|h| h.as_ref().map_or(-1, |h| h.actor_id)).collect();
        let normals: Vec<_> =
            hits.iter().map(|h| h.as_ref().map_or([f64::NAN; 3], |h| h.normal_world.to_array())).collect();
        Ok((PyArray1::from_vec(py, range), PyArray1::from_vec(py, actor), arrays::rows(py, normals)))
    }

    fn triangles<'py>(&self, py: Python<'py>) -> Result<Triangles<'py>, BorderError> {
        let (vertices, faces, actor_ids) = self.with(py, |scene| {
            let posed = scene.triangles();
            let all = posed.indexed_triangles();
            let vertices = all.vertices.iter().map(|v| v.to_array()).collect();
            let actor_ids = all.owners.iter().map(|(index, _)| posed.instances[*index as usize].actor_id).collect();
            Ok((vertices, all.faces, actor_ids))
        })?;
        Ok((arrays::rows(py, vertices), arrays::rows(py, faces), PyArray1::from_vec(py, actor_ids)))
    }

    fn sensor_poses<'py>(&self, py: Python<'py>) -> Result<Poses<'py>, BorderError> {
        let (velo, cam) = self.with(py, |scene| Ok((scene.world_from_velo(), scene.world_from_cam())))?;
        Ok((arrays::pose(py, &velo), arrays::pose(py, &cam)))
    }
}

impl Scene {
    /// Lets the core work on the scene without the interpreter's lock, if no other thread does.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut core::Scene) -> cadet_core::Result<T> + Send,
    ) -> Result<T, BorderError> {
        self.with_pauses(py, |scene| Ok(work(scene)?))
    }

    /// Does the same for work that lets signals end it now and then.
    fn with_pauses<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut core::Scene) -> Result<T, BorderError> + Send,
    ) -> Result<T, BorderError> {
        guard::detached(py, || {
            let mut scene = self.inner.try_lock().map_err(|error| {
                BorderError::Unusable(match error {
                    TryLockError::WouldBlock => {
                        "scene: another thread is using it; give each thread its own, or let them take turns"
                    }
                    TryLockError::Poisoned(_) => "scene: it can't be used after an internal error; make a new one",
                })
            })?;
            work(&mut scene)
        })
    }
}
