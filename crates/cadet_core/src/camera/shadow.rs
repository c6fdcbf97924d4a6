//! Shadow maps: the scene's triangles seen from the sun, fine near the camera and coarser beyond.

use std::ops::Range;

use multiversion::multiversion;

use super::pattern::split;
use crate::geometry::{CLUSTER_FACES, Cluster, LANES};
use crate::material::{Material, Pattern};
use crate::math::{DMat3, DVec3, Mat3, Vec3};
use crate::sense::{PosedInstance, PosedScene};

/// Texels along a side of each map.
const SIZE: usize = 1536;
/// Texels along a side of a tile: what shades no tile that the camera sees is not drawn.
const TILE: usize = 16;
const TILES: usize = SIZE / TILE;
/// From a row of texels to the next: an odd number of cache lines, else neighbours would crowd in a few of its sets.
const STRIDE: usize = SIZE + 16;
/// (distance ahead of the camera of the middle, half the side), metres: near, far.
const CASCADES: [(f64, f64); 2] = [(15.0, 20.0), (58.0, 68.0)];
/// Steps of height in a metre: near, far. Sixteen bits reach 128 and 256 m to both sides of the map's middle.
const STEPS_PER_M: [f32; 2] = [256.0, 128.0];
/// Of a cluster's leaves one in so many is drawn: near, far.
const LEAF_STEPS: [usize; 2] = [1, 2];
/// The height of what nothing was drawn on.
const EMPTY: i16 = i16::MIN;

/// One orthographic map: for each texel the coordinate towards the sun of the first surface that its light meets.
#[derive(Debug, Clone)]
struct Map {
    /// Light coordinates of the texel corner (0, 0).
    min: [f32; 2],
    /// The light coordinate of height 0.
    middle_z: f32,
    texel_m: f32,
    texels_per_m: f32,
    steps_per_m: f32,
    /// Of leaves that are drawn together one in so many casts a shadow.
    leaf_step: usize,
    height: Vec<i16>,
    seen: SeenTiles,
    /// The columns between which something was drawn, for each row of tiles.
    drawn: Vec<[usize; 2]>,
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
        mut buffers: Vec<Vec<i16>>,
    ) -> Self {
        let helper = if sun_world.z.abs() < 0.95 { Vec3::Z } else { Vec3::X };
        let right = helper.cross(sun_world).normalize();
        let up = sun_world.cross(right);
        let mut shadows = Self { right, up, sun: sun_world, maps: Vec::new() };
        let flat = DVec3::new(forward_world.x, forward_world.y, 0.0).normalize_or_zero();
        for (((ahead, half), steps_per_m), leaf_step) in CASCADES.into_iter().zip(STEPS_PER_M).zip(LEAF_STEPS) {
            let middle = shadows.to_light((eye_world + flat * ahead - DVec3::Z * 1.6).as_vec3());
            let texel_m = (2.0 * half / SIZE as f64) as f32;
            // Whole texels, so that shadow edges do not crawl when the camera moves.
            let snap = |c: f32| ((c - half as f32) / texel_m).floor() * texel_m;
            let mut height = buffers.pop().unwrap_or_default();
            height.resize(SIZE * STRIDE, EMPTY);
            shadows.maps.push(Map {
                min: [snap(middle.x), snap(middle.y)],
                middle_z: middle.z,
                texel_m,
                texels_per_m: 1.0 / texel_m,
                steps_per_m,
                leaf_step,
                height,
                seen: SeenTiles::default(),
                drawn: vec![[SIZE, 0]; TILES],
            });
        }
        shadows.mark_seen(seen_world);
        draw_casters(scene, &shadows.light_from_world(), &mut shadows.maps);
        shadows
    }

    fn mark_seen(&mut self, seen_world: Option<&[Vec3]>) {
        // The last one stands for what is on no tile.
        let unmarked = vec![seen_world.is_none(); TILES * TILES + 1];
        let mut marked = [unmarked.clone(), unmarked];
        mark(&self.maps, self.right, self.up, seen_world.unwrap_or_default(), &mut marked);
        for (map, marked) in self.maps.iter_mut().zip(&marked) {
            map.seen = SeenTiles::around(marked);
        }
    }

    /// The maps' memory, empty again: what an earlier frame drew must show nowhere, not even beside what is asked.
    #[must_use]
    pub fn into_buffers(self) -> Vec<Vec<i16>> {
        let emptied = |mut map: Map| {
            for (rows, [from, to]) in map.height.chunks_mut(STRIDE * TILE).zip(&map.drawn) {
                for row in rows.chunks_exact_mut(STRIDE) {
                    row.get_mut(*from..*to + LANES).unwrap_or_default().fill(EMPTY);
                }
            }
            map.height
        };
        self.maps.into_iter().map(emptied).collect()
    }

    #[inline]
    fn to_light(&self, p: Vec3) -> Vec3 {
        Vec3::new(self.right.dot(p), self.up.dot(p), self.sun.dot(p))
    }

    /// The light's frame from the world's.
    fn light_from_world(&self) -> DMat3 {
        DMat3::from_cols(self.right.as_dvec3(), self.up.as_dvec3(), self.sun.as_dvec3()).transpose()
    }

    /// Share of the sun that reaches each of some points, 0..1, by the shares of a square of three by three texels about
    /// it that lie no higher towards the sun ("percentage closer filtering": Reeves, Salesin & Cook 1987).
    ///
    /// `eye_world`: what the points are relative to.
    pub fn sunlit<const N: usize>(&self, eye_world: Vec3, asked: &Asked<N>, lit: &mut [f32; N]) {
        let mut at = OnMaps { first: [NOWHERE; N], x: [0.0; N], y: [0.0; N], z: [0.0; N] };
        place(self, eye_world, asked, &mut at);
        look_up(&self.maps, &at, asked, lit);
    }
}

