//! The roads, in lanes that lead on to each other, and the places beside them.

pub(in crate::town) mod limits;
pub(in crate::town) mod overpass;
pub(in crate::town) mod places;
pub(in crate::town) mod road_network;
