//! Drops and flakes that fall through the view while the shutter is open, those that are near enough to be seen one by one.
//!
//! All others dim and brighten the view as air does ([`crate::weather::Weather::extinction_per_m`]). What one looks like
//! follows Garg and Nayar, "Vision and Rain" (IJCV 2007): a streak as long as its way across the image, over which the
//! area of its disc is spread.

use std::ops::Range;

use super::compositing::blend;
use crate::camera::light::Light;
use crate::camera::visibility::{View, Visibility};
use crate::weather::{SizeDistribution, Weather};
use cadet_base::math::{self, DPose3, DVec3, Vec3};
use cadet_base::rng::{CounterRng, Stream, nearly_normal};

/// How long the shutter is open under a sky that rains or snows, s.
pub const SHUTTER_S: f64 = 0.005;
/// The lens's aperture, focused at infinity: what is near is blurred by it, m.
const APERTURE_M: f64 = 0.0012;
/// Particles are looked for up to this far away.
const REACH_M: f64 = 12.0;
/// The side of a cell of space whose particles are drawn together.
const CELL_M: f64 = 1.0;
/// No particle is looked for that is smaller on the image, at the near side of its cell, in a camera like KITTI's.
const LEAST_PX: f64 = 0.5;
const FOCAL_PX: f64 = 721.0;
/// Nor one that is smaller than this, however near, m.
const LEAST_DROP_M: f64 = 0.000_6;
const LEAST_FLAKE_M: f64 = 0.001;
/// Particles less than this far ahead of the optical center are a blur without a place.
const NEAREST_M: f64 = 0.2;
/// Flakes fall at 0.8 to 1.2 m/s and sway, one standard deviation.
const FLAKE_MPS: Range<f64> = 0.8..1.2;
const FLAKE_SWAY_MPS: f64 = 0.35;
/// A drop shows half of what is above it and half of what is below; a flake scatters what falls on it from both.
const FLAKE_ALBEDO: f32 = 0.9;

/// The rain or the snow of a moment, the same for every camera of a rig.
#[derive(Debug, Clone)]
pub struct Precipitation {
    sizes: SizeDistribution,
    is_snow: bool,
    seed: u64,
    /// Cells are sorted by their distance from here, so that all cameras of a rig see the same particles.
    center_world: DVec3,
    air_velocity_world: DVec3,
}

/// A drop or a flake.
#[derive(Debug, Clone, Copy)]
struct FallingParticle {
    at_world: DVec3,
    velocity_world: DVec3,
    diameter_m: f64,
}

/// Its way across the image.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Streak {
    /// Where it is when the shutter opens and closes: column, row.
    ends_px: [[f64; 2]; 2],
    width_px: f64,
    /// Share of the light that it takes and replaces where it passes.
    cover: f64,
    depth_m: f64,
}

/// Fall speed of a drop, m/s (Atlas, Srivastava and Sekhon 1973).
fn drop_mps(diameter_m: f64) -> f64 {
    (9.65 - 10.3 * math::exp(-600.0 * diameter_m)).max(0.1)
}

impl Precipitation {
    /// What falls about a place that moves, if anything does; the velocity is that of the cameras through the air.
    #[must_use]
    pub fn of(weather: &Weather, center_world: DVec3, air_velocity_world: DVec3, stream: &mut Stream) -> Option<Self> {
        let (drops, flakes) = (weather.drops(), weather.flakes());
        let is_snow = flakes.is_some();
        let sizes = flakes.or(drops)?;
        Some(Self { sizes, is_snow, seed: stream.next_u64(), center_world, air_velocity_world })
    }

    /// Draws what falls before the scene into linear radiance, interleaved RGB.
    pub(crate) fn draw(&self, rgb: &mut [f32], view: &View, seen: &Visibility, light: &Light) {
        let radiance = self.radiance(light);
        self.for_each_streak(view, |streak| {
            let [column, row] = [0, 1].map(|k| 0.5 * (streak.ends_px[0][k] + streak.ends_px[1][k]));
            let [column, row] = [column.clamp(0.0, view.width as f64 - 1.0), row.clamp(0.0, view.height as f64 - 1.0)];
            if f64::from(seen.depth_m_at(row as usize, column as usize)) > streak.depth_m {
                streak.draw(rgb, view, radiance);
            }
        });
    }

    fn radiance(&self, light: &Light) -> Vec3 {
        let (above, below) = (light.sky.sky_on_level, light.sky.ground);
        if self.is_snow { FLAKE_ALBEDO * (0.5 * above + 0.5 * above.min(3.0 * below)) } else { light.around() }
    }

    fn for_each_streak(&self, view: &View, mut use_it: impl FnMut(&Streak)) {
        let cam_from_world = view.world_from_cam.inverse();
        let center = (self.center_world / CELL_M).floor();
        let cells = (REACH_M / CELL_M) as i64;
        for i in -cells..=cells {
            for j in -cells..=cells {
                for k in -cells..=cells {
                    let low = (center + DVec3::new(i as f64, j as f64, k as f64)) * CELL_M;
                    if self.may_be_seen(view, &cam_from_world, low) {
                        self.for_each_in_cell(low, |particle| {
                            if let Some(streak) = self.streak(view, &cam_from_world, particle) {
                                use_it(&streak);
                            }
                        });
                    }
                }
            }
        }
    }

