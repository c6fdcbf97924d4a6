//! What moves: agents with bodies and controllers, and the immutable picture of an instant that the sensors read.

mod abreast;
mod agent;
mod appearance;
mod arena;
mod body;
mod control;
mod course;
mod ego_command;
mod footprint;
mod ground_shape;
mod junctions;
mod lamp_light;
mod lane_use;
mod outlook;
mod params;
mod physics;
mod ride;
mod roads;
mod room;
mod route;
mod sidewalk;
mod simulation;
mod slot;
mod snapshot;
mod spawn;
mod streets;
#[cfg(test)]
mod tests;
mod track;
mod traffic_state;
mod turn_signal;

pub use course::{Course, FASTEST_VEHICLE_MPS, ModelChoice, Overlap, Waypoint};
pub use ego_command::{EgoCommand, MAX_LATERAL_M};
pub use physics::DT_S;
pub use simulation::World;
pub use snapshot::{EgoState, Snapshot};
pub use spawn::TrafficConfig;
