//! What a scene's rig sees: images, scans, and what is known of the agents in them.

use std::borrow::Cow;
use std::sync::Arc;

use super::Scene;
use cadet_base::actor::ActorState;
use cadet_base::error::{Error, Result};
use cadet_base::math::{self, DPose3, DVec2, DVec3, TAU};
use cadet_sensors::camera::{
    CameraModel, Fisheye, Foreground, LastGain, LensDrops, Maps, Metering, Motions, Moving, Precipitation, Rendered,
    SurfaceMapKinds, View, Visibility, render_fisheye, render_rolling, render_through, visibility_pass,
};
use cadet_sensors::label::{
    Boxes, PinholeLook, Sighting, TakenView, add_points, may_label, pixels_of_actors, road_plane_cam, sightings,
};
use cadet_sensors::lidar::{LidarSpec, Scan, SceneInMotion, scan_in_motion, scan_through};
use cadet_sensors::rig::{Mounted, Rig};
use cadet_sensors::sense::RigidMotion;
use cadet_sensors::spray::Spray;
use cadet_town::GroundKind;
use cadet_world::{EgoState, Snapshot};

/// Request for more than the first camera's image and the first LIDAR's scan. What is not asked for costs nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CaptureRequest {
    /// Names the random streams of noise.
    pub sample: u64,
    /// Depth, instances and classes with every image, and maps of surfaces; `None` for no map at all.
    pub maps: Option<SurfaceMapKinds>,
    /// The light of every image.
    pub with_radiance: bool,
    /// How much of each actor the images show together.
    pub with_pixels: bool,
    /// What every camera sees of actors, not the first one alone.
    pub with_all_sightings: bool,
    /// More cameras, by their place in [`Rig::cameras`](cadet_sensors::rig::Rig::cameras).
    pub cameras: Vec<usize>,
    /// More LIDARs, by their place in [`Rig::lidars`](cadet_sensors::rig::Rig::lidars).
    pub lidars: Vec<usize>,
}

/// An image with the maps that belong to it.
#[derive(Debug, Clone)]
pub struct Image {
    /// The camera's name.
    pub name: String,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Colors, and maps if asked for.
    pub rendered: Rendered,
    /// What the camera sees of actors, in its own frame: those with a label by rising id, then the others; `None` unless
    /// asked for. The first camera is always asked.
    pub sightings: Option<Vec<Sighting>>,
}

/// A scan with the name of its LIDAR.
#[derive(Debug, Clone)]
pub struct NamedScan {
    /// The LIDAR's name.
    pub name: String,
    /// Its returns.
    pub scan: Scan,
}

/// Everything that was asked for at one instant.
#[derive(Debug, Clone)]
pub struct CapturedFrame {
    /// Seconds since the scene's start.
    pub time_s: f64,
    /// The ego's pose.
    pub world_from_ego: DPose3,
    /// The ego's velocity, m/s.
    pub ego_velocity_world: DVec3,
    /// The ego's angular velocity, rad/s.
    pub ego_angular_velocity_world: DVec3,
    /// Every actor around the ego, by rising id.
    pub actors: Vec<ActorState>,
    /// Pixels of each actor's outline in the images together, and those that are seen; empty unless asked for.
    pub pixels: Vec<[f64; 2]>,
    /// Which boxes the sightings hold.
    pub boxes: Boxes,
    /// The road's plane in the first camera's frame.
    pub plane_cam: [f64; 4],
    /// The first camera's image, then the others in the order in which they were asked for.
    pub images: Vec<Image>,
    /// The first LIDAR's scan, then the others in the order in which they were asked for.
    pub scans: Vec<NamedScan>,
}

impl CapturedFrame {
    /// What the first camera sees of actors.
    #[must_use]
    pub fn sightings(&self) -> &[Sighting] {
        self.images[0].sightings.as_deref().unwrap_or_default()
    }
}

/// What a camera looks at, before light and color.
struct Looked {
    seen: Seen,
    /// `None` unless asked for.
    sightings: Option<Vec<Sighting>>,
}

/// What a camera sees.
enum Seen {
    Pinhole(View, Box<Visibility>),
    Fisheye(Arc<Fisheye>, Vec<(View, Visibility)>),
}

impl Scene {
    /// What the rig sees now.
    ///
    /// # Errors
    /// A sensor that the rig lacks; [`Error::Scene`] where no ground lies ahead of the first camera.
    pub fn capture(&mut self, request: &CaptureRequest) -> Result<CapturedFrame> {
        self.check(request)?;
        let looked = self.look(0, true)?;
        self.finish(request, looked)
    }

