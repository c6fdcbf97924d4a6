//! Which maps there are, and over which part of the world.

use cadet_base::error::{Error, Result, finite};

/// One map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    /// Greatest height of a cell's points over the lower end of the slice, as a share of the slice's thickness.
    MaxHeight,
    /// Least height, in the same measure.
    MinHeight,
    /// min(1, ln(N + 1) / ln 16) for N points in the cell, as AVOD's.
    Density,
    /// min(1, ln(N + 1) / ln 64), as MV3D's (Chen et al. 2017, section 3.1).
    DensityLog64,
}

/// Which of a cell's points gives [`Feature::MaxHeight`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeightRule {
    /// The highest over the ground plane.
    Max,
    /// The one that AVOD's code takes: the first point of the scan in the topmost bin of one cell's height, bins being
    /// counted along the camera's y axis and not along the plane's normal.
    Reference,
}

/// What [`super::maps()`] makes: the slice maps of each slice from the lowest up, in the order of the list, then the
/// cloud maps.
#[derive(Debug, Clone, PartialEq)]
pub struct BevSpec {
    /// Maps of each slice.
    pub slice_maps: Vec<Feature>,
    /// Maps of all slices together.
    pub cloud_maps: Vec<Feature>,
    /// Slices of equal thickness between `height_m`'s ends.
    pub num_slices: usize,
    /// Heights over the ground plane: from, to (not included).
    pub height_m: [f64; 2],
    /// Ranges of points in the camera's frame along x, y and z; the ends do not belong to them.
    pub range_cam_m: [[f64; 2]; 3],
    /// Side of a cell.
    pub cell_m: f64,
    /// How the greatest height is taken.
    pub height_rule: HeightRule,
}

/// The most cells of all maps together: 1 GiB of single precision.
const MAX_VALUES: f64 = 268_435_456.0;

impl BevSpec {
    /// Channels, rows (ahead) and columns (across).
    #[must_use]
    pub fn shape(&self) -> [usize; 3] {
        let cells = |[from, to]: [f64; 2]| ((to - from) / self.cell_m).round() as usize;
        let channels = self.slice_maps.len() * self.num_slices + self.cloud_maps.len();
        [channels, cells(self.range_cam_m[2]), cells(self.range_cam_m[0])]
    }

    /// Checks that the ranges are ranges and the maps fit into memory.
    ///
    /// # Errors
    /// [`Error::NotFinite`] or [`Error::OutOfRange`], naming the field.
    pub fn check(&self) -> Result<()> {
        let out_of_range =
            |what, value: String, expected: &str| Err(Error::OutOfRange { what, value, expected: expected.to_owned() });
        if finite("cell_m", self.cell_m)? <= 0.0 {
            return out_of_range("cell_m", self.cell_m.to_string(), "more than 0");
        }
        let [x, y, z] = self.range_cam_m;
        for (what, [from, to]) in [("height_m", self.height_m), ("x_m", x), ("y_m", y), ("z_m", z)] {
            if finite(what, to)? <= finite(what, from)? {
                return out_of_range(what, format!("{from} to {to}"), "a range that rises");
            }
        }
        if self.num_slices == 0 {
            return out_of_range("num_slices", "0".to_owned(), "at least 1");
        }
        if self.slice_maps.is_empty() && self.cloud_maps.is_empty() {
            return out_of_range("number of maps", "0".to_owned(), "at least 1");
        }
        let values: f64 = self.shape().into_iter().map(|n| n as f64).product();
        if !(1.0..=MAX_VALUES).contains(&values) {
            return out_of_range("number of cells of all maps", format!("{values}"), "1 to 268435456");
        }
        Ok(())
    }
}
