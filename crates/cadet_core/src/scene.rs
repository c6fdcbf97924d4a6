//! A scene: a town with its traffic, its weather and a sensor rig. What Python drives.

use std::sync::Arc;

use crate::actor::ObjectClass;
use crate::assets::vehicle::UserVehicles;
use crate::camera::{Rendered, Seen, View, look, paint};
use crate::error::{Error, Result, finite};
use crate::label::{Boxes, LabelConfig, Labeled, TakenView, add_points, label_actors, may_label, road_plane_cam};
use crate::lidar::{IdealScan, LidarSpec, Scan, Turning, ideal_scan, scan, turning_scan};
use crate::math::{DPose3, DVec3, TAU};
use crate::rig::Rig;
use crate::rng::StreamKey;
use crate::sense::{FaceTrees, Motion, PosedScene, RayCaster, RayHit, Resolution};
use crate::town::{DressingConfig, GroundKind, SuburbConfig, Town};
use crate::weather::Weather;
use crate::world::{Course, ModelChoice, Overlap, Snapshot, TrafficConfig, World};

/// Where a scene's town comes from.
#[derive(Debug, Clone)]
pub enum TownSource {
    /// Generated from the scene's key.
    Suburb,
    /// An OpenDRIVE text, dressed from the scene's key.
    OpenDrive {
        /// The map's name, for messages and metadata.
        name: String,
        /// The whole `.xodr` text.
        text: String,
    },
    /// A plain square with a straight road, for scripted scenes.
    Flat,
}

/// Numbers of a scene.
#[derive(Debug, Clone, Default)]
pub struct SceneConfig {
    /// The suburb generator's.
    pub suburb: SuburbConfig,
    /// The dressing's.
    pub dressing: DressingConfig,
    /// The traffic's.
    pub traffic: TrafficConfig,
    /// The labels'.
    pub label: LabelConfig,
    /// A user's own vehicles.
    pub user_vehicles: UserVehicles,
}

/// Everything that the rig sees at one instant.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Image, depth, instance and semantic maps.
    pub rendered: Rendered,
    /// The scan.
    pub scan: Scan,
    /// Labels: objects by rising actor id, then `DontCare` by rising actor id.
    pub labels: Vec<Labeled>,
    /// Which boxes the labels hold.
    pub boxes: Boxes,
    /// The road's plane in the frame of camera 0.
    pub plane: [f64; 4],
    /// Seconds since the scene's start.
    pub time_s: f64,
    /// The ego's pose.
    pub world_from_ego: DPose3,
    /// The ego's speed.
    pub ego_speed_mps: f64,
}

/// The present instant: poses, triangles and, once asked for, parry's trees over them.
struct Sensed {
    snapshot: Arc<Snapshot>,
    posed: Arc<PosedScene>,
    caster: Option<RayCaster>,
}

/// A town, its traffic, its weather and a rig.
pub struct Scene {
    key: StreamKey,
    world: World,
    weather: Weather,
    rig: Rig,
    label: LabelConfig,
    /// The last view that [`Scene::capture_labelled`] took.
    taken: Option<TakenView>,
    /// The triangles of the present instant; dropped whenever the world moves.
    sensed: Option<Sensed>,
    /// parry's trees, kept from instant to instant.
    trees: FaceTrees,
}

/// Physics steps a second.
const STEPS_PER_S: f64 = 60.0;
/// How long a random scene settles before the first view.
const SETTLE_S: f64 = 2.0;
/// The longest time that one call may simulate.
const MAX_STEP_S: f64 = 3600.0;

impl Scene {
    /// A dressed town with traffic, settled for two seconds: a pure function of its arguments.
    ///
    /// # Errors
    /// A map that can't be read or driven, or numbers out of range.
    pub fn random(
        key: StreamKey,
        source: &TownSource,
        weather: Weather,
        rig: Rig,
        config: &SceneConfig,
    ) -> Result<Self> {
        let mut scene = Self::bare(key, source, weather, rig, config)?;
        scene.weather = scene.weather.with_sun_turned(&mut key.stream("sun"));
        scene.world.spawn_traffic(&config.traffic)?;
        scene.step(SETTLE_S)?;
        Ok(scene)
    }

