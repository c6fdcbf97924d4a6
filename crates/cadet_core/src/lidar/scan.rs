//! One turn of the LIDAR: exact, or as the sensor reports it.

use super::air::Air;
use super::returns::{Draws, Surface, receive};
use super::spec::LidarSpec;
use crate::error::Result;
use crate::math::{self, DPose3, DVec3};
use crate::rng::Stream;
use crate::sense::{Hits, Layer, NO_HIT, PosedInstance, PosedScene, cast};
use crate::weather::Weather;

/// What every beam meets first, in the order of [`LidarSpec::rays`]: every triangle opaque, no limits, no noise.
#[derive(Debug, Clone, PartialEq)]
pub struct IdealScan {
    /// Range from the beam's own origin, infinite for a miss.
    pub range_m: Vec<f32>,
    /// Index into [`PosedScene::instances`], [`NO_HIT`] for a miss.
    pub instance: Vec<u32>,
    /// Face of the instance's mesh, [`NO_HIT`] for a miss.
    pub face: Vec<u32>,
    /// -1 for a miss, 0 for the static world, at least 1 for actors.
    pub actor_id: Vec<i32>,
}

/// The returns of one turn: ring-major, azimuth rising counter-clockwise from forward. All arrays have one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scan {
    /// x, y, z in metres, rounded to 1 mm, and intensity in 0..=0.99, rounded to 0.01.
    pub points_velo: Vec<[f32; 4]>,
    /// Ring of each return.
    pub ring: Vec<i32>,
    /// Column of each return.
    pub column: Vec<i32>,
    /// 0 for the static world and the air, at least 1 for actors.
    pub actor_id: Vec<i32>,
    /// Range from the laser's own origin, before rounding.
    pub range_m: Vec<f64>,
}

/// Casts every beam of the sensor at once.
#[must_use]
pub fn ideal_scan(scene: &PosedScene, world_from_velo: &DPose3, spec: &LidarSpec) -> IdealScan {
    let mut hits = Hits::new(spec.rings().len(), spec.azimuths_rad().len());
    cast(scene, &spec.grid(*world_from_velo), Layer::All, |_| true, &mut hits);
    let actor_id =
        hits.instance.iter().map(|i| if *i == NO_HIT { -1 } else { scene.instances[*i as usize].actor_id }).collect();
    IdealScan { range_m: hits.depth, instance: hits.instance, face: hits.face, actor_id }
}

/// One turn as the sensor reports it. Every beam draws the same count of numbers from `stream`, whatever it meets.
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
    spec.check()?;
    let grid = spec.grid(*world_from_velo);
    let (rows, columns) = (spec.rings().len(), spec.azimuths_rad().len());
    let mut solid = Hits::new(rows, columns);
    // What lies beyond the longest range that is kept is never reported.
    let sensor_world = world_from_velo.translation;
    let lasers_m = spec.rings().iter().map(|r| r.height_m.abs()).fold(0.0, f64::max);
    let reach_m = spec.max_range_m + lasers_m + 1.0;
    let in_range = |i: &PosedInstance| (i.center_world - sensor_world).length() - i.radius_m < reach_m;
    cast(scene, &grid, Layer::Opaque, in_range, &mut solid);
    // Only panes in front of what is solid matter: they alone replace it.
    let mut first = solid.clone();
    cast(scene, &grid, Layer::Glass, in_range, &mut first);

    let air = Air::new(weather);
    let mut out = Scan::default();
    let (mut behind, mut in_front) = (Surfaces::new(scene), Surfaces::new(scene));
    for (ring, laser) in spec.rings().iter().enumerate() {
        let (cos, sin) = (math::cos(laser.elevation_rad), math::sin(laser.elevation_rad));
        let gain = spec.laser_gains[ring];
        let is_blind = spec.blind_columns(ring);
        for (column, heading) in spec.headings(ring).iter().enumerate() {
            let draws = Draws::new(stream);
            if is_blind[column] {
                continue;
            }
            let at = ring * columns + column;
            let direction_velo = DVec3::new(cos * heading[0], cos * heading[1], sin);
            let direction_world = world_from_velo.rotation * direction_velo;
            let is_pane = (first.instance[at], first.face[at]) != (solid.instance[at], solid.face[at]);
            let pane = if is_pane { in_front.at(&first, at, direction_world) } else { None };
            let behind = behind.at(&solid, at, direction_world);
            let Some(found) = receive(pane, behind, &air, gain, spec.range_noise_m, &draws) else {
                continue;
            };
            let p = direction_velo * found.range_m + DVec3::new(0.0, 0.0, laser.height_m);
            let [x, y, z] = p.to_array().map(|v| (round(v * 1e3) / 1e3) as f32);
            // What is kept is judged by the written point, from the frame's origin, as in KITTI's files.
            let written_m = DVec3::new(x.into(), y.into(), z.into()).length();
            if !(spec.min_range_m..spec.max_range_m).contains(&written_m) {
                continue;
            }
            let intensity = (round(found.intensity * 1e2).clamp(0.0, 99.0) / 1e2) as f32;
            out.points_velo.push([x, y, z, intensity]);
            out.ring.push(ring as i32);
            out.column.push(column as i32);
            out.actor_id.push(found.actor_id);
            out.range_m.push(found.range_m);
        }
    }
    Ok(out)
}

/// The surfaces that beams meet. Neighbours often meet the same face, so the last one is remembered.
struct Surfaces<'a> {
    scene: &'a PosedScene,
    last: (u32, u32),
    normal_world: DVec3,
}

impl<'a> Surfaces<'a> {
    fn new(scene: &'a PosedScene) -> Self {
        Self { scene, last: (NO_HIT, NO_HIT), normal_world: DVec3::ZERO }
    }

    fn at(&mut self, hits: &Hits, at: usize, direction_world: DVec3) -> Option<Surface<'a>> {
        let (instance, face) = (hits.instance[at], hits.face[at]);
        if instance == NO_HIT {
            return None;
        }
        if self.last != (instance, face) {
            let [a, b, c] = self.scene.corners(instance, face).map(|p| p.as_dvec3());
            self.normal_world = (b - a).cross(c - a).normalize_or_zero();
            self.last = (instance, face);
        }
        let posed = &self.scene.instances[instance as usize];
        Some(Surface {
            range_m: f64::from(hits.depth[at]),
            cos_incidence: self.normal_world.dot(direction_world).abs().min(1.0),
            material: posed.material(face),
            actor_id: posed.actor_id,
        })
    }
}

/// The nearest whole number, for numbers below 2^51: adding 1.5 * 2^52 leaves no place for a fraction. Without SSE 4.1
/// `round` is a call.
fn round(x: f64) -> f64 {
    const NO_FRACTION: f64 = 6_755_399_441_055_744.0;
    (x + NO_FRACTION) - NO_FRACTION
}
