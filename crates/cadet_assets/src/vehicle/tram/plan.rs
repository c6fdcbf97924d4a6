//! What trams are made of: the cars of a train in a row, and the measures of each.
//!
//! KITTI's annotators drew a box round each car of an articulated tram: rows of 14.7, 10.0 and 12.8 m, or 12.7, 3.2 and
//! 6.7 m. Only now and then is there one box round two or three cars that stood in line (23.3 m, 35.2 m). Here a car is
//! an agent with a label of its own; some trams are of stiff cars that are as long as such a box.

use cadet_base::rng::Stream;

/// Kind of end that a car has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The driver's cab, or one that nobody is in.
    Cab,
    /// Half of the bellows to the next car.
    Joint,
}

/// A car of a tram.
#[derive(Debug, Clone)]
pub(super) struct CarPlan {
    pub name: &'static str,
    pub length_m: f32,
    pub width_m: f32,
    pub height_m: f32,
    /// At the front and at the rear.
    pub ends: [End; 2],
    /// Height of the floor, and of the lower and the upper edge of the windows.
    pub floor_z: f32,
    pub sill_z: f32,
    pub header_z: f32,
    /// The tangent by which the windscreen leans back.
    pub lean_tangent: f32,
    /// How far the plan is rounded at a cab.
    pub nose_radius_m: f32,
    /// x of the middles of the doors, and their width.
    pub doors: Vec<f32>,
    pub door_width_m: f32,
    /// Doors on the left, too.
    pub has_left_doors: bool,
    /// x of the middles of the bogies.
    pub bogies: Vec<f32>,
    pub has_pantograph: bool,
    /// Number of seats that are taken, 0 to 1, and what the details are drawn from.
    pub taken_share: f32,
    pub detail: [f32; 4],
}

/// A kind of tram.
struct Kind {
    name: &'static str,
    share: f64,
    /// Lengths of the cars, without the spread.
    lengths_m: &'static [f64],
    width_m: (f64, f64),
    height_m: (f64, f64),
    is_low: bool,
    has_left_doors: bool,
}

/// By how often KITTI's labels show them.
const KINDS: [Kind; 5] = [
    Kind {
        name: "light-rail",
        share: 0.36,
        lengths_m: &[14.7, 10.0, 12.8],
        width_m: (2.32, 2.62),
        height_m: (3.55, 3.66),
        is_low: false,
        has_left_doors: true,
    },
    Kind {
        name: "low-floor",
        share: 0.18,
        lengths_m: &[12.7, 3.2, 12.9],
        width_m: (2.58, 2.80),
        height_m: (3.50, 3.70),
        is_low: true,
        has_left_doors: false,
    },
    Kind {
        name: "high-floor",
        share: 0.20,
        lengths_m: &[15.2, 15.0],
        width_m: (2.40, 2.65),
        height_m: (3.30, 3.50),
        is_low: false,
        has_left_doors: false,
    },
    Kind {
        name: "two-car",
        share: 0.12,
        lengths_m: &[17.0, 18.1],
        width_m: (2.50, 2.67),
        height_m: (3.19, 3.45),
        is_low: false,
        has_left_doors: true,
    },
    Kind {
        name: "long",
        share: 0.14,
        lengths_m: &[23.3],
        width_m: (2.37, 2.50),
        height_m: (3.33, 3.50),
        is_low: true,
        has_left_doors: false,
    },
];
const LENGTH_SPREAD_M: f64 = 0.15;

/// The cars of the tram of a number, the first ahead.
pub(super) fn train(s: &mut Stream) -> Vec<CarPlan> {
    let kind = &KINDS[s.weighted(&KINDS.map(|k| k.share))];
    let (width, height) = (s.range(kind.width_m.0, kind.width_m.1), s.range(kind.height_m.0, kind.height_m.1));
    let fullness = s.range(0.1, 0.6) as f32;
    let last = kind.lengths_m.len() - 1;
    let lifted = s.below(last + 1);
    let lean = s.range(0.22, 0.42) as f32;
    let lengths: Vec<f64> = kind.lengths_m.iter().map(|l| s.clipped_normal(*l, LENGTH_SPREAD_M)).collect();
    lengths
        .iter()
        .enumerate()
        .map(|(k, length)| {
            let end = |is_cab: bool| if is_cab { End::Cab } else { End::Joint };
            let ends = [end(k == 0), end(k == last)];
            // A pantograph stands on a car that has room for it.
            let lifted = if lengths[lifted] > 6.0 { lifted } else { 0 };
            car(kind, [*length, width, height], ends, k == lifted, fullness, lean, s)
        })
        .collect()
}

/// A car that runs alone: a cab at both ends.
pub(super) fn single(s: &mut Stream) -> CarPlan {
    let (length, width) = (s.range(13.5, 15.5), s.range(2.32, 2.62));
    let (height, fullness) = (s.range(3.3, 3.65), s.range(0.1, 0.6) as f32);
    let lean = s.range(0.22, 0.42) as f32;
    car(&KINDS[0], [length, width, height], [End::Cab; 2], true, fullness, lean, s)
}

fn car(
    kind: &Kind,
    [length_m, width_m, height_m]: [f64; 3],
    ends: [End; 2],
    has_pantograph: bool,
    taken_share: f32,
    lean_tangent: f32,
    s: &mut Stream,
) -> CarPlan {
    let (length_m, half) = (length_m as f32, length_m as f32 / 2.0);
    let door_width_m = if kind.is_low { 1.30 } else { 1.15 };
    // Clear of cabs and joints.
    let reach = ends.map(|e| half - if e == End::Cab { 2.9 } else { 1.3 });
    let room = reach[0] + reach[1];
    let count = if room < 2.0 { 0 } else { (room / 4.6).round().max(1.0) as usize };
    let doors = (0..count).map(|k| reach[0] - room * (k as f32 + 0.5) / count as f32).collect();
    // Of a car between two others a bogie stands in the middle, or under each joint; under a cab it stands back.
    let bogies = if length_m < 5.0 {
        vec![0.0]
    } else {
        let at = |end: End| half - if end == End::Cab { 2.4 } else { 1.6 };
        vec![at(ends[0]), -at(ends[1])]
    };
    let (floor_z, sill_z) = if kind.is_low { (0.36, 1.05) } else { (0.90, 1.55) };
    CarPlan {
        name: kind.name,
        length_m,
        width_m: width_m as f32,
        height_m: height_m as f32,
        ends,
        floor_z,
        sill_z,
        header_z: (height_m as f32 - 0.95).min(2.62),
        lean_tangent,
        nose_radius_m: s.range(0.35, 0.6) as f32,
        doors,
        door_width_m,
        has_left_doors: kind.has_left_doors,
        bogies,
        has_pantograph,
        taken_share,
        detail: std::array::from_fn(|_| s.unit() as f32),
    }
}