    /// Captures as [`Scene::capture`] does, or returns `None` where nothing in the first camera's view gets a label, or
    /// where neither the ego nor anything labeled has moved since the last view that this returned: much cheaper than a
    /// frame that is thrown away.
    ///
    /// # Errors
    /// As [`Scene::capture`].
    pub fn capture_labeled(&mut self, request: &CaptureRequest) -> Result<Option<CapturedFrame>> {
        self.check(request)?;
        let world_from_cam = self.world_from_cam();
        let snapshot = Arc::clone(&self.sensed().snapshot);
        if !may_label(&self.label, &as_labeled(&snapshot, &self.rig), self.rig.camera(), &world_from_cam) {
            return Ok(None);
        }
        let looked = self.look(0, true)?;
        let (world_from_ego, width, taken) = (snapshot.ego.world_from_ego, self.rig.camera().width, self.taken.clone());
        let is_new = |sightings: &[Sighting]| {
            let has_moved = |t: &TakenView| t.ego_has_moved(&world_from_ego) || t.object_has_moved(sightings, width);
            sightings.iter().any(|s| s.is_labeled) && taken.as_ref().is_none_or(has_moved)
        };
        if !is_new(looked.sightings.as_deref().unwrap_or_default()) {
            return Ok(None);
        }
        let frame = self.finish(request, looked)?;
        // The scan may have taken labels away.
        if !is_new(frame.sightings()) {
            return Ok(None);
        }
        self.taken = Some(TakenView::new(world_from_ego, frame.sightings()));
        Ok(Some(frame))
    }

    fn check(&self, request: &CaptureRequest) -> Result<()> {
        let counts = [
            ("camera", &request.cameras, self.rig.cameras().len()),
            ("LIDAR", &request.lidars, self.rig.lidars().len()),
        ];
        for (what, wanted, count) in counts {
            if let Some(index) = wanted.iter().find(|i| !(1..count).contains(*i)) {
                return Err(Error::OutOfRange {
                    what,
                    value: index.to_string(),
                    expected: format!("one of the rig's {count}, other than the first"),
                });
            }
        }
        Ok(())
    }

    /// What the camera at a place of the rig looks at; `with_sightings`: and what it sees of actors.
    fn look(&mut self, index: usize, with_sightings: bool) -> Result<Looked> {
        let (posed, snapshot) = (self.triangles(), Arc::clone(&self.sensed().snapshot));
        let Mounted { sensor, mount, .. } = &self.rig.cameras()[index];
        let world_from_cam = mount.world_from_sensor(&snapshot.ego.world_from_ego);
        let pinholes = sensor.pinholes(&world_from_cam);
        let see = |(camera, world_from_cam): &(CameraModel, DPose3)| {
            let view = View::new(camera, world_from_cam);
            visibility_pass(&posed, &view).map(|seen| (view, seen))
        };
        let mut sides = pinholes.iter().map(see).collect::<Result<Vec<_>>>()?;
        let sightings = with_sightings.then(|| {
            let (actors, air) = (as_labeled(&snapshot, &self.rig), self.weather.extinction_per_m());
            let both = pinholes.iter().zip(&sides);
            let looks = both.map(|((camera, world_from_cam), (_, seen))| PinholeLook { camera, world_from_cam, seen });
            let looks: Vec<_> = looks.collect();
            sightings(&self.label, &actors, &posed, sensor, &world_from_cam, &looks, air)
        });
        let seen = match sensor.fisheye() {
            Some(fisheye) => Seen::Fisheye(Arc::clone(fisheye), sides),
            None => {
                let (view, seen) = sides.swap_remove(0);
                Seen::Pinhole(view, Box::new(seen))
            }
        };
        Ok(Looked { seen, sightings })
    }

