//! Placement of everybody at the start, and of newcomers when others have gone: a file for each kind of placement.

mod belongings;
mod config;
mod cyclists;
mod driven;
mod ego;
mod fast;
mod groups;
mod newcomers;
mod overlap;
mod parking;
mod people;
mod placed;
mod seated;
mod spawner;
mod traffic;
mod trams;

pub use config::TrafficConfig;
pub use traffic::Shortfall;

pub(super) use ego::{EgoStarts, place_ego, too_short};
pub(super) use overlap::check_free;
pub(super) use placed::{add_cyclist, add_figure, add_person, add_vehicle, box_at};
pub(super) use seated::add_seated;
pub(super) use spawner::Spawner;
pub(super) use traffic::{RENEW_EVERY, Respawns, fill, leave, renew};
