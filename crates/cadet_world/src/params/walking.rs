//! How people walk, keep out of each other's way, and cross.

/// Half a person's width, and the room they leave to things.
pub const SHOULDER_M: f64 = 0.3;
/// Distance behind somebody within which a walker goes at their pace, and the seconds in which a gap is closed.
pub const FOLLOWS_M: f64 = 2.0;
pub const CLOSES_S: f64 = 0.8;
/// Slower people are walked round.
pub const WALKS_MPS: f64 = 0.2;
/// Gap in traffic, in seconds before the car arrives, that people accept beyond the time they need.
pub const MARGIN_S: f64 = 2.0;
pub const CROSSING_MPS: f64 = 1.5;
/// Vehicles farther away do not matter on a ford; who crawls lets pass; others stop so hard after so long.
pub const FAR_M: f64 = 40.0;
pub const FIRM_MPS2: f64 = 3.0;
pub const REACTION_S: f64 = 0.6;
/// Radius of the circle in the plane that a person's trunk stays inside of; arms and legs swing beyond it.
pub const BODY_M: f64 = 0.24;
/// From the middle of one person to that of the next ahead: a stride, which legs and arms take up.
pub const STRIDE_M: f64 = 0.9;
/// Half the width and length of a person with some room.
pub const ROOM_M: f64 = 0.5;
/// Nearer than this to the middle of a lane one is on it, unless there is a sidewalk.
pub const NEAR_LANE_M: f64 = 2.6;
/// How fast people side-step, m/s.
pub const SIDESTEP_MPS: f64 = 0.5;
/// How fast people turn.
pub const TURN_RADPS: f64 = 3.0;
/// Whoever is within this of the place beside or behind the one who leads turns round with them.
pub const TOGETHER_M: f64 = 3.0;
/// Share of those who have crossed a road that mean to cross another.
pub const CROSSES_AGAIN_SHARE: f64 = 0.7;
/// How likely it is at each look that who means to cross looks for a way.
pub const LOOKS_ACROSS_CHANCE: f64 = 0.06;
/// Whoever is farther from their line than this goes there first, and then on along it.
pub const OFF_LINE_M: f64 = 0.6;
/// How far round others one may step off the line: not into the road.
pub const ROUND_OTHERS_M: f64 = 0.45;
/// Time after which a walker who could not set a step turns round.
pub const HELD_S: f64 = 1.2;
/// Time after which a walker who found no free line turns back.
pub const BLOCKED_S: f64 = 2.5;
/// Length of the way over a zebra crossing that is kept free ahead of somebody.
pub const ZEBRA_LEAD_M: f64 = 6.0;
/// At the far curb among others one is over the road here.
pub const OVER_M: f64 = 0.8;
