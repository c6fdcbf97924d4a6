//! One scan of the LIDAR: exact, or as the sensor reports it.
//!
//! A scan is made in steps: casting says what beams meet (`casting`, `in_motion`), surfaces are looked up (`surfaces`),
//! beams at depth edges are split (`divergence`), halos are added (`blooming`), what arrives is found (`returns`, `air`), and
//! the receiver writes points (`echo_batch`).

use std::sync::Arc;

use crate::lidar::air::{Air, Plumes, Sprayed};
use crate::lidar::casting::{Casting, SceneInMotion, StillCasting};
use crate::lidar::echoes::{Blooming, Draws, SurfaceLookup, echoes_of, first_echo};
use crate::lidar::returns::{EchoBatch, Scan, arrivals};
use crate::lidar::sensor::{BeamLine, LidarSpec};
use crate::sense::{Hits, PosedScene, RayCaster, SurfaceFilter, cast};
use crate::spray::Spray;
use crate::weather::Weather;
use cadet_base::error::Result;
use cadet_base::material::Semantic;
use cadet_base::math::{DPose3, DVec3};
use cadet_base::rng::Stream;

/// What every beam meets first, in the order of [`LidarSpec::rays`]: every triangle opaque, no limits, no noise.
#[derive(Debug, Clone, PartialEq)]
pub struct IdealScan {
    /// Range from the beam's own origin, infinite for a miss.
    pub range_m: Vec<f32>,
    /// Index into [`PosedScene::instances`], [`NO_HIT`](crate::sense::NO_HIT) for a miss.
    pub instance: Vec<u32>,
    /// Face of the instance's mesh, [`NO_HIT`](crate::sense::NO_HIT) for a miss.
    pub face: Vec<u32>,
    /// -1 for a miss, 0 for the static world, at least 1 for actors.
    pub actor_id: Vec<i32>,
}

impl IdealScan {
    /// What each beam meets, [`Semantic::Sky`] for a miss; `scene` is the one that was scanned.
    #[must_use]
    pub fn semantic(&self, scene: &PosedScene) -> Vec<Semantic> {
        let of = |(instance, face): (&u32, &u32)| {
            scene.instances.get(*instance as usize).map_or(Semantic::Sky, |posed| posed.material(*face).semantic)
        };
        self.instance.iter().zip(&self.face).map(of).collect()
    }

    /// Where each beam ends, x, y, z in meters in the velo frame, and an intensity of 0; four NaN for a miss.
    ///
    /// # Panics
    /// With another sensor than the scan's.
    #[must_use]
    pub fn points_velo(&self, spec: &LidarSpec) -> Vec<[f32; 4]> {
        let mut points = Vec::with_capacity(self.range_m.len());
        assert_eq!(self.range_m.len(), spec.num_beams(), "as many ranges as beams");
        for (ring, ranges_m) in self.range_m.chunks_exact(spec.num_columns()).enumerate() {
            let beam = spec.beams(ring);
            let point = |(column, range_m): (usize, &f32)| {
                let BeamLine { origin_velo, direction_velo } = beam(column);
                let p = origin_velo + direction_velo * f64::from(*range_m);
                if *range_m < f32::INFINITY { [p.x as f32, p.y as f32, p.z as f32, 0.0] } else { [f32::NAN; 4] }
            };
            points.extend(ranges_m.iter().enumerate().map(point));
        }
        points
    }
}

/// Casts every beam of the sensor at once, all from one pose: an ideal sensor neither turns nor spreads its beams.
///
/// ```
/// use std::sync::Arc;
///
/// use cadet_base::{frames, math::DVec3};
/// use cadet_sensors::lidar::{LidarSpec, ideal_scan};
/// use cadet_sensors::sense::PosedScene;
/// use cadet_town::Town;
///
/// let scene = Arc::new(PosedScene::new(&Town::flat().scenery, DVec3::ZERO));
/// let lidar = LidarSpec::hdl64e_kitti();
/// let world_from_velo = frames::mounted(DVec3::new(0.0, 0.0, 1.73), 0.0, 0.0, 0.0);
/// let scan = ideal_scan(&scene, &world_from_velo, &lidar);
///
/// assert_eq!(scan.range_m.len(), lidar.num_beams());
/// // The lowest laser meets the road some meters ahead, the highest one the sky.
/// let lowest = 63 * lidar.num_columns();
/// assert!(scan.range_m[0].is_infinite() && (3.0..6.0).contains(&scan.range_m[lowest]));
/// ```
#[must_use]
pub fn ideal_scan(scene: &Arc<PosedScene>, world_from_velo: &DPose3, spec: &LidarSpec) -> IdealScan {
    let mut hits = Hits::new(spec.rings().len(), spec.num_columns());
    match spec.grid(*world_from_velo) {
        Some(grid) => cast(scene, &grid, SurfaceFilter::All, |_| true, &mut hits),
        None => {
            let rays = spec.rays();
            let beams = rays.origins_velo.iter().zip(&rays.directions_velo);
            let beams_world = beams.map(|(o, d)| [world_from_velo.transform_point(*o), world_from_velo.rotation * *d]);
            RayCaster::new(Arc::clone(scene)).cast_beams(beams_world, &mut hits);
        }
    }
    // Close together, so that looking them up costs nothing.
    let actors: Vec<i32> = scene.instances.iter().map(|i| i.actor_id).collect();
    let actor_id = hits.instance.iter().map(|i| actors.get(*i as usize).copied().unwrap_or(-1)).collect();
    IdealScan { range_m: hits.depth_m, instance: hits.instance, face: hits.face, actor_id }
}