    /// A town without traffic, the ego at the start of a lane: for scripted scenes.
    ///
    /// # Errors
    /// A map that can't be read or driven, or numbers out of range.
    pub fn empty(source: &TownSource, weather: Weather, rig: Rig, config: &SceneConfig) -> Result<Self> {
        Self::bare(StreamKey::scene(0), source, weather, rig, config)
    }

    fn bare(key: StreamKey, source: &TownSource, weather: Weather, rig: Rig, config: &SceneConfig) -> Result<Self> {
        let town = match source {
            TownSource::Suburb => Town::suburb(&key, &config.suburb, &config.dressing)?,
            TownSource::OpenDrive { name, text } => Town::from_opendrive(&key, name, text, &config.dressing)?,
            TownSource::Flat => Town::flat(),
        };
        let world = World::new(Arc::new(town), key)?.with_user_vehicles(config.user_vehicles.clone());
        Ok(Self {
            key,
            world,
            weather,
            rig,
            label: config.label.clone().validated()?,
            taken: None,
            sensed: None,
            trees: FaceTrees::default(),
        })
    }

    /// The place, its map's name and what its map's reader passed over.
    #[must_use]
    pub fn town(&self) -> &Town {
        self.world.town()
    }

    /// The weather.
    #[must_use]
    pub fn weather(&self) -> &Weather {
        &self.weather
    }

