//! Lanes as polylines, and how they follow each other.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use cadet_base::frames;
use cadet_base::math::{self, DPose3, DVec2, DVec3};
use cadet_base::plane::{nearest, piece_at};

/// Index of a lane in its network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneId(pub usize);

/// What a lane is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaneKind {
    /// Cars drive here.
    Driving,
    /// People walk here.
    Sidewalk,
    /// Cars stand here.
    Parking,
    /// Bicycles.
    Biking,
    /// Shoulders, curbs, borders: paved, but nobody's.
    Shoulder,
    /// Green between the two directions.
    Median,
    /// A soft shoulder: grass beside a road without a curb.
    Verge,
    /// A track in a street: trams run here, and cars cross at junctions.
    Tram,
    /// Verges and the like.
    Other,
}

/// What a lane is covered with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LaneSurface {
    /// What its kind has: asphalt on carriageways.
    #[default]
    Usual,
    /// Grass, between the rails too.
    Grass,
    /// Sleepers in ballast.
    Ballast,
    /// Slabs of concrete.
    Slabs,
    /// Setts or blocks, without a curb beside them.
    Setts,
    /// Asphalt with a red coat, as on cycle lanes in junctions.
    Red,
}

impl LaneSurface {
    /// As OpenDRIVE's lane materials call it; `None` for what is not said.
    #[must_use]
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::Usual => None,
            Self::Grass => Some("grass"),
            Self::Ballast => Some("ballast"),
            Self::Slabs => Some("concrete"),
            Self::Setts => Some("cobble"),
            Self::Red => Some("red"),
        }
    }

    /// The surface of a lane material's name; [`LaneSurface::Usual`] for any other.
    #[must_use]
    pub fn from_name(name: &str) -> Self {
        let others = [Self::Grass, Self::Ballast, Self::Slabs, Self::Setts, Self::Red];
        others.into_iter().find(|s| s.name() == Some(name)).unwrap_or(Self::Usual)
    }
}

/// A lane between two junctions, or across one.
#[derive(Debug, Clone)]
pub struct Lane {
    /// Its index in [`RoadNetwork::lanes`].
    pub id: LaneId,
    /// What it is for.
    pub kind: LaneKind,
    /// What covers it.
    pub surface: LaneSurface,
    /// The middle of the lane in driving direction; at least two points, none repeated, at most 2 m apart.
    pub center: Vec<DVec3>,
    /// Width at each point.
    pub width_m: Vec<f64>,
    /// Distance along the lane at each point; the first is 0.
    pub s_m: Vec<f64>,
    /// Lanes that follow.
    pub successors: Vec<LaneId>,
    /// Lanes that lead here.
    pub predecessors: Vec<LaneId>,
    /// The junction that the lane crosses, if it does.
    pub junction: Option<u32>,
    /// The road that it belongs to.
    pub road: u32,
    /// Speed limit.
    pub speed_limit_mps: f64,
    /// Whether traffic keeps left on its road.
    pub keeps_left: bool,
}

/// Lanes without a speed limit get the one of German towns: 50 km/h.
pub(crate) const DEFAULT_SPEED_MPS: f64 = 50.0 / 3.6;
/// A lane whose ends are nearer to each other closes on itself.
const CLOSED_M: f64 = 0.05;

impl Lane {
    /// A driving lane of 50 km/h along some points, outside of junctions and not linked to others.
    pub(crate) fn new(id: LaneId, road: u32, center: Vec<DVec3>, width_m: Vec<f64>) -> Self {
        let mut s_m = vec![0.0];
        for pair in center.windows(2) {
            s_m.push(s_m[s_m.len() - 1] + (pair[1] - pair[0]).length());
        }
        Self {
            id,
            kind: LaneKind::Driving,
            surface: LaneSurface::Usual,
            center,
            width_m,
            s_m,
            successors: Vec::new(),
            predecessors: Vec::new(),
            junction: None,
            road,
            speed_limit_mps: DEFAULT_SPEED_MPS,
            keeps_left: false,
        }
    }

    /// Where it ends.
    pub(crate) fn end(&self) -> DVec3 {
        self.center[self.center.len() - 1]
    }

