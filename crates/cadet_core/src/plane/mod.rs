//! Lines and rectangles in the plane.

mod polyline;
mod rect;

pub(crate) use polyline::{Polyline, nearest, piece_at};
pub use rect::OrientedRect;
