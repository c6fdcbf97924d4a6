//! Curves in plan, made of lines and arcs that meet without a kink.

use cadet_base::math::{self, DVec2, wrap_angle};
use cadet_base::plane::{heading_rad, unit};

/// A shorter line is none.
const LEAST_LINE_M: f64 = 1e-9;

/// A place and a direction in the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlanPose {
    pub(crate) at: DVec2,
    pub(crate) heading_rad: f64,
}

impl PlanPose {
    pub(crate) fn new(at: DVec2, heading_rad: f64) -> Self {
        Self { at, heading_rad: wrap_angle(heading_rad) }
    }

    pub(crate) fn direction(&self) -> DVec2 {
        unit(self.heading_rad)
    }

    /// The pose `right_m` to the right, looking the same way.
    pub(crate) fn shifted_right(&self, right_m: f64) -> Self {
        Self { at: self.at - self.direction().perp() * right_m, ..*self }
    }

    /// The pose at this place that looks back.
    pub(crate) fn reversed(&self) -> Self {
        Self::new(self.at, self.heading_rad + math::PI)
    }
}

/// A line (curvature 0) or an arc.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    pub(crate) start: PlanPose,
    pub(crate) length_m: f64,
    /// Positive turns left.
    pub(crate) curvature_per_m: f64,
}

impl Segment {
    fn pose_at(&self, s_m: f64) -> PlanPose {
        let turned = self.start.heading_rad + self.curvature_per_m * s_m;
        let at = if self.curvature_per_m == 0.0 {
            self.start.direction() * s_m
        } else {
            let (h, k) = (self.start.heading_rad, self.curvature_per_m);
            DVec2::new(math::sin(turned) - math::sin(h), math::cos(h) - math::cos(turned)) / k
        };
        PlanPose::new(self.start.at + at, turned)
    }
}

/// Lines and arcs, one after the other.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlanCurve {
    pub(crate) segments: Vec<Segment>,
}

impl PlanCurve {
    /// From one pose to another, by [`extend_to`](Self::extend_to).
    pub(crate) fn between(start: PlanPose, end: PlanPose) -> Self {
        let mut curve = Self::default();
        curve.extend_to(start, end);
        curve
    }

    pub(crate) fn length_m(&self) -> f64 {
        self.segments.iter().map(|s| s.length_m).sum()
    }

    /// The smallest radius of its arcs; infinite for a line.
    pub(crate) fn min_radius_m(&self) -> f64 {
        self.segments.iter().map(|s| 1.0 / s.curvature_per_m.abs()).fold(f64::INFINITY, f64::min)
    }

    /// The pose at distance `s_m` (clamped to the curve).
    pub(crate) fn pose_at(&self, s_m: f64) -> PlanPose {
        let mut left = s_m.max(0.0);
        for (i, segment) in self.segments.iter().enumerate() {
            if left <= segment.length_m || i + 1 == self.segments.len() {
                return segment.pose_at(left.min(segment.length_m));
            }
            left -= segment.length_m;
        }
        PlanPose::new(DVec2::ZERO, 0.0)
    }

    /// Goes straight on from `start` to a place ahead of it; to one that is there already it adds nothing.
    pub(crate) fn straight_to(&mut self, start: PlanPose, end: DVec2) {
        let length_m = (end - start.at).length();
        if length_m > LEAST_LINE_M {
            self.segments.push(Segment { start, length_m, curvature_per_m: 0.0 });
        }
    }

    /// Goes on to `end` with two arcs that meet tangentially (a biarc of equal tangent lengths).
    pub(crate) fn extend_to(&mut self, start: PlanPose, end: PlanPose) {
        let (t0, t1) = (start.direction(), end.direction());
        let v = end.at - start.at;
        let along = v.dot(t0 + t1);
        let bend = 2.0 * (1.0 - t0.dot(t1));
        let d = if bend > 1e-9 {
            ((along * along + bend * v.length_squared()).sqrt() - along) / bend
        } else {
            v.length_squared() / (2.0 * along)
        };
        let middle = (start.at + end.at + (t0 - t1) * d) / 2.0;
        let first = arc(start, middle);
        let joint = first.pose_at(first.length_m);
        self.segments.push(first);
        let mut second = arc(PlanPose::new(middle, joint.heading_rad), end.at);
        if second.curvature_per_m == 0.0 && first.curvature_per_m == 0.0 {
            self.segments.pop();
            second = Segment { start, length_m: v.length(), curvature_per_m: 0.0 };
        }
        self.segments.push(second);
    }
}

/// The arc that leaves `start` tangentially and ends at `end`.
fn arc(start: PlanPose, end: DVec2) -> Segment {
    let chord = end - start.at;
    let length_m = chord.length();
    let half_turn = wrap_angle(heading_rad(chord) - start.heading_rad);
    let sin = math::sin(half_turn);
    if sin.abs() < 1e-7 {
        return Segment { start, length_m, curvature_per_m: 0.0 };
    }
    Segment { start, length_m: length_m * half_turn / sin, curvature_per_m: 2.0 * sin / length_m }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Fails where a curve has a kink or a gap, or does not lead from one pose to another.
    pub(in crate::plan) fn assert_leads(curve: &PlanCurve, from: PlanPose, to: PlanPose) {
        let is_same = |p: PlanPose, q: PlanPose| {
            (p.at - q.at).length() < 1e-6 && wrap_angle(p.heading_rad - q.heading_rad).abs() < 1e-6
        };
        let mut at = from;
        for segment in &curve.segments {
            assert!(is_same(segment.start, at), "{from:?} {to:?} {curve:?}");
            at = segment.pose_at(segment.length_m);
        }
        assert!(is_same(at, to), "{at:?} {to:?}");
    }

    #[test]
    fn a_biarc_meets_both_poses_without_a_kink() {
        let mut stream = cadet_base::rng::Stream::from_seed("biarc", 1);
        for _ in 0..500 {
            let start = PlanPose::new(DVec2::new(stream.range(-5.0, 5.0), 3.0), stream.range(-3.0, 3.0));
            let reach = DVec2::new(stream.range(10.0, 90.0), stream.range(-30.0, 30.0));
            let forward = start.direction() * reach.x + start.direction().perp() * reach.y;
            let end = PlanPose::new(start.at + forward, start.heading_rad + stream.range(-1.4, 1.4));
            let mut curve = PlanCurve::default();
            curve.extend_to(start, end);
            assert_leads(&curve, start, end);
            assert!((curve.pose_at(curve.length_m()).at - end.at).length() < 1e-6);
        }
    }
}
