//! A vehicle whose driver goes along a route: bends, traffic, junctions.

use std::sync::Arc;

use super::actor::{Actor, ActorView};
use super::behavior::Behavior;
use crate::body::{Body, Chassis};
use crate::driving::{
    Axles, Cause, Decider, IdmParameters, LaneChoice, OnRoute, Overtaking, leave_junctions, perceive, pursue,
    signal_for, traffic_aside,
};
use crate::ego_command::EgoCommand;
use crate::footprint::Footprint;
use crate::junctions::Refusal;
use crate::look::{Look, TurnSignal, VehicleLook};
use crate::outlook::Outlook;
use crate::params::STANDS_MPS;
use crate::params::driver::{
    GIVES_UP_STEPS, HOLDS_BELOW_MPS, HOLDS_BELOW_MPS2, REDUCED_CLEARANCE_STEPS, RESPONSE_S, SHIFTING_M, SIDEWAYS_MPS,
    SIDEWAYS_SHARE, STANDING_MPS2, STARTS_MPS2, STOPPED_STEPS, STOPS_MPS2, WAITED_STEPS,
};
use crate::params::overtaking::OVERTAKE_SPEED_FACTOR;
use crate::physics::{DT_S, Physics};
use crate::slot::Slot;
use crate::streets::{LaneGraph, LanePosition, Route, Streets};
use crate::traffic_state::TrafficState;
use cadet_base::math::DVec3;

/// A vehicle on sprung wheels, and who drives it.
pub(crate) struct Car {
    pub own: Actor<Chassis, VehicleLook>,
    pub route: Option<Route>,
    /// Whether the driver drives; otherwise the brakes hold.
    pub drives: bool,
    pub standing_steps: u64,
    /// Until then less room beside others will do.
    reduced_clearance_until: u64,
    /// Until then it waits to go the way that it goes.
    patient_until: u64,
    idm: IdmParameters,
    interaction_mps2: f64,
    desired_mps: f64,
    command: Option<EgoCommand>,
    /// Of a driver on the way past a cyclist.
    pub overtaking: Option<Overtaking>,
    pub lanes: LaneChoice,
    /// The offset that the driver keeps unless commanded or overtaking; `None` before the first time.
    own_offset_m: Option<f64>,
    cause: Cause,
}

impl Car {
    pub fn new(chassis: Chassis, route: Option<Route>, idm: IdmParameters) -> Self {
        let look = VehicleLook::new(Arc::clone(&chassis.model), true);
        Self {
            own: Actor { body: chassis, look },
            drives: route.is_some(),
            route,
            standing_steps: 0,
            reduced_clearance_until: 0,
            patient_until: 0,
            idm,
            interaction_mps2: 0.0,
            desired_mps: 0.0,
            command: None,
            overtaking: None,
            lanes: LaneChoice::default(),
            own_offset_m: None,
            cause: Cause::Nothing,
        }
    }

    /// The speed that the driver goes for where the road is free.
    pub fn wanted_mps(&self, graph: &LaneGraph) -> f64 {
        let allowed_mps = self.route.as_ref().map_or(0.0, |r| r.speed_for_bends(30.0, 1.5, graph));
        (self.idm.desired_speed_factor * allowed_mps).min(self.idm.top_speed_mps)
    }

    /// Whether it drives on its own and has stood for some seconds.
    pub fn has_stopped(&self) -> bool {
        self.drives && self.command.is_none() && self.standing_steps > STOPPED_STEPS
    }

    /// Waits at a place of another route.
    pub fn wait_on(&mut self, route: Option<Route>) {
        (self.route, self.drives, self.standing_steps) = (route, false, 0);
        (self.command, self.overtaking, self.own_offset_m) = (None, None, None);
        self.lanes = LaneChoice::default();
    }

    /// Drives as commanded from now on, or on its own again.
    pub fn obey(&mut self, command: Option<EgoCommand>) {
        (self.command, self.overtaking, self.lanes) = (command, None, LaneChoice::default());
        self.drives = self.route.is_some();
        self.remember_offset();
    }

    /// Before the first time that the line is left.
    fn remember_offset(&mut self) {
        self.own_offset_m = self.own_offset_m.or(self.route.as_ref().map(|r| r.offset_m));
    }

