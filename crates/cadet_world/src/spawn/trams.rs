//! Trams: on the tracks of a town, a few around the ego, each of several cars.

use std::sync::Arc;

use super::spawner::{Entry, Newcomer, Spawner};
use crate::agents::{Actor, AgentKind, Coupled, Train, Tram, TramCar};
use crate::body::{Guided, Settled, settle};
use crate::footprint::Footprint;
use crate::look::VehicleLook;
use crate::physics::DT_S;
use crate::slot::Slot;
use crate::streets::{Ahead, Track};
use cadet_assets::vehicle::VehicleModel;
use cadet_assets::vehicle::tram::train_of_traffic;
use cadet_base::plane::heading_rad;
use cadet_town::{LaneId, LaneKind};

/// Trams farther from the ego than this give their place to others, which appear where it does not see them.
const GONE_M: f64 = 210.0;
const APPEARS_M: (f64, f64) = (95.0, 190.0);
/// Trams start this far from the ego.
pub(super) const STARTS_M: (f64, f64) = (12.0, 130.0);
/// What has reached the end of its line is taken away where nobody sees it.
const UNSEEN_M: f64 = 100.0;
/// Between a tram and the next that appears, whichever way it goes.
const PAUSE_S: (f64, f64) = (10.0, 30.0);
/// Nearer to each other along a track no two trams appear.
const SPACING_M: f64 = 75.0;
/// Room before and behind at the start, and beside.
const HEADWAY_M: f64 = 12.0;
const BESIDE_M: f64 = 0.3;
/// Speed at the start, and the deceleration at which it allows a stop before the next junction.
const STARTS_MPS: (f64, f64) = (5.0, 10.0);
const STOPS_MPS2: f64 = 1.0;
/// A cab stands over its bogie this far behind the front.
const CAB_TO_BOGIE_M: f64 = 2.4;