    fn finish(&mut self, request: &CaptureRequest, first: Looked) -> Result<CapturedFrame> {
        let snapshot = Arc::clone(&self.sensed().snapshot);
        let mut images = Vec::with_capacity(1 + request.cameras.len());
        let mut pixels = vec![[0.0; 2]; if request.with_pixels { snapshot.actors.len() } else { 0 }];
        let mut first = Some(first);
        // The error of the exposure is a rig's and an episode's: neither its images nor its cameras differ by it.
        let error = self.key.stream("exposure").clipped_normal(0.0, 1.0) as f32;
        let last = self.exposed.map(|(time_s, gain)| LastGain { gain, age_s: (snapshot.time_s - time_s) as f32 });
        let mut metering = Metering::Own { error, last };
        for index in std::iter::once(0).chain(request.cameras.iter().copied()) {
            // Each camera's memory serves the next one.
            let looked = first.take().map_or_else(|| self.look(index, request.with_all_sightings), Ok)?;
            if let (true, Seen::Pinhole(_, seen)) = (request.with_pixels, &looked.seen) {
                for (sum, more) in pixels.iter_mut().zip(self.pixels(index, seen)) {
                    *sum = [sum[0] + more[0], sum[1] + more[1]];
                }
            }
            let image = self.image(index, request, looked, metering)?;
            metering = Metering::Rig(image.rendered.gain);
            images.push(image);
        }
        self.exposed = Some((snapshot.time_s, images[0].rendered.gain));
        let mut scans = Vec::with_capacity(1 + request.lidars.len());
        for index in std::iter::once(0).chain(request.lidars.iter().copied()) {
            let (name, scan) = (self.rig.lidars()[index].name.clone(), self.turn(index, None, request.sample)?);
            scans.push(NamedScan { name, scan });
        }
        for sightings in images.iter_mut().filter_map(|image| image.sightings.as_mut()) {
            add_points(&self.label, sightings, &scans[0].scan.actor_id);
        }
        let labeled: Vec<i32> =
            images[0].sightings.iter().flatten().filter(|s| s.is_labeled).map(|s| s.actor_id).collect();
        self.world.note_labeled(&labeled);
        Ok(CapturedFrame {
            time_s: snapshot.time_s,
            world_from_ego: snapshot.ego.world_from_ego,
            ego_velocity_world: snapshot.ego.velocity_world,
            ego_angular_velocity_world: snapshot.ego.angular_velocity_world,
            actors: snapshot.actors.clone(),
            pixels,
            boxes: self.label.boxes,
            plane_cam: self.plane()?,
            images,
            scans,
        })
    }

    fn image(&mut self, index: usize, request: &CaptureRequest, looked: Looked, metering: Metering) -> Result<Image> {
        let (posed, snapshot) = (self.triangles(), Arc::clone(&self.sensed().snapshot));
        let Mounted { name, sensor, mount } = &self.rig.cameras()[index];
        let CameraModel { width, height, .. } = *sensor;
        let warp = sensor.warp();
        let mut stream = self.key.indexed(&stream_name("camera", index, name), request.sample);
        let drops_stream = &mut self.key.stream(&stream_name("lens drops", index, name));
        let foreground = Foreground {
            spray: self.spray(&snapshot, request.sample),
            precipitation: Precipitation::of(
                &self.weather,
                self.rig.cameras()[0].mount.world_from_sensor(&snapshot.ego.world_from_ego).translation,
                snapshot.ego.velocity_world - self.wind_world(),
                &mut self.key.indexed("precipitation", request.sample),
            ),
            lens_drops: LensDrops::at(&self.weather, snapshot.time_s, drops_stream),
            warp,
            development: sensor.development().clone(),
            with_radiance: request.with_radiance,
            metering,
        };
        let (camera, motion_of) = (motion_of_ego(&snapshot), |id| motion_of_actor(&snapshot, id));
        let world_from_cam = mount.world_from_sensor(&snapshot.ego.world_from_ego);
        let motions = Motions { camera, of_actor: &motion_of };
        let rendered = match looked.seen {
            Seen::Fisheye(fisheye, sides) => {
                let maps = request.maps.as_ref().map(|kinds| (kinds, &motions));
                let sensor = (sensor, &*fisheye, sides);
                render_fisheye(&posed, sensor, &world_from_cam, &self.weather, &foreground, maps, &mut stream)
            }
            Seen::Pinhole(..) if !sensor.is_instantaneous() => {
                let moving = Moving { scene: &posed, world_from_cam: &world_from_cam, camera, motion_of, foreground };
                render_rolling(&moving, sensor, &self.weather, request.maps.as_ref(), &mut stream)?
            }
            Seen::Pinhole(view, seen) => {
                let rendered = render_through(&posed, &view, &self.weather, &seen, &foreground, &mut stream);
                let maps = request.maps.map(|kinds| {
                    let surfaces = seen.surface_maps(&posed, |ray| sensor.pixel_of_ray(ray), &motions, &kinds);
                    Maps { surfaces, ..seen.maps(&posed) }.through(warp)
                });
                Rendered { maps, ..rendered }
            }
        };
        Ok(Image { name: name.clone(), width, height, rendered, sightings: looked.sightings })
    }

    /// The wind's velocity; its direction is drawn once a scene.
    fn wind_world(&self) -> DVec3 {
        let azimuth_rad = self.key.stream("wind").range(0.0, TAU);
        self.weather.wind_mps * DVec3::new(math::cos(azimuth_rad), math::sin(azimuth_rad), 0.0)
    }

    /// What vehicles throw up, the same for all sensors.
    fn spray(&self, snapshot: &Snapshot, sample: u64) -> Spray {
        Spray::behind(&self.weather, &snapshot.actors, &mut self.key.indexed("spray", sample))
    }

