//! Where somebody on foot may set the next step: nobody's body enters a vehicle or another person.

use crate::footprint::Footprint;
use crate::params::LEVEL_M;
use crate::params::walking::BODY_M;
use crate::slot::Slot;
use crate::traffic_state::{PersonAt, VehicleAt};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::unit;

/// Vehicles and people farther away than this are not met before the next look.
const REACH_M: f64 = 1.5;
/// What arms and feet reach now and then, on each side of a box.
const SHARED_M: f64 = 0.15;
/// The turns that are tried to get round what is in the way, first to the side on which one goes round already.
const TURNS_RAD: [f64; 4] = [0.5, 1.0, 1.5, 2.0];

/// What a person takes up: the box but for what arms and feet reach now and then, and at least the trunk.
pub(crate) fn room_of(footprint: &Footprint) -> Footprint {
    let (half_length_m, half_width_m) = (footprint.half_length_m - SHARED_M, footprint.half_width_m - SHARED_M);
    Footprint { half_length_m: half_length_m.max(BODY_M), half_width_m: half_width_m.max(BODY_M), ..*footprint }
}

/// What somebody may meet until the next look round.
#[derive(Debug, Clone)]
pub(crate) struct Nearby {
    parked: Vec<Footprint>,
    people: Vec<Slot>,
    /// Side on which one goes round things: +1 left, -1 right. Kept until that side is shut, or one would go to and fro.
    side: f64,
}

impl Default for Nearby {
    fn default() -> Self {
        Self { parked: Vec::new(), people: Vec::new(), side: -1.0 }
    }
}

impl Nearby {
    /// Looks round from `here`.
    pub fn look(&mut self, own: Slot, position: DVec3, people: &[PersonAt], parked: &[Footprint]) {
        let (here, z_m) = (position.truncate(), position.z);
        self.parked.clear();
        self.parked.extend(parked.iter().filter(|o| o.is_within(here, REACH_M) && o.is_level_with(here, z_m)));
        let is_near = |p: &&PersonAt| {
            p.agent != own && (p.room.center - here).length() < REACH_M && (p.room.z_m - z_m).abs() < LEVEL_M
        };
        self.people.clear();
        self.people.extend(people.iter().filter(is_near).map(|p| p.agent));
    }

