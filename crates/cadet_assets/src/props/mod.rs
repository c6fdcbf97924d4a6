//! Rigid props as parts lists: TOML files of primitives, read by one builder.
//!
//! Files of the crate's folder `props` are part of it; a user's own are read when a scene is made. `docs/props.md` says
//! what they may hold.

mod builder;
mod catalog;
mod expression;
mod names;
mod parser;
mod parts_list;
mod place;
mod prop;
mod reader;
mod surface;

pub use catalog::*;
pub(crate) use parts_list::Shape;
pub use place::{AtSidewalk, Facing, Homes, InBay, InGarden, Place, Streets};
pub use prop::{Drawn, Prop};
pub(crate) use reader::{Result as Read, read_file};

#[cfg(test)]
mod tests;
