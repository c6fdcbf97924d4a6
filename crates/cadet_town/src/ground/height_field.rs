//! A smooth height over the plane, fitted to the heights of lanes.
//!
//! Multilevel B-spline approximation (Lee, Wolberg and Shin 1997): bicubic lattices, each half as coarse as the one
//! before, each fitted to what the others left over. No equations to solve; smooth everywhere; far from all lanes only
//! the coarse lattices speak, so hills fade out gently.

use crate::network::Lane;
use cadet_base::math::{DVec2, DVec3};

/// The coarsest lattice: cells per side of the area.
const COARSEST_CELLS: f64 = 3.0;
/// Meters per cell of the finest lattice where roads rise and fall, and where they lie over each other.
pub(crate) const FINEST_CELL_M: f64 = 4.0;
pub(crate) const FINEST_CELL_AT_BRIDGES_M: f64 = 2.0;
/// Below this span of heights a map is flat.
const FLAT_SPAN_M: f64 = 1e-3;
/// A lattice is fitted again until no sample is further off than this, but not more often than that.
const GOOD_FIT_M: f64 = 0.004;
const MAX_PASSES: usize = 4;
/// Heights are taken from lanes at points at least this far apart.
const SAMPLE_STEP_M: f64 = 1.7;
/// No lattice has more than this many cells to a side.
const MAX_CELLS: f64 = 2000.0;

/// A smooth height over the plane.
#[derive(Debug, Clone)]
pub(crate) struct HeightField {
    base_m: f64,
    lattices: Vec<Lattice>,
}

impl HeightField {
    /// A field of one height everywhere.
    pub(crate) fn flat(base_m: f64) -> Self {
        Self { base_m, lattices: Vec::new() }
    }

    /// Fits the heights of `samples`, all of which lie in the rectangle from `min` to `max`, by lattices down to a cell.
    pub(crate) fn fit(samples: &[DVec3], (min, max): (DVec2, DVec2), finest_cell_m: f64) -> Self {
        let (lo, hi) = samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
        if samples.is_empty() {
            return Self::flat(0.0);
        }
        if hi - lo < FLAT_SPAN_M {
            return Self::flat((lo + hi) / 2.0);
        }
        let base_m = samples.iter().map(|p| p.z).sum::<f64>() / samples.len() as f64;
        let mut left: Vec<f64> = samples.iter().map(|p| p.z - base_m).collect();
        let extent = (max - min).max_element();
        let mut cell = extent / COARSEST_CELLS;
        let finest = finest_cell_m.max(extent / MAX_CELLS);
        let mut lattices = Vec::new();
        loop {
            let mut lattice = Lattice::empty(min, max, cell);
            let fit = Fit::new(&lattice, samples);
            let mut worst = f64::INFINITY;
            // One pass meets narrow strips of samples only in part. What a lattice could explain and doesn't would turn
            // up as ripples of the finer ones.
            for pass in 0..=MAX_PASSES {
                if pass > 0 && worst < GOOD_FIT_M {
                    break;
                }
                let control = fit.control(&left);
                worst = fit.take_from(&mut left, &control);
                lattice.control.iter_mut().zip(&control).for_each(|(a, b)| *a += b);
            }
            lattices.push(lattice);
            if cell <= finest {
                return Self { base_m, lattices };
            }
            cell = (cell / 2.0).max(finest);
        }
    }

    pub(crate) fn height(&self, p: DVec2) -> f64 {
        self.lattices.iter().fold(self.base_m, |z, l| z + l.height(p))
    }

    pub(crate) fn is_flat(&self) -> bool {
        self.lattices.is_empty()
    }
}

#[derive(Debug, Clone)]
struct Lattice {
    min: DVec2,
    cell_m: f64,
    columns: usize,
    rows: usize,
    control: Vec<f64>,
}