    /// The acceleration that the pedals are to give.
    fn pressed_mps2(&self, speed_mps: f64) -> f64 {
        match self.command {
            Some(command) => self.idm.pedals((command.speed_mps - speed_mps) / RESPONSE_S, 0.0),
            None => {
                let hurry = if self.overtaking.is_some() { OVERTAKE_SPEED_FACTOR } else { 1.0 };
                self.idm.pedals(self.idm.free_road(speed_mps, hurry * self.desired_mps), self.interaction_mps2)
            }
        }
    }

    /// Moves the line that is followed to where it is wanted.
    fn shift_line(&mut self, speed_mps: f64) {
        let (Some(route), Some(own_m)) = (&mut self.route, self.own_offset_m) else { return };
        if let Some(change) = &mut self.lanes.change {
            let (offset_m, is_over) = change.step(speed_mps);
            route.offset_m = offset_m;
            self.lanes.change = self.lanes.change.filter(|_| !is_over);
            return;
        }
        let overtaking_m = self.overtaking.map(|o| o.offset_m());
        let wanted_m = self.command.map(|c| c.lateral_m).or(overtaking_m).unwrap_or(own_m);
        let most_m = SIDEWAYS_MPS.min(SIDEWAYS_SHARE * speed_mps.abs()) * DT_S;
        route.offset_m += (wanted_m - route.offset_m).clamp(-most_m, most_m);
    }

    /// Pulling out to overtake, turning in again, changing lanes, or turning off at the next junction.
    fn intent(&self, speed_mps: f64, graph: &LaneGraph) -> TurnSignal {
        let Some(route) = self.route.as_ref().filter(|_| self.drives) else { return TurnSignal::Off };
        let outward = graph.lane(route.lanes[0]).curb_side();
        if let Some(overtaking) = self.overtaking {
            let is_out = overtaking.is_out_by_m(route.offset_m) < SHIFTING_M;
            return if is_out { TurnSignal::Off } else { TurnSignal::toward(-outward) };
        }
        if let Some(change) = &self.lanes.change {
            return TurnSignal::toward(if change.is_inward { -outward } else { outward });
        }
        let is_off = |own_m: f64| outward * (own_m - route.offset_m) > SHIFTING_M;
        if self.command.is_none() && self.own_offset_m.is_some_and(is_off) {
            return TurnSignal::toward(outward);
        }
        signal_for(route, speed_mps, self.own.look.signal, graph)
    }

    /// Stays in the lane or begins to leave it.
    fn choose_lane(&mut self, slot: Slot, own: &Footprint, around: &TrafficState, graph: &LaneGraph, step: u64) {
        self.remember_offset();
        let (Some(route), Some(offset_m)) = (&mut self.route, self.own_offset_m) else { return };
        let decider = Decider { slot, own, idm: &self.idm, offset_m };
        self.lanes.decide(&decider, route, around, graph, step);
    }

    /// Takes another way where somebody has long stood in the one that it would swing into: of two who wait for each
    /// other to get out of an arm that is too narrow for both, neither would ever move.
    fn give_up(&mut self, graph: &LaneGraph, step: u64) {
        let is_barred = matches!(self.cause, Cause::Junction(Refusal::InSweep(_))) && self.command.is_none();
        if !is_barred || self.standing_steps < GIVES_UP_STEPS || step < self.patient_until {
            return;
        }
        self.patient_until = step + GIVES_UP_STEPS;
        if let Some(route) = &mut self.route {
            route.turn_elsewhere(graph);
        }
    }

    /// What others have to know of a lane change.
    fn claim(&self, own: &Footprint, graph: &LaneGraph) -> Option<Footprint> {
        let (change, route) = (self.lanes.change.as_ref()?, self.route.as_ref()?);
        Some(change.claim(own, route, graph))
    }
}

pub(crate) fn axles_of(chassis: &Chassis) -> Axles {
    Axles { wheelbase_m: chassis.wheelbase_m(), rear_m: chassis.rear_axle_m() }
}