/// The questions of [`Shadows::sunlit`], axis by axis.
#[derive(Debug, Clone, Copy)]
pub struct Asked<'a, const N: usize> {
    /// Points, relative to the eye.
    pub points: &'a [[f32; N]; 3],
    /// Unit geometric normals towards the viewer's side.
    pub normals: &'a [[f32; N]; 3],
    /// Their cosines to the sun.
    pub cos_sun: &'a [f32; N],
    /// The others get 0.
    pub is_asked: &'a [bool; N],
    /// Beyond these nothing is asked.
    pub count: usize,
}

/// Texels of a map.
const MAP: usize = SIZE * STRIDE;
/// On no map.
const NOWHERE: u32 = u32::MAX;

/// Where points fall on the maps: the first texel of the four by four about it, counted through both maps, the shares of
/// its column and row that lie outside of the square, and the height towards the sun.
struct OnMaps<const N: usize> {
    first: [u32; N],
    x: [f32; N],
    y: [f32; N],
    z: [f32; N],
}

/// How far a point is moved along its normal where the sun stands square to it, texels.
const NORMAL_OFFSET: f32 = 0.8;
/// Half the side of the square, texels.
const REACH: f32 = 1.5;

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn place<const N: usize>(shadows: &Shadows, eye_world: Vec3, asked: &Asked<N>, out: &mut OnMaps<N>) {
    let count = asked.count.next_multiple_of(LANES).min(N);
    let axes = [shadows.right, shadows.up, shadows.sun];
    let eye = shadows.to_light(eye_world);
    let [px, py, pz] = asked.points;
    let [nx, ny, nz] = asked.normals;
    // The near map has the last word.
    for (index, map) in shadows.maps.iter().enumerate().rev() {
        let base = (index * MAP) as i32;
        let (min_x, min_y, to_z) = (eye.x - map.min[0], eye.y - map.min[1], eye.z - map.middle_z + map.texel_m * 0.8);
        let (texel_m, texels_per_m) = (map.texel_m, map.texels_per_m);
        for i in 0..count {
            let (point, normal) = (Vec3::new(px[i], py[i], pz[i]), Vec3::new(nx[i], ny[i], nz[i]));
            let cos_sun = asked.cos_sun[i];
            // Normal offset: moves grazing surfaces off their own texels, where a depth bias alone leaks.
            let offset = texel_m * (NORMAL_OFFSET + 2.2 * (1.0 - cos_sun.abs())) + 0.006;
            let offset = if cos_sun < 0.0 { -offset } else { offset };
            let p = point + normal * offset;
            let x = (axes[0].dot(p) + min_x) * texels_per_m;
            let y = (axes[1].dot(p) + min_y) * texels_per_m;
            let (low, high) = (MARGIN, SIZE as f32 - MARGIN);
            let z = (axes[2].dot(p) + to_z) * map.steps_per_m;
            let is_inside = (x >= low) & (x < high) & (y >= low) & (y < high) & (z.abs() < HIGHEST);
            let ((column, in_column), (row, in_row)) = (split(x - REACH), split(y - REACH));
            let texel = base.wrapping_add(row.wrapping_mul(STRIDE as i32)).wrapping_add(column);
            out.first[i] = if is_inside { texel as u32 } else { out.first[i] };
            out.x[i] = if is_inside { in_column } else { out.x[i] };
            out.y[i] = if is_inside { in_row } else { out.y[i] };
            out.z[i] = if is_inside { z } else { out.z[i] };
        }
    }
}

