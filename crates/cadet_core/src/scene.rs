//! A scene: a town with its traffic, its weather and a sensor rig. What Python drives.

mod capture;

pub use capture::{CaptureRequest, CapturedFrame, Image, NamedScan};

use std::sync::Arc;

use cadet_assets::imported::UserModels;
use cadet_base::actor::{BrakesFor, ObjectClass};
use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{DPose3, DVec3, TAU};
use cadet_base::rng::StreamKey;
use cadet_sensors::camera::Gain;
use cadet_sensors::label::{LabelConfig, TakenView};
use cadet_sensors::lidar::{IdealScan, LidarSpec, ideal_scan};
use cadet_sensors::rig::Rig;
use cadet_sensors::sense::{FaceTrees, PosedScene, RayCaster, RayHit, Resolution};
use cadet_sensors::weather::{Sun, Weather};
use cadet_town::{PropConfig, SuburbConfig, Town};
use cadet_world::{Course, EgoCommand, ModelChoice, Overlap, Retouch, Shortfall, Snapshot, TrafficConfig, World};

/// Where a scene's town comes from.
#[derive(Debug, Clone)]
pub enum TownSource {
    /// Generated from the scene's key.
    Suburb,
    /// An OpenDRIVE text with props drawn from the scene's key.
    OpenDrive {
        /// The map's name, for messages and metadata.
        name: String,
        /// The whole `.xodr` text.
        text: String,
    },
    /// A plain square with a straight road, for scripted scenes.
    Flat,
}

/// What an ego does that has driven to the end of its road.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtRoadEnd {
    /// It stands there.
    Stand,
    /// It comes in at another place, as other traffic does.
    ComeInElsewhere,
}

/// Numbers of a scene.
#[derive(Debug, Clone, Default)]
pub struct SceneConfig {
    /// The suburb generator's.
    pub suburb: SuburbConfig,
    /// Those of prop placement.
    pub props: PropConfig,
    /// The traffic's.
    pub traffic: TrafficConfig,
    /// The labels'.
    pub label: LabelConfig,
    /// A user's own vehicles, people, and riders.
    pub user_models: UserModels,
    /// Where the sun stands.
    pub sun: Sun,
}

/// The present instant: poses, triangles and, once asked for, parry's trees over them.
struct Sensed {
    snapshot: Arc<Snapshot>,
    posed: Arc<PosedScene>,
    caster: Option<RayCaster>,
}

/// A town, its traffic, its weather and a rig.
///
/// ```
/// # use cadet_core::camera::CameraModel;
/// # use cadet_core::frames;
/// # use cadet_core::lidar::LidarSpec;
/// # use cadet_core::math::{DVec3, PI};
/// # use cadet_core::nalgebra::Matrix3x4;
/// # use cadet_core::rig::{Mount, Mounted, Rig};
/// use cadet_core::actor::ObjectClass;
/// use cadet_core::scene::{CaptureRequest, Scene, SceneConfig, TownSource};
/// use cadet_core::weather::Weather;
/// use cadet_core::world::{Course, ModelChoice, Overlap};
///
/// # let projection = Matrix3x4::new(300.0, 0.0, 160.0, 0.0, 0.0, 300.0, 60.0, 0.0, 0.0, 0.0, 1.0, 0.0);
/// # let sensor = CameraModel::new(320, 120, projection, None)?;
/// # let ego_from_cam = frames::mounted(DVec3::new(0.0, 0.0, 1.65), -PI / 2.0, 0.0, -PI / 2.0);
/// # let camera = Mounted { name: "front".to_owned(), sensor, mount: Mount::new(vec![ego_from_cam]) };
/// # let ego_from_velo = frames::mounted(DVec3::new(-0.3, 0.0, 1.73), 0.0, 0.0, 0.0);
/// # let mount = Mount::new(vec![ego_from_velo]);
/// # let lidar = Mounted { name: "top".to_owned(), sensor: LidarSpec::cadet(), mount };
/// # let rig = Rig::new("mine".to_owned(), vec![camera], vec![lidar])?;
/// // `rig` is made as in the example of `Rig`.
/// let weather = Weather::preset("clear_noon")?;
/// let mut scene = Scene::empty(&TownSource::Flat, weather, rig, &SceneConfig::default())?;
/// let place = Course::Stand { x_m: 20.0, y_m: 0.0, yaw_rad: 0.0 };
/// let car = scene.add(ObjectClass::Car, ModelChoice::Seed(3), &place, Overlap::Refuse)?;
///
/// let frame = scene.capture(&CaptureRequest::default())?;
/// assert_eq!((frame.images.len(), frame.scans.len()), (1, 1));
/// assert_eq!(frame.sightings()[0].actor_id, car);
/// # Ok::<_, cadet_core::Error>(())
/// ```
pub struct Scene {
    key: StreamKey,
    world: World,
    /// What of the traffic found no room.
    shortfalls: Vec<Shortfall>,
    weather: Weather,
    rig: Rig,
    label: LabelConfig,
    /// The last view that `Scene::capture_labeled` took.
    taken: Option<TakenView>,
    /// When the first camera took its last image, seconds, and with what gain; none once the scene was changed by hand.
    exposed: Option<(f64, Gain)>,
    /// The triangles of the present instant; dropped whenever the world moves.
    sensed: Option<Sensed>,
    /// parry's trees, kept from instant to instant.
    trees: FaceTrees,
}

