//! Right of way: who crosses a junction when. A lane across a junction is reserved before it is entered; lanes that
//! come too near to each other exclude one another; the first to come is the first to go.

use super::roads::Roads;
use super::slot::{EGO, Slot};
use crate::math::{self, DVec3};
use crate::town::{Lane, LaneId, LaneKind};

/// Straight lanes nearer than this to each other can't be used at once.
const CLEARANCE_M: f64 = 2.6;
/// The same where one of them bends: a car sweeps more than its width there.
const CLEARANCE_IN_BENDS_M: f64 = 3.3;
/// The same of a bicycle's way and a car's, straight and in bends, and of two bicycles' ways.
const BESIDE_CYCLES_M: (f64, f64) = (1.8, 2.6);
const BETWEEN_CYCLES_M: f64 = 1.3;

/// One car's right to cross.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reservation {
    car: Slot,
    lane: LaneId,
    has_priority: bool,
    /// The lane on which it leaves the junction, and the room that it takes there.
    exit: LaneId,
    room_m: f64,
    /// How far the car's tail has come along the lane.
    tail_m: f64,
    /// Set once the car's middle has left the lane: the odometer at which its tail has left too.
    clear_at_m: Option<f64>,
}

/// A car that waits at a junction.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    car: Slot,
    lane: LaneId,
    /// At a light, who turns left lets those who come toward it go first.
    yields_to_oncoming: bool,
    has_priority: bool,
    since_step: u64,
    seen_step: u64,
    /// Whether it waits for a tram: whose way does not cross the tram's need not wait with it.
    waits_for_tram: bool,
}

/// What a car asks for.
pub(super) struct Request<'a> {
    pub car: Slot,
    /// The lanes across the junction, and the one after it.
    pub lanes: &'a [LaneId],
    pub exit: LaneId,
    /// What the car takes of the exit, and who leaves less.
    pub room_m: f64,
    pub exit_blocked_by: Option<Slot>,
    /// Whether it turns left at a light.
    pub yields_to_oncoming: bool,
    /// Whether all others let it go first: a tram.
    pub has_priority: bool,
}

/// Who has let others pass for so long goes when its turn comes.
const PATIENCE_STEPS: u64 = 18 * 60;

/// Why a junction may not be entered yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refusal {
    /// Others are ahead of us in the queue.
    NotFirst,
    /// Somebody leaves no room to leave it again.
    ExitFull(Slot),
    /// Somebody whose way crosses ours came earlier.
    Earlier(Slot),
    /// Somebody whose way crosses ours is in it or about to enter.
    Taken(Slot),
    /// Somebody stands where we would swing out.
    InSweep(Slot),
    /// The light is not green.
    Light,
}

/// Conflicts between lanes, and who holds and wants which.
#[derive(Debug, Default)]
pub(super) struct Junctions {
    /// For each lane the lanes that can't be used with it, and how far along it they come too near.
    conflicts: Vec<Vec<(LaneId, f64)>>,
    held: Vec<Reservation>,
    waiting: Vec<Waiting>,
}

impl Junctions {
    pub fn new(roads: &Roads) -> Self {
        let lanes = roads.lanes();
        let crossing: Vec<&Lane> = lanes.iter().filter(|l| is_crossed(l)).collect();
        let mut conflicts = vec![Vec::new(); lanes.len()];
        for (i, a) in crossing.iter().enumerate() {
            for b in &crossing[i + 1..] {
                // Who follows on one lane goes one after the other, but a bicycle's way crosses those of the cars beside it.
                let siblings = a.kind == b.kind && a.predecessors.iter().any(|p| b.predecessors.contains(p));
                if a.junction == b.junction
                    && !siblings
                    && let (Some(until_a_m), Some(until_b_m)) = (conflict_until_m(a, b), conflict_until_m(b, a))
                {
                    conflicts[a.id.0].push((b.id, until_a_m));
                    conflicts[b.id.0].push((a.id, until_b_m));
                }
            }
        }
        Self { conflicts, held: Vec::new(), waiting: Vec::new() }
    }

