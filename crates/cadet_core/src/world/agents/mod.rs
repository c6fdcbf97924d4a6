//! The kinds of agents, a file each.

mod agent;
mod car;
mod controller;
mod cyclist;
mod parked;
mod pedestrian;
mod scripted;
mod timed_path;
mod tram;

pub(super) use agent::Agent;
pub(super) use car::Driver;
#[cfg(test)]
pub(super) use car::axles_of;
pub(super) use controller::{AgentParts, Controller};
pub(super) use cyclist::Cyclist;
pub(super) use parked::Parked;
pub(super) use pedestrian::Pedestrian;
pub(super) use scripted::{PERSON_HALF_CHORD_M, Scripted};
pub(super) use timed_path::TimedPath;
pub(super) use tram::{Coupled, Trailer, Train, TramDriver};
