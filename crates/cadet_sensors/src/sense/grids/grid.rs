//! Grids of beams: rows x columns that leave one point, or one vertical axis.

use std::ops::Range;

use super::hits::Hits;
use cadet_base::geometry::{LANES, Lanes};
use cadet_base::math::{DPose3, DVec3, Vec3};

/// One beam of a grid: the points `origin_world + depth * direction_world` with depth > 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Where the beam starts.
    pub origin_world: DVec3,
    /// Its direction, scaled so that the grid's depth counts in multiples of it (not a unit vector for a camera).
    pub direction_world: DVec3,
}

/// A rectangle of beams, by the grid's inner row order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Window {
    /// Rows, in the order in which the grid keeps them inside.
    pub rows: Range<usize>,
    /// Columns.
    pub columns: Range<usize>,
}

impl Window {
    /// True where no beam is inside.
    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty() || self.columns.is_empty()
    }
}

/// Tangents of the directions in which a circle is seen from the origin of its plane: the middle lies at `across_m` and
/// `along > 0` or behind. Infinite where the circle reaches beyond a right angle, None where it lies behind altogether.
#[inline]
pub(crate) fn tangents_of_circle(across_m: f32, along_m: f32, radius_m: f32) -> Option<[f32; 2]> {
    if along_m < -radius_m {
        return None;
    }
    // Points (across, along) with slope t touch the circle where |across - t along| = radius sqrt(1 + t^2).
    let a = along_m * along_m - radius_m * radius_m;
    if along_m <= 0.0 || a <= 1e-3 * along_m * along_m {
        return Some([f32::NEG_INFINITY, f32::INFINITY]);
    }
    let reach = radius_m * (across_m * across_m + a).sqrt();
    Some([(across_m * along_m - reach) / a, (across_m * along_m + reach) / a])
}

/// Beams in rows and columns, and what the visibility kernel needs of them.
///
/// Bounds may be too wide but never too narrow; [`BeamGrid::cover`] decides exactly.
pub trait BeamGrid {
    /// Where a vertex falls on the grid.
    type Footprint: Copy + Default;

    /// Number of rows.
    fn rows(&self) -> usize;

    /// Number of columns.
    fn columns(&self) -> usize;

    /// The frame in which the grid works.
    fn world_from_grid(&self) -> DPose3;

    /// The beam of a row and a column.
    fn beam(&self, row: usize, column: usize) -> Beam;

    /// The beams that may meet a sphere, and a depth below that of its every point.
    fn sphere_windows(&self, center_grid: Vec3, radius_m: f32) -> ([Window; 2], f32);

    /// Where the first beam of an inner row stands in a row-major array.
    fn row_start(&self, inner_row: usize) -> usize;

    /// Where points fall on the grid.
    fn footprints(&self, points_grid: &Lanes, out: &mut [Self::Footprint; LANES]);

    /// False if no beam can meet a piece with these footprints: the quick question before [`BeamGrid::windows`].
    #[inline(always)]
    fn may_meet(&self, _footprints: &[Self::Footprint; 4]) -> bool {
        true
    }

    /// The beams that may meet a piece, a convex quadrilateral or a triangle whose last corner stands twice: two windows, as a
    /// piece may lie across the seam of a turn.
    fn windows(&self, corners_grid: &[DVec3; 4], footprints: &[Self::Footprint; 4]) -> [Window; 2];

    /// A depth that no point of a piece falls below.
    #[inline(always)]
    fn near_m(&self, _corners_grid: &[DVec3; 4]) -> f32 {
        f32::NEG_INFINITY
    }

    /// How far from the origin of the grid's frame a beam may start, meters.
    #[inline(always)]
    fn most_offset_m(&self) -> f64 {
        0.0
    }

    /// True if every beam's origin lies behind a triangle, from where its corners run clockwise.
    #[inline(always)]
    fn is_turned_away(&self, [a, b, c]: &[DVec3; 3]) -> bool {
        a.dot((*b - *a).cross(*c - *a)) > 0.0
    }

    /// Calls `visit(row * columns + column, depth)` for every beam of the window that meets the triangle.
    fn cover(&self, triangle: &[DVec3; 3], window: &Window, visit: impl FnMut(usize, f64));

    /// Keeps the triangle, a face of an instance, where it is the nearest that a beam of the window meets.
    #[inline(always)]
    fn cast(&self, triangle: &[DVec3; 3], window: &Window, hits: &mut Hits, ids: [u32; 2]) {
        self.cover(triangle, window, |at, depth| hits.keep_nearer(at, [depth as f32, f32::NAN], ids));
    }
}