    /// Whether it closes on itself, as about the middle of a roundabout.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.center.len() > 3 && (self.end() - self.center[0]).truncate().length() < CLOSED_M
    }

    /// Whether vehicles drive or stand on it.
    pub(crate) fn is_driven(&self) -> bool {
        matches!(self.kind, LaneKind::Driving | LaneKind::Parking | LaneKind::Biking | LaneKind::Tram)
    }

    /// The sign of offsets to the left that lead away from oncoming traffic, to the curb: -1 where traffic keeps right.
    #[must_use]
    pub fn curb_side(&self) -> f64 {
        if self.keeps_left { 1.0 } else { -1.0 }
    }

    /// Unit vector along the lane at its start, in the plane.
    #[must_use]
    pub fn start_tangent(&self) -> DVec2 {
        (self.center[1] - self.center[0]).truncate().normalize_or(DVec2::X)
    }

    /// Unit vector along the lane at its end, in the plane.
    #[must_use]
    pub fn end_tangent(&self) -> DVec2 {
        let n = self.center.len();
        (self.center[n - 1] - self.center[n - 2]).truncate().normalize_or(DVec2::X)
    }

    /// The angle from its direction at the start to that at the end: above 0 where it turns left.
    #[must_use]
    pub fn turn_rad(&self) -> f64 {
        math::turn_rad(self.start_tangent(), self.end_tangent())
    }

    /// Length along the middle.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.s_m.last().copied().unwrap_or(0.0)
    }

    /// The place at distance `s_m` (clamped to the lane), x along the lane, z up from the road.
    #[must_use]
    pub fn pose_at(&self, s_m: f64) -> DPose3 {
        let (at, along) = self.point_and_way_at(s_m);
        frames::facing(at, along, DVec3::Z)
    }

    /// The point at distance `s_m` (clamped to the lane).
    #[must_use]
    pub fn point_at(&self, s_m: f64) -> DVec3 {
        self.point_and_way_at(s_m).0
    }

    /// The middle of the lane at distance `s_m` (clamped to the lane), and the unit vector to its left, in the plane.
    pub fn middle_and_left(&self, s_m: f64) -> (DVec3, DVec2) {
        let pose = self.pose_at(s_m);
        (pose.translation, (pose.rotation * DVec3::Y).truncate().normalize_or_zero())
    }

    fn point_and_way_at(&self, s_m: f64) -> (DVec3, DVec3) {
        let (i, share) = piece_at(&self.s_m, s_m.clamp(0.0, self.length_m()));
        let (a, b) = (self.center[i - 1], self.center[i]);
        (a + (b - a) * share, b - a)
    }

    /// The piece between two of its points, both included.
    pub(crate) fn piece(&self, points: RangeInclusive<usize>) -> Self {
        let from_m = self.s_m[*points.start()];
        Self {
            center: self.center[points.clone()].to_vec(),
            width_m: self.width_m[points.clone()].to_vec(),
            s_m: self.s_m[points].iter().map(|s| s - from_m).collect(),
            ..self.clone()
        }
    }

    /// The longest pieces of which every point is kept; points that stand alone are no piece.
    pub(crate) fn pieces(&self, is_kept: impl Fn(&DVec3) -> bool) -> Vec<Self> {
        let kept: Vec<usize> = (0..self.center.len()).filter(|i| is_kept(&self.center[*i])).collect();
        let runs = kept.chunk_by(|a, b| b - a == 1).filter(|run| run.len() > 1);
        runs.map(|run| self.piece(run[0]..=run[run.len() - 1])).collect()
    }

    /// Width at distance `s_m` (clamped to the lane).
    #[must_use]
    pub fn width_at(&self, s_m: f64) -> f64 {
        let i = self.s_m.partition_point(|v| *v <= s_m).clamp(1, self.center.len()) - 1;
        self.width_m[i]
    }

    /// Distance along the lane of the point nearest to `position` in the plane, and how far away that is.
    #[must_use]
    pub fn project(&self, position: DVec3) -> (f64, f64) {
        nearest(self.center.iter().map(|p| p.truncate()), &self.s_m, position.truncate())
    }
}

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