impl Spawner<'_> {
    /// Replaces a tram that has gone too far away, or has reached the end of its line, unseen; returns how many steps pass
    /// before the next one.
    pub(super) fn renew_tram(&mut self, respawns: &mut u64) -> Option<u64> {
        for slot in self.gone_trams() {
            let mut stream = self.key.indexed("new trams", *respawns);
            *respawns += 1;
            let mut by = Newcomer { slot, stream: &mut stream, ring_m: APPEARS_M, entry: Entry::Unseen };
            let Some(tram) = self.new_tram(&mut by) else { continue };
            self.arena.replace(slot, tram);
            return Some((stream.within(PAUSE_S) / DT_S) as u64);
        }
        None
    }

    /// The slots of trams that may go.
    fn gone_trams(&self) -> Vec<Slot> {
        let (ego, view) = self.arena.ego_place();
        let trams = self.arena.each::<Tram>().filter(|(_, agent, _)| !agent.is_placed);
        let gone = trams.filter(|(_, agent, tram)| {
            agent.actors().all(|(_, car)| {
                let to = car.body.world_from_box(&self.arena.physics).translation.truncate() - ego;
                let is_unseen = to.length() > UNSEEN_M || (to.length() > 30.0 && to.dot(view) < 0.0);
                to.length() > GONE_M || (tram.train.is_at_end() && is_unseen)
            })
        });
        gone.map(|(slot, ..)| slot).collect()
    }

    /// A tram at a random free place of the tracks.
    pub(super) fn new_tram(&mut self, by: &mut Newcomer<'_>) -> Option<AgentKind> {
        let models = train_of_traffic(by.stream.next_u64());
        let length_m: f64 = models.iter().map(|m| m.size_lwh.x).sum();
        let tracks = self.arena.streets.graph.lanes().iter();
        let tracks = tracks.filter(|l| l.kind == LaneKind::Tram && l.junction.is_none());
        let places = self.places_on(tracks, length_m / 2.0, by);
        for _ in 0..12 {
            let place = by.stream.try_pick(&places)?;
            if let Some(tram) = self.tram_at(by, &models, length_m, place) {
                return Some(tram.into());
            }
        }
        None
    }

    /// A tram with its middle at a place of a track, if it is free.
    fn tram_at(
        &mut self,
        by: &mut Newcomer<'_>,
        models: &[Arc<VehicleModel>],
        length_m: f64,
        (lane, s_m): (LaneId, f64),
    ) -> Option<Tram> {
        let graph = &self.arena.streets.graph;
        let track = Track::through(lane, graph);
        let front_m = track.start_of(lane)? + s_m + length_m / 2.0;
        let free_m = graph.lane(lane).length_m() - s_m - length_m / 2.0;
        let speed_mps = by.stream.within(STARTS_MPS).min((2.0 * STOPS_MPS2 * (free_m - 5.0).max(0.0)).sqrt());
        // A vehicle that has been let into the junction behind needs the room.
        let junctions = &self.arena.around.junctions;
        let behind = std::iter::successors(Some(lane), |id| graph.lane(*id).predecessors.first().copied());
        if behind.take_while(|id| graph.lane(*id).junction.is_none()).any(|id| junctions.is_exit(id)) {
            return None;
        }
        let is_spaced = self.arena.each::<Tram>().all(|(slot, _, tram)| {
            let other = &tram.train;
            let ahead_m = other.track.start_of(lane).map(|m| other.front_m - m - s_m - length_m / 2.0);
            slot == by.slot || ahead_m.is_none_or(|m| m.abs() > SPACING_M)
        });
        if !is_spaced {
            return None;
        }
        let train = Train { track: Arc::new(track), front_m, length_m, speed_mps, accel_mps2: 0.0 };
        let cars = coupled(models);
        let footprints: Vec<Footprint> = models
            .iter()
            .zip(&cars)
            .map(|(model, car)| {
                let (center, heading) = train.place(car);
                let on = train.track.position(train.front_m - car.middle_m);
                let z_m = graph.lane(on.lane).point_at(on.s_m).z;
                Ahead { distance_m: 0.0, at: center, z_m, tangent: heading }.covered_by(model.size_lwh, speed_mps)
            })
            .collect();
        let is_taken = footprints.iter().any(|own| {
            let wide = own.grown(BESIDE_M);
            let long = Footprint { half_length_m: own.half_length_m + HEADWAY_M, ..wide };
            self.arena.vehicles().any(|(slot, other)| slot != by.slot && long.overlaps(&other))
                || self.arena.around.standing.iter().any(|o| own.overlaps(o))
                || self.arena.on_road().any(|o| long.overlaps(&o))
        });
        if is_taken {
            return None;
        }
        // All of them find ground before the first is in rapier's world.
        let settled = models.iter().zip(&footprints).map(|(model, place)| {
            let (at, yaw_rad) = (place.center, heading_rad(place.heading));
            Some((settle(&self.arena.physics, model, at.extend(place.z_m), yaw_rad).ok()?, yaw_rad))
        });
        let settled: Option<Vec<(Settled, f64)>> = settled.collect();
        let places = settled?.into_iter().zip(&footprints);
        let cars = models.iter().zip(cars).zip(places).map(|((model, coupled), ((settled, yaw_rad), place))| {
            let body = Guided::new(&mut self.arena.physics, Arc::clone(model), settled, yaw_rad, place.velocity);
            TramCar { own: Actor { body, look: VehicleLook::new(Arc::clone(model), true) }, coupled }
        });
        Some(Tram::new(cars.collect(), train, by.stream))
    }
}

/// Where each car of a train is behind the front: over the joints to the others, and over a bogie below a cab.
fn coupled(models: &[Arc<VehicleModel>]) -> Vec<Coupled> {
    let mut from_m = 0.0;
    let last = models.len() - 1;
    models
        .iter()
        .enumerate()
        .map(|(k, model)| {
            let to_m = from_m + model.size_lwh.x;
            let front_m = if k == 0 { from_m + CAB_TO_BOGIE_M } else { from_m };
            let rear_m = if k == last { to_m - CAB_TO_BOGIE_M } else { to_m };
            let car = Coupled { pivots_m: [front_m, rear_m], middle_m: (from_m + to_m) / 2.0 };
            from_m = to_m;
            car
        })
        .collect()
}
