//! What drivers keep beside themselves, how they press the pedals, and how long they wait.

/// Room kept beside what stands, and beside what moves.
pub const SIDE_STANDING_M: f64 = 0.12;
pub const SIDE_MOVING_M: f64 = 0.25;
/// The same beside what moves, of who has waited long: two buses pass each other in narrow lanes with less than usual.
pub const SIDE_MOVING_REDUCED_M: f64 = 0.08;
/// And beside a post or what else stands.
pub const SIDE_STANDING_REDUCED_M: f64 = 0.04;
/// What is kept in front of all of a vehicle that turns, usually and then.
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
/// Who has stood for so long makes do with less room for a while.
pub const WAITED_STEPS: u64 = 10 * 60;
pub const REDUCED_CLEARANCE_STEPS: u64 = 8 * 60;
/// Who has stood for so long before a junction takes another way across it, if that is free.
pub const GIVES_UP_STEPS: u64 = 25 * 60;
/// Who stands for so long has stopped for good where nothing follows.
pub const STOPPED_STEPS: u64 = 3 * 60;
/// Who is so far from the line that is wanted is changing lines, and shows it.
pub const SHIFTING_M: f64 = 0.3;