impl Behavior for Car {
    fn actor(&self, k: usize) -> Option<ActorView<'_>> {
        (k == 0).then(|| self.own.view())
    }

    fn look(&mut self, slot: Slot, around: &TrafficState, streets: &Streets, step: u64) -> Outlook {
        let graph = &streets.graph;
        let mut outlook = Outlook::default();
        self.cause = Cause::Nothing;
        if let Some(route) = self.route.as_ref().filter(|_| self.drives)
            && let Some(footprint) = around.vehicle(slot)
        {
            let speed = footprint.velocity.dot(footprint.heading);
            self.desired_mps =
                (self.idm.desired_speed_factor * route.speed_for_bends(speed, 1.5, graph)).min(self.idm.top_speed_mps);
            if self.standing_steps >= WAITED_STEPS {
                self.reduced_clearance_until = step + REDUCED_CLEARANCE_STEPS;
            }
            let rider = OnRoute {
                slot,
                footprint,
                route,
                idm: &self.idm,
                axles: Some(axles_of(&self.own.body)),
                train_m: None,
                reduced_clearance: step < self.reduced_clearance_until,
                around,
                graph,
                step,
            };
            let ahead = rider.in_sight();
            let mut perceived = perceive(&rider, &ahead);
            let (_, cause) = rider.tightest(&perceived.constraints);
            self.overtaking = match (self.overtaking, cause) {
                (Some(begun), _) => begun.go_on(&rider, self.desired_mps),
                (None, Cause::Vehicle(other)) if self.command.is_none() => {
                    Overtaking::begin(&rider, other, self.desired_mps)
                }
                _ => None,
            };
            if let Some(change) = &self.lanes.change {
                // Until one is there, both lanes are one's own.
                let aside_m = change.left_m(route.offset_m);
                perceived.constraints.extend(traffic_aside(&rider, aside_m, &ahead));
            }
            (self.interaction_mps2, self.cause) = rider.tightest(&perceived.constraints);
            let may_change = self.command.is_none() && graph.allows_changes(route.lanes[0]);
            if self.overtaking.is_some() {
                self.remember_offset();
            } else if may_change {
                self.choose_lane(slot, footprint, around, graph, step);
                self.interaction_mps2 = self.interaction_mps2.min(self.lanes.stays_behind_mps2);
            }
            self.give_up(graph, step);
            self.own.look.signal = self.intent(speed, graph);
            outlook = Outlook {
                way_ahead: ahead,
                request: perceived.request,
                claim: self.claim(footprint, graph),
                walk: None,
            };
        } else {
            self.own.look.signal = TurnSignal::Off;
        }
        outlook
    }

    fn act(&mut self, physics: &mut Physics, streets: &Streets) {
        let speed = self.own.body.forward_mps(physics);
        self.shift_line(speed);
        let mut accel = self.pressed_mps2(speed);
        let Actor { body: chassis, look } = &mut self.own;
        match self.route.as_ref().filter(|_| self.drives) {
            None => chassis.command(-3.0 * speed.clamp(-1.0, 1.0), 0.0, true, physics),
            Some(route) => {
                let pose = chassis.world_from_box(physics);
                let heading = (pose.rotation * DVec3::X).truncate().normalize();
                let axles = axles_of(chassis);
                let rear_axle = pose.translation.truncate() - heading * axles.rear_m;
                let steer = pursue(rear_axle, heading, axles, speed, (route, 0.0), &streets.graph);
                let starts_mps2 = if chassis.is_held() { STARTS_MPS2 } else { STOPS_MPS2 };
                let stand = accel < starts_mps2 && speed < 0.4;
                // A driver who has closed up keeps a foot on the brake, though centimeters are left to go.
                let holds = stand || speed < HOLDS_BELOW_MPS && accel < HOLDS_BELOW_MPS2;
                look.accelerate(if holds { STANDING_MPS2 } else { accel });
                // Brakes stop a car, they don't push it backwards.
                if accel < 0.0 {
                    accel = accel.max(-speed / (2.0 * DT_S)).min(0.0);
                }
                chassis.command(accel, steer, stand, physics);
            }
        }
        chassis.apply(physics);
    }

    fn track(&mut self, slot: Slot, physics: &Physics, around: &mut TrafficState, streets: &Streets) {
        let chassis = &self.own.body;
        let tail_m = self.own.look.size_lwh().x / 2.0 + 0.5;
        if let Some(route) = &mut self.route {
            let position = chassis.world_from_box(physics).translation;
            leave_junctions(slot, route, position, tail_m, &mut around.junctions, &streets.graph);
        }
        let stands = chassis.forward_mps(physics).abs() < STANDS_MPS;
        self.standing_steps = if stands { self.standing_steps + 1 } else { 0 };
    }

    fn cause(&self) -> Cause {
        self.cause
    }

    fn on_lane(&self, _k: usize) -> Option<LanePosition> {
        self.route.as_ref().map(Route::position)
    }
}
