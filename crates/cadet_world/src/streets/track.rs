//! A tram's line: its track from one end to the other, as a polyline with the lanes that it follows.

use std::collections::VecDeque;

use super::lane_graph::{LaneGraph, LanePosition};
use cadet_base::math::DVec2;
use cadet_base::plane::Polyline;
use cadet_town::{LaneId, LaneKind};

/// The longest line; one that closes on itself is gone round until it is so long.
const LONGEST_M: f64 = 4000.0;
/// How far back a line is known from where a tram begins: longer than any tram.
const BEHIND_M: f64 = 120.0;

/// A way along tracks.
#[derive(Debug)]
pub(crate) struct Track {
    /// The lanes in order, and the distance along the line at which each begins.
    lanes: Vec<(LaneId, f64)>,
    line: Polyline,
}

impl Track {
    /// The line that leads through a lane: back to where it begins or far enough, on to its end, at points always the first
    /// of the ways that lead on.
    pub fn through(lane: LaneId, graph: &LaneGraph) -> Self {
        let is_track = |id: &LaneId| graph.lane(*id).kind == LaneKind::Tram;
        let mut lanes = VecDeque::from([lane]);
        let mut behind_m = 0.0;
        while behind_m < BEHIND_M
            && let Some(before) = graph.lane(lanes[0]).predecessors.iter().copied().find(is_track)
        {
            behind_m += graph.lane(before).length_m();
            lanes.push_front(before);
        }
        let mut length_m = behind_m + graph.lane(lane).length_m();
        while length_m < LONGEST_M
            && let Some(next) = graph.lane(lanes[lanes.len() - 1]).successors.iter().copied().find(is_track)
        {
            length_m += graph.lane(next).length_m();
            lanes.push_back(next);
        }
        Self::of(lanes, graph)
    }

    fn of(ids: VecDeque<LaneId>, graph: &LaneGraph) -> Self {
        let (mut lanes, mut points): (Vec<_>, Vec<DVec2>) = (Vec::new(), Vec::new());
        let mut length_m = 0.0;
        for id in ids {
            lanes.push((id, length_m));
            for p in graph.lane(id).center.iter().map(|p| p.truncate()) {
                // Where two lanes meet, both have the point.
                let step_m = points.last().map_or(f64::INFINITY, |last| (p - *last).length());
                if step_m > 1e-3 {
                    length_m += if points.is_empty() { 0.0 } else { step_m };
                    points.push(p);
                }
            }
        }
        Self { lanes, line: Polyline::new(points) }
    }

    pub fn length_m(&self) -> f64 {
        self.line.length_m()
    }

    /// The place at a distance along the line; beyond its ends it goes straight on.
    pub fn at(&self, s_m: f64) -> DVec2 {
        self.line.at(s_m)
    }

    /// The place on the lanes at a distance along the line.
    pub fn position(&self, s_m: f64) -> LanePosition {
        let i = self.lanes.partition_point(|(_, from_m)| *from_m <= s_m).max(1) - 1;
        let (lane, from_m) = self.lanes[i];
        LanePosition { lane, s_m: (s_m - from_m).max(0.0), left_m: 0.0 }
    }

    /// The lanes from the one at a distance along the line on.
    pub fn lanes_from(&self, s_m: f64) -> VecDeque<LaneId> {
        let i = self.lanes.partition_point(|(_, from_m)| *from_m <= s_m).max(1) - 1;
        self.lanes[i..].iter().map(|(lane, _)| *lane).collect()
    }

    /// Where the first of the stretches of a lane begins.
    pub fn start_of(&self, lane: LaneId) -> Option<f64> {
        self.lanes.iter().find(|(id, _)| *id == lane).map(|(_, from_m)| *from_m)
    }
}
