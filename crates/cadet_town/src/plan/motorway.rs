//! Motorways and bypasses: a course that closes on itself, and what lies across it from the median to the verge.

use crate::plan::{PlanCurve, PlanPose};
use cadet_base::math::{self, TAU};
use cadet_base::plane::{heading_rad, unit};
use cadet_base::rng::Stream;

/// Share of bypasses: two lanes a direction without a hard shoulder. Share of the other motorways with three lanes.
const BYPASS_SHARE: f64 = 0.3;
const THREE_LANES_SHARE: f64 = 0.4;
/// Speed limit, and the tightest bend that it goes with (RAA, German guideline for motorways: about 400 m on bypasses; bends
/// taken at the limit ask for less than 2 m/s²).
const BYPASS: (u32, f64) = (100, 400.0);
const LIMITS: [(u32, f64); 2] = [(120, 570.0), (130, 680.0)];
/// How far the course is from a circle: shares of the second and the third wave round it.
const OVAL: (f64, f64) = (0.05, 0.14);
const TRIANGLE: (f64, f64) = (0.0, 0.05);
/// The course is made of biarcs between poses so far apart, and cut into roads of about such a length.
const POSES_M: f64 = 45.0;
const ROAD_M: f64 = 600.0;
/// Carriageways tilt into bends by so much at a radius of 1 m, and no more than this.
const TILT_M: f64 = 20.0;
const MOST_TILT: f64 = 0.05;
/// Bends are looked at over this length to either side, so that the tilt grows and fades.
const TILT_OVER_M: f64 = 40.0;

/// What lies across a motorway on one side of its middle; the other side is the same.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CrossSection {
    /// Half of the median, which is green.
    pub half_median_m: f64,
    /// Paved strip between the median and the first lane.
    pub inner_strip_m: f64,
    /// Widths of the lanes from the median outwards.
    pub lanes_m: [f64; 3],
    pub num_lanes: usize,
    /// Hard shoulder; on bypasses a narrow strip.
    pub shoulder_m: f64,
    /// Grass along it.
    pub verge_m: f64,
    pub speed_kmh: u32,
}

/// A motorway that closes on itself.
#[derive(Debug)]
pub(crate) struct Motorway {
    pub section: CrossSection,
    /// Its roads, each from where the last one ended; the first follows the last.
    pub roads: Vec<PlanCurve>,
    /// Its roads joined into one.
    whole: PlanCurve,
}

impl Motorway {
    /// Draws one.
    pub fn draw(stream: &mut Stream) -> Self {
        let (is_bypass, has_three) = (stream.chance(BYPASS_SHARE), stream.chance(THREE_LANES_SHARE));
        let (motorway, median_m) = (LIMITS[stream.below(LIMITS.len())], stream.range(3.5, 4.0));
        let (speed_kmh, tightest_m) = if is_bypass { BYPASS } else { motorway };
        let wide_m = if is_bypass { 3.5 } else { 3.75 };
        let section = CrossSection {
            half_median_m: if is_bypass { 1.5 } else { (median_m * 5.0).round() / 10.0 },
            inner_strip_m: if is_bypass { 0.5 } else { 0.75 },
            lanes_m: if has_three { [3.5, 3.5, wide_m] } else { [wide_m; 3] },
            num_lanes: if has_three && !is_bypass { 3 } else { 2 },
            shoulder_m: if is_bypass { 0.5 } else { 2.5 },
            verge_m: 2.0,
            speed_kmh,
        };
        let roads = draw_course(stream, tightest_m);
        let whole = PlanCurve { segments: roads.iter().flat_map(|r| r.segments.iter().copied()).collect() };
        Self { section, roads, whole }
    }

    /// How steeply the carriageways rise to the left at a distance along the whole course: into bends.
    pub fn tilt(&self, s_m: f64) -> f64 {
        let length_m = self.whole.length_m();
        let heading = |s: f64| self.whole.pose_at(s.rem_euclid(length_m)).heading_rad;
        let turned = math::wrap_angle(heading(s_m + TILT_OVER_M) - heading(s_m - TILT_OVER_M));
        -(TILT_M * turned / (2.0 * TILT_OVER_M)).clamp(-MOST_TILT, MOST_TILT)
    }
}

/// A closed course round the origin, counter-clockwise, as the roads that it is cut into.
fn draw_course(stream: &mut Stream, tightest_m: f64) -> Vec<PlanCurve> {
    let [oval, triangle] = [OVAL, TRIANGLE].map(|(least, most)| (stream.range(least, most), stream.range(0.0, TAU)));
    let start = stream.range(0.0, TAU);
    let waves = [(2.0, oval), (3.0, triangle)];
    // Distance from the origin and its first two derivatives.
    let radius = |turn: f64| {
        waves.iter().fold([1.0, 0.0, 0.0], |[r, d, dd], (k, (share, phase))| {
            let (sin, cos) = (math::sin(k * turn + phase), math::cos(k * turn + phase));
            [r + share * cos, d - k * share * sin, dd - k * k * share * cos]
        })
    };
    let around = |n: usize| (0..n).map(move |i| start + TAU * i as f64 / n as f64);
    let curvature = |turn: f64| {
        let [r, d, dd] = radius(turn);
        let square = r * r + d * d;
        (square + d * d - r * dd).abs() / (square * square.sqrt())
    };
    let scale_m = tightest_m * around(720).map(curvature).fold(0.0, f64::max);
    let pose = |turn: f64| {
        let [r, d, _] = radius(turn);
        let out = unit(turn);
        PlanPose::new(out * (r * scale_m), heading_rad(out * d + out.perp() * r))
    };
    let length_m = around(720).map(|turn| radius(turn)[0]).sum::<f64>() * scale_m * TAU / 720.0;
    let num_roads = ((length_m / ROAD_M).round() as usize).max(3);
    let per_road = ((length_m / num_roads as f64 / POSES_M).round() as usize).max(2);
    let poses: Vec<PlanPose> = around(num_roads * per_road).map(pose).collect();
    (0..num_roads)
        .map(|road| {
            let mut curve = PlanCurve::default();
            for k in road * per_road..(road + 1) * per_road {
                curve.extend_to(poses[k], poses[(k + 1) % poses.len()]);
            }
            curve
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn courses_close_without_a_kink_and_bend_as_their_speed_allows() {
        for seed in 0..40 {
            let motorway = Motorway::draw(&mut Stream::from_seed("motorway", seed));
            let mut at = motorway.roads[0].pose_at(0.0);
            for road in motorway.roads.iter().cycle().take(motorway.roads.len() + 1) {
                let begins = road.pose_at(0.0);
                assert!((begins.at - at.at).length() < 1e-6, "seed {seed}");
                assert!(math::wrap_angle(begins.heading_rad - at.heading_rad).abs() < 1e-6, "seed {seed}");
                at = road.pose_at(road.length_m());
            }
            let length_m = motorway.whole.length_m();
            assert!((2_500.0..9_000.0).contains(&length_m), "seed {seed}: {length_m} m");
            let v_mps = f64::from(motorway.section.speed_kmh) / 3.6;
            let tightest_m = motorway.whole.min_radius_m();
            // Biarcs between poses of a smooth curve bend by some percent more than it does.
            assert!(v_mps * v_mps / tightest_m < 2.1, "seed {seed}: {tightest_m} m at {v_mps} m/s");
            // A circle's tilt is into it: down to the left, as the course turns left.
            assert!((0..50).all(|k| motorway.tilt(length_m * f64::from(k) / 50.0) <= 0.001), "seed {seed}");
        }
    }
}
