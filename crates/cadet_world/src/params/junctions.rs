//! What junctions ask of drivers: lines, lights, conflicts between lanes, and who waits how long.

use cadet_town::STOP_LINE_M as PAINTED_M;

/// Where the front bumper stops before a junction's first point: out of the sweep of those who turn in.
pub const STOP_LINE_M: f64 = 3.3;
/// Where the front bumper stops before a junction's first point at the line of a light or a zebra crossing.
pub const LIGHT_LINE_M: f64 = PAINTED_M.1 + 0.9;
/// Whose front is so far over that, a light does not hold any more: the painted line is farther yet.
pub const OVER_LINE_M: f64 = -0.7;
/// Lights are heeded from so much before one has to brake.
pub const SEES_LIGHT_M: f64 = 12.0;
/// How hard drivers brake at most when a light turns yellow, and when it is red.
pub const YELLOW_MPS2: f64 = 3.0;
pub const RED_MPS2: f64 = 6.5;
/// Others reckon with who is at the junction in this time; who is slower, as if it went so fast.
pub const COMES_S: f64 = 12.0;
pub const STARTS_MPS: f64 = 2.0;
/// One brakes for a line from so much before it takes a comfortable deceleration.
pub const EARLY_M: f64 = 6.0;
pub const EARLY_S: f64 = 0.5;
/// Time before having to brake at which a driver asks for a junction: the next look decides.
pub const DECIDED_S: f64 = 0.1;
/// Distance to a stop sign's line within which a vehicle that crawls has stopped at it.
pub const AT_LINE_M: f64 = 1.5;
/// Steps after which a vehicle that was let go, but still stands, gives back its right to cross.
pub const UNUSED_STEPS: u64 = 3 * 60;
/// Kept free behind a vehicle that leaves a junction.
pub const EXIT_ROOM_M: f64 = 2.5;
/// Straight lanes nearer than this to each other can't be used at once.
pub const CLEARANCE_M: f64 = 2.6;
/// Clearance between lanes one of which bends: a car sweeps more than its width there.
pub const CLEARANCE_IN_BENDS_M: f64 = 3.3;
/// Clearance between a bicycle's way and a car's, straight and in bends, and between two bicycles' ways.
pub const BESIDE_CYCLES_M: (f64, f64) = (1.8, 2.6);
pub const BETWEEN_CYCLES_M: f64 = 1.3;
/// A lane that turns by more bends.
pub const BENDS_RAD: f64 = 0.25;
/// From the middle to the end of the longest vehicle.
pub const LONGEST_TAIL_M: f64 = 9.0;
/// Cosine of the greatest angle between two approaches that lie on one line.
pub const COS_ON_ONE_LINE: f64 = 0.75;
/// Time by which a yielding vehicle has to be across before the other arrives: with the time that it needs to cross,
/// this makes critical headways of 5 to 8 s from a standstill, where HCM 2010, exhibit 19-10, has 4.1 to 7.1 s.
pub const MARGIN_S: f64 = 1.0;
/// Time after which a vehicle that has asked and was let by none goes when its turn comes.
pub const PATIENCE_S: f64 = 18.0;
