//! The roads, in lanes that lead on to each other, and the places beside them.

pub(crate) mod limits;
pub(crate) mod overpass;
pub(crate) mod places;
pub(crate) mod road_network;
