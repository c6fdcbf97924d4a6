//! Spray: the water that wheels throw up from wet roads, a plume behind each vehicle that drives fast; one for all sensors.

use std::ops::Range;

use crate::weather::Weather;
use cadet_base::actor::{ActorState, ObjectClass};
use cadet_base::math::{DPose3, DVec3, Vec3};
use cadet_base::rng::{CounterRng, Stream};

/// Below this speed tires leave the water on the road, m/s.
const ONSET_MPS: f64 = 8.0;
/// A plume is as long as the way of this time, up to a limit.
const HANGS_S: f64 = 1.0;
const LONGEST_M: f64 = 12.0;
/// Optical depth along a whole plume, on the road, of a car on a road under water, per (m/s)^2 above the onset's square.
const DEPTH_PER_MPS2: f64 = 0.0025;
/// The front of the car of that depth, width times height: spray of others is denser by the root of what theirs is of it, over
/// as much more of the road.
const CAR_FRONT_M2: f64 = 1.8 * 1.5;
/// Height of a plume over the vehicle's: of cars, and of what is as high as a truck.
const HEIGHTS: [(f64, f64); 2] = [(1.5, 0.80), (3.0, 1.0)];
/// Way behind the bumper over which a plume grows dense.
const RISE_M: f32 = 1.5;
/// Width at the bumper and at the end over the vehicle's, height at the bumper over that at the end.
const FIRST_WIDTH: f32 = 1.0;
const LAST_WIDTH: f32 = 1.5;
const FIRST_HEIGHT: f32 = 0.55;
/// Spray is lumpy: least and greatest density at the corners of cells, over the mean.
const LUMPS: Range<f64> = 0.1..1.9;
const CELLS: [usize; 3] = [12, 5, 3];
const CORNERS: usize = (CELLS[0] + 1) * (CELLS[1] + 1) * (CELLS[2] + 1);

/// The spray of a moment.
#[derive(Debug, Clone, Default)]
pub struct Spray {
    plumes: Vec<Plume>,
}

/// The spray behind one vehicle: half an ellipse on the road that widens backward.
#[derive(Debug, Clone)]
pub struct Plume {
    /// x forward, y left, z up, on the road below the middle of the rear bumper.
    world_from_plume: DPose3,
    plume_from_world: DPose3,
    length_m: f32,
    /// Half the vehicle's width, and the height at the end.
    half_width_m: f32,
    height_m: f32,
    /// Extinction where it is densest, 1/m, in the mean of its lumps.
    peak_per_m: f32,
    lumps: [f32; CORNERS],
}

impl Spray {
    /// The spray behind vehicles; none on roads that are dry or snowed on, nor where the rain has stopped.
    #[must_use]
    pub fn behind(weather: &Weather, actors: &[ActorState], stream: &mut Stream) -> Self {
        if weather.rain_mm_per_h <= 0.0 || weather.wetness <= 0.0 {
            return Self::default();
        }
        let seed = stream.next_u64();
        let lumps = |id: i32| {
            let mut rng = CounterRng::new(CounterRng::key(seed, [id as u64, 0, 0]));
            std::array::from_fn(|_| (LUMPS.start + (LUMPS.end - LUMPS.start) * rng.unit()) as f32)
        };
        Self { plumes: actors.iter().filter_map(|a| Plume::behind(a, weather.wetness, lumps)).collect() }
    }

    /// One plume a vehicle that has one, by rising id.
    #[must_use]
    pub fn plumes(&self) -> &[Plume] {
        &self.plumes
    }
}

/// Optical depth along a plume, on the road, behind a vehicle of a size.
fn depth_along(speed_mps: f64, wetness: f64, size_lwh: DVec3) -> f64 {
    let fast = (speed_mps * speed_mps - ONSET_MPS * ONSET_MPS).max(0.0);
    DEPTH_PER_MPS2 * fast * wetness * (size_lwh.y * size_lwh.z / CAR_FRONT_M2).sqrt()
}

/// The integral of a plume's density along its axis over the peak, meters.
fn length_of_peak(length_m: f32) -> f32 {
    let r = RISE_M / length_m;
    let after = 1.0 - r;
    length_m * (r / 2.0 - 2.0 * r * r / 3.0 + r * r * r / 4.0 + after * after * after / 3.0)
}