    /// Whether the ball about a cell reaches into the view.
    fn may_be_seen(&self, view: &View, cam_from_world: &DPose3, low: DVec3) -> bool {
        let radius_m = 0.87 * CELL_M;
        let [fx, fy, cx, cy] = view.intrinsics_px;
        let p = *cam_from_world * (low + DVec3::splat(0.5 * CELL_M));
        let within = |at: f64, focal_px: f64, middle_px: f64, size_px: usize| {
            let (lo, hi) = (-middle_px / focal_px, (size_px as f64 - middle_px) / focal_px);
            at - lo * p.z > -radius_m * math::hypot(1.0, lo) && at - hi * p.z < radius_m * math::hypot(1.0, hi)
        };
        p.z > -radius_m
            && (low + DVec3::splat(0.5 * CELL_M) - self.center_world).length() < REACH_M
            && within(p.x, fx, cx, view.width)
            && within(p.y, fy, cy, view.height)
    }

    /// The particles of a cell that are large enough to be seen: exponential sizes above a limit are exponential again.
    fn for_each_in_cell(&self, low: DVec3, mut use_it: impl FnMut(&FallingParticle)) {
        let middle = low + DVec3::splat(0.5 * CELL_M);
        let near_m = ((middle - self.center_world).length() - 0.87 * CELL_M).max(0.0);
        let least = if self.is_snow { LEAST_FLAKE_M } else { LEAST_DROP_M };
        let from_m = (LEAST_PX * near_m / FOCAL_PX).max(least);
        let mean = self.sizes.number_per_m3 * CELL_M * CELL_M * CELL_M * math::exp(-self.sizes.slope_per_m * from_m);
        let names = [low.x, low.y, low.z].map(|at| (at / CELL_M) as i64 as u64);
        let mut rng = CounterRng::new(CounterRng::key(self.seed, names));
        for _ in 0..rng.poisson(mean) {
            let at_world = low + DVec3::new(rng.unit(), rng.unit(), rng.unit()) * CELL_M;
            let diameter_m = from_m - math::quick_ln((1.0 - rng.unit()).max(1e-12)) / self.sizes.slope_per_m;
            let velocity_world = if self.is_snow {
                let sway = [rng.next_u64(), rng.next_u64()].map(|bits| FLAKE_SWAY_MPS * nearly_normal(bits));
                DVec3::new(sway[0], sway[1], -math::lerp(FLAKE_MPS.start, FLAKE_MPS.end, rng.unit()))
            } else {
                DVec3::new(0.0, 0.0, -drop_mps(diameter_m))
            };
            use_it(&FallingParticle { at_world, velocity_world, diameter_m });
        }
    }

    fn streak(&self, view: &View, cam_from_world: &DPose3, particle: &FallingParticle) -> Option<Streak> {
        let way = (particle.velocity_world - self.air_velocity_world) * (0.5 * SHUTTER_S);
        let ends = [particle.at_world - way, particle.at_world + way].map(|p| *cam_from_world * p);
        let depth_m = 0.5 * (ends[0].z + ends[1].z);
        if ends.iter().any(|p| p.z < NEAREST_M) {
            return None;
        }
        let [fx, fy, cx, cy] = view.intrinsics_px;
        let ends_px = ends.map(|p| [fx * p.x / p.z + cx, fy * p.y / p.z + cy]);
        let sharp_px = fx * particle.diameter_m / depth_m;
        let width_px = math::hypot(sharp_px, fx * APERTURE_M / depth_m).max(1.0);
        let length_px = math::hypot(ends_px[1][0] - ends_px[0][0], ends_px[1][1] - ends_px[0][1]);
        let disc_px2 = |width_px: f64| 0.25 * math::PI * width_px * width_px;
        let cover = disc_px2(sharp_px) / (disc_px2(width_px) + width_px * length_px);
        let margin_px = 0.5 * width_px + 1.0;
        let sizes = [view.width as f64, view.height as f64];
        let is_inside = (0..2).all(|k| {
            let (lo, hi) = (ends_px[0][k].min(ends_px[1][k]), ends_px[0][k].max(ends_px[1][k]));
            hi > -margin_px && lo < sizes[k] + margin_px
        });
        is_inside.then_some(Streak { ends_px, width_px, cover, depth_m })
    }
}

impl Streak {
    /// Blends it into an image: a capsule with an edge one pixel wide.
    fn draw(&self, rgb: &mut [f32], view: &View, radiance: Vec3) {
        let [[ax, ay], [bx, by]] = self.ends_px;
        let half_px = 0.5 * self.width_px;
        let reach_px = half_px + 0.5;
        let span = |a: f64, b: f64, size: usize| {
            let (lo, hi) =
                ((a.min(b) - reach_px).ceil().max(0.0), (a.max(b) + reach_px).floor().min(size as f64 - 1.0));
            lo as usize..if hi < lo { lo as usize } else { hi as usize + 1 }
        };
        let (dx, dy) = (bx - ax, by - ay);
        let length2 = dx * dx + dy * dy;
        for row in span(ay, by, view.height) {
            for column in span(ax, bx, view.width) {
                let (px, py) = (column as f64 - ax, row as f64 - ay);
                let t = if length2 > 0.0 { ((px * dx + py * dy) / length2).clamp(0.0, 1.0) } else { 0.0 };
                let off_px = math::hypot(px - t * dx, py - t * dy);
                let cover = (self.cover * (reach_px - off_px).clamp(0.0, 1.0)) as f32;
                if cover > 0.0 {
                    let at = 3 * (row * view.width + column);
                    blend(&mut rgb[at..at + 3], radiance, cover);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
