//! The rails of tracks: grooved rails in streets and grass, others on sleepers, as thin quadrilaterals.

use crate::network::{Lane, LaneSurface, PaintColor, PaintedQuad, RoadNetwork};
use cadet_base::math::{DVec2, DVec3};

/// Between the inner edges of the heads of both rails.
pub(crate) const GAUGE_M: f64 = 1.435;
const HEAD_M: f64 = 0.067;
/// The groove beside the head of a rail that lies in a road, and the lip beyond it.
const GROOVE_M: f64 = 0.040;
const LIP_M: f64 = 0.018;
/// Height over the ground of what lies flush, and of rails on sleepers.
const FLUSH_M: f64 = 0.006;
const ON_SLEEPERS_M: f64 = 0.11;
/// Rails are laid in pieces about this long, so that they hug the ground.
const PIECE_M: f64 = 1.0;
/// Distance between sleepers, their length across and along the track, and their height over the ballast.
const SLEEPER_EVERY_M: f64 = 0.65;
const SLEEPER_M: (f64, f64) = (2.4, 0.24);
const SLEEPER_LIFT_M: f64 = 0.008;

/// Height of the surface nearest to a place.
type Height<'a> = &'a dyn Fn(DVec3) -> Option<f64>;

/// Adds the rails of every track, on the surface nearest to it. A piece on a curb is left out.
pub(crate) fn draw(network: &RoadNetwork, height: Height<'_>, quads: &mut Vec<PaintedQuad>) {
    for lane in network.tracks() {
        let is_raised = lane.surface == LaneSurface::Ballast;
        let pieces = (lane.length_m() / PIECE_M).ceil().max(1.0) as usize;
        let ends: Vec<TrackEdge> =
            (0..=pieces).map(|k| lane.middle_and_left(lane.length_m() * k as f64 / pieces as f64)).collect();
        for pair in ends.windows(2) {
            for side in [-1.0, 1.0] {
                if is_raised {
                    raised_rail([pair[0], pair[1]], side, height, quads);
                } else {
                    grooved_rail([pair[0], pair[1]], side, height, quads);
                }
            }
        }
        if is_raised {
            sleepers(lane, height, quads);
        }
    }
}

/// A place of a track, and the unit vector to its left.
type TrackEdge = (DVec3, DVec2);

/// A strip between two lines beside the track's middle, each so far to the left and so high over the ground below it.
fn strip(
    [from, to]: [TrackEdge; 2],
    [right, left]: [(f64, f64); 2],
    color: PaintColor,
    height: Height<'_>,
    quads: &mut Vec<PaintedQuad>,
) {
    let at = |(middle, side): TrackEdge, (offset_m, lift_m): (f64, f64)| {
        let p = middle + (side * offset_m).extend(0.0);
        height(p).map(|z| p.with_z(z + lift_m))
    };
    if let [Some(a), Some(b), Some(c), Some(d)] = [at(from, right), at(to, right), at(to, left), at(from, left)] {
        let (lowest, highest) = [a, b, c, d].iter().fold((a.z, a.z), |(l, h), p| (l.min(p.z), h.max(p.z)));
        // A piece with an end on a curb would rise steeply.
        if highest - lowest < ON_SLEEPERS_M + 0.08 {
            quads.push(PaintedQuad { corners: [a, b, c, d], color, line: 0 });
        }
    }
}

fn grooved_rail(ends: [TrackEdge; 2], side: f64, height: Height<'_>, quads: &mut Vec<PaintedQuad>) {
    let inner = side * GAUGE_M / 2.0;
    let mut lay = |a: f64, b: f64, color| {
        strip(ends, [(a.min(b), FLUSH_M), (a.max(b), FLUSH_M)], color, height, quads);
    };
    // The groove for the flange is on the inner side of the head.
    lay(inner, inner + side * HEAD_M, PaintColor::Steel);
    lay(inner, inner - side * GROOVE_M, PaintColor::Dark);
    lay(inner - side * GROOVE_M, inner - side * (GROOVE_M + LIP_M), PaintColor::Steel);
}