    /// The rig.
    #[must_use]
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Seconds since the start.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.world.time_s()
    }

    /// Adds an actor that stands on the ground or follows a script, and returns its id.
    ///
    /// # Errors
    /// As [`World::add`].
    pub fn add(
        &mut self,
        class: ObjectClass,
        model: ModelChoice<'_>,
        course: &Course,
        overlap: Overlap,
    ) -> Result<i32> {
        self.sensed = None;
        self.world.add(class, model, course, overlap)
    }

    /// Puts the ego on the ground at a place, at rest.
    ///
    /// # Errors
    /// A place that is not finite, off the ground, or where somebody stands.
    pub fn move_ego(&mut self, x: f64, y: f64, yaw: f64, overlap: Overlap) -> Result<()> {
        self.sensed = None;
        self.world.move_ego(finite("x", x)?, finite("y", y)?, finite("yaw", yaw)?, overlap)
    }

    /// Lets physics run, in whole steps of 1/60 s.
    ///
    /// # Errors
    /// A time that is negative, not finite or longer than an hour.
    pub fn step(&mut self, seconds: f64) -> Result<()> {
        let seconds = in_range("seconds", seconds, 0.0, MAX_STEP_S)?;
        self.sensed = None;
        self.world.step((seconds * STEPS_PER_S).round() as u32);
        Ok(())
    }

    /// Drives until the ego has gone `distance_m` along its lane, or has stood for `blocked_s`.
    ///
    /// # Errors
    /// Numbers that are negative, not finite or too large.
    pub fn drive(&mut self, distance_m: f64, blocked_s: f64) -> Result<()> {
        let distance_m = in_range("distance_m", distance_m, 0.0, 1000.0)?;
        let blocked_s = in_range("blocked_s", blocked_s, 1.0 / STEPS_PER_S, MAX_STEP_S)?;
        self.sensed = None;
        let _ = self.world.drive(distance_m, blocked_s)?;
        Ok(())
    }

    fn sensed(&mut self) -> &mut Sensed {
        let world = &self.world;
        let resolution = resolution(&self.rig);
        self.sensed.get_or_insert_with(|| {
            let snapshot = Arc::new(world.snapshot());
            let viewer = snapshot.ego.world_from_ego.translation;
            let posed = Arc::new(PosedScene::for_resolution(&snapshot.instances, viewer, resolution));
            Sensed { snapshot, posed, caster: None }
        })
    }

    /// The world at the present instant.
    pub fn snapshot(&mut self) -> &Snapshot {
        &self.sensed().snapshot
    }

    /// The very triangles that the sensors see at the present instant.
    pub fn triangles(&mut self) -> Arc<PosedScene> {
        Arc::clone(&self.sensed().posed)
    }

    /// The poses of the LIDAR and of camera 0.
    pub fn sensor_poses(&mut self) -> (DPose3, DPose3) {
        let world_from_ego = self.snapshot().ego.world_from_ego;
        (self.rig.world_from_velo(&world_from_ego), self.rig.world_from_cam(&world_from_ego))
    }

    /// Everything that the rig sees now. `sample` names the random streams of noise; `with_maps` adds depth and identity
    /// to the image.
    ///
    /// # Errors
    /// [`Error::Scene`] where no ground lies ahead of the camera.
    pub fn capture(&mut self, sample: u64, with_maps: bool) -> Result<Frame> {
        let (view, seen, labels) = self.look()?;
        self.finish(sample, with_maps, &view, &seen, labels)
    }

    /// The same, or `None` where nothing in view gets a label (`DontCare` is none), or where neither the ego nor
    /// anything labelled has moved since the last view that this returned: much cheaper than a frame that is thrown
    /// away.
    ///
    /// # Errors
    /// As [`Scene::capture`].
    pub fn capture_labelled(&mut self, sample: u64, with_maps: bool) -> Result<Option<Frame>> {
        let (_, world_from_cam) = self.sensor_poses();
        let sensed = self.sensed();
        let actors = Arc::clone(&sensed.snapshot);
        if !may_label(&self.label, &actors.actors, &self.rig.camera, &world_from_cam) {
            return Ok(None);
        }
        let (view, seen, labels) = self.look()?;
        if !labels.iter().any(Labeled::is_object) {
            return Ok(None);
        }
        let (world_from_ego, width) = (self.snapshot().ego.world_from_ego, self.rig.camera.width);
        if self.taken.as_ref().is_some_and(|t| !t.ego_has_moved(&world_from_ego) && !t.object_has_moved(&labels, width))
        {
            return Ok(None);
        }
        let frame = self.finish(sample, with_maps, &view, &seen, labels)?;
        // The scan may have taken the last label away.
        if !frame.labels.iter().any(Labeled::is_object) {
            return Ok(None);
        }
        self.taken = Some(TakenView::new(world_from_ego, &frame.labels));
        Ok(Some(frame))
    }

    fn look(&mut self) -> Result<(View, Seen, Vec<Labeled>)> {
        let (_, world_from_cam) = self.sensor_poses();
        let (posed, snapshot) = (self.triangles(), Arc::clone(&self.sensed().snapshot));
        let view = View::new(&self.rig.camera, &world_from_cam);
        let seen = look(&posed, &view)?;
        let camera = &self.rig.camera;
        let extinction_per_m = self.weather.extinction_per_m();
        let labels =
            label_actors(&self.label, &snapshot.actors, &posed, camera, &world_from_cam, &seen, extinction_per_m);
        Ok((view, seen, labels))
    }

    fn finish(
        &mut self,
        sample: u64,
        with_maps: bool,
        view: &View,
        seen: &Seen,
        mut labels: Vec<Labeled>,
    ) -> Result<Frame> {
        let (_, world_from_cam) = self.sensor_poses();
        let (posed, snapshot) = (self.triangles(), Arc::clone(&self.sensed().snapshot));
        let (key, weather) = (self.key, &self.weather);
        let image = paint(&posed, view, weather, seen, &mut key.indexed("camera", sample));
        let rendered = Rendered { image, maps: with_maps.then(|| seen.maps(&posed)) };
        let scan = self.scan(None, sample)?;
        add_points(&self.label, &mut labels, &scan.actor_id);
        let ground = &self.world.town().ground;
        let plane = road_plane_cam(
            &world_from_cam,
            |p| ground.height_at(p.x, p.y).filter(|_| ground.kind_at(p.x, p.y) == Some(GroundKind::Road)),
            |p| ground.height_at(p.x, p.y),
        )
        .ok_or_else(|| Error::Scene { reason: "no ground ahead of the camera".to_owned() })?;
        Ok(Frame {
            labels,
            boxes: self.label.boxes,
            plane,
            time_s: snapshot.time_s,
            world_from_ego: snapshot.ego.world_from_ego,
            ego_speed_mps: snapshot.ego.velocity_world.length(),
            rendered,
            scan,
        })
    }

    /// A scan with returns, noise and weather, by `lidar` or by the rig's own.
    ///
    /// # Errors
    /// A LIDAR whose numbers make no sense.
    pub fn scan(&mut self, lidar: Option<&LidarSpec>, sample: u64) -> Result<Scan> {
        let (world_from_velo, _) = self.sensor_poses();
        let (posed, snapshot) = (self.triangles(), Arc::clone(&self.sensed().snapshot));
        let spec = lidar.unwrap_or(&self.rig.lidar);
        let mut stream = self.key.indexed("lidar", sample);
        if !spec.rolling {
            return scan(&posed, &world_from_velo, spec, &self.weather, &mut stream);
        }
        let of_ego = &snapshot.ego;
        let motion = |pose: &DPose3, velocity_world, angular_velocity_world| Motion {
            pivot_world: pose.translation,
            velocity_world,
            angular_velocity_world,
        };
        let ego = motion(&of_ego.world_from_ego, of_ego.velocity_world, of_ego.angular_velocity_world);
        // Actors stand in the order of their ids.
        let motion_of = |id: i32| match snapshot.actors.binary_search_by_key(&id, |a| a.id) {
            Ok(i) => {
                let actor = &snapshot.actors[i];
                motion(&actor.world_from_box, actor.velocity_world, actor.angular_velocity_world)
            }
            Err(_) => Motion::default(),
        };
        let turning = Turning::new(posed, &mut self.trees, spec, world_from_velo, ego, motion_of);
        let scan = turning_scan(&turning, spec, &self.weather, &mut stream);
        self.trees.forget_unused();
        scan
    }

    /// One row for each of the LIDAR's rays: every triangle opaque, nothing dropped.
    pub fn ideal_scan(&mut self, lidar: Option<&LidarSpec>) -> IdealScan {
        let (world_from_velo, _) = self.sensor_poses();
        let posed = self.triangles();
        ideal_scan(&posed, &world_from_velo, lidar.unwrap_or(&self.rig.lidar))
    }

    /// Casts arbitrary rays against the present instant, by parry.
    ///
    /// # Errors
    /// A ray that is not finite, or a direction of length 0.
    pub fn cast_rays(&mut self, rays_world: &[(DVec3, DVec3)]) -> Result<Vec<Option<RayHit>>> {
        let sensed = self.sensed();
        let caster = sensed.caster.get_or_insert_with(|| RayCaster::new(Arc::clone(&sensed.posed)));
        rays_world.iter().map(|(origin_world, direction_world)| caster.cast(*origin_world, *direction_world)).collect()
    }
}

fn in_range(what: &'static str, value: f64, lo: f64, hi: f64) -> Result<f64> {
    let value = finite(what, value)?;
    if (lo..=hi).contains(&value) {
        return Ok(value);
    }
    Err(Error::OutOfRange { what, value: value.to_string(), expected: format!("{lo:.3} to {hi}") })
}

/// The finest angle between a rig's pixels or beams.
fn resolution(rig: &Rig) -> Resolution {
    let azimuths_rad = rig.lidar.azimuths_rad();
    let (Some(first), Some(last)) = (azimuths_rad.first(), azimuths_rad.last()) else {
        return Resolution::of(rig.camera.intrinsics()[0], 1);
    };
    let step_rad = (last - first).abs() / (azimuths_rad.len() - 1).max(1) as f64;
    let beams_per_turn = if step_rad > 0.0 { TAU / step_rad } else { 1.0 };
    Resolution::of(rig.camera.intrinsics()[0], beams_per_turn.round() as usize)
}
