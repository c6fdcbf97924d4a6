//! What a bridge spans, in plan.

use crate::ground::region::{Contour, Frame, Inside, Ring, Shapes, grow, union};
use crate::network::{Overpass, RoadNetwork};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::bounds;

/// Abutments stand behind the lower road's sidewalks by this and by as much as the deck is high, within bounds.
const BEHIND_M: f64 = 2.5;
const EMBANKMENT_M: (f64, f64) = (4.0, 14.0);
/// The upper road's lanes on the ground go on so far below the deck's ends, and those of the deck over its ends.
const OVERLAP_M: f64 = 4.0;
const APPROACH_M: f64 = 12.0;
/// Nothing else is put so near to a bridge.
const NEAR_M: f64 = 4.0;
/// A point of a lane belongs to the bridge's road if its height differs by less from that of the nearest point over the
/// lower road: by that, and by a road's slope.
const AT_DECK_M: f64 = 1.7;
const SLOPE: f64 = 0.07;

/// The stretch of a road that is a bridge.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    overpass: Overpass,
    /// Its outline, from one abutment to the other and beyond the deck's sides.
    pub outline: Vec<Ring>,
    pub inside: Inside,
    /// The outline without its border, without the ends of the deck, with the approaches, and with what is kept free.
    pub inner: Inside,
    middle: Inside,
    approach: Inside,
    near: Inside,
}

impl Span {
    /// The span over the lower lanes of an overpass.
    pub fn of(overpass: Overpass, network: &RoadNetwork) -> Self {
        let lanes = &network.lanes;
        let crossings = &overpass.crossings;
        let (min, max) = bounds(crossings.iter().map(|c| c.lower.truncate()));
        let frame = Frame { origin: ((min + max) / 2.0).round() };
        let height_m = crossings.iter().map(|c| c.upper.z - c.lower.z).fold(0.0, f64::max);
        let margin_m = network.usual_sidewalk_m() + BEHIND_M + height_m.clamp(EMBANKMENT_M.0, EMBANKMENT_M.1);
        let mut points: Vec<(usize, usize)> = crossings.iter().map(|c| (c.lanes[1], c.point)).collect();
        points.sort_unstable();
        points.dedup();
        // Pieces of lower lanes, from the point before a crossing to the one after it.
        let strips: Vec<Contour> = points
            .chunk_by(|a, b| a.0 == b.0 && b.1 <= a.1 + 2)
            .filter_map(|run| {
                let (lane, first, last) = (&lanes[run[0].0], run[0].1, run[run.len() - 1].1);
                frame.strip(&lane.piece(first.saturating_sub(1)..=(last + 1).min(lane.center.len() - 1)))
            })
            .collect();
        let below = union(&strips);
        let rings = |shapes: &Shapes| frame.rings(shapes);
        let outline = grow(&below, margin_m);
        let grown = |by_m: f64| Inside::new(&rings(&grow(&below, margin_m + by_m)));
        Self {
            inside: Inside::new(&rings(&outline)),
            inner: grown(-0.05),
            middle: grown(-OVERLAP_M),
            approach: grown(APPROACH_M),
            near: grown(NEAR_M),
            outline: rings(&outline),
            overpass,
        }
    }

    /// Whether a point of a lane is at the height of the road that leads over the bridge, if it is in plan near it.
    fn is_at_deck(&self, p: DVec3) -> bool {
        let (nearest, distance_m) = self.overpass.nearest(p);
        (p.z - nearest.upper.z).abs() < AT_DECK_M + SLOPE * distance_m
    }

    /// Whether a point of a lane is on the deck, its ends left out.
    pub fn holds_up(&self, p: DVec3) -> bool {
        self.middle.contains(p.truncate()) && self.is_at_deck(p)
    }

    /// Whether a point of a lane is on the deck or right before it.
    pub fn leads_over(&self, p: DVec3) -> bool {
        self.approach.contains(p.truncate()) && self.is_at_deck(p)
    }

    /// Whether a point of a lane lies below the deck or right beside.
    pub fn leads_under(&self, p: DVec3) -> bool {
        let is_below = || p.z < self.overpass.nearest(p).0.upper.z;
        self.near.contains(p.truncate()) && !self.is_at_deck(p) && is_below()
    }

    /// Whether a place is on the bridge, below it, or on the way to it.
    pub fn is_approached(&self, p: DVec2) -> bool {
        self.approach.contains(p)
    }

    /// Whether a place is under the bridge or right beside it.
    pub fn is_near(&self, p: DVec2) -> bool {
        self.near.contains(p)
    }
}
