//! What years leave on the asphalt of a street: cuts for pipes and patches of another age, cracks and the bitumen that seals
//! them, covers of manholes.
//!
//! How much there is of it is drawn street by street.

use crate::network::{Lane, LaneKind, LaneSurface, PaintColor, PaintedQuad, RoadNetwork};
use crate::paint::{Paint, Wear};
use cadet_base::math::{DVec2, DVec3, TAU};
use cadet_base::plane::unit;
use cadet_base::rng::Stream;

/// Part of the width of a lane's half that stays free at its border: the next lane draws its own.
const MARGIN_M: f64 = 0.1;
/// Numbers for 100 m of a lane of the oldest street: cuts along it and across it, patches, cracks along and across.
const CUTS_ALONG: f64 = 1.0;
const CUTS_ACROSS: f64 = 1.4;
const PATCHES: f64 = 2.6;
const CRACKS_ALONG: f64 = 2.6;
const CRACKS_ACROSS: f64 = 4.5;
/// Covers of manholes for 100 m, in streets of any age.
const COVERS: f64 = 1.7;
/// Inside junctions lanes lie over each other: each has so little of all.
const IN_JUNCTIONS: f64 = 0.25;
/// How many of the repairs are new and dark; the others have bleached more than what lies about them.
const NEW_SHARE: f64 = 0.6;
/// How many cracks are sealed.
const SEALED_SHARE: f64 = 0.6;
const SEAL_M: (f64, f64) = (0.035, 0.09);
const OPEN_M: (f64, f64) = (0.012, 0.028);
/// Pieces of a crack, and how far it wanders in each.
const CRACK_PIECE_M: (f64, f64) = (0.45, 0.9);
const WANDERS_M: f64 = 0.09;
/// A cover: its radius, the radius of the concrete that fills it, and corners of the circle.
const COVER_M: (f64, f64) = (0.33, 0.24);
const COVER_CORNERS: usize = 14;
/// Repairs keep so far apart along a lane that none lies in another.
const APART_M: f64 = 0.15;
/// Heights over the road: what may lie over another lies higher, and all lie below paint.
const REPAIR_LIFT_M: f64 = 0.002;
const CRACK_LIFT_M: f64 = 0.003;
const COVER_LIFT_M: f64 = 0.004;

/// Lays the repairs of all streets of asphalt on the surface nearest to each place, which is so high and a road or not.
pub(crate) fn draw(
    network: &RoadNetwork,
    wear: &Wear,
    surface_near: &dyn Fn(DVec3) -> Option<(f64, bool)>,
) -> Vec<PaintedQuad> {
    let mut paint = Paint::new(surface_near, true);
    let is_asphalt = |l: &&Lane| l.kind == LaneKind::Driving && l.surface == LaneSurface::Usual;
    for lane in network.lanes.iter().filter(is_asphalt) {
        let Some(mut stream) = wear.stream("repairs", lane.id.0 as u64) else { break };
        let age = wear.stream("street age", u64::from(lane.road)).map_or(0.0, |mut s| s.unit());
        let lanes = if lane.junction.is_some() { IN_JUNCTIONS } else { 1.0 };
        let share = lanes * lane.length_m() / 100.0;
        let mut works = Works { lane, share, age, taken: Vec::new(), paint: &mut paint };
        works.covers(&mut stream);
        works.repairs(&mut stream);
        works.cracks(&mut stream);
    }
    paint.quads
}

/// Covers, repairs, and cracks of one lane. Places are (along the lane, to the left of its middle).
struct Works<'a, 'b> {
    lane: &'a Lane,
    /// The lane's share of the numbers above.
    share: f64,
    /// 0 for new streets, 1 for the oldest.
    age: f64,
    /// Middles and halves of what repairs keep off.
    taken: Vec<(DVec2, DVec2)>,
    paint: &'a mut Paint<'b>,
}

impl Works<'_, '_> {
    fn half_width_m(&self, s_m: f64) -> f64 {
        (self.lane.width_at(s_m) / 2.0 - MARGIN_M).max(0.0)
    }

    fn at(&self, place: DVec2) -> DVec3 {
        let (at, left) = self.lane.middle_and_left(place.x);
        at + (left * place.y).extend(0.0)
    }

    /// A quadrilateral whose corners are places, counter-clockwise from above.
    fn lay(&mut self, corners: [DVec2; 4], color: PaintColor) {
        let corners = corners.map(|place| self.at(place));
        self.paint.area(&PaintedQuad { corners, color, line: 0 });
    }

    /// Whether nothing lies about a place yet; then it is taken.
    fn takes(&mut self, middle: DVec2, half: DVec2) -> bool {
        let is_free = self.taken.iter().all(|(other, size)| {
            let apart = (middle - other).abs() - half - size;
            apart.x > APART_M || apart.y > APART_M
        });
        if is_free {
            self.taken.push((middle, half));
        }
        is_free
    }

