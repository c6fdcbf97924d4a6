//! The lanes of a town, how they follow each other, and what a map has along them.

use std::collections::BTreeMap;

use crate::network::lane::{Lane, LaneId, LaneKind, LaneSurface};
use cadet_base::math::{DVec2, DVec3};

/// Color of the paint on a road.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PaintColor {
    /// White, and whatever a map names that is not yellow.
    White,
    /// Yellow: roadworks in Germany, the middle of the road elsewhere.
    Yellow,
    /// The bare steel of a rail's head: no paint, but laid on the ground as paint is.
    Steel,
    /// The groove beside it, a rail's foot, or a sleeper.
    Dark,
    /// The coat of a cycle lane.
    Red,
    /// Asphalt of a repair, darker or lighter than the street's.
    NewAsphalt,
    /// See `NewAsphalt`.
    OldAsphalt,
    /// What seals cracks, and their shade where nothing does.
    Bitumen,
    /// The cover of a manhole.
    Iron,
}

/// A piece of a painted line.
#[derive(Debug, Clone, Copy)]
pub struct PaintedQuad {
    /// Counter-clockwise from above.
    pub corners: [DVec3; 4],
    /// Its color.
    pub color: PaintColor,
    /// Which line it is a piece of: all pieces of one are equally worn.
    pub line: u32,
}

/// A traffic light as a map has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapLight {
    /// The lanes whose traffic it holds before a junction.
    pub lanes: Vec<LaneId>,
    /// The controller that it belongs to.
    pub controller: Option<usize>,
}

/// What traffic does at the junction at the end of its lane, as the German StVO has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RightOfWay {
    /// As the light says (§ 37).
    Signal,
    /// It goes first (sign 306).
    Priority,
    /// It lets those with priority go first (sign 205): at roundabouts, and where a faster road goes through.
    Yield,
    /// It stops before it goes (sign 206): where only fast streets meet.
    Stop,
    /// Traffic from the right goes first (§ 8).
    RightFirst,
}

/// The lanes of a town.
#[derive(Debug, Clone, Default)]
pub struct RoadNetwork {
    /// Every lane; a [`LaneId`] indexes it.
    pub lanes: Vec<Lane>,
    /// Lines that the map has along its lanes.
    pub lane_marks: Vec<PaintedQuad>,
    /// The traffic lights that the map has.
    pub lights: Vec<MapLight>,
    /// What the map's signs say of who goes first, by lane before a junction.
    pub(crate) signs: BTreeMap<LaneId, RightOfWay>,
    /// The junctions that are roundabouts, in ascending order.
    pub roundabouts: Vec<u32>,
    /// What places of the network lack of the map's own coordinates, in whole kilometers; 0 for maps near their origin.
    pub offset_m: DVec2,
    /// Where the map lies on the earth, if it says so.
    pub geo_reference: Option<GeoReference>,
}

/// Where a map lies on the earth (ASAM OpenDRIVE 1.8, section 8.4).
#[derive(Debug, Clone, PartialEq)]
pub struct GeoReference {
    /// The projection of its coordinates, as a PROJ string.
    pub projection: String,
    /// What the map's header adds to them, meters: x, y, z, after a turn about z by the heading.
    pub offset_m: [f64; 3],
    /// See `offset_m`.
    pub heading_rad: f64,
}

impl RoadNetwork {
    /// A straight level road of two lanes along x through the origin, 50 km/h: eastbound at y = -width/2, westbound at
    /// y = +width/2. The length is at least 1 m.
    #[must_use]
    pub fn straight(length_m: f64, lane_width_m: f64) -> Self {
        let length_m = length_m.max(1.0);
        let steps = (length_m / 2.0).ceil() as usize;
        let lane = |id: usize, side: f64| {
            let s_m: Vec<f64> = (0..=steps).map(|i| length_m * i as f64 / steps as f64).collect();
            let place = |s: &f64| DVec3::new((s - length_m / 2.0) * -side, side * lane_width_m / 2.0, 0.0);
            let (center, width_m) = (s_m.iter().map(place).collect(), vec![lane_width_m; s_m.len()]);
            Lane { s_m, ..Lane::new(LaneId(id), 0, center, width_m) }
        };
        Self { lanes: vec![lane(0, -1.0), lane(1, 1.0)], ..Self::default() }
    }

    /// The lane of an id.
    #[must_use]
    pub fn lane(&self, id: LaneId) -> &Lane {
        &self.lanes[id.0]
    }

    /// Whether most of the map's traffic keeps left.
    #[must_use]
    pub fn is_left_hand(&self) -> bool {
        let left = self.driving().filter(|l| l.keeps_left).count();
        2 * left > self.driving().count()
    }

    /// Whether the roads lie in open country: with verges, and without a sidewalk anywhere.
    #[must_use]
    pub fn is_rural(&self) -> bool {
        self.of_kind(LaneKind::Verge).next().is_some() && self.of_kind(LaneKind::Sidewalk).next().is_none()
    }

    /// The width that three quarters of the map's sidewalks have; 2 m where it has none.
    pub(crate) fn usual_sidewalk_m(&self) -> f64 {
        let sidewalks = self.of_kind(LaneKind::Sidewalk).filter(|l| l.junction.is_none());
        let mut widths: Vec<f64> = sidewalks.map(|l| l.width_m[l.width_m.len() / 2]).filter(|w| *w > 0.5).collect();
        widths.sort_by(f64::total_cmp);
        widths.get(widths.len() / 4).copied().unwrap_or(2.0).clamp(1.2, 4.5)
    }

    /// Whether all streets are paved with setts from wall to wall, without curbs.
    #[must_use]
    pub fn is_curbless(&self) -> bool {
        let mut streets = self.driving().filter(|l| l.junction.is_none()).peekable();
        streets.peek().is_some() && streets.all(|l| l.surface == LaneSurface::Setts)
    }

    /// Whether the roads are a motorway's or a bypass's: two carriageways in open country.
    #[must_use]
    pub fn is_motorway(&self) -> bool {
        self.is_rural() && self.of_kind(LaneKind::Median).next().is_some()
    }

    /// Whether a lane leads through a roundabout.
    #[must_use]
    pub fn is_in_roundabout(&self, lane: &Lane) -> bool {
        lane.junction.is_some_and(|junction| self.roundabouts.binary_search(&junction).is_ok())
    }

    /// Whether the traffic of a lane comes to a roundabout at its end.
    #[must_use]
    pub fn ends_at_roundabout(&self, lane: &Lane) -> bool {
        lane.successors.iter().any(|next| self.is_in_roundabout(self.lane(*next)))
    }

    /// The junction that a lane outside of junctions leads to.
    pub(crate) fn junction_after(&self, lane: &Lane) -> Option<u32> {
        lane.successors.iter().find_map(|next| self.lane(*next).junction)
    }

    /// Whether a lane leads into a junction from outside.
    pub(crate) fn leads_into(&self, lane: &Lane, junction: u32) -> bool {
        lane.junction.is_none() && lane.successors.iter().any(|next| self.lane(*next).junction == Some(junction))
    }

    /// The lanes of a kind.
    pub fn of_kind(&self, kind: LaneKind) -> impl Iterator<Item = &Lane> {
        self.lanes.iter().filter(move |l| l.kind == kind)
    }

    /// The lanes that trams run on.
    pub fn tracks(&self) -> impl Iterator<Item = &Lane> {
        self.of_kind(LaneKind::Tram)
    }

    /// The lanes that cars drive on.
    pub fn driving(&self) -> impl Iterator<Item = &Lane> {
        self.of_kind(LaneKind::Driving)
    }
}
