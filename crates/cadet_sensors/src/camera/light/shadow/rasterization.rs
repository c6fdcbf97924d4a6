//! Draws the scene's faces onto the shadow maps: eight are set up at a time, and raise the texels they cover.

use std::ops::Range;

use macro_rules_attribute::apply;

use super::face_setup::{Corners, FaceSetup, Plane, rounded};
use super::map::{EMPTY, HIGHEST_STEPS, Map, SIZE, STRIDE, TILE, steps};
use crate::sense::PosedScene;
use crate::wide_registers::array_of;
use cadet_base::geometry::{CLUSTER_FACES, CLUSTER_VERTICES, Cluster, ClusterPiece, LANES};
use cadet_base::material::Material;
use cadet_base::math::{DMat3, Mat3, Vec3, greater, lesser};

/// Draws all that may shade what the camera sees.
#[apply(for_wide_registers)]
pub(super) fn rasterize_casters(scene: &PosedScene, light_from_world: &DMat3, maps: &mut [Map]) {
    let mut points = [[[0.0; LANES]; CLUSTER_VERTICES / LANES]; 3];
    for instance in &scene.instances {
        let center = (*light_from_world * instance.center_world).as_vec3();
        if !maps.iter().any(|m| m.may_shade_receivers(center, instance.radius_m as f32)) {
            continue;
        }
        let castings: Vec<ShadowCasting> = instance.palette.materials().iter().map(ShadowCasting::of).collect();
        let slots_of = |casting: ShadowCasting| {
            let of_casting = castings.iter().take(LAST_SLOT).enumerate().filter(|(_, k)| **k == casting);
            of_casting.fold(0, |bits, (slot, _)| bits | 1_u64 << slot)
        };
        let (never, always) = (slots_of(ShadowCasting::Never), slots_of(ShadowCasting::Always));
        let leaves = instance.palette.leaf_slots() & !(1 << LAST_SLOT);
        let light_from_local = *light_from_world * instance.placement.rotation;
        let origin = (*light_from_world * instance.placement.translation).as_vec3();
        let light_from_local = light_from_local.as_mat3();
        let clusters = &instance.shadow_proxy.clusters;
        let summaries = clusters.summaries().iter().enumerate();
        for (number, summary) in summaries.filter(|(_, c)| c.slots & !never != 0) {
            let all_cast = summary.slots & !always == 0;
            let all_leaves = summary.slots & !leaves == 0;
            // Of solids, the sides that face the sun cast the same shadow as all of them.
            let is_solid = summary.closed_slots & !always == 0;
            let one_sided = if is_solid { summary.closed_pieces } else { 0 };
            let center = light_from_local * summary.center + origin;
            let radius = summary.radius_m + ROUNDING_M;
            for map in maps.iter_mut().filter(|m| m.may_shade_receivers(center, radius)) {
                let cluster = clusters.get(number);
                map.project(&cluster, &light_from_local, origin, &mut points);
                if all_leaves && map.leaf_step > 1 {
                    map.draw_some(&points, cluster.pieces);
                } else if all_cast {
                    map.draw(&points, cluster.pieces, one_sided, 1.0);
                } else {
                    let up = light_from_world.z_axis.as_vec3();
                    let pieces: Vec<ClusterPiece> = map.casters_of(&cluster, &castings, &points, up).collect();
                    map.draw(&points, &pieces, 0, 1.0);
                }
            }
        }
    }
}

/// Bit 63 of a cluster's slots may stand for several.
const LAST_SLOT: usize = 63;
/// Far from the world's origin, single precision errs by millimeters.
const ROUNDING_M: f32 = 0.01;
/// Ground whose normal's square has more than this upwards is level.
pub(super) const LEVEL: f32 = 0.9;

/// The vertices of a cluster, axis by axis, by eights.
type Points = [[[f32; LANES]; CLUSTER_VERTICES / LANES]; 3];

