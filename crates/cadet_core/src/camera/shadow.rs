//! Shadow maps: the scene's triangles seen from the sun, fine near the camera and coarser beyond.

use std::ops::Range;

use multiversion::multiversion;

use crate::geometry::{Cluster, LANES};
use crate::material::Material;
use crate::math::{DMat3, DVec3, Mat3, Vec3};
use crate::sense::{PosedInstance, PosedScene};

/// Texels along a side of each map.
const SIZE: usize = 1536;
/// Texels along a side of a tile: what shades no tile that the camera sees is not drawn.
const TILE: usize = 16;
const TILES: usize = SIZE / TILE;
/// (distance ahead of the camera of the middle, half the side), metres: near, far.
const CASCADES: [(f64, f64); 2] = [(15.0, 20.0), (58.0, 68.0)];

/// One orthographic map: for each texel the coordinate towards the sun of the first surface that its light meets.
#[derive(Debug, Clone)]
struct Map {
    /// Light coordinates of the texel corner (0, 0).
    min: [f32; 2],
    texel_m: f32,
    texels_per_m: f32,
    height: Vec<f32>,
    seen: SeenTiles,
}

/// The tiles of a map on which the camera sees something.
#[derive(Debug, Clone, Default)]
struct SeenTiles {
    /// Their number over all tiles before a row and a column.
    sums: Vec<u16>,
    /// The columns of texels between the first and the last of them, for each row of tiles.
    spans: Vec<[usize; 2]>,
}

impl SeenTiles {
    /// Counts the marked tiles and those around them.
    fn around(marked: &[bool]) -> Self {
        let mut sums = vec![0_u16; (TILES + 1) * (TILES + 1)];
        let mut spans = vec![[SIZE, 0]; TILES];
        for y in 0..TILES {
            let mut row = 0;
            for x in 0..TILES {
                let (from, to) = (x.saturating_sub(1), (x + 2).min(TILES));
                let near = (y.saturating_sub(1)..(y + 2).min(TILES))
                    .any(|y| marked[y * TILES + from..y * TILES + to].contains(&true));
                row += u16::from(near);
                if near {
                    spans[y] = [spans[y][0].min(x * TILE), (x + 1) * TILE];
                }
                sums[(y + 1) * (TILES + 1) + x + 1] = sums[y * (TILES + 1) + x + 1] + row;
            }
        }
        Self { sums, spans }
    }

    /// True if some tile between two texels (both included) is seen.
    #[inline]
    fn any(&self, [x0, y0]: [usize; 2], [x1, y1]: [usize; 2]) -> bool {
        let (x0, y0, x1, y1) = (x0 / TILE, y0 / TILE, x1 / TILE + 1, y1 / TILE + 1);
        let at = |x: usize, y: usize| self.sums[y * (TILES + 1) + x];
        at(x1, y1).wrapping_add(at(x0, y0)) != at(x1, y0).wrapping_add(at(x0, y1))
    }
}

/// The sun's view of a scene around a camera.
#[derive(Debug, Clone)]
pub struct Shadows {
    right: Vec3,
    up: Vec3,
    sun: Vec3,
    maps: Vec<Map>,
}

