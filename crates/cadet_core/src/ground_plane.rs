//! The road's plane ahead of the camera, estimated from a LIDAR scan.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use cadet_base::error::{Error, Result};
use cadet_base::math;
use cadet_base::rng::Stream;

/// Where the ground is looked for, in the frame of camera 0, meters: ahead, to either side, below the camera.
const AHEAD_M: Range<f64> = 2.0..50.0;
const ASIDE_M: f64 = 8.0;
const LEAST_BELOW_M: f64 = 0.3;
const MOST_BELOW_M: f64 = 4.5;
/// Side of the square cells of ground that count once each, however many returns they hold, meters.
const CELL_M: f64 = 0.5;
const NUM_COLUMNS: usize = (2.0 * ASIDE_M / CELL_M) as usize;
const NUM_ROWS: usize = (AHEAD_M.end / CELL_M) as usize;
/// The height of a cell is this quantile of its returns, counted from the lowest: above the outliers, below what stands
/// on the ground.
const QUANTILE: f64 = 0.25;
/// Half the width of a usual street, meters: cells farther to the side than this count for less.
const STREET_M: f64 = 4.0;
const MIN_POINTS: usize = 30;

const HYPOTHESES: usize = 300;
/// The steepest slopes of a hypothesis, and its least and greatest height under the camera, meters.
const MAX_SLOPE: f64 = 0.15;
const LEAST_HEIGHT_M: f64 = 0.5;
const MOST_HEIGHT_M: f64 = 3.5;
/// Within this of a hypothesis a cell supports it, at the camera; `WIDENS_PER_M` with depth.
const SUPPORT_M: f64 = 0.06;
const WIDENS_PER_M: f64 = 0.0125;

/// Reweighted least squares: the width of the weight at first and at last, and how it falls from step to step, meters; below
/// the plane it is twice as wide, since what stands on the ground is above it.
const FIRST_WIDTH_M: f64 = 0.08;
const LAST_WIDTH_M: f64 = 0.03;
const WIDTH_STEP_M: f64 = 0.008;
const ITERATIONS: usize = 8;
/// Prior, known before a scan is seen: slopes of the ground to the side and ahead in the camera's frame, mean and
/// standard deviation over KITTI's published planes, and the variance that a cell's height stands for, with neighbors
/// that err together.
const PRIOR_SLOPES: [(f64, f64); 2] = [(-0.01, 0.02), (0.0, 0.012)];
const CELL_VARIANCE_M2: f64 = 0.01;
/// Hypotheses are judged by the prior with standard deviations so many times as large.
const SEARCH_WIDENS: [f64; 2] = [2.0, 2.5];

/// A plane as y = s.x + s.y * x + s.z * z in the frame of camera 0 (y points down).
type Slopes = Vector3<f64>;

/// A cell's representative return.
struct GroundCell {
    /// (1, x, z), meters.
    regressors: Vector3<f64>,
    y_m: f64,
    /// What the cell counts in sums.
    weight: f64,
}

/// Estimates the plane a x + b y + c z + d = 0 of the road: unit normal, b < 0, in the frame of camera 0.
///
/// Random sample consensus over cells of ground, then least squares with weights that let go of what stands on the
/// ground, and a weak prior of the ground's slopes for scans in which little of it is seen (Fischler and Bolles,
/// "Random Sample Consensus", 1981).
///
/// # Frames and units
/// `points_cam`: meters, frame of camera 0 (x right, y down, z forward), all finite.
///
/// # Errors
/// [`Error::Ground`] for fewer than 30 returns 2 to 50 m ahead, 8 m to either side and 0.3 to 4.5 m below the camera, or
/// none of them in a plane that a car could stand on.
///
/// # Determinism
/// A seed always gives the same plane; the order of the points does not matter but for the last bits.
pub fn estimate_ground_plane(points_cam: impl Iterator<Item = [f64; 3]>, seed: u64) -> Result<[f64; 4]> {
    let cells = ground_cells(points_cam)?;
    let mut slopes = best_hypothesis(&cells, seed)
        .ok_or_else(|| Error::Ground { reason: "no plane that a car could stand on ahead of the camera".to_owned() })?;
    for k in 0..ITERATIONS {
        let width_m = (FIRST_WIDTH_M - WIDTH_STEP_M * k as f64).max(LAST_WIDTH_M);
        slopes = refine(&cells, &slopes, width_m);
    }
    let length = (slopes.y * slopes.y + slopes.z * slopes.z + 1.0).sqrt();
    Ok([slopes.y / length, -1.0 / length, slopes.z / length, slopes.x / length])
}

