//! One pass over the points fills every map.

use super::spec::{BevSpec, Feature, HeightRule};
use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{self, floor};

/// What the logarithms of counts are divided by; a cell with one point less is full.
const FULL: usize = 16;
const FULL_LOG64: usize = 64;

/// ln(n + 1) / ln N for n points.
fn densities<const N: usize>() -> [f32; N] {
    std::array::from_fn(|n| (math::ln(n as f64 + 1.0) / math::ln(N as f64)) as f32)
}

/// Fills `out` (channel, row, column; row 0 farthest) with the maps of points in the frame of camera 0.
///
/// `points_cam` may come in any order; those outside of the ranges are left out. `plane_cam` is a x + b y + c z + d = 0
/// with y down, of any length and sign. Cells without points are 0. `out` must hold zeros: a fresh array does.
///
/// Reference: AVOD (Ku et al., 2018), section III.A; configurations by "Multimodal 3D Object Detection from Simulated
/// Pretraining" (2019).
///
/// ```
/// use cadet_core::bev::{BevSpec, Feature, HeightRule, maps};
///
/// let spec = BevSpec {
///     slice_maps: vec![Feature::MaxHeight],
///     cloud_maps: vec![Feature::Density],
///     num_slices: 5,
///     height_m: [-0.2, 2.3],
///     range_cam_m: [[-40.0, 40.0], [-5.0, 3.0], [0.0, 70.0]],
///     cell_m: 0.1,
///     height_rule: HeightRule::Max,
/// };
/// let [channels, rows, columns] = spec.shape();
/// let mut out = vec![0.0; channels * rows * columns];
/// // A point 1 m over the ground, 10 m ahead; the camera is 1.65 m over the ground.
/// maps([[0.05, 0.65, 10.05]].into_iter(), [0.0, -1.0, 0.0, 1.65], &spec, &mut out)?;
/// assert_eq!((channels, rows, columns), (6, 700, 800));
/// assert_eq!(out.iter().filter(|value| **value > 0.0).count(), 2);
/// # Ok::<_, cadet_core::Error>(())
/// ```
///
/// # Errors
/// What [`BevSpec::check`] finds; a plane that is none; [`Error::Shape`] for an `out` of another size.
pub fn maps(
    points_cam: impl Iterator<Item = [f64; 3]>,
    plane_cam: [f64; 4],
    spec: &BevSpec,
    out: &mut [f32],
) -> Result<()> {
    spec.check()?;
    let up = upward_unit_plane(plane_cam)?;
    let [channels, rows, columns] = spec.shape();
    if out.len() != channels * rows * columns {
        return Err(Error::Shape {
            what: "out",
            got: format!("({},)", out.len()),
            expected: format!("({channels}, {rows}, {columns})"),
        });
    }
    let grid = MapGrid::new(spec);
    let cells = rows * columns;
    let mut filler = Filler {
        spec,
        out,
        cells,
        touched: Vec::new(),
        candidates: Vec::new(),
        slice_m: grid.slice_m,
        cloud_m: grid.height_m[1] - grid.height_m[0],
    };
    for (order, point) in points_cam.enumerate() {
        if let Some(place) = grid.place(point, &up) {
            filler.add(&place, order);
        }
    }
    filler.finish();
    Ok(())
}

/// The plane with its normal upward (y points down) and of unit length, so that it gives heights.
fn upward_unit_plane(plane: [f64; 4]) -> Result<[f64; 4]> {
    for value in plane {
        let _ = finite("plane", value)?;
    }
    let [a, b, c, _] = plane;
    let length = (a * a + b * b + c * c).sqrt();
    if length < 1e-9 || b == 0.0 {
        return Err(Error::OutOfRange {
            what: "plane",
            value: format!("{plane:?}"),
            expected: "a normal with a vertical part".to_owned(),
        });
    }
    let scale = if b > 0.0 { -length } else { length };
    Ok(plane.map(|v| v / scale))
}

