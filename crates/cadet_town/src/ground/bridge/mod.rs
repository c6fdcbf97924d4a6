//! Bridges: where a road passes over another, its surface there is a deck of its own above the ground.

mod deck;
mod span;
mod structure;

use std::borrow::Cow;

pub(crate) use deck::{Deck, pieces_of_rings};
use span::Span;

use crate::ground::region::Ring;
use crate::network::{Lane, Overpass, RoadNetwork};
use cadet_base::error::Result;
use cadet_base::math::{DVec2, DVec3};

/// The thickness of a deck, from the road to its underside.
const DECK_DEPTH_M: f64 = 1.1;

/// The ground is as high as the road up to so far beside its sidewalks.
const BESIDE_SIDEWALK_M: f64 = 0.5;

/// The bridges of a network.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bridges {
    spans: Vec<Span>,
}

impl Bridges {
    /// Finds them.
    pub fn of(network: &RoadNetwork) -> Self {
        let overpasses = Overpass::all(&network.lanes);
        Self { spans: overpasses.into_iter().map(|overpass| Span::of(overpass, network)).collect() }
    }

    /// Lays their decks, with bumps and dips as the ground has them.
    ///
    /// # Errors
    /// [`cadet_base::Error::Map`] where a deck has no carriageway or can't be cut into triangles.
    pub fn decks(&self, network: &RoadNetwork, bumps: &dyn Fn(DVec2) -> f64) -> Result<Vec<Deck<'_>>> {
        self.spans.iter().map(|span| Deck::lay(span, network, bumps)).collect()
    }

    /// What of the lanes lies on the ground: all but the pieces on decks. A deck's ends lie over pieces that go on below.
    pub fn on_ground<'a>(&self, lanes: &'a [Lane]) -> Cow<'a, [Lane]> {
        if self.spans.is_empty() {
            return Cow::Borrowed(lanes);
        }
        let is_on_ground = |p: &DVec3| !self.spans.iter().any(|span| span.holds_up(*p));
        Cow::Owned(lanes.iter().flat_map(|lane| lane.pieces(is_on_ground)).collect())
    }

    /// Points beside the lanes near bridges, at their heights: the ground between an abutment and the road below is steep, and
    /// would swing between the lanes' middles.
    pub fn beside_lanes(&self, lanes: &[Lane], sidewalk_m: f64) -> Vec<DVec3> {
        let near = |lane: &Lane| lane.pieces(|p| self.spans.iter().any(|span| span.is_approached(p.truncate())));
        edges_of(&lanes.iter().flat_map(near).collect::<Vec<Lane>>(), sidewalk_m)
    }

    /// The outlines of all spans.
    pub fn outlines(&self) -> Vec<Ring> {
        self.spans.iter().flat_map(|span| span.outline.clone()).collect()
    }

    /// Whether a place is under a bridge or right beside.
    pub fn are_near(&self, p: DVec2) -> bool {
        self.spans.iter().any(|span| span.is_near(p))
    }
}

/// Points on both edges of the lanes that are driven on and on sidewalks beside them, at the heights of the lanes' middles.
fn edges_of(lanes: &[Lane], sidewalk_m: f64) -> Vec<DVec3> {
    let edges = |lane: &Lane| -> Vec<DVec3> {
        let beside = |s_m: &f64| {
            let ((middle, left), half_m) = (lane.middle_and_left(*s_m), lane.width_at(*s_m) / 2.0);
            let reach_m = half_m + sidewalk_m + BESIDE_SIDEWALK_M;
            [-reach_m, -half_m, half_m, reach_m].map(|left_m| middle + (left * left_m).extend(0.0))
        };
        lane.s_m.iter().flat_map(beside).collect()
    };
    lanes.iter().filter(|l| l.is_driven()).flat_map(edges).collect()
}