    /// The step to `to` of somebody who takes up `own`, or one of its length beside it; `allowed` has to agree. `None` where
    /// something is in the way on all sides. Who is too near to something already may step away from it, not toward it.
    pub fn step(
        &mut self,
        own: &Footprint,
        to: DVec2,
        people: &[PersonAt],
        vehicles: &[VehicleAt],
        allowed: impl Fn(DVec2) -> bool,
    ) -> Option<DVec2> {
        let from = own.center;
        let is_near = |o: &&Footprint| o.is_within(from, REACH_M) && o.is_level_with(from, own.z_m);
        let near_vehicles: Vec<&Footprint> = vehicles.iter().map(|v| &v.footprint).filter(is_near).collect();
        let room_taken_by =
            |agent: &Slot| people.binary_search_by_key(agent, |p| p.agent).ok().map(|i| &people[i].room);
        let near_people: Vec<&Footprint> = self.people.iter().filter_map(room_taken_by).collect();
        let is_free = |p: DVec2| {
            let enters = |o: &Footprint| {
                let (before, after) = (o.distance_m(from), o.distance_m(p));
                after < BODY_M && after < before
            };
            let moved = Footprint { center: p, ..*own };
            let touches = |other: &Footprint| {
                (other.center - p).length() < (other.center - from).length() && moved.overlaps(other)
            };
            !self.parked.iter().any(enters)
                && !near_vehicles.iter().any(|v| enters(v))
                && !near_people.iter().any(|other| touches(other))
        };
        if is_free(to) && allowed(to) {
            return Some(to);
        }
        let turned = |turn: f64| from + unit(turn).rotate(to - from);
        let (side, p) = [self.side, -self.side]
            .into_iter()
            .flat_map(|side| TURNS_RAD.map(|turn| (side, turned(side * turn))))
            .find(|(_, p)| is_free(*p) && allowed(*p))?;
        self.side = side;
        Some(p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math;

    const CAR: Footprint = Footprint {
        center: DVec2::new(3.0, 0.0),
        heading: DVec2::X,
        half_length_m: 2.0,
        half_width_m: 0.8,
        z_m: 0.0,
        velocity: DVec2::ZERO,
    };

    fn room(center: DVec2, heading: DVec2) -> Footprint {
        Footprint { center, heading, half_length_m: 0.4, half_width_m: BODY_M, ..CAR }
    }

    fn people(places: &[DVec2]) -> Vec<PersonAt> {
        let person = |(agent, at): (Slot, &DVec2)| PersonAt { agent, room: room(*at, DVec2::X) };
        places.iter().enumerate().map(person).collect()
    }

    /// The places of somebody who takes a step from each to the next, past others and a car, parked or not.
    fn walk(start: DVec2, step: impl Fn(DVec2) -> DVec2, others: &[DVec2], is_parked: bool) -> Vec<DVec2> {
        let parked: &[Footprint] = if is_parked { &[CAR] } else { &[] };
        let vehicles: &[VehicleAt] =
            if is_parked { &[] } else { &[VehicleAt { agent: 99, footprint: CAR, is_cycle: false }] };
        let mut places = vec![start];
        places.extend(others);
        let mut nearby = Nearby::default();
        (0..600)
            .map(|_| {
                let (from, wanted) = (places[0], step(places[0]));
                nearby.look(0, from.extend(0.0), &people(&places), parked);
                let own = room(from, wanted.normalize_or(DVec2::X));
                places[0] = nearby.step(&own, from + wanted, &people(&places), vehicles, |_| true).unwrap_or(from);
                places[0]
            })
            .collect()
    }

    #[test]
    fn nobody_steps_into_a_vehicle_and_everybody_gets_round_one() {
        for is_parked in [true, false] {
            let way = walk(DVec2::new(0.0, -0.3), |_| DVec2::X * 0.02, &[], is_parked);
            assert!(way.iter().all(|p| CAR.distance_m(*p) >= BODY_M));
            assert!(way.iter().any(|p| p.y < -CAR.half_width_m), "never got to the side: {}", way[399]);
            assert!(way[399].x > 2.0, "stayed at {}", way[399]);
        }
    }

    #[test]
    fn one_gets_round_the_long_side_of_a_vehicle_to_a_goal_behind_it() {
        let goal = DVec2::new(3.4, 3.0);
        let toward = |from: DVec2| (goal - from).normalize_or_zero() * 0.025;
        let way = walk(DVec2::new(3.0, -2.0), toward, &[], false);
        assert!(way.iter().all(|p| CAR.distance_m(*p) >= BODY_M));
        assert!((way[599] - goal).length() < 0.1, "stayed at {}", way[599]);
    }

    #[test]
    fn nobody_steps_into_a_person() {
        let other = DVec2::new(1.0, 0.05);
        let way = walk(DVec2::ZERO, |_| DVec2::X * 0.01, &[other], true);
        assert!(way.iter().all(|p| (other - *p).length() >= 2.0 * BODY_M));
        assert!(way[399].length() > 0.4);
    }

    #[test]
    fn who_stands_in_something_may_leave_it() {
        let other = DVec2::new(0.1, 0.0);
        let way = walk(DVec2::ZERO, |_| DVec2::X * -0.01, &[other], true);
        assert!((way[399] - other).length() > 2.0 * BODY_M);
    }

    #[test]
    fn shut_in_on_all_sides_one_stays() {
        let ring: Vec<DVec2> = (0..12).map(|k| unit(f64::from(k) * math::PI / 6.0) * 0.48).collect();
        assert!(walk(DVec2::ZERO, |_| DVec2::X * 0.03, &ring, true)[399].length() < 0.03);
    }
}