    /// Lanes that can't be used together with this one.
    #[cfg(test)]
    pub fn conflicts_of(&self, lane: LaneId) -> Vec<LaneId> {
        self.conflicts[lane.0].iter().map(|c| c.0).collect()
    }

    pub fn holds(&self, car: Slot, lane: LaneId) -> bool {
        self.held.iter().any(|r| r.car == car && r.lane == lane)
    }

    pub fn holds_any(&self, car: Slot) -> bool {
        self.held.iter().any(|r| r.car == car && r.clear_at_m.is_none())
    }

    /// Room on an exit lane that is promised to others than `car`, once to each, however many lanes it holds.
    pub fn promised(&self, car: Slot, exit: LaneId) -> impl Iterator<Item = (Slot, f64)> {
        let promised = move |r: &Reservation| r.car != car && r.exit == exit;
        let is_first =
            move |(i, r): &(usize, &Reservation)| !self.held[..*i].iter().any(|q| q.car == r.car && q.exit == exit);
        self.held.iter().enumerate().filter(move |(_, r)| promised(r)).filter(is_first).map(|(_, r)| (r.car, r.room_m))
    }

    /// Asks for a chain of lanes across a junction.
    ///
    /// # Errors
    /// Why it may not enter.
    pub fn request(&mut self, asked: &Request<'_>, step: u64) -> Result<(), Refusal> {
        let Request { car, lanes, exit, room_m, exit_blocked_by, yields_to_oncoming, has_priority } = *asked;
        let Some(&first) = lanes.first() else { return Ok(()) };
        if let Some(other) = exit_blocked_by {
            // It keeps its place, but nobody waits for it meanwhile.
            self.queue(car, first, yields_to_oncoming, (step, false));
            return Err(Refusal::ExitFull(other));
        }
        let taken = self.held.iter().find(|r| {
            r.car != car && self.conflicts[r.lane.0].iter().any(|(l, until_m)| r.tail_m < *until_m && lanes.contains(l))
        });
        let waits_for_tram = taken.is_some_and(|r| r.has_priority) && !has_priority;
        let (since_step, seen_step) = (step, step);
        let asks =
            Waiting { car, lane: first, yields_to_oncoming, has_priority, since_step, seen_step, waits_for_tram };
        let since_step = match self.waiting.iter_mut().find(|w| w.car == car) {
            Some(w) => {
                *w = Waiting { since_step: w.since_step, ..asks };
                w.since_step
            }
            None => {
                self.waiting.push(asks);
                step
            }
        };
        // Trams are let go first. Who turns left lets others pass, for a while; then the ego is let go first, then who came
        // earlier and still asks.
        let rank = |has_priority: bool, car: Slot, yields_to_oncoming: bool, since: u64| {
            (!has_priority, yields_to_oncoming && since + PATIENCE_STEPS > step, car != EGO, since, car)
        };
        let own_rank = rank(has_priority, car, yields_to_oncoming, since_step);
        let earlier = self.waiting.iter().find(|w| {
            w.car != car
                && w.seen_step + 30 > step
                && !w.waits_for_tram
                && rank(w.has_priority, w.car, w.yields_to_oncoming, w.since_step) < own_rank
                && self.conflicts[first.0].iter().any(|c| c.0 == w.lane)
        });
        if let Some(by) = taken {
            return Err(Refusal::Taken(by.car));
        }
        if let Some(by) = earlier {
            return Err(Refusal::Earlier(by.car));
        }
        self.waiting.retain(|w| w.car != car);
        self.held.extend(lanes.iter().map(|lane| Reservation {
            car,
            lane: *lane,
            has_priority,
            exit,
            room_m,
            tail_m: f64::NEG_INFINITY,
            clear_at_m: None,
        }));
        Ok(())
    }

