//! The numbers of the traffic model: what several rules share here, those of one kind of behavior in a file each. What only
//! says how finely or how far a rule looks stands beside it.

pub(super) mod cycling;
pub(super) mod driver;
pub(super) mod junctions;
pub(super) mod lane_change;
pub(super) mod overtaking;
pub(super) mod walking;

use super::physics::DT_S;

/// Steps between two looks, and the time: nobody needs more than ten a second.
pub(super) const LOOK_STEPS: u64 = 6;
pub(super) const LOOK_S: f64 = LOOK_STEPS as f64 * DT_S;
/// Slower vehicles stand.
pub(super) const STANDS_MPS: f64 = 0.1;
/// Slower vehicles have all but stopped: others reckon with them as if they stood.
pub(super) const CRAWLS_MPS: f64 = 0.3;
/// Longer vehicles neither overtake nor change lanes in towns, and go straight on where they can.
pub(super) const LONG_M: f64 = 6.0;
/// A way that changes direction by more turns.
pub(super) const TURNS_RAD: f64 = 0.6;
/// Cosine of the greatest angle between two that go the same way.
pub(super) const COS_SAME_WAY: f64 = 0.8;
/// Two further apart in height are on different levels where a road passes over another: by that, and by a steep road's
/// slope over the distance between them.
pub(super) const LEVEL_M: f64 = 2.5;
pub(super) const STEEP_SLOPE: f64 = 0.1;

/// How a kind of vehicle follows others, in the terms of the intelligent driver model.
pub(super) struct Following {
    /// Strongest acceleration, the deceleration that is comfortable, and what the brakes can do.
    pub accel_mps2: f64,
    pub comfortable_mps2: f64,
    pub hardest_mps2: f64,
    /// Bumper to bumper at a standstill.
    pub minimum_gap_m: f64,
    /// Time gap: mean and standard deviation over drivers.
    pub time_gap_s: (f64, f64),
    /// Desired speed as a fraction of what limit and bends allow, likewise.
    pub desired_speed_factor: (f64, f64),
}

/// Brisker than the model's authors have cars on freeways: 0.73 and 1.67 m/s², 2 m, 1.5 s (Treiber, Hennecke, Helbing 2000).
pub(super) const CAR: Following = Following {
    accel_mps2: 1.2,
    comfortable_mps2: 2.0,
    hardest_mps2: 7.0,
    minimum_gap_m: 2.0,
    time_gap_s: (1.2, 0.25),
    desired_speed_factor: (1.0, 0.09),
};

/// Of KITTI's cars none is ahead in the own lane within 7 m of the camera, and one in a hundred within 20 m.
pub(super) const EGO: Following = Following { minimum_gap_m: 4.5, time_gap_s: (2.2, 0.25), ..CAR };

/// ISO 4210 asks of brakes to stop from 24 km/h within 5.5 m: 4.0 m/s². Over the first 26 s of a ride cyclists speed up by
/// 0.23 m/s² in the mean (Parkin and Rotheram 2010), off the line by more.
pub(super) const CYCLIST: Following = Following {
    accel_mps2: 0.9,
    hardest_mps2: 4.5,
    minimum_gap_m: 1.3,
    time_gap_s: (1.05, 0.14),
    desired_speed_factor: (1.0, 0.0),
    ..CAR
};

/// Passengers stand: 1.0 m/s² either way, and more with all brakes.
pub(super) const TRAM: Following = Following {
    accel_mps2: 1.0,
    comfortable_mps2: 1.0,
    hardest_mps2: 3.2,
    minimum_gap_m: 3.0,
    time_gap_s: (2.2, 0.23),
    desired_speed_factor: (0.85, 0.06),
};