/// The shares of squares of three by three texels that lie no higher than the points. A square begins in a point's first
/// texel (the shares `x` and `y` of that one's column and row lie outside) and ends in the third after it.
///
/// Copies what is looked at first: the processor waits for many texels at once, and not for one point's after another's.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn look_up<const N: usize>(maps: &[Map], at: &OnMaps<N>, asked: &Asked<N>, lit: &mut [f32; N]) {
    let mut which = [0_u8; N];
    let mut count = 0;
    for i in 0..asked.count.min(N) {
        which[count] = i as u8;
        let is_known = asked.is_asked[i] & (at.first[i] != NOWHERE);
        count += usize::from(is_known);
        lit[i] = if asked.is_asked[i] { 1.0 } else { 0.0 };
    }
    // By rows: what follows goes over four neighbours of every point in turn.
    let (mut texels, mut heights) = ([[[0_i16; 4]; N]; 4], [[0_i16; 4]; N]);
    let (mut top, mut bottom, mut columns) = ([[0.0; 4]; N], [[0.0; 4]; N], [[0.0; 4]; N]);
    for (k, i) in which[..count].iter().enumerate() {
        let i = usize::from(*i);
        let first = at.first[i] as usize;
        let map = &maps[first / MAP];
        let rows = &map.height[first % MAP..][..3 * STRIDE + 4];
        for (row, texels) in texels.iter_mut().enumerate() {
            texels[k].copy_from_slice(&rows[row * STRIDE..row * STRIDE + 4]);
        }
        let (x, y) = (at.x[i], at.y[i]);
        (top[k], bottom[k], heights[k]) = ([1.0 - y; 4], [y; 4], [steps(at.z[i]) as i16; 4]);
        columns[k] = [1.0 - x, 1.0, 1.0, x];
    }
    let [row_0, row_1, row_2, row_3] = texels.each_ref().map(|row| row.as_flattened());
    let (top, bottom, heights) = (top.as_flattened(), bottom.as_flattened(), heights.as_flattened());
    let sums = columns.as_flattened_mut();
    for j in 0..(count * 4).next_multiple_of(2 * LANES).min(4 * N) {
        let z = heights[j];
        let share = |texel: i16, share: f32| if texel <= z { share } else { 0.0 };
        let ends = share(row_0[j], top[j]) + share(row_3[j], bottom[j]);
        sums[j] *= ends + (share(row_1[j], 1.0) + share(row_2[j], 1.0));
    }
    let mut shares = [0.0; N];
    for (share, [a, b, c, d]) in shares.iter_mut().zip(&columns) {
        let sum = (a + b) + (c + d);
        // Neither rounding nor the edge of a texel dims what is lit all over.
        *share = if sum > 8.95 { 1.0 } else { sum * (1.0 / 9.0) };
    }
    for (i, share) in which[..count].iter().zip(shares) {
        lit[usize::from(*i)] = share;
    }
}