impl Shadows {
    /// Rasterises the casters. `sun_world` is the unit vector to the sun, `forward_world` the camera's axis.
    ///
    /// `seen_world`: points all over what the camera sees; only there are shadows known. Without them, everywhere.
    /// `buffers` are the maps of an earlier frame ([`Shadows::into_buffers`]), whose memory is used again.
    #[must_use]
    pub fn new(
        scene: &PosedScene,
        eye_world: DVec3,
        forward_world: DVec3,
        sun_world: Vec3,
        seen_world: Option<&[Vec3]>,
        mut buffers: Vec<Vec<f32>>,
    ) -> Self {
        let helper = if sun_world.z.abs() < 0.95 { Vec3::Z } else { Vec3::X };
        let right = helper.cross(sun_world).normalize();
        let up = sun_world.cross(right);
        let mut shadows = Self { right, up, sun: sun_world, maps: Vec::new() };
        let flat = DVec3::new(forward_world.x, forward_world.y, 0.0).normalize_or_zero();
        for (ahead, half) in CASCADES {
            let middle = shadows.to_light((eye_world + flat * ahead - DVec3::Z * 1.6).as_vec3());
            let texel_m = (2.0 * half / SIZE as f64) as f32;
            // Whole texels, so that shadow edges do not crawl when the camera moves.
            let snap = |c: f32| ((c - half as f32) / texel_m).floor() * texel_m;
            let mut height = buffers.pop().unwrap_or_default();
            height.resize(SIZE * SIZE + LANES, f32::NEG_INFINITY);
            shadows.maps.push(Map {
                min: [snap(middle.x), snap(middle.y)],
                texel_m,
                texels_per_m: 1.0 / texel_m,
                height,
                seen: SeenTiles::default(),
            });
        }
        shadows.mark_seen(seen_world);
        draw_casters(scene, &shadows.light_from_world(), &mut shadows.maps);
        shadows
    }

    fn mark_seen(&mut self, seen_world: Option<&[Vec3]>) {
        let mut marked = [vec![seen_world.is_none(); TILES * TILES], vec![seen_world.is_none(); TILES * TILES]];
        for p in seen_world.unwrap_or_default() {
            let (x, y) = (self.right.dot(*p), self.up.dot(*p));
            for (map, marked) in self.maps.iter().zip(&mut marked) {
                let (x, y) = ((x - map.min[0]) * map.texels_per_m, (y - map.min[1]) * map.texels_per_m);
                let (size, rim) = (SIZE as f32, 2.0 * MARGIN);
                if x < 0.0 || y < 0.0 || x >= size || y >= size {
                    continue;
                }
                marked[y as usize / TILE * TILES + x as usize / TILE] = true;
                if x > rim && y > rim && x < size - rim && y < size - rim {
                    break; // the coarser map is not asked there
                }
            }
        }
        for (map, marked) in self.maps.iter_mut().zip(&marked) {
            map.seen = SeenTiles::around(marked);
            for (rows, [from, to]) in map.height.chunks_mut(SIZE * TILE).zip(&map.seen.spans) {
                for row in rows.chunks_exact_mut(SIZE) {
                    row.get_mut(*from..*to).unwrap_or_default().fill(f32::NEG_INFINITY);
                }
            }
        }
    }

    /// The maps' memory.
    #[must_use]
    pub fn into_buffers(self) -> Vec<Vec<f32>> {
        self.maps.into_iter().map(|m| m.height).collect()
    }

    #[inline]
    fn to_light(&self, p: Vec3) -> Vec3 {
        Vec3::new(self.right.dot(p), self.up.dot(p), self.sun.dot(p))
    }

    /// The light's frame from the world's.
    fn light_from_world(&self) -> DMat3 {
        DMat3::from_cols(self.right.as_dvec3(), self.up.as_dvec3(), self.sun.as_dvec3()).transpose()
    }

    /// Share of the sun that reaches a point, 0..1: `normal` is the unit geometric normal towards the viewer's side,
    /// `cos_sun` its cosine to the sun.
    #[cfg(test)]
    #[must_use]
    pub fn sunlit(&self, point_world: Vec3, normal: Vec3, cos_sun: f32) -> f32 {
        for (index, map) in self.maps.iter().enumerate() {
            // Normal offset: moves grazing surfaces off their own texels, where a depth bias alone leaks.
            let offset = map.texel_m * (0.6 + 1.6 * (1.0 - cos_sun.abs())) + 0.006;
            let p = self.to_light(point_world + normal * (offset * if cos_sun < 0.0 { -1.0 } else { 1.0 }));
            let x = (p.x - map.min[0]) * map.texels_per_m;
            let y = (p.y - map.min[1]) * map.texels_per_m;
            let inside = MARGIN..SIZE as f32 - MARGIN;
            if inside.contains(&x) && inside.contains(&y) {
                return map.sunlit(x, y, p.z, spread_of(index));
            }
        }
        1.0
    }
}