/// Sorts what may be ground into cells and picks one return of each.
fn ground_cells(points_cam: impl Iterator<Item = [f64; 3]>) -> Result<Vec<GroundCell>> {
    let mut by_cell: Vec<Vec<[f64; 3]>> = vec![Vec::new(); NUM_COLUMNS * NUM_ROWS];
    let mut num_points = 0;
    for [x, y, z] in points_cam {
        let is_ahead = AHEAD_M.contains(&z) && (-ASIDE_M..ASIDE_M).contains(&x);
        if is_ahead && y > LEAST_BELOW_M && y < MOST_BELOW_M {
            let (row, column) = ((z / CELL_M) as usize, ((x + ASIDE_M) / CELL_M) as usize);
            by_cell[row * NUM_COLUMNS + column].push([x, y, z]);
            num_points += 1;
        }
    }
    if num_points < MIN_POINTS {
        let Range { start: near, end: far } = AHEAD_M;
        return Err(Error::Ground {
            reason: format!(
                "expected at least {MIN_POINTS} points of the ground {near} to {far} m ahead of the camera, \
                 got {num_points}"
            ),
        });
    }
    let is_lower = |a: &[f64; 3], b: &[f64; 3]| b[1].total_cmp(&a[1]).then(a[0].total_cmp(&b[0]));
    let cells = by_cell.iter_mut().filter(|cell| !cell.is_empty()).map(|cell| {
        let k = (QUANTILE * (cell.len() - 1) as f64) as usize;
        let [x, y, z] = *cell.select_nth_unstable_by(k, is_lower).1;
        let aside = x / STREET_M;
        GroundCell { regressors: Vector3::new(1.0, x, z), y_m: y, weight: 1.0 / (1.0 + aside * aside) }
    });
    Ok(cells.collect())
}

/// The plane through three cells that most cells support and that is likely as a street.
fn best_hypothesis(cells: &[GroundCell], seed: u64) -> Option<Slopes> {
    let mut stream = Stream::from_seed("ground plane", seed);
    let mut best: Option<(f64, Slopes)> = None;
    for _ in 0..HYPOTHESES {
        let [a, b, c] = [(); 3].map(|()| &cells[stream.below(cells.len())]);
        let Some(slopes) = through(a, b, c) else { continue };
        let support: f64 = cells
            .iter()
            .filter(|g| (g.y_m - g.regressors.dot(&slopes)).abs() < SUPPORT_M * widening(g))
            .map(|g| g.weight)
            .sum();
        let squared = |axis: usize, slope: f64| {
            let (mean, deviation) = PRIOR_SLOPES[axis];
            let off = (slope - mean) / (SEARCH_WIDENS[axis] * deviation);
            off * off
        };
        let score = support * math::exp(-0.5 * (squared(0, slopes.y) + squared(1, slopes.z)));
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, slopes));
        }
    }
    best.map(|(_, slopes)| slopes)
}

/// The plane through three cells; `None` where they are in line or no car could stand on it.
fn through(a: &GroundCell, b: &GroundCell, c: &GroundCell) -> Option<Slopes> {
    let rows = Matrix3::from_rows(&[a.regressors.transpose(), b.regressors.transpose(), c.regressors.transpose()]);
    let slopes = (rows.determinant().abs() > 1e-2)
        .then(|| rows.try_inverse())
        .flatten()
        .map(|inverse| inverse * Vector3::new(a.y_m, b.y_m, c.y_m))?;
    let is_level = slopes.y.abs() < MAX_SLOPE && slopes.z.abs() < MAX_SLOPE;
    (is_level && slopes.x > LEAST_HEIGHT_M && slopes.x < MOST_HEIGHT_M).then_some(slopes)
}

/// One step of reweighted least squares with Tukey's weights and the prior.
fn refine(cells: &[GroundCell], slopes: &Slopes, width_m: f64) -> Slopes {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (axis, (mean, deviation)) in PRIOR_SLOPES.iter().enumerate() {
        let weight = CELL_VARIANCE_M2 / (deviation * deviation);
        normal[(axis + 1, axis + 1)] += weight;
        right[axis + 1] += weight * mean;
    }
    for cell in cells {
        let below_m = cell.y_m - cell.regressors.dot(slopes);
        let u = below_m / (width_m * widening(cell) * if below_m > 0.0 { 2.0 } else { 1.0 });
        if u.abs() < 1.0 {
            let kept = 1.0 - u * u;
            let weight = cell.weight * kept * kept;
            normal += cell.regressors * cell.regressors.transpose() * weight;
            right += cell.regressors * (weight * cell.y_m);
        }
    }
    normal.cholesky().map_or(*slopes, |factor| factor.solve(&right))
}

