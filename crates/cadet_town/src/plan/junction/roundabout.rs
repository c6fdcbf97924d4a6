//! Roundabouts: one lane about an island, in place of the ways across a junction.

use crate::plan::junction::StreetArm;
use crate::plan::{PlanCurve, PlanPose, Segment, StreetKind};
use cadet_base::math::{self, DVec2, PI, TAU};
use cadet_base::plane::unit;
use cadet_base::rng::Stream;

/// Radius of the island and width of the lane about it: 26 to 30 m from side to side, a small roundabout of the German
/// guideline (FGSV, Merkblatt fuer die Anlage von Kreisverkehren, 2006).
const ISLAND_M: (f64, f64) = (8.5, 10.5);
const LANE_M: (f64, f64) = (4.5, 5.0);
/// Radius at which the ways in and out bend, on their left.
const BEND_M: f64 = 14.0;
/// Streets that meet at a smaller angle leave no room between their ways.
const LEAST_BETWEEN_RAD: f64 = 1.1;
/// A shorter stretch on the ring is none.
const LEAST_ARC_RAD: f64 = 0.005;

/// One in the place of a junction; traffic goes round counter-clockwise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Roundabout {
    pub(crate) center: DVec2,
    pub(crate) island_m: f64,
    pub(crate) lane_m: f64,
}

/// Where a way through a junction is on the ring, and how wide its lane is there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OnRing {
    pub(crate) from_m: f64,
    pub(crate) to_m: f64,
    pub(crate) lane_m: f64,
}

impl Roundabout {
    /// Draws whether a junction is one: of streets in town with one lane a direction and none for bicycles. Arms go round
    /// counter-clockwise.
    pub(crate) fn draw(arms: &[StreetArm], share: f64, stream: &mut Stream) -> Option<Self> {
        let (is_drawn, island_m, lane_m) = (stream.chance(share), stream.within(ISLAND_M), stream.within(LANE_M));
        let is_plain = |arm: &StreetArm| {
            let style = &arm.style;
            !style.is_main_road()
                && style.cycle_lane.is_none()
                && style.country.is_none()
                && style.kind == StreetKind::Usual
        };
        let between_rad = |i: usize| {
            let next_rad = arms[(i + 1) % arms.len()].heading_rad;
            (next_rad - arms[i].heading_rad).rem_euclid(TAU)
        };
        let fits = arms.iter().all(is_plain) && (0..arms.len()).all(|i| between_rad(i) > LEAST_BETWEEN_RAD);
        (is_drawn && fits).then_some(Self { center: arms.first()?.center, island_m, lane_m })
    }

    /// How far from the middle the ways leave the streets' middles: the streets end there.
    pub(crate) fn approach_m(&self) -> f64 {
        (self.island_m * (self.island_m + 2.0 * BEND_M)).sqrt()
    }

    /// From the middle of one street to that of another: their poses look into the junction and out of it.
    pub(crate) fn way(&self, from: PlanPose, to: PlanPose) -> (PlanCurve, Option<OnRing>) {
        let (into_rad, out_rad) = (from.heading_rad + PI, to.heading_rad);
        let on_axis = |heading_rad: f64| self.center + unit(heading_rad) * self.approach_m();
        let entry = PlanPose::new(on_axis(into_rad), from.heading_rad);
        let exit = PlanPose::new(on_axis(out_rad), to.heading_rad);
        let beside_rad = math::atan2(BEND_M, self.approach_m());
        let around_rad = (out_rad - into_rad).rem_euclid(TAU) - 2.0 * beside_rad;
        let mut curve = PlanCurve::default();
        curve.straight_to(from, entry.at);
        let mut on_ring = None;
        if around_rad < LEAST_ARC_RAD {
            curve.extend_to(entry, exit);
        } else {
            let bend = |start: PlanPose| Segment {
                start,
                length_m: BEND_M * (PI / 2.0 - beside_rad),
                curvature_per_m: -1.0 / BEND_M,
            };
            let at =
                |place_rad: f64| PlanPose::new(self.center + unit(place_rad) * self.island_m, place_rad + PI / 2.0);
            let (first_rad, last_rad) = (into_rad + beside_rad, out_rad - beside_rad);
            curve.segments.push(bend(entry));
            let from_m = curve.length_m();
            curve.segments.push(Segment {
                start: at(first_rad),
                length_m: around_rad * self.island_m,
                curvature_per_m: 1.0 / self.island_m,
            });
            on_ring = Some(OnRing { from_m, to_m: curve.length_m(), lane_m: self.lane_m });
            curve.segments.push(bend(at(last_rad)));
        }
        curve.straight_to(exit, to.at);
        (curve, on_ring)
    }

    /// The edge of its island, once round, counter-clockwise.
    pub(crate) fn island(&self) -> PlanCurve {
        let start = PlanPose::new(self.center + DVec2::X * self.island_m, PI / 2.0);
        PlanCurve {
            segments: vec![Segment { start, length_m: TAU * self.island_m, curvature_per_m: 1.0 / self.island_m }],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::plan_curve::tests::assert_leads;

    #[test]
    fn ways_lead_without_a_kink_around_the_island_and_never_over_it() {
        let mut stream = Stream::from_seed("roundabout", 1);
        for _ in 0..300 {
            let island_m = stream.within(ISLAND_M);
            let ring = Roundabout { center: DVec2::new(3.0, -7.0), island_m, lane_m: 4.6 };
            let into_rad = stream.range(-3.0, 3.0);
            let between_rad = stream.range(LEAST_BETWEEN_RAD, TAU - LEAST_BETWEEN_RAD);
            let cut_m = ring.approach_m() + stream.range(0.0, 3.0);
            let arm = |heading_rad: f64| PlanPose::new(ring.center + unit(heading_rad) * cut_m, heading_rad);
            let (from, to) = (arm(into_rad).reversed(), arm(into_rad + between_rad));
            let (curve, on_ring) = ring.way(from, to);
            assert_leads(&curve, from, to);
            let mut turned_rad = 0.0;
            for k in 0..200 {
                let s = |k: usize| curve.length_m() * k as f64 / 200.0;
                let (a, b) = (curve.pose_at(s(k)).at - ring.center, curve.pose_at(s(k + 1)).at - ring.center);
                // The first way out of streets at a sharp angle touches no ring, and may cut it by some centimeters.
                let cut_m = if on_ring.is_some() { 1e-6 } else { 0.05 };
                assert!(a.length() > island_m - cut_m, "{} m of {island_m}", a.length());
                turned_rad += math::turn_rad(a, b);
            }
            assert!((turned_rad - between_rad).abs() < 1e-6, "round by {turned_rad} instead of {between_rad}");
            if let Some(on_ring) = on_ring {
                for s in [on_ring.from_m, (on_ring.from_m + on_ring.to_m) / 2.0, on_ring.to_m] {
                    assert!(((curve.pose_at(s).at - ring.center).length() - island_m).abs() < 1e-6);
                }
            } else {
                assert!(between_rad < 2.2, "a way round by {between_rad} that touches no ring");
            }
        }
    }
}
