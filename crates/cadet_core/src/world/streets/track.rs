//! A tram's line: its track from one end to the other, as a polyline with the lanes that it follows.

use std::collections::VecDeque;

use super::roads::Roads;
use crate::math::DVec2;
use crate::town::{LaneId, LaneKind};

/// The longest line; one that closes on itself is gone round until it is so long.
const LONGEST_M: f64 = 4000.0;
/// How far back a line is known from where a tram begins: longer than any tram.
const BEHIND_M: f64 = 120.0;

/// A way along tracks.
#[derive(Debug)]
pub(crate) struct Track {
    /// The lanes in order, and the distance along the line at which each begins.
    lanes: Vec<(LaneId, f64)>,
    points: Vec<DVec2>,
    /// Distance along the line of each point.
    s_m: Vec<f64>,
}

impl Track {
    /// The line that leads through a lane: back to where it begins or far enough, on to its end, at points always the first
    /// of the ways that lead on.
    pub fn through(lane: LaneId, roads: &Roads) -> Self {
        let is_track = |id: &LaneId| roads.lane(*id).kind == LaneKind::Tram;
        let mut lanes = VecDeque::from([lane]);
        let mut behind_m = 0.0;
        while behind_m < BEHIND_M
            && let Some(before) = roads.lane(lanes[0]).predecessors.iter().copied().find(is_track)
        {
            behind_m += roads.lane(before).length_m();
            lanes.push_front(before);
        }
        let mut length_m = behind_m + roads.lane(lane).length_m();
        while length_m < LONGEST_M
            && let Some(next) = roads.lane(lanes[lanes.len() - 1]).successors.iter().copied().find(is_track)
        {
            length_m += roads.lane(next).length_m();
            lanes.push_back(next);
        }
        Self::of(lanes, roads)
    }

    fn of(ids: VecDeque<LaneId>, roads: &Roads) -> Self {
        let (mut lanes, mut points, mut s_m): (Vec<_>, Vec<DVec2>, Vec<f64>) = (Vec::new(), Vec::new(), Vec::new());
        for id in ids {
            lanes.push((id, s_m.last().copied().unwrap_or(0.0)));
            for p in &roads.lane(id).center {
                let p = p.truncate();
                let Some(last) = points.last() else {
                    (points, s_m) = (vec![p], vec![0.0]);
                    continue;
                };
                let step_m = (p - *last).length();
                // Where two lanes meet, both have the point.
                if step_m > 1e-3 {
                    s_m.push(s_m[s_m.len() - 1] + step_m);
                    points.push(p);
                }
            }
        }
        Self { lanes, points, s_m }
    }

    pub fn length_m(&self) -> f64 {
        self.s_m[self.s_m.len() - 1]
    }

    /// The place at a distance along the line; beyond its ends it goes straight on.
    pub fn at(&self, s_m: f64) -> DVec2 {
        let i = self.s_m.partition_point(|v| *v <= s_m).clamp(1, self.points.len() - 1);
        let (a, b) = (self.points[i - 1], self.points[i]);
        a + (b - a) * ((s_m - self.s_m[i - 1]) / (self.s_m[i] - self.s_m[i - 1]))
    }

    /// The lane at a distance along the line, and how far along that lane it is.
    pub fn lane_at(&self, s_m: f64) -> (LaneId, f64) {
        let i = self.lanes.partition_point(|(_, from_m)| *from_m <= s_m).max(1) - 1;
        let (lane, from_m) = self.lanes[i];
        (lane, (s_m - from_m).max(0.0))
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