/// Heights of points end here, steps.
const HIGHEST: f32 = 32_000.0;

/// The nearest step to a height that sixteen bits can hold, in the lower half of a number.
#[inline(always)]
fn steps(z: f32) -> i32 {
    const LARGE: f32 = 12_582_912.0; // 1.5 * 2^23, whose own lower half is 0
    (z + LARGE).to_bits() as i32
}

/// Marks the tiles of two maps that points fall on; the coarser one's are not asked within the rim of the finer one.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn mark(maps: &[Map], right: Vec3, up: Vec3, points_world: &[Vec3], marked: &mut [Vec<bool>; 2]) {
    for points in points_world.chunks(LANES) {
        let mut world = [[0.0; LANES]; 3];
        for (i, p) in points.iter().enumerate() {
            (world[0][i], world[1][i], world[2][i]) = (p.x, p.y, p.z);
        }
        let [x, y, z] = &world;
        let mut is_finer = [false; LANES];
        for (map, marked) in maps.iter().zip(marked.iter_mut()) {
            let mut tiles = [0; LANES];
            for i in 0..LANES {
                let (u, v) =
                    (right.x * x[i] + right.y * y[i] + right.z * z[i], up.x * x[i] + up.y * y[i] + up.z * z[i]);
                let (u, v) = ((u - map.min[0]) * map.texels_per_m, (v - map.min[1]) * map.texels_per_m);
                let within = |rim: f32| {
                    let end = SIZE as f32 - rim;
                    (u >= rim) & (v >= rim) & (u < end) & (v < end)
                };
                // At a border it may be the neighbour: those around a marked one are drawn as well.
                let tile = |texel: f32| {
                    split(least(most(texel, 0.0), SIZE as f32) * (1.0 / TILE as f32)).0.clamp(0, TILES as i32 - 1)
                };
                let (column, row) = (tile(u), tile(v));
                let is_marked = within(0.0) & !is_finer[i];
                tiles[i] = if is_marked {
                    row.wrapping_mul(TILES as i32).wrapping_add(column)
                } else {
                    (TILES * TILES) as i32
                };
                is_finer[i] |= within(2.0 * MARGIN);
            }
            for tile in &tiles[..points.len()] {
                marked[*tile as usize] = true;
            }
        }
    }
}