/// Physics steps a second.
const STEPS_PER_S: f64 = 60.0;
/// How long a random scene settles before the first view.
const SETTLE_S: f64 = 2.0;
/// The longest time that one call may simulate, seconds.
pub const MAX_STEP_S: f64 = 3600.0;

impl Scene {
    /// A town with props and traffic, settled for two seconds: a pure function of its arguments.
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
        scene.weather = scene.weather.with_sun_turned(&mut key.stream("sun")).with_sun(&config.sun);
        scene.shortfalls = scene.world.spawn_traffic(&config.traffic)?;
        scene.step(SETTLE_S)?;
        Ok(scene)
    }

    /// A town without traffic, the ego at the start of a lane: for scripted scenes.
    ///
    /// # Errors
    /// A map that can't be read or driven, or numbers out of range.
    pub fn empty(source: &TownSource, weather: Weather, rig: Rig, config: &SceneConfig) -> Result<Self> {
        Self::bare(StreamKey::scene(0), source, weather.with_sun(&config.sun), rig, config)
    }

    fn bare(key: StreamKey, source: &TownSource, weather: Weather, rig: Rig, config: &SceneConfig) -> Result<Self> {
        config.sun.check()?;
        let town = match source {
            TownSource::Suburb => Town::suburb(&key, &config.suburb, &config.props)?,
            TownSource::OpenDrive { name, text } => Town::from_opendrive(&key, name, text, &config.props)?,
            TownSource::Flat => Town::flat(),
        };
        let world = World::new(Arc::new(town), key)?
            .with_user_models(config.user_models.clone())
            .with_lamps(weather.needs_lamps())
            .with_night(weather.is_night())
            .with_rain(weather.rain_mm_per_h > 0.0);
        Ok(Self {
            key,
            world,
            shortfalls: Vec::new(),
            weather,
            rig,
            label: config.label.clone().validated()?,
            taken: None,
            exposed: None,
            sensed: None,
            trees: FaceTrees::default(),
        })
    }

    /// The place, its map's name and what its map's reader passed over.
    #[must_use]
    pub fn town(&self) -> &Town {
        self.world.town()
    }

    /// What of the traffic found no room.
    #[must_use]
    pub fn shortfalls(&self) -> &[Shortfall] {
        &self.shortfalls
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
        (self.sensed, self.exposed) = (None, None);
        self.world.add(class, model, course, overlap)
    }

    /// Puts the ego on the ground at a place, at rest.
    ///
    /// # Errors
    /// A place that is not finite, off the ground, or where somebody stands.
    pub fn move_ego(&mut self, x: f64, y: f64, yaw_rad: f64, overlap: Overlap) -> Result<()> {
        (self.sensed, self.exposed) = (None, None);
        self.world.move_ego(finite("x", x)?, finite("y", y)?, finite("yaw", yaw_rad)?, overlap)
    }

    /// Shows an actor otherwise to all sensors from now on, while the world goes on as it was.
    ///
    /// # Errors
    /// As [`World::retouch`].
    pub fn retouch(&mut self, actor_id: i32, retouch: Retouch) -> Result<()> {
        self.sensed = None;
        self.world.retouch(actor_id, retouch)
    }

    /// Drives the ego by command from the next step on; `None` lets its driver drive.
    ///
    /// # Errors
    /// As [`World::command_ego`].
    pub fn command_ego(&mut self, command: Option<EgoCommand>) -> Result<()> {
        self.world.command_ego(command)
    }

    /// Lets physics run, in whole steps of 1/60 s; an ego at the end of its road stands there.
    ///
    /// # Errors
    /// A time that is negative, not finite or longer than an hour.
    pub fn step(&mut self, duration_s: f64) -> Result<()> {
        self.step_until(duration_s, AtRoadEnd::Stand, || Ok(()))
    }

    /// Lets physics run; `pause` is called after each simulated second and may end it there.
    ///
    /// # Errors
    /// As [`Self::step`], and what `pause` returns.
    pub fn step_until<E: From<Error>>(
        &mut self,
        duration_s: f64,
        at_road_end: AtRoadEnd,
        mut pause: impl FnMut() -> std::result::Result<(), E>,
    ) -> std::result::Result<(), E> {
        let seconds = in_range("seconds", duration_s, 0.0, MAX_STEP_S)?;
        self.sensed = None;
        let mut steps = (seconds * STEPS_PER_S).round() as u32;
        while steps > 0 {
            let now = steps.min(STEPS_PER_S as u32);
            match at_road_end {
                AtRoadEnd::Stand => self.world.step(now),
                AtRoadEnd::ComeInElsewhere => self.world.step_on(now),
            }
            steps -= now;
            pause()?;
        }
        Ok(())
    }

    /// Drives until the ego has gone `distance_m` along its lane, has stood for `blocked_s`, or has come to the end of its
    /// road.
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

    /// What the ego's driver brakes or waits for.
    #[must_use]
    pub fn ego_brakes_for(&self) -> Option<BrakesFor> {
        self.world.ego_brakes_for()
    }

    /// Whether the ego has come to where its road ends, so that it can't go on.
    #[must_use]
    pub fn ego_is_at_road_end(&self) -> bool {
        self.world.ego_is_at_road_end()
    }

    fn sensed(&mut self) -> &mut Sensed {
        let world = &self.world;
        let resolution = resolution(&self.rig);
        self.sensed.get_or_insert_with(|| {
            let snapshot = Arc::new(world.snapshot());
            let viewer = snapshot.ego.world_from_ego.translation;
            let posed = PosedScene::for_resolution(&snapshot.instances, viewer, resolution);
            let posed = Arc::new(posed.with_lamps(&snapshot.ego_lamps));
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

    /// The pose of the first LIDAR.
    pub fn world_from_velo(&mut self) -> DPose3 {
        let world_from_ego = self.snapshot().ego.world_from_ego;
        self.rig.world_from_velo(&world_from_ego)
    }

    /// The pose of the first camera's frame.
    pub fn world_from_cam(&mut self) -> DPose3 {
        let world_from_ego = self.snapshot().ego.world_from_ego;
        self.rig.world_from_cam(&world_from_ego)
    }

    /// One row for each of the LIDAR's rays: every triangle opaque, nothing dropped.
    pub fn ideal_scan(&mut self, lidar: Option<&LidarSpec>) -> IdealScan {
        let world_from_velo = self.world_from_velo();
        let posed = self.triangles();
        ideal_scan(&posed, &world_from_velo, lidar.unwrap_or(self.rig.lidar()))
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
    let focal_px = rig.cameras().iter().map(|c| c.sensor.intrinsics_px()[0]).fold(1.0, f64::max);
    let beams_per_turn = rig.lidars().iter().map(|l| beams_per_turn(&l.sensor)).max().unwrap_or(1);
    Resolution::of(focal_px, beams_per_turn)
}

fn beams_per_turn(lidar: &LidarSpec) -> usize {
    let step_rad = lidar.beam_step_rad();
    if step_rad > 0.0 { (TAU / step_rad).round() as usize } else { 1 }
}