/// The four uniform cubic B-spline weights at `t` in 0..1.
fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    let u = 1.0 - t;
    [u * u * u / 6.0, (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0, (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0, t3 / 6.0]
}

impl Lattice {
    /// Heights of 0.
    fn empty(min: DVec2, max: DVec2, cell_m: f64) -> Self {
        let cells = ((max - min) / cell_m).ceil().max(DVec2::ONE);
        let (columns, rows) = (cells.x as usize + 3, cells.y as usize + 3);
        Self { min, cell_m, columns, rows, control: vec![0.0; columns * rows] }
    }

    /// Index of the first of the 4 x 4 control points, and the weights along x and y; clamped to the rectangle.
    fn place(&self, p: DVec2) -> (usize, [f64; 4], [f64; 4]) {
        let u = (p - self.min) / self.cell_m;
        let axis = |v: f64, n: usize| {
            let v = v.clamp(0.0, (n - 3) as f64);
            let i = (v as usize).min(n - 4);
            (i, weights(v - i as f64))
        };
        let ((i, wx), (j, wy)) = (axis(u.x, self.columns), axis(u.y, self.rows));
        (j * self.columns + i, wx, wy)
    }

    fn height(&self, p: DVec2) -> f64 {
        height(&self.control, self.columns, self.place(p))
    }
}

fn height(control: &[f64], columns: usize, (first, wx, wy): (usize, [f64; 4], [f64; 4])) -> f64 {
    let mut z = 0.0;
    for (j, y) in wy.iter().enumerate() {
        let row = &control[first + j * columns..][..4];
        z += y * (wx[0] * row[0] + wx[1] * row[1] + wx[2] * row[2] + wx[3] * row[3]);
    }
    z
}

/// Samples on a lattice: what does not change from pass to pass.
struct Fit {
    columns: usize,
    places: Vec<(usize, [f64; 4], [f64; 4])>,
    /// Sum of the squared weights of each control point.
    weight: Vec<f64>,
}

impl Fit {
    fn new(lattice: &Lattice, samples: &[DVec3]) -> Self {
        let places: Vec<_> = samples.iter().map(|p| lattice.place(p.truncate())).collect();
        let columns = lattice.columns;
        let mut weight = vec![0.0; lattice.control.len()];
        for (first, wx, wy) in &places {
            for (j, y) in wy.iter().enumerate() {
                let row = &mut weight[first + j * columns..][..4];
                for i in 0..4 {
                    let w = wx[i] * y;
                    row[i] += w * w;
                }
            }
        }
        Self { columns, places, weight }
    }

    /// The control points that meet each sample alone, averaged.
    fn control(&self, heights: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.weight.len()];
        for ((first, wx, wy), z) in self.places.iter().zip(heights) {
            let square = |w: &[f64; 4]| w.iter().map(|v| v * v).sum::<f64>();
            let total = square(wx) * square(wy);
            for (j, y) in wy.iter().enumerate() {
                let row = &mut sum[first + j * self.columns..][..4];
                for i in 0..4 {
                    let w = wx[i] * y;
                    row[i] += w * w * (w * z / total);
                }
            }
        }
        sum.iter().zip(&self.weight).map(|(z, w)| if *w > 0.0 { z / w } else { 0.0 }).collect()
    }

    /// Leaves in `heights` what the control points do not explain; returns the largest of it.
    fn take_from(&self, heights: &mut [f64], control: &[f64]) -> f64 {
        heights.iter_mut().zip(&self.places).fold(0.0, |worst, (z, place)| {
            *z -= height(control, self.columns, *place);
            worst.max(z.abs())
        })
    }
}

/// Points of the lanes that are driven on, at the height that the ground is to have there.
pub(crate) fn road_heights(lanes: &[Lane]) -> Vec<DVec3> {
    lanes.iter().filter(|l| l.is_driven()).flat_map(spaced_points).collect()
}

/// The lane's points, without those that follow closer than [`SAMPLE_STEP_M`].
fn spaced_points(lane: &Lane) -> Vec<DVec3> {
    let mut next_s = 0.0;
    let spaced = lane.center.iter().zip(&lane.s_m).filter(|(_, s)| {
        let keep = **s >= next_s;
        next_s = if keep { **s + SAMPLE_STEP_M } else { next_s };
        keep
    });
    spaced.map(|(p, _)| *p).chain(lane.center.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math;

    #[test]
    fn a_hill_sampled_along_lines_is_met_on_them_and_stays_gentle_between() {
        let hill = |p: DVec2| 5.0 * math::sin(p.x / 60.0) + 3.0 * math::cos(p.y / 80.0 + 1.0);
        let mut samples = Vec::new();
        for line in 0..5 {
            for i in 0..400 {
                let (a, b) = (f64::from(line) * 100.0, f64::from(i));
                samples.push(DVec2::new(a, b).extend(hill(DVec2::new(a, b))));
                samples.push(DVec2::new(b, a).extend(hill(DVec2::new(b, a))));
            }
        }
        let field = HeightField::fit(&samples, (DVec2::splat(-150.0), DVec2::splat(550.0)), FINEST_CELL_M);
        let worst = samples.iter().map(|p| (field.height(p.truncate()) - p.z).abs()).fold(0.0, f64::max);
        assert!(worst < 0.01, "{worst}");
        for i in 0..400 {
            let p = DVec2::new(50.0, f64::from(i));
            assert!((field.height(p) - hill(p)).abs() < 1.5, "{p} {} {}", field.height(p), hill(p));
        }
    }
}
