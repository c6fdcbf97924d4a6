//! From the world to a grid's frame.

use super::grid::BeamGrid;
use cadet_base::geometry::{LANES, Lanes};
use cadet_base::math::{DMat3, DVec3};

/// World to grid, in double precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ToGrid {
    pub rotation: DMat3,
    pub origin_world: DVec3,
}

impl ToGrid {
    pub(crate) fn new<G: BeamGrid>(grid: &G) -> Self {
        let world_from_grid = grid.world_from_grid();
        Self {
            rotation: DMat3::from_quat(world_from_grid.rotation).transpose(),
            origin_world: world_from_grid.translation,
        }
    }

    /// [`LANES`] points at once.
    #[inline(always)]
    pub(crate) fn lanes(&self, [x, y, z]: &Lanes) -> [[f64; LANES]; 3] {
        let (r, o) = (&self.rotation, &self.origin_world);
        let mut out = [[0.0; LANES]; 3];
        for i in 0..LANES {
            let (x, y, z) = (f64::from(x[i]) - o.x, f64::from(y[i]) - o.y, f64::from(z[i]) - o.z);
            out[0][i] = r.x_axis.x * x + r.y_axis.x * y + r.z_axis.x * z;
            out[1][i] = r.x_axis.y * x + r.y_axis.y * y + r.z_axis.y * z;
            out[2][i] = r.x_axis.z * x + r.y_axis.z * y + r.z_axis.z * z;
        }
        out
    }
}