impl Plume {
    fn behind(actor: &ActorState, wetness: f64, lumps: impl Fn(i32) -> [f32; CORNERS]) -> Option<Self> {
        let has_tires =
            matches!(actor.class, ObjectClass::Car | ObjectClass::Van | ObjectClass::Truck | ObjectClass::Misc);
        let speed_mps = actor.velocity_world.dot(actor.world_from_box.rotation * DVec3::X);
        if !has_tires || speed_mps <= ONSET_MPS {
            return None;
        }
        let size = actor.size_lwh;
        let bumper = DPose3::from_translation(DVec3::new(-0.5 * size.x, 0.0, 0.0));
        let world_from_plume = actor.world_from_box * bumper;
        let length_m = (speed_mps * HANGS_S).min(LONGEST_M) as f32;
        let [(low_m, of_low), (high_m, of_high)] = HEIGHTS;
        let share = of_low + (of_high - of_low) * ((size.z - low_m) / (high_m - low_m)).clamp(0.0, 1.0);
        Some(Self {
            world_from_plume,
            plume_from_world: world_from_plume.inverse(),
            length_m,
            half_width_m: (0.5 * size.y) as f32,
            height_m: (share * size.z) as f32,
            peak_per_m: depth_along(speed_mps, wetness, size) as f32 / length_of_peak(length_m),
            lumps: lumps(actor.id),
        })
    }

    /// From the world to the frame of the plume: x forward, y left, z up, on the road below the middle of the rear bumper.
    #[must_use]
    pub fn plume_from_world(&self) -> &DPose3 {
        &self.plume_from_world
    }

    /// Back.
    #[must_use]
    pub fn world_from_plume(&self) -> &DPose3 {
        &self.world_from_plume
    }

    /// The lowest and the highest corner of the box that it fills, in its frame.
    #[must_use]
    pub fn bounds(&self) -> [Vec3; 2] {
        let half_m = LAST_WIDTH * self.half_width_m;
        [Vec3::new(-self.length_m, -half_m, 0.0), Vec3::new(0.0, half_m, self.height_m)]
    }

    /// The extinction at a place in its frame, 1/m.
    #[inline]
    #[must_use]
    pub fn extinction_per_m(&self, at: Vec3) -> f32 {
        let behind_m = -at.x;
        if behind_m <= 0.0 || behind_m >= self.length_m || at.z < 0.0 {
            return 0.0;
        }
        let u = behind_m / self.length_m;
        let aside = at.y / (self.half_width_m * (FIRST_WIDTH + (LAST_WIDTH - FIRST_WIDTH) * u));
        let up = at.z / (self.height_m * (FIRST_HEIGHT + (1.0 - FIRST_HEIGHT) * u * (2.0 - u)));
        let out2 = aside * aside + up * up;
        let edge = 1.0 - out2 * out2;
        if edge <= 0.0 {
            return 0.0;
        }
        let left = 1.0 - u;
        self.peak_per_m * (behind_m / RISE_M).min(1.0) * left * left * edge * edge * self.lump(u, at)
    }

    /// Its density over the mean, a share of its length behind the bumper.
    #[inline]
    fn lump(&self, u: f32, at: Vec3) -> f32 {
        let half_m = LAST_WIDTH * self.half_width_m;
        let places = [u, (at.y + half_m) / (2.0 * half_m), at.z / self.height_m];
        let mut first = [0; 3];
        let mut share = [0.0; 3];
        for k in 0..3 {
            let place = (places[k] * CELLS[k] as f32).clamp(0.0, CELLS[k] as f32);
            first[k] = (place as usize).min(CELLS[k] - 1);
            share[k] = place - first[k] as f32;
        }
        let across = CELLS[1] + 1;
        let of = |i: usize, j: usize| {
            let column = &self.lumps[((first[0] + i) * across + first[1] + j) * (CELLS[2] + 1) + first[2]..];
            column[0] + (column[1] - column[0]) * share[2]
        };
        let near = of(0, 0) + (of(0, 1) - of(0, 0)) * share[1];
        let far = of(1, 0) + (of(1, 1) - of(1, 0)) * share[1];
        near + (far - near) * share[0]
    }

    /// The part of a ray in its frame, `from + t direction` with 0 <= t < `end_m`, that is in the box which it fills.
    #[inline]
    #[must_use]
    pub fn crossing(&self, from: Vec3, direction: Vec3, end_m: f32) -> Option<[f32; 2]> {
        let [low, high] = self.bounds();
        let (mut enters, mut leaves) = (0.0_f32, end_m);
        for (from, direction, low, high) in [
            (from.x, direction.x, low.x, high.x),
            (from.y, direction.y, low.y, high.y),
            (from.z, direction.z, low.z, high.z),
        ] {
            if direction == 0.0 {
                if from < low || from > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - from) / direction, (high - from) / direction);
            enters = enters.max(a.min(b));
            leaves = leaves.min(a.max(b));
        }
        (enters < leaves).then_some([enters, leaves])
    }
}

#[cfg(test)]
pub(crate) mod tests;
