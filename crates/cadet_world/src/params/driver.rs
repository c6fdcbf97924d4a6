//! What drivers keep beside themselves, how they press the pedals, and how long they wait.

/// Room kept beside what stands, and beside what moves.
pub const SIDE_STANDING_M: f64 = 0.12;
pub const SIDE_MOVING_M: f64 = 0.25;
/// Clearance beside moving vehicles for a driver who has waited long: two buses pass each other in narrow lanes with
/// less than usual.
pub const SIDE_MOVING_REDUCED_M: f64 = 0.08;
/// Clearance beside a post, or whatever else stands, for a driver who has waited long.
pub const SIDE_STANDING_REDUCED_M: f64 = 0.04;
/// Clearance in front of all of a vehicle that turns, usually and for a driver who has waited long.
pub const SWEPT_M: (f64, f64) = (0.1, 0.03);
/// Where the front stops before the end of a road.
pub const BEFORE_END_M: f64 = 1.0;
/// A car that hardly moves is held below this acceleration, and then until it is worth starting: at one limit for both
/// it would start and stop by turns, a millimeter at a time.
pub const STOPS_MPS2: f64 = 0.05;
pub const STARTS_MPS2: f64 = 0.15;
/// What the brakes of a car that stands are pressed as if for.
pub const STANDING_MPS2: f64 = -1.0;
/// Speed and acceleration below which brake lamps stay lit.
pub const HOLDS_BELOW_MPS: f64 = 0.05;
pub const HOLDS_BELOW_MPS2: f64 = 0.3;
/// How soon a commanded speed is to be reached, within what the pedals can do.
pub const RESPONSE_S: f64 = 0.5;
/// How fast a car moves across its lane by command, and by how much of its speed: a jump would make it skid.
pub const SIDEWAYS_MPS: f64 = 1.0;
pub const SIDEWAYS_SHARE: f64 = 0.2;
/// Steps of standing after which a driver makes do with less room, and for how many steps.
pub const WAITED_STEPS: u64 = 10 * 60;
pub const REDUCED_CLEARANCE_STEPS: u64 = 8 * 60;
/// Steps of standing before a junction after which a driver takes another way across it, if another leads on.
pub const GIVES_UP_STEPS: u64 = 25 * 60;
/// Steps of standing after which a driver has stopped for good where nothing follows.
pub const STOPPED_STEPS: u64 = 3 * 60;
/// Distance from the wanted line beyond which a vehicle is changing lines, and shows it.
pub const SHIFTING_M: f64 = 0.3;