fn raised_rail(ends: [TrackEdge; 2], side: f64, height: Height<'_>, quads: &mut Vec<PaintedQuad>) {
    let inner = side * GAUGE_M / 2.0;
    let (right, left) = (inner.min(inner + side * HEAD_M), inner.max(inner + side * HEAD_M));
    let mut lay = |a, b, color| strip(ends, [a, b], color, height, quads);
    lay((right, ON_SLEEPERS_M), (left, ON_SLEEPERS_M), PaintColor::Steel);
    // The flanks lean outward to the foot.
    lay((right - 0.03, 0.0), (right, ON_SLEEPERS_M), PaintColor::Dark);
    lay((left, ON_SLEEPERS_M), (left + 0.03, 0.0), PaintColor::Dark);
}

fn sleepers(lane: &Lane, height: Height<'_>, quads: &mut Vec<PaintedQuad>) {
    let half_m = SLEEPER_M.0 / 2.0;
    let count = (lane.length_m() / SLEEPER_EVERY_M) as usize;
    for k in 0..count {
        let middle_m = (k as f64 + 0.5) * SLEEPER_EVERY_M;
        let ends = [-0.5, 0.5].map(|t| lane.middle_and_left(middle_m + t * SLEEPER_M.1));
        strip(ends, [(-half_m, SLEEPER_LIFT_M), (half_m, SLEEPER_LIFT_M)], PaintColor::Dark, height, quads);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::LaneKind;

    fn tracks(surface: LaneSurface) -> Vec<PaintedQuad> {
        let mut network = RoadNetwork::straight(60.0, 3.2);
        network.lanes.iter_mut().for_each(|l| (l.kind, l.surface) = (LaneKind::Tram, surface));
        let mut quads = Vec::new();
        draw(&network, &|p| Some(0.02 * p.x), &mut quads);
        quads
    }

    #[test]
    fn the_heads_of_rails_are_a_gauge_apart_and_look_up() {
        for surface in [LaneSurface::Usual, LaneSurface::Grass, LaneSurface::Ballast, LaneSurface::Slabs] {
            let quads = tracks(surface);
            for quad in &quads {
                let [a, b, c, _] = quad.corners;
                assert!((b - a).cross(c - a).z > 0.0, "{surface:?}: {quad:?} looks down");
            }
            let heads: Vec<f64> = quads
                .iter()
                .filter(|q| q.color == PaintColor::Steel && (q.corners[0].y - q.corners[2].y).abs() > 0.05)
                .flat_map(|q| q.corners.map(|p| p.y))
                .filter(|y| *y > 0.0)
                .collect();
            // Seen from the track's middle at 1.6 m: the edge of each head that is nearest to it.
            let inner = |side: f64| heads.iter().map(|y| side * (y - 1.6)).filter(|d| *d > 0.0).fold(9.0, f64::min);
            let gauge_m = inner(1.0) + inner(-1.0);
            assert!((gauge_m - GAUGE_M).abs() < 1e-9, "{surface:?}: {gauge_m}");
        }
    }

    #[test]
    fn only_ballast_has_sleepers_and_raised_rails() {
        let highest = |quads: &[PaintedQuad]| {
            quads.iter().flat_map(|q| q.corners).map(|p| p.z - 0.02 * p.x).fold(f64::NEG_INFINITY, f64::max)
        };
        assert!((highest(&tracks(LaneSurface::Ballast)) - ON_SLEEPERS_M).abs() < 1e-9);
        assert!((highest(&tracks(LaneSurface::Grass)) - FLUSH_M).abs() < 1e-9);
        let across =
            |quads: &[PaintedQuad]| quads.iter().filter(|q| (q.corners[0].y - q.corners[2].y).abs() > 2.0).count();
        assert_eq!(across(&tracks(LaneSurface::Ballast)), 2 * (60.0 / SLEEPER_EVERY_M) as usize);
        assert_eq!(across(&tracks(LaneSurface::Slabs)), 0);
    }
}
