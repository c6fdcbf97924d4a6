//! How drivers change lanes, in the terms of MOBIL (Kesting, Treiber, Helbing 2007).

/// How much others' gains and losses count.
pub const POLITENESS_FACTOR: f64 = 0.25;
/// A change is worth this at least.
pub const THRESHOLD_MPS2: f64 = 0.1;
/// Nobody is made to brake harder, neither who follows nor who changes.
pub const SAFE_MPS2: f64 = 2.0;
/// Kept free at least: ahead and behind, at a standstill and by seconds of the one behind.
pub const LEAST_GAP_M: f64 = 3.0;
pub const LEAST_GAP_S: f64 = 0.55;
/// Faster than this nobody passes on the curb's side (StVO § 7 (2a)), braking so hard for it at most.
pub const CRITICAL_MPS: f64 = 60.0 / 3.6;
pub const STAYS_BEHIND_MPS2: f64 = 2.5;
/// How long one stays in a lane before the next change.
pub const STAY_S: f64 = 4.0;
/// Slower vehicles don't change.
pub const LEAST_MPS: f64 = 4.0;
/// Time of the way across.
pub const ACROSS_S: f64 = 4.6;
/// What keeping to the curb's side is worth on a motorway. In towns any lane may be chosen (StVO § 7 (3)).
pub const OUTER_BIAS_MPS2: f64 = 0.3;
/// A change is over so far before a junction or the lane's end, on a motorway and in a town.
pub const BEFORE_END_M: f64 = 45.0;
pub const BEFORE_JUNCTION_M: f64 = 15.0;