    /// Covers of manholes lie in the middle of lanes or between the wheels' tracks.
    fn covers(&mut self, stream: &mut Stream) {
        self.paint.lift_m = COVER_LIFT_M;
        for _ in 0..stream.poisson(COVERS * self.share) {
            let s_m = stream.range(0.0, self.lane.length_m());
            let middle = DVec2::new(s_m, stream.clipped_normal(0.0, 0.25) * self.half_width_m(s_m));
            let is_filled = stream.chance(0.6);
            let (outer_m, inner_m) = COVER_M;
            if middle.y.abs() + outer_m > self.half_width_m(s_m) || !self.takes(middle, DVec2::splat(outer_m)) {
                continue;
            }
            let corner = |k: usize, radius_m: f64| {
                let angle = TAU * k as f64 / COVER_CORNERS as f64;
                middle + unit(angle) * radius_m
            };
            for k in 0..COVER_CORNERS {
                let (a, b) = (corner(k, outer_m), corner(k + 1, outer_m));
                let (c, d) = (corner(k + 1, inner_m), corner(k, inner_m));
                self.lay([a, b, c, d], PaintColor::Iron);
            }
            let fill = if is_filled { PaintColor::OldAsphalt } else { PaintColor::Iron };
            for k in 1..COVER_CORNERS / 2 {
                let last = COVER_CORNERS - k;
                let around = [k - 1, k, last, last + 1].map(|k| corner(k, inner_m));
                self.lay(around, fill);
            }
        }
    }

    /// Cuts along, cuts across, patches.
    fn repairs(&mut self, stream: &mut Stream) {
        self.paint.lift_m = REPAIR_LIFT_M;
        let rate = self.age * self.share;
        for _ in 0..stream.poisson(CUTS_ALONG * rate) {
            self.repair(stream, (5.0, 45.0), (0.5, 1.1));
        }
        for _ in 0..stream.poisson(CUTS_ACROSS * rate) {
            self.repair(stream, (0.45, 1.2), (9.0, 9.0));
        }
        for _ in 0..stream.poisson(PATCHES * rate) {
            self.repair(stream, (0.6, 3.5), (0.5, 1.7));
        }
    }

