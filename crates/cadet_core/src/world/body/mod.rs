//! How an agent stands in the world: one interface to everything that has a pose.

mod chassis;
mod cycle;
mod fixed;
mod guided;
mod settle;
mod upright;
mod wheels;

pub(super) use chassis::{Chassis, MAX_STEER_RAD, STEER_RATE_RADPS};
pub(super) use cycle::{Cycle, stand_up};
pub(super) use fixed::Fixed;
pub(super) use guided::{Guided, Step};
pub(super) use settle::settle;
pub(super) use upright::Upright;

use super::physics::Physics;
use crate::math::{DPose3, DVec3};

/// A body, in rapier's world or beside it.
pub(super) enum Body {
    /// A car on sprung wheels that forces move.
    Sprung(Box<Chassis>),
    /// A vehicle that stands for good, settled on the ground.
    Fixed(Box<Fixed>),
    /// A vehicle that its controller leads along the ground.
    Guided(Box<Guided>),
    /// A bicycle that its rider leads along the ground.
    Cycle(Box<Cycle>),
    /// A person, on foot or on a seat, moved by the controller if at all, not in rapier's world.
    Upright(Upright),
}

impl Body {
    /// Pose of the box frame.
    pub fn world_from_box(&self, physics: &Physics) -> DPose3 {
        match self {
            Self::Sprung(chassis) => chassis.world_from_box(physics),
            Self::Fixed(fixed) => fixed.world_from_box,
            Self::Guided(guided) => guided.world_from_box(),
            Self::Cycle(cycle) => cycle.world_from_box,
            Self::Upright(upright) => upright.world_from_box(),
        }
    }

    /// Velocity of the box frame's origin.
    pub fn velocity_world(&self, physics: &Physics) -> DVec3 {
        match self {
            Self::Sprung(chassis) => chassis.velocity_world(physics),
            Self::Fixed(_) => DVec3::ZERO,
            Self::Guided(guided) => guided.velocity_world,
            Self::Cycle(cycle) => cycle.velocity_world,
            Self::Upright(upright) => upright.velocity_world,
        }
    }

    /// Speed along the body's own x axis.
    pub fn forward_mps(&self, physics: &Physics) -> f64 {
        match self {
            Self::Sprung(chassis) => chassis.speed_mps(physics),
            _ => self.velocity_world(physics).dot(self.world_from_box(physics).rotation * DVec3::X),
        }
    }

    /// Angular velocity, rad/s; 0 for people, whose turns take longer than a scan.
    pub fn angular_velocity_world(&self, physics: &Physics) -> DVec3 {
        match self {
            Self::Sprung(chassis) => chassis.angular_velocity_world(physics),
            Self::Guided(guided) => guided.angular_velocity_world,
            Self::Cycle(cycle) => cycle.angular_velocity_world,
            Self::Fixed(_) | Self::Upright(_) => DVec3::ZERO,
        }
    }

    /// The four wheels in the box frame; `None` for a body that has not as many.
    pub fn box_from_wheels(&self) -> Option<[DPose3; 4]> {
        match self {
            Self::Sprung(chassis) => Some(chassis.wheels()),
            Self::Fixed(fixed) => Some(fixed.box_from_wheels),
            Self::Guided(guided) => Some(guided.box_from_wheels()),
            Self::Cycle(_) | Self::Upright(_) => None,
        }
    }

    /// Takes the body out of rapier's world.
    pub fn remove_from(&self, physics: &mut Physics) {
        match self {
            Self::Sprung(chassis) => physics.remove(chassis.body),
            Self::Fixed(fixed) => physics.remove(fixed.body),
            Self::Guided(guided) => physics.remove(guided.body),
            Self::Cycle(cycle) => physics.remove(cycle.body),
            Self::Upright(_) => {}
        }
    }
}
