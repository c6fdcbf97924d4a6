//! The roads, in lanes that lead on to each other, and the places beside them.

mod lane;
mod limits;
mod overpass;
mod places;
mod road_network;

pub(crate) use lane::DEFAULT_SPEED_MPS;
pub use lane::{Lane, LaneId, LaneKind, LaneSurface};
pub(crate) use limits::{AISLE_KMH, CURB_HEIGHT_M};
pub(crate) use overpass::{CLEARANCE_M, Crossing, Overpass, crossings};
pub use places::{ParkingSpot, SpotKind, Walkway};
pub use road_network::{GeoReference, MapLight, PaintColor, PaintedQuad, RightOfWay, RoadNetwork};