/// Points whose shadows are looked up together.
pub const TOGETHER: usize = 16;

/// The questions of [`Shadows::sunlit_together`]: as the arguments of [`Shadows::sunlit`], axis by axis.
#[derive(Debug, Default)]
pub struct Asked {
    /// Points.
    pub points_world: [[f32; TOGETHER]; 3],
    /// Unit geometric normals towards the viewer's side.
    pub normals: [[f32; TOGETHER]; 3],
    /// Their cosines to the sun.
    pub cos_sun: [f32; TOGETHER],
    /// The others get 0.
    pub is_asked: [bool; TOGETHER],
}

/// Where points fall on a map: texels, the height towards the sun, and the texels of the four widest taps.
struct OnMap {
    x: [f32; TOGETHER],
    y: [f32; TOGETHER],
    z: [f32; TOGETHER],
    taps: [[u32; TOGETHER]; 4],
    is_inside: [bool; TOGETHER],
}

impl Shadows {
    /// [`Shadows::sunlit`] of many points.
    #[must_use]
    pub fn sunlit_together(&self, asked: &Asked) -> [f32; TOGETHER] {
        let mut lit = [0.0; TOGETHER];
        let mut left = asked.is_asked;
        for (index, map) in self.maps.iter().enumerate() {
            if !left.contains(&true) {
                break;
            }
            let spread = spread_of(index);
            let on_map = place(&[self.right, self.up, self.sun], map.min, map.texel_m, map.texels_per_m, spread, asked);
            for i in 0..TOGETHER {
                if left[i] && on_map.is_inside[i] {
                    left[i] = false;
                    let z = on_map.z[i] + map.texel_m * 0.8;
                    let first: u32 = on_map.taps.iter().map(|t| u32::from(map.height[t[i] as usize] <= z)).sum();
                    lit[i] = match first {
                        0 => 0.0,
                        4 => 1.0,
                        _ => map.sunlit(on_map.x[i], on_map.y[i], on_map.z[i], spread),
                    };
                }
            }
        }
        for (lit, left) in lit.iter_mut().zip(left) {
            if left {
                *lit = 1.0;
            }
        }
        lit
    }
}

/// How wide the taps of a map are set.
#[inline]
fn spread_of(index: usize) -> f32 {
    if index == 0 { 1.0 } else { 0.9 }
}

#[multiversion(targets("x86_64+avx2"))]
fn place(light_axes: &[Vec3; 3], min: [f32; 2], texel_m: f32, texels_per_m: f32, spread: f32, asked: &Asked) -> OnMap {
    let mut out = OnMap {
        x: [0.0; TOGETHER],
        y: [0.0; TOGETHER],
        z: [0.0; TOGETHER],
        taps: [[0; TOGETHER]; 4],
        is_inside: [false; TOGETHER],
    };
    let axis = |lanes: &[[f32; TOGETHER]; 3], i: usize| Vec3::new(lanes[0][i], lanes[1][i], lanes[2][i]);
    for i in 0..TOGETHER {
        let cos_sun = asked.cos_sun[i];
        let offset = texel_m * (0.6 + 1.6 * (1.0 - cos_sun.abs())) + 0.006;
        let side = if cos_sun < 0.0 { -1.0 } else { 1.0 };
        let p = axis(&asked.points_world, i) + axis(&asked.normals, i) * (offset * side);
        out.x[i] = (light_axes[0].dot(p) - min[0]) * texels_per_m;
        out.y[i] = (light_axes[1].dot(p) - min[1]) * texels_per_m;
        out.z[i] = light_axes[2].dot(p);
    }
    for i in 0..TOGETHER {
        let (low, high) = (MARGIN, SIZE as f32 - MARGIN);
        let (x, y) = (out.x[i], out.y[i]);
        out.is_inside[i] = x >= low && x < high && y >= low && y < high;
    }
    for (taps, (dx, dy)) in out.taps.iter_mut().zip(TAPS) {
        for i in 0..TOGETHER {
            // Texels are numbered from the corner; outside of the map nobody asks.
            let texel = |v: f32, d: f32| (v.clamp(MARGIN, SIZE as f32 - MARGIN) + d * spread) as i32 as u32;
            taps[i] = texel(out.y[i], dy) * SIZE as u32 + texel(out.x[i], dx);
        }
    }
    out
}