#[inline(always)]
fn point(points: &Points, i: u8) -> Vec3 {
    let i = usize::from(i);
    Vec3::from_array(array_of(|axis| points[axis].as_flattened()[i]))
}

/// How the faces of a material cast shadows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ShadowCasting {
    Always,
    /// Level ground fills the maps and shades nothing; kerbs and banks do.
    UnlessLevel,
    Never,
}

impl ShadowCasting {
    fn of(material: &Material) -> Self {
        match () {
            () if material.is_transparent() => Self::Never,
            () if material.semantic.is_ground() => Self::UnlessLevel,
            () => Self::Always,
        }
    }
}

impl Map {
    /// True if a sphere in light coordinates may shade something that the camera sees.
    #[inline]
    fn may_shade_receivers(&self, center: Vec3, radius: f32) -> bool {
        let (x, y) = ((center.x - self.min_m[0]) * self.texels_per_m, (center.y - self.min_m[1]) * self.texels_per_m);
        let (r, size) = (radius * self.texels_per_m, SIZE as f32);
        if x + r < 0.0 || y + r < 0.0 || x - r >= size || y - r >= size {
            return false;
        }
        let texel = |v: f32| (v.max(0.0) as usize).min(SIZE - 1);
        let highest = (center.z + radius - self.middle_z) * self.steps_per_m;
        self.receivers.any([texel(x - r), texel(y - r)], [texel(x + r), texel(y + r)], highest)
    }

    /// Puts a cluster's vertices into `out`: x and y in texels, z in steps.
    #[inline(always)]
    fn project(&self, cluster: &Cluster<'_>, light_from_local: &Mat3, origin: Vec3, out: &mut Points) {
        let (m, scale) = (light_from_local, self.texels_per_m);
        let (x0, y0, z0) = (origin.x - self.min_m[0], origin.y - self.min_m[1], origin.z - self.middle_z);
        for (k, local) in cluster.lanes.iter().enumerate().take(CLUSTER_VERTICES / LANES) {
            let mut posed = [[0.0; LANES]; 3];
            let [x, y, z] = local;
            for i in 0..LANES {
                let turned = *m * Vec3::new(x[i], y[i], z[i]);
                posed[0][i] = (turned.x + x0) * scale;
                posed[1][i] = (turned.y + y0) * scale;
                posed[2][i] = (turned.z + z0) * self.steps_per_m;
            }
            [out[0][k], out[1][k], out[2][k]] = posed;
        }
    }