/// One turn as the sensor reports it, all of it at one instant. The beams' random numbers follow from one of
/// `stream`'s.
///
/// # Errors
/// What [`LidarSpec::check`] finds.
pub fn scan(
    scene: &PosedScene,
    world_from_velo: &DPose3,
    spec: &LidarSpec,
    weather: &Weather,
    stream: &mut Stream,
) -> Result<Scan> {
    scan_through(scene, world_from_velo, spec, (weather, &Spray::default()), stream)
}

/// One turn as [`scan()`] takes it, through the spray behind vehicles.
///
/// # Errors
/// What [`LidarSpec::check`] finds.
pub fn scan_through(
    scene: &PosedScene,
    world_from_velo: &DPose3,
    spec: &LidarSpec,
    air: (&Weather, &Spray),
    stream: &mut Stream,
) -> Result<Scan> {
    spec.check()?;
    Ok(scan_by(&StillCasting::new(scene, world_from_velo, spec)?, spec, air, stream))
}

/// One scan as the sensor reports it while it and the world move; spray hangs in the air meanwhile. Every beam draws the same
/// numbers as in [`scan`].
///
/// # Errors
/// What [`LidarSpec::check`] finds.
pub fn scan_in_motion(
    scene: &SceneInMotion,
    spec: &LidarSpec,
    air: (&Weather, &Spray),
    stream: &mut Stream,
) -> Result<Scan> {
    spec.check()?;
    Ok(scan_by(&scene.firings(spec), spec, air, stream))
}

/// A vector turned about z, counter-clockwise.
#[inline(always)]
fn turned(v: DVec3, [cos, sin]: [f64; 2]) -> DVec3 {
    DVec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z)
}

/// The air as each ring sees it: one for all lasers of one focus.
fn airs(spec: &LidarSpec, weather: &Weather) -> Vec<Arc<Air>> {
    let mut airs: Vec<Arc<Air>> = Vec::with_capacity(spec.rings().len());
    for (ring, laser) in spec.laser_receivers.iter().enumerate() {
        let known = spec.laser_receivers[..ring].iter().position(|other| other.focus_m == laser.focus_m);
        let air = || Arc::new(Air::new(weather, spec.receiver(), laser.focus_m));
        airs.push(known.map_or_else(air, |other| Arc::clone(&airs[other])));
    }
    airs
}

fn scan_by<C: Casting>(
    casting: &C,
    spec: &LidarSpec,
    (weather, spray): (&Weather, &Spray),
    stream: &mut Stream,
) -> Scan {
    let met = casting.cast(spec);
    let (edges, split) = match spec.divergent() {
        None => Default::default(),
        Some(divergent) => {
            let edges = divergent.edge_beams(&met.opaque);
            let split = casting.cast_sub_beams(spec, divergent, &edges);
            (edges, split)
        }
    };
    let blooming = Blooming::of(casting, spec, &met);
    let mut split_beams = edges.iter().map(|beam| *beam as usize).zip(&split).peekable();
    let receiver = spec.receiver();
    let airs = airs(spec, weather);
    let pulse_m = receiver.pulse_m();
    let plumes = Plumes::about(spray, casting.place_world(0, DVec3::ZERO), receiver);
    let snow_cover = weather.snow_cover();
    let surfaces = SurfaceLookup::new(casting, snow_cover, spec.records_surfaces);
    let mut out = Scan::of_turn(spec);
    let mut batch = EchoBatch::new();
    let scan_key = stream.next_u64();
    let mut beams = 0..;
    for (ring, laser) in spec.rings().iter().enumerate() {
        let beam_of = spec.beams(ring);
        let first_return = out.range_m.len();
        let is_blind = spec.blind_columns(ring);
        let receiver = &spec.ring_receiver(ring);
        let air = &airs[ring];
        for (column, is_blind) in is_blind.iter().enumerate() {
            let beam = beams.next().expect("endless");
            let draws = Draws::new(scan_key, beam);
            let quarters = split_beams.next_if(|(edge, _)| *edge == beam);
            if *is_blind {
                continue;
            }
            let BeamLine { origin_velo, direction_velo } = beam_of(column);
            let transparent = met.transparent(beam).and_then(|p| surfaces.at(p, column, origin_velo, direction_velo));
            let mut echoes = if let Some((_, quarters)) = quarters {
                let quarters = quarters
                    .map(|q| first_echo(transparent, surfaces.at(q, column, origin_velo, direction_velo), &draws));
                echoes_of(quarters, pulse_m)
            } else {
                let opaque = surfaces.at(met.opaque(beam), column, origin_velo, direction_velo);
                [first_echo(transparent, opaque, &draws), None, None, None]
            };
            if let Some(blooming) = &blooming {
                blooming.join(&mut echoes, casting, &met.opaque, beam);
            }
            let sprayed = |range_m| {
                if plumes.is_empty() {
                    return Sprayed::NOT;
                }
                let [origin, ahead] =
                    [origin_velo, origin_velo + direction_velo].map(|place| casting.place_world(column, place));
                plumes.meet(origin, ahead - origin, range_m, receiver.laser.focus_m, draws.air_key())
            };
            let turn = spec.reporting_turns()[column];
            arrivals(&echoes, air, sprayed, (spec.returns, receiver, &draws), |arrival| {
                let reported = [origin_velo, direction_velo].map(|v| turned(v, turn).to_array());
                batch.push(arrival, &draws, column, reported);
                if batch.is_full() {
                    batch.receive(receiver, ring, spec.records_surfaces, &mut out);
                }
            });
        }
        batch.receive(receiver, ring, spec.records_surfaces, &mut out);
        if laser.left_m != 0.0 {
            out.order_by_azimuth(first_return);
        }
    }
    out
}
