//! The roads, in lanes: how they lead on, who goes first, where people walk and cars park.

pub(in crate::town) mod parking_spots;
pub(in crate::town) mod right_of_way;
pub(in crate::town) mod road_network;
pub(in crate::town) mod walkway;
