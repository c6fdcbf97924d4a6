//! A triangle as the beams of one row of a spinning LIDAR meet it.

use super::row_lookup::SortedRow;
use crate::sense::grids::Hits;
use crate::wide_registers::array_of;
use cadet_base::math::DVec3;

/// Beams that are tested together.
pub(super) const EIGHT: usize = 8;

/// A number for each edge and, last, for the normal: what the compiler puts into one vector register.
type PerPlane = [f64; 4];

/// [`crate::sense::grids::EdgePlanes`], axis by axis.
pub(super) struct PlaneLanes {
    /// x, y and z of a x b, b x c, c x a, and of the normal.
    cross: [PerPlane; 3],
    /// x, y and z of b - a, c - b, a - c, and of nothing.
    delta: [PerPlane; 3],
    volume6_m3: f64,
    /// Square of the normal's length.
    normal2_m4: f64,
}

impl PlaneLanes {
    /// The planes of a triangle given in the grid's frame.
    #[inline(always)]
    pub(super) fn new([a, b, c]: &[DVec3; 3]) -> Self {
        let (ab, ac) = (*b - *a, *c - *a);
        let from = [[a.x, b.x, c.x, ab.x], [a.y, b.y, c.y, ab.y], [a.z, b.z, c.z, ab.z]];
        let to = [[b.x, c.x, a.x, ac.x], [b.y, c.y, a.y, ac.y], [b.z, c.z, a.z, ac.z]];
        let (mut cross, mut delta) = ([[0.0; 4]; 3], [[0.0; 4]; 3]);
        for axis in 0..3 {
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            for i in 0..4 {
                cross[axis][i] = from[j][i] * to[k][i] - to[j][i] * from[k][i];
                delta[axis][i] = if i < 3 { to[axis][i] - from[axis][i] } else { 0.0 };
            }
        }
        let volume6_m3 = a.x * cross[0][3] + a.y * cross[1][3] + a.z * cross[2][3];
        let normal2_m4 = cross[0][3] * cross[0][3] + cross[1][3] * cross[1][3] + cross[2][3] * cross[2][3];
        Self { cross, delta, volume6_m3, normal2_m4 }
    }
}

/// A triangle as one row sees it from one of its sides: in the beam's azimuth, its edges, its normal and the volume that
/// it spans with the laser are `a cos + b sin + c`.
pub(super) struct RowPlanes {
    /// a, b and c of the edges and, last, of the normal.
    planes: [PerPlane; 3],
    /// By the secant of the row's elevation; positive where the laser is on this side.
    volume: [f64; 3],
    level: f64,
    normal2_m4: f64,
}

impl RowPlanes {
    /// The volume that a triangle spans with a row's laser, not yet by the secant, and the sides that the laser is on: both
    /// for one beside the axis that may go around the triangle's plane.
    #[inline(always)]
    pub(super) fn sides(triangle: &PlaneLanes, row: &SortedRow) -> ([f64; 3], [Option<f64>; 2]) {
        let ([x, y, z], left) = (array_of::<_, 3>(|axis| triangle.cross[axis][3]), row.left_m);
        let volume = [-left * y, left * x, triangle.volume6_m3 - row.height_m * z];
        let changes = volume[0].abs() + volume[1].abs();
        let sides = if volume[2].abs() > changes {
            // Without a branch, which would be guessed wrong half of the time.
            [Some(1_f64.copysign(volume[2])), None]
        } else if changes > 0.0 {
            [Some(1.0), Some(-1.0)]
        } else {
            [None; 2]
        };
        (volume, sides)
    }

    /// The triangle from one of its [`RowPlanes::sides`]: the beam's direction times (A - origin) x (B - origin) for each
    /// edge AB, where the origin turns with the beam.
    #[inline(always)]
    pub(super) fn seen_from(side: f64, triangle: &PlaneLanes, row: &SortedRow, volume: [f64; 3]) -> Self {
        let SortedRow { tangent, secant, level, height_m: h, left_m: left } = *row;
        let aside = tangent * left;
        let ([nx, ny, nz], [dx, dy, dz]) = (&triangle.cross, &triangle.delta);
        let mut planes = [[0.0; 4]; 3];
        for i in 0..4 {
            planes[0][i] = side * (nx[i] + h * dy[i] + aside * dx[i]);
            planes[1][i] = side * (ny[i] - h * dx[i] + aside * dy[i]);
            planes[2][i] = side * (nz[i] * tangent - left * dz[i]);
        }
        Self { planes, volume: array_of(|i| side * volume[i] * secant), level, normal2_m4: triangle.normal2_m4 }
    }