/// Draws all that may shade what the camera sees.
#[multiversion(targets("x86_64+avx2"))]
fn draw_casters(scene: &PosedScene, light_from_world: &DMat3, maps: &mut [Map]) {
    let mut points = [[0.0; MAX_POINTS]; 3];
    for instance in &scene.instances {
        let center = (*light_from_world * instance.center_world).as_vec3();
        if !maps.iter().any(|m| m.is_asked_in(center, instance.radius_m as f32)) {
            continue;
        }
        let kinds: Vec<Caster> = instance.palette.0.iter().map(Caster::of).collect();
        let slots_of = |kind: Caster| {
            let of_kind = kinds.iter().take(63).enumerate().filter(|(_, k)| **k == kind);
            of_kind.fold(0, |bits, (slot, _)| bits | 1_u64 << slot)
        };
        let (never, always) = (slots_of(Caster::Never), slots_of(Caster::Always));
        let light_from_local = *light_from_world * instance.placement.rotation;
        let origin = (*light_from_world * instance.placement.translation).as_vec3();
        let light_from_local = light_from_local.as_mat3();
        for cluster in instance.mesh.clusters.iter().filter(|c| c.slots & !never != 0) {
            let all_cast = cluster.slots & !always == 0;
            let center = light_from_local * cluster.center + origin;
            // Far from the world's origin, single precision errs by millimetres.
            let radius = cluster.radius_m + 0.01;
            for map in maps.iter_mut().filter(|m| m.is_asked_in(center, radius)) {
                map.project(cluster, &light_from_local, origin, &mut points);
                if all_cast {
                    for corners in &cluster.corners {
                        map.triangle(corners.map(|i| point(&points, i)));
                    }
                } else {
                    map.draw_some(instance, cluster, &kinds, &points, light_from_world.z_axis.as_vec3());
                }
            }
        }
    }
}

/// A cluster's corners are bytes.
const MAX_POINTS: usize = 256;
type Points = [[f32; MAX_POINTS]; 3];

#[inline(always)]
fn point(points: &Points, i: u8) -> Vec3 {
    let i = usize::from(i);
    Vec3::new(points[0][i], points[1][i], points[2][i])
}

/// Texels along a map's rim that are not asked: the next map knows them.
const MARGIN: f32 = 8.0;

/// How the faces of a material cast shadows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Caster {
    Always,
    /// Level ground fills the maps and shades nothing; kerbs and banks do.
    UnlessLevel,
    Never,
}

impl Caster {
    fn of(material: &Material) -> Self {
        match () {
            () if material.is_glass() => Self::Never,
            () if material.semantic.is_ground() => Self::UnlessLevel,
            () => Self::Always,
        }
    }
}

/// Offsets in texels of the taps, the four widest first.
const TAPS: [(f32, f32); 12] = [
    (-1.5, -0.5),
    (0.5, -1.5),
    (1.5, 0.5),
    (-0.5, 1.5),
    (-0.4, -0.6),
    (0.6, -0.4),
    (0.4, 0.6),
    (-0.6, 0.4),
    (-1.1, 0.9),
    (0.9, 1.1),
    (1.1, -0.9),
    (-0.9, -1.1),
];

impl Map {
    /// True if a sphere in light coordinates may shade something that the camera sees.
    #[inline]
    fn is_asked_in(&self, center: Vec3, radius: f32) -> bool {
        let (x, y) = ((center.x - self.min[0]) * self.texels_per_m, (center.y - self.min[1]) * self.texels_per_m);
        let (r, size) = (radius * self.texels_per_m, SIZE as f32);
        if x + r < 0.0 || y + r < 0.0 || x - r >= size || y - r >= size {
            return false;
        }
        let texel = |v: f32| (v.max(0.0) as usize).min(SIZE - 1);
        self.seen.any([texel(x - r), texel(y - r)], [texel(x + r), texel(y + r)])
    }