    /// Waits for a lane across a junction that may not be asked for yet; others reckon with it once it soon may.
    pub fn queue(&mut self, car: Slot, lane: LaneId, yields_to_oncoming: bool, (step, is_soon): (u64, bool)) {
        let seen_step = if is_soon { step } else { 0 };
        match self.waiting.iter_mut().find(|w| w.car == car) {
            Some(w) => w.seen_step = seen_step,
            None => self.waiting.push(Waiting {
                car,
                lane,
                yields_to_oncoming,
                has_priority: false,
                since_step: step,
                seen_step,
                waits_for_tram: false,
            }),
        }
    }

    /// The car's tail has come this far along the lane that its middle is on.
    pub fn advance(&mut self, car: Slot, lane: LaneId, tail_m: f64) {
        for r in self.held.iter_mut().filter(|r| r.car == car && r.lane == lane) {
            r.tail_m = tail_m;
        }
    }

    /// The car's middle has left a lane; its tail follows when the odometer reads `clear_at_m`.
    pub fn leaving(&mut self, car: Slot, lane: LaneId, clear_at_m: f64) {
        for r in self.held.iter_mut().filter(|r| r.car == car && r.lane == lane) {
            r.clear_at_m = Some(clear_at_m);
        }
    }

    /// Gives back what the car has cleared.
    pub fn release_cleared(&mut self, car: Slot, odometer_m: f64) {
        self.held.retain(|r| r.car != car || r.clear_at_m.is_none_or(|clear| odometer_m < clear));
    }

    /// Gives lanes back that the car has not entered: a light has changed.
    pub fn release(&mut self, car: Slot, lanes: &[LaneId]) {
        self.held.retain(|r| r.car != car || !lanes.contains(&r.lane));
        self.waiting.retain(|w| w.car != car);
    }

    /// Forgets a car: it was moved away.
    pub fn forget(&mut self, car: Slot) {
        self.held.retain(|r| r.car != car);
        self.waiting.retain(|w| w.car != car);
    }
}

fn is_crossed(lane: &Lane) -> bool {
    matches!(lane.kind, LaneKind::Driving | LaneKind::Tram | LaneKind::Biking) && lane.junction.is_some()
}

fn bends(lane: &Lane) -> bool {
    let c = &lane.center;
    let (a, b) = ((c[1] - c[0]).truncate(), (c[c.len() - 1] - c[c.len() - 2]).truncate());
    math::atan2(a.perp_dot(b), a.dot(b)).abs() > 0.25
}

/// How far along lane `a` a car has to be before another may use lane `b`; `None` if they never come too near.
fn conflict_until_m(a: &Lane, b: &Lane) -> Option<f64> {
    let has_bend = bends(a) || bends(b);
    let limit_m = match (a.kind, b.kind) {
        (LaneKind::Biking, LaneKind::Biking) => BETWEEN_CYCLES_M,
        (LaneKind::Biking, LaneKind::Driving) | (LaneKind::Driving, LaneKind::Biking) if has_bend => BESIDE_CYCLES_M.1,
        (LaneKind::Biking, LaneKind::Driving) | (LaneKind::Driving, LaneKind::Biking) => BESIDE_CYCLES_M.0,
        _ if has_bend => CLEARANCE_IN_BENDS_M,
        _ => CLEARANCE_M,
    };
    let near = |p: &DVec3| {
        let p = p.truncate();
        b.center.windows(2).any(|w| {
            let (q, d) = (p - w[0].truncate(), (w[1] - w[0]).truncate());
            (q - d * (q.dot(d) / d.length_squared()).clamp(0.0, 1.0)).length() < limit_m
        })
    };
    // Points lie at most 2 m apart, less than the limit: no crossing slips between two of them.
    let last = a.center.iter().rposition(near)?;
    Some(a.s_m.get(last + 1).copied().unwrap_or(f64::INFINITY))
}
