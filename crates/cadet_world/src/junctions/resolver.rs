//! Decides who goes first: all who want to cross a junction are looked at together, whatever the order of their slots.

use super::exit_room::exit_blocked_by;
use super::request::{Request, Stage};
use super::reservations::{Junctions, Queued, Refusal, Reservation};
use crate::lane_use::LaneUse;
use crate::params::LOOK_S;
use crate::params::junctions::{MARGIN_S, PATIENCE_S};
use crate::slot::Slot;
use crate::streets::LaneGraph;
use cadet_town::LaneId;

/// A request with its place in the queue.
struct Candidate<'a> {
    request: &'a Request,
    queued: Queued,
    /// Whether it waits for a decision.
    asks: bool,
}

impl Candidate<'_> {
    /// What orders requests: the lane parts those who came at the same look.
    fn came(&self) -> (u64, LaneId) {
        (self.queued.since_step, self.queued.first)
    }

    /// Whether it lets another go first whose way crosses its own.
    fn waits_for(&self, other: &Self) -> bool {
        let is_patient = |a: &Self| f64::from(a.queued.asked_looks) * LOOK_S < PATIENCE_S;
        let is_let = |a: &Self, b: &Self| is_patient(a) || b.request.is_tram && b.asks;
        let yields = |a: &Self, b: &Self| a.request.yields_to(b.request) && is_let(a, b);
        if yields(self, other) {
            return other.request.arrives_s < self.request.clears_s + MARGIN_S;
        }
        !yields(other, self) && other.asks && other.came() < self.came()
    }
}

impl Junctions {
    /// Decides on all requests of one look. Who may go holds the lanes across from now on; what others hold who have
    /// not entered yet and have to wait after all is free again.
    pub fn resolve(&mut self, requests: &[Request], lane_use: &LaneUse, graph: &LaneGraph, step: u64) {
        for waits in requests.iter().filter(|r| r.stage == Stage::Waits) {
            self.held.retain(|h| h.slot != waits.slot || !waits.lanes.contains(&h.lane));
        }
        self.line_up(requests, step);
        // Of those who come on one lane the first alone counts: who is behind it can't go before it.
        let is_first =
            |own: &Request| !requests.iter().any(|other| other.before == own.before && other.front_m < own.front_m);
        let mut candidates: Vec<Candidate<'_>> = requests
            .iter()
            .zip(&self.queue)
            .filter(|(request, _)| request.stage != Stage::Waits && is_first(request))
            .map(|(request, queued)| Candidate { request, queued: *queued, asks: request.stage == Stage::Asks })
            .collect();
        // Nobody waits for who has no way out.
        let blocked = |c: &Candidate<'_>| exit_blocked_by(c.request, lane_use, self, graph).filter(|_| c.asks);
        let blocked: Vec<(Slot, Slot)> =
            candidates.iter().filter_map(|c| Some((c.request.slot, blocked(c)?))).collect();
        for (slot, by) in blocked {
            self.refuse(slot, Refusal::ExitFull(by));
            candidates.retain(|c| c.request.slot != slot);
        }
        candidates.sort_by_key(|c| (!c.request.is_tram, c.came()));
        for own in candidates.iter().filter(|c| c.asks) {
            let decision = match self.hindrance(own, lane_use, graph) {
                Some(refusal) => Err(refusal),
                None => self.first_before(own, &candidates).map_or(Ok(()), |by| Err(Refusal::Yields(by))),
            };
            match decision {
                Ok(()) => self.grant(own.request, step),
                Err(refusal) => self.refuse(own.request.slot, refusal),
            }
        }
        self.break_circles(&candidates, lane_use, graph, step);
    }

    /// Gives every request its place in the queue, in the order of the requests; who asks no more loses it.
    fn line_up(&mut self, requests: &[Request], step: u64) {
        let queue = requests.iter().map(|request| {
            let Request { slot, stage, .. } = *request;
            let first = request.lanes[0];
            let before = self.queue.iter().find(|q| q.slot == slot && q.first == first);
            let since_step = before.filter(|_| stage != Stage::Comes).map_or(step, |q| q.since_step);
            let asked_looks = before.map_or(0, |q| q.asked_looks) + u32::from(stage == Stage::Asks);
            Queued { slot, first, since_step, asked_looks, refusal: Refusal::Undecided }
        });
        self.queue = queue.collect();
    }

    /// The obstacle in the way of a request, whoever goes first.
    fn hindrance(&self, own: &Candidate<'_>, lane_use: &LaneUse, graph: &LaneGraph) -> Option<Refusal> {
        if let Some(by) = exit_blocked_by(own.request, lane_use, self, graph) {
            return Some(Refusal::ExitFull(by));
        }
        let is_in_the_way = |r: &&Reservation| {
            let crosses = |(lane, until_m): &(LaneId, f64)| r.tail_m < *until_m && own.request.lanes.contains(lane);
            r.slot != own.request.slot && self.conflicts.with(r.lane).iter().any(crosses)
        };
        self.held.iter().find(is_in_the_way).map(|r| Refusal::Taken(r.slot))
    }

    /// The first of those whom a request lets go first.
    fn first_before(&self, own: &Candidate<'_>, candidates: &[Candidate<'_>]) -> Option<Slot> {
        let goes_first = |other: &&Candidate<'_>| {
            other.request.slot != own.request.slot
                && self.conflicts.cross([&own.request.lanes, &other.request.lanes])
                && own.waits_for(other)
        };
        candidates.iter().find(goes_first).map(|other| other.request.slot)
    }

    fn refuse(&mut self, slot: Slot, refusal: Refusal) {
        if let Some(q) = self.queue.iter_mut().find(|q| q.slot == slot) {
            q.refusal = refusal;
        }
    }

    fn grant(&mut self, request: &Request, step: u64) {
        self.queue.retain(|q| q.slot != request.slot);
        let exit = request.exits.first().copied().unwrap_or(request.lanes[request.lanes.len() - 1]);
        self.held.extend(request.lanes.iter().map(|lane| Reservation {
            slot: request.slot,
            lane: *lane,
            since_step: step,
            exit,
            room_m: request.room_m,
            tail_m: f64::NEG_INFINITY,
            clear_at_m: None,
        }));
    }

    /// Where each of some waits for another of them, who came first goes: four who come from each other's right.
    fn break_circles(&mut self, candidates: &[Candidate<'_>], lane_use: &LaneUse, graph: &LaneGraph, step: u64) {
        for own in candidates.iter().filter(|c| c.asks) {
            let waits_for = |slot: Slot| match self.refusal(slot) {
                Refusal::Yields(by) => Some(by),
                _ => None,
            };
            let mut circle = vec![own.request.slot];
            while let Some(next) = waits_for(circle[circle.len() - 1]).filter(|next| !circle.contains(next)) {
                circle.push(next);
            }
            // The candidates stand in their order: the first of a circle is the first to be looked at.
            if waits_for(circle[circle.len() - 1]) == Some(own.request.slot)
                && self.hindrance(own, lane_use, graph).is_none()
            {
                self.grant(own.request, step);
            }
        }
    }
}