    fn pixels(&mut self, index: usize, seen: &Visibility) -> Vec<[f64; 2]> {
        let (posed, snapshot) = (self.triangles(), Arc::clone(&self.sensed().snapshot));
        let mounted = &self.rig.cameras()[index];
        let world_from_cam = mounted.mount.world_from_sensor(&snapshot.ego.world_from_ego);
        pixels_of_actors(&snapshot.actors, &posed, &mounted.sensor, &world_from_cam, seen)
    }

    fn plane(&mut self) -> Result<[f64; 4]> {
        let world_from_cam = self.world_from_cam();
        let ego_z_m = self.sensed().snapshot.ego.world_from_ego.translation.z;
        let ground = &self.world.town().ground;
        let surface_near = |p: DVec2| ground.surface_near(p.extend(ego_z_m));
        road_plane_cam(
            &world_from_cam,
            |p| surface_near(p).filter(|(_, kind)| *kind == GroundKind::Road).map(|(z, _)| z),
            |p| surface_near(p).map(|(z, _)| z),
        )
        .ok_or_else(|| Error::Scene { reason: "no ground ahead of the camera".to_owned() })
    }

    /// A scan with returns, noise and weather, by `lidar` or by the rig's first.
    ///
    /// # Errors
    /// A LIDAR whose numbers make no sense.
    pub fn scan(&mut self, lidar: Option<&LidarSpec>, sample: u64) -> Result<Scan> {
        self.turn(0, lidar, sample)
    }

    /// One turn of the LIDAR at a place of the rig, or of another one in that place.
    fn turn(&mut self, index: usize, in_its_place: Option<&LidarSpec>, sample: u64) -> Result<Scan> {
        let (posed, snapshot) = (self.triangles(), Arc::clone(&self.sensed().snapshot));
        let Mounted { name, sensor, mount } = &self.rig.lidars()[index];
        let world_from_velo = mount.world_from_sensor(&snapshot.ego.world_from_ego);
        let spec = in_its_place.unwrap_or(sensor);
        let mut stream = self.key.indexed(&stream_name("lidar", index, name), sample);
        let spray = self.spray(&snapshot, sample);
        let air = (&self.weather, &spray);
        if !spec.rolling && spec.spins() {
            return scan_through(&posed, &world_from_velo, spec, air, &mut stream);
        }
        let spec = &spec.clone().at_time(snapshot.time_s);
        let while_it_scans = |motion| if spec.rolling { motion } else { RigidMotion::default() };
        let motion_of = |id| while_it_scans(motion_of_actor(&snapshot, id));
        let ego = while_it_scans(motion_of_ego(&snapshot));
        let scene = SceneInMotion::new(posed, &mut self.trees, spec, world_from_velo, ego, motion_of);
        let scan = scan_in_motion(&scene, spec, air, &mut stream);
        self.trees.forget_unused();
        scan
    }
}

/// Every actor where its label's box stands: at the instant, or among the points of the first LIDAR's turn.
fn as_labeled<'a>(snapshot: &'a Snapshot, rig: &Rig) -> Cow<'a, [ActorState]> {
    let (lidar, ego) = (rig.lidar(), snapshot.ego.world_from_ego);
    if !lidar.rolling {
        return Cow::Borrowed(&snapshot.actors);
    }
    let (world_from_velo, sensor) = (rig.world_from_velo(&ego), motion_of_ego(snapshot));
    let seen = |actor: &ActorState| ActorState {
        world_from_box: lidar.seen_pose((&actor.world_from_box, &motion_of(actor)), (&world_from_velo, &sensor)),
        ..actor.clone()
    };
    snapshot.actors.iter().map(seen).collect()
}

fn motion_of_ego(snapshot: &Snapshot) -> RigidMotion {
    let EgoState { world_from_ego, velocity_world, angular_velocity_world } = snapshot.ego;
    RigidMotion { pivot_world: world_from_ego.translation, velocity_world, angular_velocity_world }
}

/// How the actor of an id moves.
fn motion_of_actor(snapshot: &Snapshot, id: i32) -> RigidMotion {
    // They stand in the order of their ids.
    snapshot
        .actors
        .binary_search_by_key(&id, |a| a.id)
        .map_or_else(|_| RigidMotion::default(), |i| motion_of(&snapshot.actors[i]))
}

fn motion_of(actor: &ActorState) -> RigidMotion {
    let ActorState { world_from_box, velocity_world, angular_velocity_world, .. } = *actor;
    RigidMotion { pivot_world: world_from_box.translation, velocity_world, angular_velocity_world }
}

/// The random stream of a sensor's noise: the first of a kind has the kind's own, so that more sensors change nothing.
fn stream_name(kind: &str, index: usize, name: &str) -> String {
    if index == 0 { kind.to_owned() } else { format!("{kind} {name}") }
}