/// Where points fall on the maps of a [`BevSpec`].
struct MapGrid {
    range_cam_m: [[f64; 2]; 3],
    cell_m: f64,
    first: [i64; 2],
    rows: usize,
    columns: usize,
    height_m: [f64; 2],
    slice_m: f64,
    num_slices: usize,
}

/// A point on the maps.
struct PointOnMaps {
    cell: usize,
    /// Its slice; None in the hair's breadth that rounding may leave between two.
    slice: Option<usize>,
    /// Height over the lower end of its slice, and of all slices.
    in_slice_m: f64,
    in_cloud_m: f64,
    y_m: f64,
}

impl MapGrid {
    fn new(spec: &BevSpec) -> Self {
        let [_, rows, columns] = spec.shape();
        let [x, _, z] = spec.range_cam_m;
        Self {
            range_cam_m: spec.range_cam_m,
            cell_m: spec.cell_m,
            first: [x[0], z[0]].map(|from_m| (from_m / spec.cell_m).round() as i64),
            rows,
            columns,
            height_m: spec.height_m,
            slice_m: (spec.height_m[1] - spec.height_m[0]) / spec.num_slices as f64,
            num_slices: spec.num_slices,
        }
    }

    #[inline(always)]
    fn place(&self, [x, y, z]: [f64; 3], [a, b, c, d]: &[f64; 4]) -> Option<PointOnMaps> {
        let inside = |v: f64, [from, to]: [f64; 2]| from < v && v < to;
        let [range_x, range_y, range_z] = self.range_cam_m;
        if !(inside(x, range_x) && inside(y, range_y) && inside(z, range_z)) {
            return None;
        }
        let height_m = a * x + b * y + c * z + d;
        let [low, high] = self.height_m;
        if !(low <= height_m && height_m < high) {
            return None;
        }
        // Divided as the reference does: at the edges of cells a multiplication would round another way.
        let cell = |v: f64, first: i64, count: usize| ((floor(v / self.cell_m) - first).max(0) as usize).min(count - 1);
        let column = cell(x, self.first[0], self.columns);
        let ahead = cell(z, self.first[1], self.rows);
        let guess = ((height_m - low) / self.slice_m) as usize;
        let floor_m = |slice: usize| low + slice as f64 * self.slice_m;
        let holds = |s: usize| s < self.num_slices && floor_m(s) <= height_m && height_m < floor_m(s) + self.slice_m;
        let slice = if holds(guess) {
            Some(guess)
        } else {
            [guess.saturating_sub(1), guess + 1].into_iter().find(|s| holds(*s))
        };
        Some(PointOnMaps {
            cell: (self.rows - 1 - ahead) * self.columns + column,
            slice,
            in_slice_m: slice.map_or(0.0, |s| height_m - floor_m(s)),
            in_cloud_m: height_m - low,
            y_m: y,
        })
    }
}

/// The maps while points come in.
struct Filler<'a> {
    spec: &'a BevSpec,
    out: &'a mut [f32],
    cells: usize,
    /// Values that hold a count, or a height below zero, until the end.
    touched: Vec<(usize, Feature)>,
    /// What [`HeightRule::Reference`] chooses from.
    candidates: Vec<HeightCandidate>,
    /// Thickness of a slice, and of all.
    slice_m: f64,
    cloud_m: f64,
}

/// A point's height for a value of the maps.
struct HeightCandidate {
    /// Index of the value.
    at: usize,
    y_bin: i32,
    /// Number of the point.
    order: usize,
    /// As a share of the slice's or the cloud's thickness.
    height_share: f32,
}