    /// The pieces of a cluster that cast shadows.
    fn casters_of<'a>(
        &'a self,
        cluster: &'a Cluster<'a>,
        castings: &'a [ShadowCasting],
        points: &'a Points,
        up: Vec3,
    ) -> impl Iterator<Item = ClusterPiece> + 'a {
        let is_level = move |[a, b, c, _]: [u8; 4]| {
            let corner = |i: u8| {
                let p = point(points, i);
                Vec3::new(p.x * self.texel_m, p.y * self.texel_m, p.z / self.steps_per_m)
            };
            let (a, b, c) = (corner(a), corner(b), corner(c));
            let normal = (b - a).cross(c - a);
            let rise = normal.dot(up);
            rise * rise > LEVEL * normal.length_squared()
        };
        let casts = move |piece: &ClusterPiece| {
            let face = &cluster.faces[usize::from(piece.first)];
            match castings[usize::from(face.slot)] {
                ShadowCasting::Always => true,
                ShadowCasting::UnlessLevel => !is_level(piece.corners),
                ShadowCasting::Never => false,
            }
        };
        cluster.pieces.iter().copied().filter(casts)
    }

    /// Draws some of a cluster's leaves, each larger about its own middle, so that all together cover as much as before
    /// (stochastic simplification: Cook, Halstead, Planck & Ryu 2007).
    #[inline(always)]
    fn draw_some(&mut self, points: &Points, pieces: &[ClusterPiece]) {
        let mut some = [ClusterPiece { corners: [0; 4], first: 0 }; CLUSTER_FACES];
        let mut count = 0;
        for (some, piece) in some.iter_mut().zip(pieces.iter().step_by(self.leaf_step)) {
            *some = *piece;
            count += 1;
        }
        self.draw(points, &some[..count], 0, (pieces.len() as f32 / count as f32).sqrt());
    }

    /// Draws faces, [`LANES`] of them set up at a time and enlarged about their middles. `one_sided`: a bit for each of the
    /// first 64 that has one side.
    #[inline(always)]
    fn draw(&mut self, points: &Points, pieces: &[ClusterPiece], one_sided: u64, scale: f32) {
        for (some, first) in pieces.chunks(LANES).zip((0_u32..).step_by(LANES)) {
            let mut corners: Corners = [[[0.0; LANES]; 3]; 4];
            for (i, piece) in some.iter().enumerate() {
                for (corner, k) in corners.iter_mut().zip(piece.corners) {
                    for (corner, axis) in corner.iter_mut().zip(points) {
                        corner[i] = axis.as_flattened()[usize::from(k)];
                    }
                }
            }
            if scale > 1.0 {
                for axis in 0..3 {
                    for i in 0..LANES {
                        let [a, b, c, d]: [f32; 4] = array_of(|corner| corners[corner][axis][i]);
                        // Of a triangle, whose last corner stands twice, nearer to that one.
                        let middle = ((a + c) + (b + d)) * 0.25;
                        for corner in &mut corners {
                            corner[axis][i] = middle + (corner[axis][i] - middle) * scale;
                        }
                    }
                }
            }
            let setup = FaceSetup::of(&corners);
            let one_sided = one_sided.checked_shr(first).unwrap_or(0);
            for i in 0..some.len() {
                if !setup.meets_texels[i] || !setup.faces_sun[i] && one_sided >> i & 1 == 1 {
                    continue;
                }
                self.face(&setup, i);
            }
        }
    }

    /// Raises the texels whose middles lie within one of eight faces.
    #[inline(always)]
    fn face(&mut self, setup: &FaceSetup, i: usize) {
        let [x0, y0, x1, y1]: [usize; 4] = array_of(|k| setup.bounds[k][i] as usize);
        if !self.receivers.any([x0, y0], [x1 - 1, y1 - 1], setup.highest_steps[i]) {
            return;
        }
        for [from, to] in &mut self.drawn[y0 / TILE..=(y1 - 1) / TILE] {
            (*from, *to) = ((*from).min(x0), (*to).max(x1));
        }
        let plane = |plane: &Plane| [plane.first[i], plane.along_x[i], plane.along_y[i]];
        let edges: [[f32; 3]; 4] = array_of(|k| plane(&setup.edges[k]));
        let [z, zx, zy] = plane(&setup.z);
        if x1 - x0 <= 2 * LANES {
            // Small ones, which are most: testing eight texels at a time costs less than finding out where a row begins.
            let (highest, rows) = (setup.highest_steps[i], y1 - y0);
            for first in (x0..x1).step_by(LANES) {
                let columns: [f32; LANES] = array_of(|k| (first - x0 + k) as i32 as f32);
                for row in 0..rows {
                    let y = row as i32 as f32;
                    let mut heights = [0; LANES];
                    for (height, x) in heights.iter_mut().zip(columns) {
                        // A triangle's third edge has no length.
                        let mut inside = f32::INFINITY;
                        for [start, by_x, by_y] in edges {
                            inside = lesser(inside, start + by_x * x + by_y * y);
                        }
                        // Rounding may not lead beyond sixteen bits.
                        let z = greater(lesser(z + zx * x + zy * y, highest), -HIGHEST_STEPS);
                        *height = if inside >= 0.0 { steps(z) } else { EMPTY.into() };
                    }
                    raise(&mut self.height[(y0 + row) * STRIDE + first..], &heights);
                }
            }
            return;
        }
        // Eight rows at a time are cut by the edges; nothing is tested within a row's span.
        let width = (x1 - x0) as i32 as f32;
        for top in (y0 / LANES * LANES..y1).step_by(LANES) {
            // Rows of no tile's border: they share what is seen.
            let [receivers_from, receivers_to] = self.receivers.spans[top / TILE];
            let (from, to) = (x0.max(receivers_from), x1.min(receivers_to));
            if from >= to {
                continue;
            }
            let above = top as i32 as f32 - y0 as i32 as f32;
            let height = (y1 - y0) as i32 as f32;
            let dy: [f32; LANES] = array_of(|k| above + k as i32 as f32);
            let (mut lo, mut hi) = ([(from - x0) as i32 as f32; LANES], [(to - x0) as i32 as f32 - 1.0; LANES]);
            for k in 0..LANES {
                hi[k] = if (dy[k] >= 0.0) & (dy[k] < height) { hi[k] } else { -1.0 };
            }
            for [first, slope, down] in edges {
                let inverse = -1.0 / slope;
                // slope * dx + first + down * dy >= 0
                if slope > 0.0 {
                    for k in 0..LANES {
                        lo[k] = greater((first + down * dy[k]) * inverse, lo[k]);
                    }
                } else if slope < 0.0 {
                    for k in 0..LANES {
                        hi[k] = lesser((first + down * dy[k]) * inverse, hi[k]);
                    }
                } else {
                    for k in 0..LANES {
                        hi[k] = if first + down * dy[k] < 0.0 { -1.0 } else { hi[k] };
                    }
                }
            }
            let (mut first, mut end) = ([0_i32; LANES], [0_i32; LANES]);
            for k in 0..LANES {
                // The first at or after `lo`, and the one after the last at or before `hi`.
                let (start, start_f) = rounded(lesser(lo[k], width));
                first[k] = start + i32::from(start_f < lo[k]);
                let (stop, stop_f) = rounded(hi[k] + 1.0);
                end[k] = stop - i32::from(stop_f > hi[k] + 1.0);
            }
            for k in 0..LANES {
                if first[k] < end[k] {
                    let from = first[k] as usize;
                    let height = z + zy * dy[k] + zx * first[k] as f32;
                    raise_span(&mut self.height[(top + k) * STRIDE..], x0 + from..x0 + end[k] as usize, height, zx);
                }
            }
        }
    }
}

