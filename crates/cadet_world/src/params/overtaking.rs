//! How drivers overtake cyclists.

/// Kept beside a cyclist: what StVO § 5 (4) asks for in towns.
pub const BESIDE_M: f64 = 1.5;
/// From the rear bumper to the front wheel of who has been overtaken, before one turns in.
pub const AFTER_M: f64 = 3.0;
/// How long it takes to be back in the lane.
pub const RETURN_S: f64 = 1.5;
/// Factor on the speed that a driver otherwise wants, while overtaking.
pub const OVERTAKE_SPEED_FACTOR: f64 = 1.15;
/// The farthest that anybody leaves the middle of the lane.
pub const MOST_ASIDE_M: f64 = 3.0;
/// Slower cyclists are about to stop or to turn; others are worth it if one gets so much faster on.
pub const LEAST_RIDER_MPS: f64 = 2.0;
pub const LEAST_GAIN_MPS: f64 = 1.5;
/// How fast one gets faster meanwhile, and the longest that it may take.
pub const ACCELERATION_MPS2: f64 = 0.9;
pub const LONGEST_S: f64 = 15.0;
pub const STEP_S: f64 = 0.25;
/// Least speed reckoned for oncoming vehicles, standing or not, and how far away they are at least when one is done: at
/// the start, and before one gives up.
pub const ONCOMING_MPS: f64 = 8.0;
pub const SPARE_M: f64 = 10.0;
pub const LEAST_SPARE_M: f64 = 2.0;
/// From there to the next junction: who is still behind the cyclist where drivers begin to look out for it brakes.
pub const BEFORE_JUNCTION_M: f64 = 12.0;
/// One can still fall back if the front is so far behind the cyclist once one is as slow, braking so hard.
pub const FALLS_BACK_M: f64 = 1.5;
pub const FALLS_BACK_MPS2: f64 = 2.0;
/// Time that a vehicle on another lane needs at least to come up from behind.
pub const BEHIND_S: f64 = 3.0;
/// Room beside what stands, and beside people.
pub const SIDE_STANDING_M: f64 = 0.3;
pub const SIDE_PEOPLE_M: f64 = 1.0;
/// Room beside other vehicles on the way: what is farther to the side is not on it.
pub const SIDE_MOVING_M: f64 = 0.6;
