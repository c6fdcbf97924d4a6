//! What moves: agents, and the immutable picture of an instant that the sensors read.

mod agents;
mod arena;
mod body;
mod course;
mod driving;
mod ego_command;
mod footprint;
mod ground_shape;
mod junctions;
mod lane_use;
mod look;
mod outlook;
mod params;
mod physics;
mod retouch;
mod simulation;
mod slot;
mod snapshot;
mod spawn;
mod streets;
#[cfg(test)]
mod tests;
mod traffic_state;
mod walking;

pub use course::{Course, FASTEST_VEHICLE_MPS, ModelChoice, Overlap, Waypoint};
pub use ego_command::{EgoCommand, MAX_LATERAL_M};
pub use physics::DT_S;
pub use retouch::Retouch;
pub use simulation::World;
pub use snapshot::{EgoState, Snapshot};
pub use spawn::{Shortfall, TrafficConfig};