    /// Puts a cluster's vertices into `out`: x and y in texels, z in metres.
    #[inline(always)]
    fn project(&self, cluster: &Cluster, light_from_local: &Mat3, origin: Vec3, out: &mut Points) {
        let (m, scale) = (light_from_local, self.texels_per_m);
        let (x0, y0) = (origin.x - self.min[0], origin.y - self.min[1]);
        let [out_x, out_y, out_z] = out;
        let out = out_x.chunks_exact_mut(LANES).zip(out_y.chunks_exact_mut(LANES)).zip(out_z.chunks_exact_mut(LANES));
        for (local, ((out_x, out_y), out_z)) in cluster.lanes.iter().zip(out) {
            for i in 0..LANES {
                let [x, y, z] = [local[0][i], local[1][i], local[2][i]];
                out_x[i] = (m.x_axis.x * x + m.y_axis.x * y + m.z_axis.x * z + x0) * scale;
                out_y[i] = (m.x_axis.y * x + m.y_axis.y * y + m.z_axis.y * z + y0) * scale;
                out_z[i] = m.x_axis.z * x + m.y_axis.z * y + m.z_axis.z * z + origin.z;
            }
        }
    }

    /// Draws the faces of a cluster that cast shadows.
    #[inline(always)]
    fn draw_some(&mut self, instance: &PosedInstance, cluster: &Cluster, kinds: &[Caster], points: &Points, up: Vec3) {
        for (corners, face) in cluster.corners.iter().zip(&cluster.faces) {
            let corners = corners.map(|i| point(points, i));
            let kind = kinds[usize::from(instance.mesh.slots[*face as usize])];
            let is_level = || {
                let [a, b, c] = corners.map(|p| Vec3::new(p.x * self.texel_m, p.y * self.texel_m, p.z));
                let normal = (b - a).cross(c - a);
                let rise = normal.dot(up);
                rise * rise > 0.9 * normal.length_squared()
            };
            if kind == Caster::Always || kind == Caster::UnlessLevel && !is_level() {
                self.triangle(corners);
            }
        }
    }

    #[inline]
    fn lit_at(&self, x: f32, y: f32, z: f32) -> f32 {
        let blocker = self.height[y as usize * SIZE + x as usize];
        f32::from(u8::from(blocker <= z))
    }

    #[inline]
    fn sunlit(&self, x: f32, y: f32, z: f32, spread: f32) -> f32 {
        let z = z + self.texel_m * 0.8;
        let tap = |(dx, dy): (f32, f32), wide: f32| self.lit_at(x + dx * wide, y + dy * wide, z);
        let first = tap(TAPS[0], spread) + tap(TAPS[1], spread) + tap(TAPS[2], spread) + tap(TAPS[3], spread);
        if first == 0.0 || first == 4.0 {
            return first * 0.25;
        }
        let rest: f32 = TAPS[4..].iter().map(|t| tap(*t, spread)).sum();
        (first + rest) * (1.0 / 12.0)
    }

