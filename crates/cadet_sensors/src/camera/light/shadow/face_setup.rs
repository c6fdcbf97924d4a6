//! Faces about to be drawn onto a shadow map, eight at a time.

use super::map::{HIGHEST_STEPS, SIZE};
use cadet_base::geometry::LANES;
use cadet_base::math::{greater, lesser};

/// Faces of less area have none, square texels.
const LEAST_AREA: f32 = 1e-9;
/// Corners and edges of a face; a triangle's last corner stands twice.
const EDGES: usize = 4;

/// The corners of [`LANES`] faces: x and y in texels, z in steps. A triangle's last one stands twice.
pub(super) type Corners = [[[f32; LANES]; 3]; EDGES];

/// A function that is linear over each of [`LANES`] faces: its value in the middle of the first texel of the face's
/// bounds, and how it changes from texel to texel.
#[derive(Default)]
pub(super) struct Plane {
    pub first: [f32; LANES],
    pub along_x: [f32; LANES],
    pub along_y: [f32; LANES],
}

/// [`LANES`] faces about to be drawn.
#[derive(Default)]
pub(super) struct FaceSetup {
    /// The first column and row of texels whose middles lie within their bounds, and those after the last.
    pub bounds: [[i32; LANES]; 4],
    /// Not negative on the inner side of their edges.
    pub edges: [Plane; EDGES],
    /// Their heights, steps.
    pub z: Plane,
    /// The highest corners.
    pub highest_steps: [f32; LANES],
    /// False where no texel's middle is met for certain, and without an area.
    pub meets_texels: [bool; LANES],
    /// Counter-clockwise seen from the sun.
    pub faces_sun: [bool; LANES],
}

impl FaceSetup {
    #[inline(always)]
    pub fn of(corners: &Corners) -> Self {
        let mut out = Self::default();
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz], [dx, dy, dz]] = corners;
        let (mut sign, mut middle) = ([0.0; LANES], [[0.0; LANES]; 2]);
        for i in 0..LANES {
            let (min_x, max_x) = bounds([ax[i], bx[i], cx[i], dx[i]]);
            let (min_y, max_y) = bounds([ay[i], by[i], cy[i], dy[i]]);
            // Texels' middles lie half a texel beyond their numbers: bounds are rounded to the nearest number.
            let ((x0, left), (x1, right)) = (rounded(min_x), rounded(max_x));
            let ((y0, top), (y1, bottom)) = (rounded(min_y), rounded(max_y));
            let (abx, aby, abz) = (bx[i] - ax[i], by[i] - ay[i], bz[i] - az[i]);
            let (acx, acy, acz) = (cx[i] - ax[i], cy[i] - ay[i], cz[i] - az[i]);
            let area = abx * acy - aby * acx;
            out.meets_texels[i] = (left < right) & (top < bottom) & (area.abs() > LEAST_AREA);
            out.faces_sun[i] = area > 0.0;
            [out.bounds[0][i], out.bounds[1][i], out.bounds[2][i], out.bounds[3][i]] = [x0, y0, x1, y1];
            let inverse = 1.0 / area;
            // The height is linear in the weights of b and c, and they are linear in x and y.
            let (z_x, z_y) = ((abz * acy - acz * aby) * inverse, (acz * abx - abz * acx) * inverse);
            sign[i] = if area > 0.0 { 1.0 } else { -1.0 };
            (middle[0][i], middle[1][i]) = (left + 0.5, top + 0.5);
            let (to_x, to_y) = (middle[0][i] - ax[i], middle[1][i] - ay[i]);
            (out.z.first[i], out.z.along_x[i], out.z.along_y[i]) = (az[i] + (z_x * to_x + z_y * to_y), z_x, z_y);
            out.highest_steps[i] = lesser(greater(greater(az[i], bz[i]), greater(cz[i], dz[i])), HIGHEST_STEPS);
        }
        for (k, edge) in out.edges.iter_mut().enumerate() {
            let ([from_x, from_y, _], [to_x, to_y, _]) = (&corners[k], &corners[(k + 1) % EDGES]);
            for i in 0..LANES {
                let (x, y) = ((from_y[i] - to_y[i]) * sign[i], (to_x[i] - from_x[i]) * sign[i]);
                edge.first[i] = x * (middle[0][i] - from_x[i]) + y * (middle[1][i] - from_y[i]);
                (edge.along_x[i], edge.along_y[i]) = (x, y);
            }
        }
        out
    }
}

/// The least and the greatest of four numbers.
#[inline(always)]
fn bounds([a, b, c, d]: [f32; 4]) -> (f32, f32) {
    (lesser(lesser(a, b), lesser(c, d)), greater(greater(a, b), greater(c, d)))
}

/// The nearest integer on a map, as such and as it was; ties go to the even one.
#[inline(always)]
pub(super) fn rounded(x: f32) -> (i32, f32) {
    const LARGE: f32 = 12_582_912.0; // 1.5 * 2^23
    let moved = lesser(greater(x, 0.0), SIZE as f32) + LARGE;
    ((moved.to_bits() as i32).wrapping_sub(LARGE.to_bits() as i32), moved - LARGE)
}
