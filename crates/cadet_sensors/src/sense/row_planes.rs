//! A triangle as the beams of one row of a spinning LIDAR meet it.

use super::edges::EdgePlanes;
use super::hits::Hits;
use super::row_lookup::SortedRow;

/// Beams that are tested together.
pub(super) const EIGHT: usize = 8;

/// A triangle as one row sees it from one of its sides: in the beam's azimuth, its edges, its normal and the volume that
/// it spans with the laser are `a cos + b sin + c`.
pub(super) struct RowPlanes {
    pub(super) edges: [[f64; 3]; 3],
    normal: [f64; 3],
    /// By the secant of the row's elevation; positive where the laser is on this side.
    volume: [f64; 3],
}

impl RowPlanes {
    /// The side that the row's laser is on; both for a laser beside the axis that may go around the triangle's plane.
    #[inline(always)]
    pub(super) fn sides(triangle: &EdgePlanes, row: &SortedRow) -> [Option<Self>; 2] {
        let (n, left) = (triangle.normal, row.left_m);
        let volume = [-left * n.y, left * n.x, triangle.volume6_m3 - row.height_m * n.z];
        let changes = volume[0].abs() + volume[1].abs();
        if volume[2].abs() > changes {
            let sign = if volume[2] > 0.0 { 1.0 } else { -1.0 };
            [Some(Self::seen_from(triangle, row, volume, sign)), None]
        } else if changes > 0.0 {
            [1.0, -1.0].map(|sign| Some(Self::seen_from(triangle, row, volume, sign)))
        } else {
            [None, None]
        }
    }

    /// The beam's direction times (A - origin) x (B - origin) for each edge AB, where the origin turns with the beam.
    #[inline(always)]
    fn seen_from(triangle: &EdgePlanes, row: &SortedRow, volume: [f64; 3], sign: f64) -> Self {
        let SortedRow { tangent, secant, height_m: h, left_m: left } = *row;
        let aside = tangent * left;
        let edge = |i: usize| {
            let (n, d) = (triangle.cross[i], triangle.delta[i]);
            let along_x = n.x + h * d.y + aside * d.x;
            let along_y = n.y - h * d.x + aside * d.y;
            [sign * along_x, sign * along_y, sign * (n.z * tangent - left * d.z)]
        };
        let n = triangle.normal;
        Self {
            edges: [edge(0), edge(1), edge(2)],
            normal: [sign * n.x, sign * n.y, sign * n.z * tangent],
            volume: volume.map(|v| sign * v * secant),
        }
    }

    #[inline(always)]
    pub(super) fn edges_at(&self, cos: f64, sin: f64) -> [f64; 3] {
        self.edges.map(|p| p[0] * cos + p[1] * sin + p[2])
    }

    /// The range of the beam with this heading, if it meets the triangle from this side.
    #[inline(always)]
    pub(super) fn depth(&self, [cos, sin]: [f64; 2]) -> Option<f64> {
        let is_inside = self.edges_at(cos, sin).iter().all(|e| *e >= 0.0);
        let [facing, volume] = [&self.normal, &self.volume].map(|p| p[0] * cos + p[1] * sin + p[2]);
        (is_inside && facing > 0.0 && volume > 0.0).then(|| volume / facing)
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
        let ([p, q, r], n) = (&self.edges, &self.normal);
        let (mut inside, mut facing) = ([false; EIGHT], [0.0; EIGHT]);
        let mut any = false;
        for i in 0..EIGHT {
            let on = |p: &[f64; 3]| p[0] * cos[i] + p[1] * sin[i] + p[2];
            facing[i] = on(n);
            inside[i] = (on(p) >= 0.0) & (on(q) >= 0.0) & (on(r) >= 0.0) & (facing[i] > 0.0);
            any |= inside[i];
        }
        if !any {
            return;
        }
        let volume: [f64; EIGHT] =
            std::array::from_fn(|i| self.volume[0] * cos[i] + self.volume[1] * sin[i] + self.volume[2]);
        for i in 0..EIGHT {
            inside[i] &= volume[i] > 0.0;
        }
        let (Ok(depths), Ok(instances), Ok(faces)) = (
            <&mut [f32; EIGHT]>::try_from(&mut hits.depth_m[at..at + EIGHT]),
            <&mut [u32; EIGHT]>::try_from(&mut hits.instance[at..at + EIGHT]),
            <&mut [u32; EIGHT]>::try_from(&mut hits.face[at..at + EIGHT]),
        ) else {
            return;
        };
        // Copies, so that the compiler knows that no store changes what is still to be read.
        let (old, (old_instances, old_faces)) = (*depths, (*instances, *faces));
        let (mut found, mut tie) = ([0.0_f32; EIGHT], false);
        for i in 0..EIGHT {
            found[i] = if inside[i] { (volume[i] / facing[i]) as f32 } else { f32::INFINITY };
            tie |= inside[i] & (found[i] == old[i]);
        }
        *depths = std::array::from_fn(|i| if found[i] < old[i] { found[i] } else { old[i] });
        *instances = std::array::from_fn(|i| if found[i] < old[i] { instance } else { old_instances[i] });
        *faces = std::array::from_fn(|i| if found[i] < old[i] { face } else { old_faces[i] });
        if tie {
            for i in (0..EIGHT).filter(|i| inside[*i]) {
                hits.keep_nearer(at + i, found[i], instance, face);
            }
        }
    }
}