/// Tolerances grow with depth: far roads bend, and their returns are few.
fn widening(cell: &GroundCell) -> f64 {
    1.0 + WIDENS_PER_M * cell.regressors.z
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns of a street y = s.x + s.y x + s.z z with noise of a centimeter, and of what stands beside and on it.
    fn street(slopes: [f64; 3], clutter_share: f64, seed: u64) -> Vec<[f64; 3]> {
        let mut s = Stream::from_seed("street", seed);
        (0..6000)
            .map(|_| {
                // Rings lie the closer the nearer they are.
                let (x, z) = (s.range(-7.5, 7.5), 3.0 + 40.0 * s.unit() * s.unit());
                let road_y = slopes[0] + slopes[1] * x + slopes[2] * z + 0.01 * s.normal();
                let stands = s.chance(clutter_share) || (x > 3.0 && s.chance(0.5));
                [x, if stands { road_y - s.range(0.1, 1.4) } else { road_y }, z]
            })
            .collect()
    }

    fn estimated(points: &[[f64; 3]], seed: u64) -> [f64; 4] {
        estimate_ground_plane(points.iter().copied(), seed).expect("a street")
    }

    #[test]
    fn a_known_plane_is_found_among_clutter() {
        for (seed, slopes) in
            (0..).zip([[1.65, 0.0, 0.0], [1.60, -0.03, 0.01], [1.72, 0.02, -0.02], [2.0, -0.05, 0.03]])
        {
            for clutter_share in [0.0, 0.3] {
                let [a, b, c, d] = estimated(&street(slopes, clutter_share, seed), 0);
                assert!((a * a + b * b + c * c - 1.0).abs() < 1e-12 && b < 0.0);
                for (x, z) in [(0.0, 0.0), (0.0, 10.0), (-3.0, 20.0), (3.0, 30.0)] {
                    let y = -(a * x + c * z + d) / b;
                    let off_m = y - (slopes[0] + slopes[1] * x + slopes[2] * z);
                    assert!(off_m.abs() < 0.03, "{slopes:?}, clutter {clutter_share}: {off_m} at {x} {z}");
                }
            }
        }
    }

    #[test]
    fn returns_from_below_the_road_do_not_pull_the_plane_down() {
        let mut points = street([1.65, 0.0, 0.0], 0.1, 9);
        for point in points.iter_mut().step_by(25) {
            point[1] += 0.8;
        }
        let [_, b, _, d] = estimated(&points, 0);
        assert!((d / -b - 1.65).abs() < 0.02, "{}", d / -b);
    }

    #[test]
    fn the_order_of_points_does_not_matter_and_the_seed_names_the_plane() {
        let mut points = street([1.65, -0.01, 0.01], 0.3, 5);
        let before = estimated(&points, 7);
        assert_eq!(before, estimated(&points, 7));
        Stream::from_seed("order", 0).shuffle(&mut points);
        let after = estimated(&points, 7);
        assert!(before.iter().zip(after).all(|(p, q)| (p - q).abs() < 1e-9), "{before:?} {after:?}");
    }

    #[test]
    fn points_elsewhere_do_not_count() {
        let mut points = street([1.65, 0.0, 0.0], 0.1, 3);
        let before = estimated(&points, 1);
        points.extend([[0.0, 1.0, 1.9], [0.0, 1.0, 51.0], [9.0, 1.0, 10.0], [0.0, 0.2, 10.0], [0.0, 5.0, 10.0]]);
        assert_eq!(before, estimated(&points, 1));
    }

    #[test]
    fn too_few_points_and_walls_are_refused() {
        let street = street([1.65, 0.0, 0.0], 0.0, 0);
        let refused =
            |points: &[[f64; 3]]| estimate_ground_plane(points.iter().copied(), 0).expect_err("refused").to_string();
        assert!(refused(&street[..29]).contains("got 29"), "{}", refused(&street[..29]));
        assert!(estimate_ground_plane(street[..30].iter().copied(), 0).is_ok());
        let wall: Vec<[f64; 3]> = (0..200).map(|k| [0.0, 0.5 + 0.02 * f64::from(k), 10.0]).collect();
        assert!(refused(&wall).contains("no plane"), "{}", refused(&wall));
    }
}