    /// A cut or patch of a length and a width between two; what is wider than the lane reaches from border to border.
    fn repair(&mut self, stream: &mut Stream, length_m: (f64, f64), width_m: (f64, f64)) {
        let color = if stream.chance(NEW_SHARE) { PaintColor::NewAsphalt } else { PaintColor::OldAsphalt };
        let half_length_m = stream.within(length_m).min(self.lane.length_m()) / 2.0;
        let s_m = stream.range(half_length_m, (self.lane.length_m() - half_length_m).max(half_length_m));
        let room_m =
            [-1.0, 0.0, 1.0].map(|k| self.half_width_m(s_m + k * half_length_m)).into_iter().fold(9.0, f64::min);
        let wanted_m = stream.within(width_m) / 2.0;
        let half_width_m = wanted_m.min(room_m + MARGIN_M);
        let free_m = (room_m - half_width_m).max(0.0);
        let middle = DVec2::new(s_m, stream.range(-free_m, free_m));
        // Saws cut straight, but seldom square to the street.
        let skew_m = stream.clipped_normal(0.0, 0.05) * half_width_m;
        let half = DVec2::new(half_length_m, half_width_m);
        if half_width_m > 0.15 && self.takes(middle, half + DVec2::X * skew_m.abs()) {
            let corner = |x: f64, y: f64| middle + DVec2::new(x * half.x + y * skew_m, y * half.y);
            self.strip(corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), color);
        }
    }

    /// A quadrilateral that follows the lane's bends.
    fn strip(&mut self, a: DVec2, b: DVec2, c: DVec2, d: DVec2, color: PaintColor) {
        let pieces = ((b.x - a.x) / 2.0).ceil().max(1.0);
        for k in 0..pieces as usize {
            let [from, to] = [k as f64 / pieces, (k + 1) as f64 / pieces];
            self.lay([a.lerp(b, from), a.lerp(b, to), d.lerp(c, to), d.lerp(c, from)], color);
        }
    }

    fn cracks(&mut self, stream: &mut Stream) {
        self.paint.lift_m = CRACK_LIFT_M;
        let rate = self.age * self.age * self.share;
        for _ in 0..stream.poisson(CRACKS_ALONG * rate) {
            let s_m = stream.range(0.0, self.lane.length_m());
            let start = DVec2::new(s_m, stream.range(-1.0, 1.0) * self.half_width_m(s_m));
            let length_m = stream.range(3.0, 22.0);
            self.crack(stream, start, DVec2::X, length_m);
        }
        for _ in 0..stream.poisson(CRACKS_ACROSS * rate) {
            let s_m = stream.range(0.0, self.lane.length_m());
            let half_m = self.half_width_m(s_m);
            let start = DVec2::new(s_m, if stream.chance(0.7) { -half_m } else { stream.range(-half_m, 0.0) });
            let length_m = stream.range(0.4, 1.0) * 2.0 * half_m;
            self.crack(stream, start, DVec2::Y, length_m);
        }
    }

    /// A line that wanders as it goes, to its length or the lane's border.
    fn crack(&mut self, stream: &mut Stream, start: DVec2, way: DVec2, length_m: f64) {
        let is_sealed = stream.chance(SEALED_SHARE);
        let (least_m, most_m) = if is_sealed { SEAL_M } else { OPEN_M };
        let half_m = stream.range(least_m, most_m) / 2.0;
        let (mut here, mut gone_m, mut drift_m) = (start, 0.0, 0.0);
        while gone_m < length_m {
            let piece_m = stream.within(CRACK_PIECE_M);
            drift_m = 0.5 * drift_m + WANDERS_M * stream.normal();
            let next = here + way * piece_m + way.perp() * drift_m;
            if next.x < 0.0 || next.x > self.lane.length_m() || next.y.abs() > self.half_width_m(next.x) + MARGIN_M {
                break;
            }
            let aside = (next - here).normalize_or(way).perp() * half_m;
            self.lay([here - aside, next - aside, next + aside, here + aside], PaintColor::Bitumen);
            (here, gone_m) = (next, gone_m + piece_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::LaneId;
    use cadet_base::rng::StreamKey;

    /// Streets of one straight lane each, 100 m long and 3.5 m wide, side by side.
    fn streets(count: usize) -> RoadNetwork {
        let lanes = (0..count).map(|i| {
            let center = (0..=50).map(|k| DVec3::new(2.0 * f64::from(k), 10.0 * i as f64, 0.0)).collect();
            Lane::new(LaneId(i), i as u32, center, vec![3.5; 51])
        });
        RoadNetwork { lanes: lanes.collect(), ..RoadNetwork::default() }
    }

    fn drawn(network: &RoadNetwork, wear: &Wear) -> Vec<PaintedQuad> {
        draw(network, wear, &|_| Some((0.0, true)))
    }

    fn area_m2(quad: &PaintedQuad) -> f64 {
        let [a, b, c, d] = quad.corners.map(|p| p.truncate());
        (c - a).perp_dot(d - b) / 2.0
    }

    #[test]
    fn repairs_stay_on_their_lane_face_up_and_lie_below_paint() {
        let quads = drawn(&streets(60), &Wear::new(&mut StreamKey::scene(3).stream("wear")));
        assert!(quads.len() > 2000, "{}", quads.len());
        for quad in &quads {
            assert!(area_m2(quad) > 0.0, "{quad:?}");
            for p in quad.corners {
                let off_m = (p.y - 10.0 * (p.y / 10.0).round()).abs();
                assert!(off_m < 1.75 + 0.06 && (-0.1..100.1).contains(&p.x), "{quad:?}");
                assert!((0.0015..crate::paint::PAINT_LIFT_M - 0.001).contains(&p.z), "{quad:?}");
            }
        }
    }

    #[test]
    fn old_streets_have_repairs_on_a_tenth_of_their_area_and_new_ones_have_none() {
        let wear = Wear::new(&mut StreamKey::scene(5).stream("wear"));
        let network = streets(400);
        let mut covered = vec![0.0; 400];
        for quad in drawn(&network, &wear).iter().filter(|q| q.color != PaintColor::Iron) {
            covered[(quad.corners[0].y / 10.0).round() as usize] += area_m2(quad) / 350.0;
        }
        let age = |road: u64| wear.stream("street age", road).unwrap().unit();
        let mean = |ages: std::ops::Range<f64>| {
            let of: Vec<f64> = (0..400).filter(|i| ages.contains(&age(*i as u64))).map(|i| covered[i]).collect();
            of.iter().sum::<f64>() / of.len() as f64
        };
        let (new, old) = (mean(0.0..0.1), mean(0.8..1.0));
        assert!(new < 0.02 && (0.05..0.2).contains(&old), "{new} {old}");
    }

    #[test]
    fn what_no_wear_was_drawn_for_has_no_repairs() {
        assert!(drawn(&streets(3), &Wear::default()).is_empty());
        let mut setts = streets(3);
        setts.lanes.iter_mut().for_each(|l| l.surface = LaneSurface::Setts);
        assert!(drawn(&setts, &Wear::new(&mut StreamKey::scene(3).stream("wear"))).is_empty());
    }
}
