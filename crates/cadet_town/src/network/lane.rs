//! Lanes as polylines.

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
    /// Those that OpenDRIVE's lane materials tell, as they call them.
    const NAMES: [(Self, &'static str); 5] = [
        (Self::Grass, "grass"),
        (Self::Ballast, "ballast"),
        (Self::Slabs, "concrete"),
        (Self::Setts, "cobble"),
        (Self::Red, "red"),
    ];

    /// As OpenDRIVE's lane materials call it; `None` for what is not said.
    #[must_use]
    pub fn name(self) -> Option<&'static str> {
        Self::NAMES.into_iter().find(|(surface, _)| *surface == self).map(|(_, name)| name)
    }

    /// The surface of a lane material's name; [`LaneSurface::Usual`] for any other.
    #[must_use]
    pub fn from_name(name: &str) -> Self {
        Self::NAMES.into_iter().find(|(_, of)| *of == name).map_or(Self::Usual, |(surface, _)| surface)
    }
}

/// A lane between two junctions, or across one.
#[derive(Debug, Clone)]
pub struct Lane {
    /// Its index in [`RoadNetwork::lanes`](crate::RoadNetwork::lanes).
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
