//! What who comes to a junction wants of it, and lets others know.

use crate::params::TURNS_RAD;
use crate::params::junctions::COS_ON_ONE_LINE;
use crate::slot::Slot;
use cadet_base::math::DVec2;
use cadet_town::{LaneId, RightOfWay};

/// How far a request has got.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    /// It comes: others reckon with it, and it needs no decision yet.
    Comes,
    /// It has to brake from now on unless it may go.
    Asks,
    /// It may not go yet, whatever others do.
    Waits,
}

/// Where somebody goes at a junction, by what they yield to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Turn {
    Straight,
    /// To the side of the curb, across nobody's way who comes toward one.
    Near,
    /// Across the way of those who come toward one: to the left where traffic keeps right.
    Across,
}

impl Turn {
    /// That of a way that turns by so much, above 0 to the side of the curb.
    pub fn of(to_curb_rad: f64) -> Self {
        match to_curb_rad {
            t if t > TURNS_RAD => Self::Near,
            t if t < -TURNS_RAD => Self::Across,
            _ => Self::Straight,
        }
    }
}

/// A vehicle and the way across the next junction that it has no right to enter yet.
#[derive(Debug, Clone)]
pub(crate) struct Request {
    pub slot: Slot,
    /// The lane that it comes on, and how far its front is from the junction.
    pub before: LaneId,
    pub front_m: f64,
    /// The lanes across the junction, and those after it up to the next one.
    pub lanes: Vec<LaneId>,
    pub exits: Vec<LaneId>,
    /// The room that it takes behind the junction.
    pub room_m: f64,
    pub is_tram: bool,
    /// That of its approach; `None` at roundabouts, where all who come are alike.
    pub right_of_way: Option<RightOfWay>,
    /// Unit vector along its approach.
    pub heading: DVec2,
    pub turn: Turn,
    /// +1 where traffic keeps left, -1 where it keeps right.
    pub curb_side: f64,
    /// When its front is at the junction if it goes on as it does, and when its tail has crossed if it starts now.
    pub arrives_s: f64,
    pub clears_s: f64,
    pub stage: Stage,
}

impl Request {
    /// Whether it has to let another go first (StVO 8, 9 (3), 37).
    pub fn yields_to(&self, other: &Self) -> bool {
        if self.is_tram || other.is_tram {
            return !self.is_tram && other.is_tram;
        }
        let (Some(own), Some(theirs)) = (self.right_of_way, other.right_of_way) else { return false };
        let is_minor = |r: RightOfWay| matches!(r, RightOfWay::Yield | RightOfWay::Stop);
        if is_minor(own) != is_minor(theirs) {
            return is_minor(own);
        }
        if self.heading.dot(other.heading).abs() > COS_ON_ONE_LINE {
            return other.turn < self.turn;
        }
        // From the side of the curb: from the right where traffic keeps right.
        let from_curb = -self.curb_side * self.heading.perp_dot(other.heading);
        own == RightOfWay::RightFirst && from_curb > 0.0
    }
}

#[cfg(test)]
impl Request {
    /// That of a car that has stood at a junction's line, to go straight on.
    pub fn of_car(slot: Slot, lanes: &[LaneId]) -> Self {
        Self {
            slot,
            before: LaneId(slot),
            front_m: 0.0,
            lanes: lanes.to_vec(),
            exits: Vec::new(),
            room_m: 1.0,
            is_tram: false,
            right_of_way: Some(RightOfWay::RightFirst),
            heading: DVec2::X,
            turn: Turn::Straight,
            curb_side: -1.0,
            arrives_s: 0.0,
            clears_s: 5.0,
            stage: Stage::Asks,
        }
    }
}