/// Texels of a row that are raised together: as many as fit into a register.
const WIDE: usize = 2 * LANES;

/// Raises the texels of a part of a row to a plane's height, which is `first` in the first of them and rises by `step`
/// from texel to texel. `row` must go on beyond the span by sixteen texels, which stay as they are.
#[inline(always)]
fn raise_span(row: &mut [i16], span: Range<usize>, first: f32, step: f32) {
    let (mut first, stride) = (first, step * WIDE as f32);
    for start in span.clone().step_by(WIDE) {
        let left = (span.end - start) as i32 as f32;
        let mut heights = [0; WIDE];
        for (i, height) in heights.iter_mut().enumerate() {
            let i = i as i32 as f32;
            let z = lesser(greater(first + step * i, -HIGHEST_STEPS), HIGHEST_STEPS);
            *height = if i < left { steps(z) } else { EMPTY.into() };
        }
        raise(&mut row[start..], &heights);
        // Summed up, so that the compiler goes along rows and not across their pieces.
        first += stride;
    }
}

/// Raises the first texels of a row to heights in the lower halves of numbers.
#[inline(always)]
fn raise<const N: usize>(row: &mut [i16], heights: &[i32; N]) {
    for (texel, height) in row[..N].iter_mut().zip(heights) {
        *texel = (*texel).max(*height as i16);
    }
}
