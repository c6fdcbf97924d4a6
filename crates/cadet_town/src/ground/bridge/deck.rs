//! The deck of a bridge: a surface laid as the ground is, above it.

use super::span::Span;
use super::structure::structure;
use super::{DECK_DEPTH_M, edges_of};
use crate::ground::mesh;
use crate::ground::region::{Inside, Regions, with_steps};
use crate::ground::{FINEST_CELL_AT_BRIDGES_M, Fineness, HeightField, Heights, PlanMesh, Surface, road_heights};
use crate::network::{Lane, RoadNetwork};
use cadet_base::error::Result;
use cadet_base::instance::Instance;
use cadet_base::math::DVec2;
use cadet_base::plane::bounds;

/// What covers the ground goes on so far beyond the outlines of lanes that lead under a bridge.
const BESIDE_M: f64 = 0.2;

/// The deck of a bridge.
pub(crate) struct Deck<'a> {
    pub plan: PlanMesh,
    pub surface: Surface,
    /// Sides, railings, and underside, to look at.
    pub structure: Instance,
    /// Lines along the middles of its sidewalks.
    pub walks: Vec<Vec<DVec2>>,
    height: HeightField,
    /// All that lies on the deck's road and its approaches.
    outline: Inside,
    /// What the lanes below cover, with their sidewalks.
    below: Inside,
    span: &'a Span,
}

impl<'a> Deck<'a> {
    /// Lays the deck of a span, with bumps and dips as the ground has them.
    ///
    /// # Errors
    /// As [`Regions::of`].
    pub fn lay(span: &'a Span, network: &RoadNetwork, bumps: &dyn Fn(DVec2) -> f64) -> Result<Self> {
        let lanes: Vec<Lane> = network.lanes.iter().flat_map(|l| l.pieces(|p| span.leads_over(*p))).collect();
        let regions = Regions::of(network, &lanes, None)?;
        let mut samples = road_heights(&lanes);
        samples.extend(edges_of(&lanes, regions.sidewalk_width_m));
        let rings = regions.carriageway.iter().chain(&regions.sidewalk).chain(&span.outline);
        let (min, max) = bounds(rings.flatten().copied());
        let (min, max) = (min - 1.0, max + 1.0);
        let height = HeightField::fit(&samples, (min, max), FINEST_CELL_AT_BRIDGES_M);
        let whole = mesh::triangulate(
            (&regions, network.is_curbless()),
            &samples,
            (min, max),
            (Fineness::HILLY, &span.outline),
        )?;
        let outline = Inside::new(&regions.sidewalk);
        let plan = whole.retain(|middle| span.inside.contains(middle) && outline.contains(middle));
        let road = |p: DVec2| height.height(p) + bumps(p);
        let surface = Surface::raise(&plan, &Heights::beside_roads(&road, network));
        let structure = structure(&plan, &surface, &|p| span.inner.contains(p));
        let walks = pieces_of_rings(&regions.walks, |p| span.inside.contains(p));
        let under: Vec<Lane> = network.lanes.iter().flat_map(|l| l.pieces(|p| span.leads_under(*p))).collect();
        let below = Inside::new(&Regions::covered(network, &under, BESIDE_M));
        Ok(Self { plan, surface, structure, walks, height, outline, below, span })
    }

    /// Height of the road on the deck at a place, without bumps.
    pub fn height_m(&self, p: DVec2) -> f64 {
        self.height.height(p)
    }

    /// The most that the ground may rise to at a place: as far as the deck's underside where it lies below the deck.
    pub fn ceiling_m(&self, p: DVec2) -> f64 {
        let is_below = self.span.inner.contains(p) && self.outline.contains(p);
        if is_below { self.height.height(p) - DECK_DEPTH_M } else { f64::INFINITY }
    }

    /// Whether what would lie on the ground at a place is the end of the deck's road, which the deck hides.
    pub fn hides(&self, p: DVec2) -> bool {
        self.span.inside.contains(p) && self.outline.contains(p) && !self.below.contains(p)
    }
}

/// The pieces of closed lines that are kept; a line of which all is kept ends where it begins.
pub(crate) fn pieces_of_rings(rings: &[Vec<DVec2>], is_kept: impl Fn(DVec2) -> bool) -> Vec<Vec<DVec2>> {
    /// Between two points of a line.
    const STEP_M: f64 = 1.9;
    let mut lines = Vec::new();
    for ring in rings {
        let mut ring = with_steps(ring, STEP_M);
        match ring.iter().position(|p| !is_kept(*p)) {
            // From a point that is left out on, so that no piece is cut in two.
            Some(first) => {
                ring.rotate_left(first);
                let pieces = ring.chunk_by(|a, b| is_kept(*a) == is_kept(*b)).filter(|piece| is_kept(piece[0]));
                lines.extend(pieces.filter(|piece| piece.len() > 1).map(<[DVec2]>::to_vec));
            }
            None => {
                ring.extend(ring.first().copied());
                lines.push(ring);
            }
        }
    }
    lines
}