    /// a, b and c of an edge.
    #[inline(always)]
    pub(super) fn edge(&self, i: usize) -> [f64; 3] {
        let [a, b, c] = &self.planes;
        [a[i], b[i], c[i]]
    }

    /// The edges and, last, the normal, at a heading.
    #[inline(always)]
    pub(super) fn at(&self, [cos, sin]: [f64; 2]) -> PerPlane {
        let ([a, b, c], mut out) = (&self.planes, [0.0; 4]);
        for i in 0..4 {
            out[i] = a[i] * cos + b[i] * sin + c[i];
        }
        out
    }

    /// What turns the normal's product with a level heading and the elevation's tangent into the cosine of the angle.
    #[inline(always)]
    fn cosine_scale(&self) -> f64 {
        self.level / self.normal2_m4.sqrt()
    }

    /// The range of the beam with this heading and the cosine of its incidence angle, if it meets the triangle from this side.
    #[inline(always)]
    pub(super) fn meet(&self, [cos, sin]: [f64; 2]) -> Option<[f64; 2]> {
        let [p, q, r, facing] = self.at([cos, sin]);
        let volume = self.volume[0] * cos + self.volume[1] * sin + self.volume[2];
        (p >= 0.0 && q >= 0.0 && r >= 0.0 && facing > 0.0 && volume > 0.0)
            .then(|| [volume / facing, facing * self.cosine_scale()])
    }

    /// Finds the ranges of eight beams, the first of them at `at`, and keeps what is nearer.
    #[inline(always)]
    pub(super) fn cast_eight(
        &self,
        [cos, sin]: [&[f64; EIGHT]; 2],
        hits: &mut Hits,
        at: usize,
        [instance, face]: [u32; 2],
    ) {
        let [p, q, r, n] = array_of::<_, 4>(|i| self.edge(i));
        let (mut inside, mut facing) = ([false; EIGHT], [0.0; EIGHT]);
        let mut any = false;
        for i in 0..EIGHT {
            let on = |p: &[f64; 3]| p[0] * cos[i] + p[1] * sin[i] + p[2];
            facing[i] = on(&n);
            inside[i] = (on(&p) >= 0.0) & (on(&q) >= 0.0) & (on(&r) >= 0.0) & (facing[i] > 0.0);
            any |= inside[i];
        }
        if !any {
            return;
        }
        let volume: [f64; EIGHT] = array_of(|i| self.volume[0] * cos[i] + self.volume[1] * sin[i] + self.volume[2]);
        for i in 0..EIGHT {
            inside[i] &= volume[i] > 0.0;
        }
        let scale = self.cosine_scale();
        let (Ok(depths), Ok(instances), Ok(faces), Ok(cosines)) = (
            <&mut [f32; EIGHT]>::try_from(&mut hits.depth_m[at..at + EIGHT]),
            <&mut [u32; EIGHT]>::try_from(&mut hits.instance[at..at + EIGHT]),
            <&mut [u32; EIGHT]>::try_from(&mut hits.face[at..at + EIGHT]),
            <&mut [f32; EIGHT]>::try_from(&mut hits.cos_incidence[at..at + EIGHT]),
        ) else {
            return;
        };
        // Copies, so that the compiler knows that no store changes what is still to be read.
        let (old, (old_instances, old_faces), old_cosines) = (*depths, (*instances, *faces), *cosines);
        let (mut found, mut cosine, mut tie) = ([0.0_f32; EIGHT], [0.0_f32; EIGHT], false);
        for i in 0..EIGHT {
            found[i] = if inside[i] { (volume[i] / facing[i]) as f32 } else { f32::INFINITY };
            cosine[i] = (facing[i] * scale) as f32;
            tie |= inside[i] & (found[i] == old[i]);
        }
        *depths = array_of(|i| if found[i] < old[i] { found[i] } else { old[i] });
        *instances = array_of(|i| if found[i] < old[i] { instance } else { old_instances[i] });
        *faces = array_of(|i| if found[i] < old[i] { face } else { old_faces[i] });
        *cosines = array_of(|i| if found[i] < old[i] { cosine[i] } else { old_cosines[i] });
        if tie {
            for i in (0..EIGHT).filter(|i| inside[*i]) {
                hits.keep_nearer(at + i, [found[i], cosine[i]], [instance, face]);
            }
        }
    }
}