impl Filler<'_> {
    #[inline(always)]
    fn add(&mut self, place: &PointOnMaps, order: usize) {
        let spec = self.spec;
        if let Some(slice) = place.slice {
            for (i, feature) in spec.slice_maps.iter().enumerate() {
                self.put(slice * spec.slice_maps.len() + i, *feature, place, [place.in_slice_m, self.slice_m], order);
            }
        }
        for (i, feature) in spec.cloud_maps.iter().enumerate() {
            let channel = spec.slice_maps.len() * spec.num_slices + i;
            self.put(channel, *feature, place, [place.in_cloud_m, self.cloud_m], order);
        }
    }

    #[inline(always)]
    fn put(&mut self, channel: usize, feature: Feature, place: &PointOnMaps, height_m: [f64; 2], order: usize) {
        let height = || (height_m[0] / height_m[1]) as f32;
        let at = channel * self.cells + place.cell;
        let value = &mut self.out[at];
        match feature {
            Feature::MaxHeight if self.spec.height_rule == HeightRule::Reference => {
                let (y_bin, height_share) = (floor(place.y_m / self.spec.cell_m) as i32, height());
                self.candidates.push(HeightCandidate { at, y_bin, order, height_share });
            }
            Feature::MaxHeight => *value = value.max(height()),
            // An empty cell holds +0, one with points minus its least height: the sign tells them apart.
            Feature::MinHeight if value.is_sign_negative() => *value = value.max(-height()),
            Feature::MinHeight => {
                *value = -height();
                self.touched.push((at, feature));
            }
            Feature::Density | Feature::DensityLog64 => {
                if *value == 0.0 {
                    self.touched.push((at, feature));
                }
                *value += 1.0;
            }
        }
    }

    fn finish(mut self) {
        let (density, log64) = (densities::<FULL>(), densities::<FULL_LOG64>());
        for (at, feature) in self.touched {
            let value = &mut self.out[at];
            *value = match feature {
                Feature::Density => density[(*value as usize).min(FULL - 1)],
                Feature::DensityLog64 => log64[(*value as usize).min(FULL_LOG64 - 1)],
                Feature::MaxHeight | Feature::MinHeight => -*value,
            };
        }
        self.candidates.sort_unstable_by_key(|c| (c.at, c.y_bin, c.order));
        self.candidates.dedup_by_key(|c| c.at);
        for candidate in self.candidates {
            self.out[candidate.at] = candidate.height_share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(slice_maps: &[Feature], cloud_maps: &[Feature]) -> BevSpec {
        BevSpec {
            slice_maps: slice_maps.to_vec(),
            cloud_maps: cloud_maps.to_vec(),
            num_slices: 2,
            height_m: [0.0, 2.0],
            range_cam_m: [[-2.0, 2.0], [-5.0, 3.0], [0.0, 3.0]],
            cell_m: 0.5,
            height_rule: HeightRule::Max,
        }
    }

    fn filled(points: &[[f64; 3]], spec: &BevSpec) -> Vec<f32> {
        let mut out = vec![0.0; spec.shape().into_iter().product()];
        maps(points.iter().copied(), [0.0, -1.0, 0.0, 1.5], spec, &mut out).expect("a good specification");
        out
    }

    #[test]
    fn one_point_lands_in_one_cell_of_its_slice() {
        let spec = spec(&[Feature::MaxHeight, Feature::Density], &[Feature::MinHeight]);
        assert_eq!(spec.shape(), [5, 6, 8]);
        // Height 1.5 - 0.25 = 1.25 over the road: the second slice, a quarter up; 62.5 % of the cloud's range.
        let out = filled(&[[-1.9, 0.25, 2.9]], &spec);
        let mut expected = vec![0.0; 5 * 48];
        expected[2 * 48] = 0.25;
        expected[3 * 48] = 0.25;
        expected[4 * 48] = 0.625;
        assert_eq!(out, expected);
        // Right in front of the camera: last row, right half.
        let out = filled(&[[0.1, 0.25, 0.1]], &spec);
        assert_eq!(out.iter().position(|v| *v != 0.0), Some(2 * 48 + 5 * 8 + 4));
    }

    #[test]
    fn densities_count_and_saturate_at_one_less_than_their_logarithm() {
        let spec = spec(&[], &[Feature::Density, Feature::MaxHeight, Feature::MinHeight, Feature::DensityLog64]);
        for n in 1..80 {
            let points: Vec<[f64; 3]> = (0..n).map(|i| [0.2, 1.4 - 0.01 * f64::from(i), 1.2]).collect();
            let out = filled(&points, &spec);
            let at = 3 * 8 + 4;
            let expected = (math::ln(f64::from(n + 1)) / math::ln(16.0)).min(1.0);
            assert!((f64::from(out[at]) - expected).abs() < 1e-6, "{n}: {}", out[at]);
            assert!((out[48 + at] - (0.1 + 0.01 * (n - 1) as f32) / 2.0).abs() < 1e-6);
            assert!((out[96 + at] - 0.05).abs() < 1e-6);
            let expected = (math::ln(f64::from(n + 1)) / math::ln(64.0)).min(1.0);
            assert!((f64::from(out[144 + at]) - expected).abs() < 1e-6, "{n}: {}", out[144 + at]);
        }
    }

    #[test]
    fn ends_of_ranges_do_not_belong_to_them_and_nan_is_nowhere() {
        let spec = spec(&[Feature::Density], &[Feature::Density]);
        let outside = [
            [-2.0, 0.5, 1.0],
            [2.0, 0.5, 1.0],
            [0.0, 0.5, 0.0],
            [0.0, 0.5, 3.0],
            [0.0, -0.5, 1.0],
            [0.0, 1.500_001, 1.0],
            [f64::NAN, 0.5, 1.0],
            [0.0, f64::INFINITY, 1.0],
        ];
        assert!(filled(&outside, &spec).iter().all(|v| *v == 0.0));
        // A height of exactly 0 is inside: it counts.
        assert!(filled(&[[0.0, 1.5, 1.0]], &spec).iter().any(|v| *v > 0.0));
        assert!(filled(&[], &spec).iter().all(|v| *v == 0.0));
    }

    #[test]
    fn the_reference_takes_the_first_point_of_the_topmost_bin() {
        let mut spec = spec(&[], &[Feature::MaxHeight]);
        // y bins of 0.5 m: -0.1 and -0.4 lie in the topmost one, and -0.1 came first.
        let points = [[0.2, 0.2, 1.2], [0.2, -0.1, 1.2], [0.2, -0.4, 1.2]];
        let at = 3 * 8 + 4;
        assert!((filled(&points, &spec)[at] - 0.95).abs() < 1e-6);
        spec.height_rule = HeightRule::Reference;
        assert!((filled(&points, &spec)[at] - 0.8).abs() < 1e-6);
    }

    #[test]
    fn planes_of_any_sign_and_length_are_one_plane_and_nonsense_is_refused() {
        let spec = spec(&[Feature::MaxHeight], &[Feature::Density]);
        let point = || [[0.3, 0.4, 1.7]].into_iter();
        let of = |plane: [f64; 4]| {
            let mut out = vec![0.0; spec.shape().into_iter().product()];
            maps(point(), plane, &spec, &mut out).map(|()| out)
        };
        let tilted = [0.01, -1.0, 0.02, 1.6];
        assert_eq!(of(tilted), of(tilted.map(|v| v * -4.0)));
        assert!(of([0.0, 0.0, 0.0, 1.0]).expect_err("no plane").to_string().contains("plane is [0.0"));
        assert!(of([1.0, 0.0, 0.0, 1.0]).expect_err("a wall").to_string().contains("vertical part"));
        assert!(of([f64::NAN, -1.0, 0.0, 1.0]).expect_err("NaN").to_string().contains("plane is not finite"));
        let short = maps(point(), tilted, &spec, &mut [0.0; 7]).expect_err("short");
        assert_eq!(short.to_string(), "out has shape (7,), expected (3, 6, 8)");
        let flat = BevSpec { height_m: [1.0, 1.0], ..spec.clone() };
        assert!(maps(point(), tilted, &flat, &mut []).expect_err("flat").to_string().contains("height_m is 1 to 1"));
    }
}