/// Draws all that may shade what the camera sees.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
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
        let palette = instance.palette.0.iter().take(63).enumerate();
        let leaves =
            palette.filter(|(_, m)| m.pattern == Pattern::Leaves).fold(0, |bits, (slot, _)| bits | 1_u64 << slot);
        let light_from_local = *light_from_world * instance.placement.rotation;
        let origin = (*light_from_world * instance.placement.translation).as_vec3();
        let light_from_local = light_from_local.as_mat3();
        for cluster in instance.mesh.clusters.iter().filter(|c| c.slots & !never != 0) {
            let all_cast = cluster.slots & !always == 0;
            let all_leaves = cluster.slots & !leaves == 0;
            // Of solids, the sides that face the sun cast the same shadow as all of them.
            let is_solid = cluster.closed_slots & !always == 0;
            let solid = if is_solid { cluster.closed } else { 0 };
            let center = light_from_local * cluster.center + origin;
            // Far from the world's origin, single precision errs by millimetres.
            let radius = cluster.radius_m + 0.01;
            for map in maps.iter_mut().filter(|m| m.is_asked_in(center, radius)) {
                map.project(cluster, &light_from_local, origin, &mut points);
                if all_leaves && map.leaf_step > 1 {
                    map.draw_some(&points, &cluster.corners);
                } else if all_cast {
                    map.draw(&points, &cluster.corners, solid, 1.0);
                } else {
                    let up = light_from_world.z_axis.as_vec3();
                    let corners: Vec<[u8; 3]> = map.casters_of(instance, cluster, &kinds, &points, up).collect();
                    map.draw(&points, &corners, 0, 1.0);
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

    /// Puts a cluster's vertices into `out`: x and y in texels, z in steps.
    #[inline(always)]
    fn project(&self, cluster: &Cluster, light_from_local: &Mat3, origin: Vec3, out: &mut Points) {
        let (m, scale) = (light_from_local, self.texels_per_m);
        let (x0, y0, z0) = (origin.x - self.min[0], origin.y - self.min[1], origin.z - self.middle_z);
        let [out_x, out_y, out_z] = out;
        let out = out_x.chunks_exact_mut(LANES).zip(out_y.chunks_exact_mut(LANES)).zip(out_z.chunks_exact_mut(LANES));
        for (local, ((out_x, out_y), out_z)) in cluster.lanes.iter().zip(out) {
            for i in 0..LANES {
                let [x, y, z] = [local[0][i], local[1][i], local[2][i]];
                out_x[i] = (m.x_axis.x * x + m.y_axis.x * y + m.z_axis.x * z + x0) * scale;
                out_y[i] = (m.x_axis.y * x + m.y_axis.y * y + m.z_axis.y * z + y0) * scale;
                out_z[i] = (m.x_axis.z * x + m.y_axis.z * y + m.z_axis.z * z + z0) * self.steps_per_m;
            }
        }
    }

    /// The corners of those faces of a cluster that cast shadows.
    fn casters_of<'a>(
        &'a self,
        instance: &'a PosedInstance,
        cluster: &'a Cluster,
        kinds: &'a [Caster],
        points: &'a Points,
        up: Vec3,
    ) -> impl Iterator<Item = [u8; 3]> + 'a {
        let is_level = move |corners: [u8; 3]| {
            let [a, b, c] = corners.map(|i| {
                let p = point(points, i);
                Vec3::new(p.x * self.texel_m, p.y * self.texel_m, p.z / self.steps_per_m)
            });
            let normal = (b - a).cross(c - a);
            let rise = normal.dot(up);
            rise * rise > 0.9 * normal.length_squared()
        };
        let casts = move |corners: [u8; 3], face: u32| match kinds[usize::from(instance.mesh.slots[face as usize])] {
            Caster::Always => true,
            Caster::UnlessLevel => !is_level(corners),
            Caster::Never => false,
        };
        let faces = cluster.corners.iter().zip(&cluster.faces);
        faces.filter(move |(corners, face)| casts(**corners, **face)).map(|(corners, _)| *corners)
    }

    /// Draws some of a cluster's leaves, each larger about its own middle, so that all together cover as much as before
    /// (stochastic simplification: Cook, Halstead, Planck & Ryu 2007).
    #[inline(always)]
    fn draw_some(&mut self, points: &Points, corners: &[[u8; 3]]) {
        let mut some = [[0; 3]; CLUSTER_FACES];
        let mut count = 0;
        for (some, corners) in some.iter_mut().zip(corners.iter().step_by(self.leaf_step)) {
            *some = *corners;
            count += 1;
        }
        self.draw(points, &some[..count], 0, (corners.len() as f32 / count as f32).sqrt());
    }

    /// Draws triangles, [`LANES`] of them set up at a time and enlarged about their middles. `solid`: a bit for each of the
    /// first 64 that has one side.
    #[inline(always)]
    fn draw(&mut self, points: &Points, corners: &[[u8; 3]], solid: u64, scale: f32) {
        for (some, first) in corners.chunks(LANES).zip((0_u32..).step_by(LANES)) {
            let mut lanes: Triangles = [[[0.0; LANES]; 3]; 3];
            for (i, corners) in some.iter().enumerate() {
                for (lanes, k) in lanes.iter_mut().zip(corners) {
                    for (lanes, axis) in lanes.iter_mut().zip(points) {
                        lanes[i] = axis[usize::from(*k)];
                    }
                }
            }
            if scale > 1.0 {
                for axis in 0..3 {
                    for i in 0..LANES {
                        let middle = (lanes[0][axis][i] + lanes[1][axis][i] + lanes[2][axis][i]) * (1.0 / 3.0);
                        for corner in &mut lanes {
                            corner[axis][i] = middle + (corner[axis][i] - middle) * scale;
                        }
                    }
                }
            }
            let setup = Setup::of(&lanes);
            let solid = solid.checked_shr(first).unwrap_or(0);
            let mut drawn = [0; LANES];
            let mut count = 0;
            for i in 0..LANES {
                drawn[count] = i;
                count += usize::from(setup.meets_texels[i] & (setup.faces_sun[i] | (solid >> i & 1 == 0)));
            }
            for i in &drawn[..count] {
                self.triangle(&setup, *i % LANES);
            }
        }
    }

    /// Raises the texels whose middles lie within one of eight triangles.
    #[inline(always)]
    fn triangle(&mut self, setup: &Setup, i: usize) {
        let [x0, y0, x1, y1] = setup.bounds.each_ref().map(|lanes| lanes[i] as usize);
        if !self.seen.any([x0, y0], [x1 - 1, y1 - 1]) {
            return;
        }
        for [from, to] in &mut self.drawn[y0 / TILE..=(y1 - 1) / TILE] {
            (*from, *to) = ((*from).min(x0), (*to).max(x1));
        }
        let plane = |plane: &Plane| [plane.first[i], plane.along_x[i], plane.along_y[i]];
        let ([b, bx, by], [c, cx, cy], [z, zx, zy]) = (plane(&setup.b), plane(&setup.c), plane(&setup.z));
        if x1 - x0 <= 2 * LANES {
            // Small ones, which are most: testing eight texels at a time costs less than finding out where a row begins.
            let highest = setup.highest[i];
            for first in (x0..x1).step_by(LANES) {
                let (mut wa, mut wb, mut wc, mut height) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
                for k in 0..LANES {
                    let dx = (first - x0) as i32 as f32 + k as i32 as f32;
                    (wb[k], wc[k], height[k]) = (b + bx * dx, c + cx * dx, z + zx * dx);
                    wa[k] = 1.0 - wb[k] - wc[k];
                }
                for (dy, row) in self.height[y0 * STRIDE + first..].chunks_mut(STRIDE).take(y1 - y0).enumerate() {
                    let dy = dy as i32 as f32;
                    let (row_b, row_c, row_z) = (by * dy, cy * dy, zy * dy);
                    let row_a = row_b + row_c;
                    let mut heights = [0; LANES];
                    for k in 0..LANES {
                        let inside = least(least(wb[k] + row_b, wc[k] + row_c), wa[k] - row_a);
                        // Rounding may not lead beyond sixteen bits.
                        let z = most(least(height[k] + row_z, highest), -HIGHEST);
                        heights[k] = if inside >= 0.0 { steps(z) } else { EMPTY.into() };
                    }
                    raise(row, &heights);
                }
            }
            return;
        }
        // Eight rows at a time are cut by the edges; nothing is tested within a row's span.
        let edges =
            [(bx, by, b), (cx, cy, c), (-bx - cx, -by - cy, 1.0 - b - c)].map(|(x, y, first)| (x, y, first, -1.0 / x));
        let width = (x1 - x0) as i32 as f32;
        for top in (y0 / LANES * LANES..y1).step_by(LANES) {
            // Rows of no tile's border: they share what is seen.
            let [seen_from, seen_to] = self.seen.spans[top / TILE];
            let (from, to) = (x0.max(seen_from), x1.min(seen_to));
            if from >= to {
                continue;
            }
            let above = top as i32 as f32 - y0 as i32 as f32;
            let height = (y1 - y0) as i32 as f32;
            let dy: [f32; LANES] = std::array::from_fn(|k| above + k as i32 as f32);
            let (mut lo, mut hi) = ([(from - x0) as i32 as f32; LANES], [(to - x0) as i32 as f32 - 1.0; LANES]);
            for k in 0..LANES {
                hi[k] = if (dy[k] >= 0.0) & (dy[k] < height) { hi[k] } else { -1.0 };
            }
            for (slope, down, first, inverse) in edges {
                // slope * dx + first + down * dy >= 0
                if slope > 0.0 {
                    for k in 0..LANES {
                        lo[k] = most((first + down * dy[k]) * inverse, lo[k]);
                    }
                } else if slope < 0.0 {
                    for k in 0..LANES {
                        hi[k] = least((first + down * dy[k]) * inverse, hi[k]);
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
                let (start, start_f) = rounded(least(lo[k], width));
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

/// The corners of [`LANES`] triangles: x and y in texels, z in steps.
type Triangles = [[[f32; LANES]; 3]; 3];

/// What is linear over each of [`LANES`] triangles: its value in the middle of the first texel of the triangle's bounds,
/// and how it changes from texel to texel.
#[derive(Default)]
struct Plane {
    first: [f32; LANES],
    along_x: [f32; LANES],
    along_y: [f32; LANES],
}

/// [`LANES`] triangles about to be drawn.
#[derive(Default)]
struct Setup {
    /// The first column and row of texels whose middles lie within their bounds, and those after the last.
    bounds: [[i32; LANES]; 4],
    /// The weights of their second and third corners.
    b: Plane,
    c: Plane,
    /// Their heights, steps.
    z: Plane,
    /// The highest corners.
    highest: [f32; LANES],
    /// False where no texel's middle is met for certain, and without an area.
    meets_texels: [bool; LANES],
    /// Counter-clockwise seen from the sun.
    faces_sun: [bool; LANES],
}

impl Setup {
    #[inline(always)]
    fn of([[ax, ay, az], [bx, by, bz], [cx, cy, cz]]: &Triangles) -> Self {
        let mut out = Self::default();
        for i in 0..LANES {
            let (min_x, max_x) = (least(least(ax[i], bx[i]), cx[i]), most(most(ax[i], bx[i]), cx[i]));
            let (min_y, max_y) = (least(least(ay[i], by[i]), cy[i]), most(most(ay[i], by[i]), cy[i]));
            // Texels' middles lie half a texel beyond their numbers: bounds are rounded to the nearest number.
            let ((x0, left), (x1, right)) = (rounded(min_x), rounded(max_x));
            let ((y0, top), (y1, bottom)) = (rounded(min_y), rounded(max_y));
            let (abx, aby, abz) = (bx[i] - ax[i], by[i] - ay[i], bz[i] - az[i]);
            let (acx, acy, acz) = (cx[i] - ax[i], cy[i] - ay[i], cz[i] - az[i]);
            let area = abx * acy - aby * acx;
            out.meets_texels[i] = (left < right) & (top < bottom) & (area.abs() > 1e-9);
            out.faces_sun[i] = area > 0.0;
            [out.bounds[0][i], out.bounds[1][i], out.bounds[2][i], out.bounds[3][i]] = [x0, y0, x1, y1];
            let inverse = 1.0 / area;
            // Weights of b and c and the height are linear in x and y.
            let (b_x, b_y) = (acy * inverse, -acx * inverse);
            let (c_x, c_y) = (-aby * inverse, abx * inverse);
            let (z_x, z_y) = (abz * b_x + acz * c_x, abz * b_y + acz * c_y);
            let (dx, dy) = (left + 0.5 - ax[i], top + 0.5 - ay[i]);
            (out.b.first[i], out.b.along_x[i], out.b.along_y[i]) = (b_x * dx + b_y * dy, b_x, b_y);
            (out.c.first[i], out.c.along_x[i], out.c.along_y[i]) = (c_x * dx + c_y * dy, c_x, c_y);
            (out.z.first[i], out.z.along_x[i], out.z.along_y[i]) = (az[i] + (z_x * dx + z_y * dy), z_x, z_y);
            out.highest[i] = least(most(most(az[i], bz[i]), cz[i]), HIGHEST);
        }
        out
    }
}

/// The nearest integer on a map, as such and as it was; ties go to the even one.
#[inline(always)]
fn rounded(x: f32) -> (i32, f32) {
    const LARGE: f32 = 12_582_912.0; // 1.5 * 2^23
    let moved = least(most(x, 0.0), SIZE as f32) + LARGE;
    ((moved.to_bits() as i32).wrapping_sub(LARGE.to_bits() as i32), moved - LARGE)
}

/// The smaller of two numbers, as vector registers compare them.
#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

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
            let z = least(most(first + step * i, -HIGHEST), HIGHEST);
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
