//! What lies between carriageways and plots: lines to walk along and places to park.

mod parking_spots;
mod walkway;

pub(crate) use parking_spots::bay_lines;
pub use parking_spots::parking_spots;
pub use walkway::walkways;