    /// Raises the texels whose middles lie within a triangle; x and y in texels.
    #[inline(always)]
    fn triangle(&mut self, [a, b, c]: [Vec3; 3]) {
        let (min_x, max_x) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
        let (min_y, max_y) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let size = SIZE as f32;
        if max_x < 0.5 || max_y < 0.5 || min_x >= size - 0.5 || min_y >= size - 0.5 {
            return;
        }
        // Texel centres lie at +0.5: the first is the one at or after the bound.
        let x0 = (min_x + 0.5).max(0.0) as usize;
        let y0 = (min_y + 0.5).max(0.0) as usize;
        let x1 = ((max_x + 0.5).min(size)) as usize;
        let y1 = ((max_y + 0.5).min(size)) as usize;
        if x0 >= x1 || y0 >= y1 || !self.seen.any([x0, y0], [x1 - 1, y1 - 1]) {
            return;
        }
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area.abs() < 1e-9 {
            return;
        }
        let (b, c, area) = if area < 0.0 { (c, b, -area) } else { (b, c, area) };
        let inverse = 1.0 / area;
        // Weights of b and c and the height are linear in x and y.
        let (bx, by) = ((c.y - a.y) * inverse, -(c.x - a.x) * inverse);
        let (cx, cy) = (-(b.y - a.y) * inverse, (b.x - a.x) * inverse);
        let (zb, zc) = (b.z - a.z, c.z - a.z);
        let (zx, zy) = (zb * bx + zc * cx, zb * by + zc * cy);
        if x1 - x0 <= 2 * LANES {
            // Small ones, which are most: testing eight texels at a time costs less than finding out where a row begins.
            let highest = a.z.max(b.z).max(c.z);
            for first in (x0..x1).step_by(LANES) {
                let first = first.min(SIZE - LANES);
                for y in y0..y1 {
                    let dy = y as f32 + 0.5 - a.y;
                    let (row_b, row_c, row_z) = (by * dy, cy * dy, zy * dy + a.z);
                    for (i, texel) in self.height[y * SIZE + first..][..LANES].iter_mut().enumerate() {
                        let dx = first as f32 + 0.5 - a.x + i as f32;
                        let (wb, wc) = (bx * dx + row_b, cx * dx + row_c);
                        let z = (zx * dx + row_z).min(highest);
                        let is_inside = (wb >= 0.0) & (wc >= 0.0) & (wb + wc <= 1.0) & (z > *texel);
                        *texel = if is_inside { z } else { *texel };
                    }
                }
            }
            return;
        }
        // Rows are cut by the edges; nothing is tested within a span.
        let edges = [(bx, by, 0.0), (cx, cy, 0.0), (-bx - cx, -by - cy, 1.0)];
        let inverse = edges.map(|(slope, ..)| -1.0 / slope);
        for y in y0..y1 {
            let dy = y as f32 + 0.5 - a.y;
            let [seen_from, seen_to] = self.seen.spans[y / TILE];
            let (x0, x1) = (x0.max(seen_from), x1.min(seen_to));
            let (mut lo, mut hi) = (x0 as f32 - a.x, x1 as f32 - 0.5 - a.x);
            for ((slope, down, offset), inverse) in edges.into_iter().zip(inverse) {
                // slope * dx + at >= 0
                let at = offset + down * dy;
                let cut = at * inverse;
                if slope > 0.0 {
                    lo = if cut > lo { cut } else { lo };
                } else if slope < 0.0 {
                    hi = if cut < hi { cut } else { hi };
                } else if at < 0.0 {
                    hi = f32::NEG_INFINITY;
                }
            }
            if lo > hi {
                continue;
            }
            let from = (lo + a.x + 0.5).max(x0 as f32) as usize;
            let to = ((hi + a.x + 0.5).max(0.0) as usize).min(x1);
            let first = a.z + zy * dy + zx * (from as f32 + 0.5 - a.x);
            raise_span(&mut self.height[y * SIZE..], from..to, first, zx);
        }
    }
}

/// Raises the texels of a part of a row to a plane's height, which is `first` in the first of them and rises by `step`
/// from texel to texel. `row` must go on beyond the span by eight texels, which stay as they are.
#[inline(always)]
fn raise_span(row: &mut [f32], span: Range<usize>, first: f32, step: f32) {
    for start in span.clone().step_by(LANES) {
        let (before, left) = ((start - span.start) as i32 as f32, (span.end - start) as i32 as f32);
        let texels = &mut row[start..start + LANES];
        for (i, texel) in texels.iter_mut().enumerate() {
            let i = i as i32 as f32;
            let z = first + step * (before + i);
            let is_higher = (z > *texel) & (i < left);
            *texel = if is_higher { z } else { *texel };
        }
    }
}
