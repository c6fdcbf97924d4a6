//! Shadow maps: the scene's triangles seen from the sun, fine near the camera and coarser beyond.

mod face_setup;
mod map;
mod rasterization;

use macro_rules_attribute::apply;

use self::map::{EMPTY, HIGHEST_STEPS, Map, ReceiverTiles, SIZE, STRIDE, TILE, TILES, steps};
use self::rasterization::{LEVEL, rasterize_casters};
use crate::camera::surfaces::{Flags, split};
use crate::sense::PosedScene;
use crate::wide_registers::array_of;
use cadet_base::geometry::LANES;
use cadet_base::math::{DMat3, DVec3, Vec3, greater, lesser};

/// (distance ahead of the camera of the middle, half the side), meters: near, far.
const CASCADES: [(f64, f64); 2] = [(15.0, 20.0), (58.0, 68.0)];
/// Steps of height in a meter: near, far. Sixteen bits reach 128 and 256 m to both sides of the map's middle.
const STEPS_PER_M: [f32; 2] = [256.0, 128.0];
/// Of a cluster's leaves one in so many is drawn: near, far.
const LEAF_STEPS: [usize; 2] = [1, 2];
/// How far below the points that are known some more may be seen on the same tiles, meters.
const RECEIVERS_BELOW_M: f32 = 0.3;
/// Height of the camera over the ground, on which the maps' middles lie, meters.
const EYE_HEIGHT_M: f64 = 1.6;
/// Above this sine of the sun's elevation the maps' axes are built on x in place of the vertical.
const NEAR_ZENITH: f32 = 0.95;

/// The sun's view of a scene around a camera.
#[derive(Debug, Clone)]
pub struct ShadowMaps {
    right: Vec3,
    up: Vec3,
    sun: Vec3,
    maps: Vec<Map>,
}

impl ShadowMaps {
    /// Rasterizes the casters. `sun_world` is the unit vector to the sun, `forward_world` the camera's axis.
    ///
    /// `visible_world`: points all over what the camera sees; only there are shadows known. Without them, everywhere.
    /// `buffers` are the maps of an earlier frame ([`ShadowMaps::into_buffers`]), whose memory is used again.
    #[must_use]
    pub fn new(
        scene: &PosedScene,
        eye_world: DVec3,
        forward_world: DVec3,
        sun_world: Vec3,
        visible_world: Option<&[Vec3]>,
        mut buffers: Vec<Vec<i16>>,
    ) -> Self {
        let helper = if sun_world.z.abs() < NEAR_ZENITH { Vec3::Z } else { Vec3::X };
        let right = helper.cross(sun_world).normalize();
        let up = sun_world.cross(right);
        let mut shadows = Self { right, up, sun: sun_world, maps: Vec::new() };
        let flat = DVec3::new(forward_world.x, forward_world.y, 0.0).normalize_or_zero();
        for (((ahead, half), steps_per_m), leaf_step) in CASCADES.into_iter().zip(STEPS_PER_M).zip(LEAF_STEPS) {
            let middle = shadows.to_light((eye_world + flat * ahead - DVec3::Z * EYE_HEIGHT_M).as_vec3());
            let texel_m = (2.0 * half / SIZE as f64) as f32;
            // Whole texels, so that shadow edges do not crawl when the camera moves.
            let snap = |c: f32| ((c - half as f32) / texel_m).floor() * texel_m;
            let mut height = buffers.pop().unwrap_or_default();
            height.resize(SIZE * STRIDE, EMPTY);
            shadows.maps.push(Map {
                min_m: [snap(middle.x), snap(middle.y)],
                middle_z: middle.z,
                texel_m,
                texels_per_m: 1.0 / texel_m,
                steps_per_m,
                leaf_step,
                height,
                receivers: ReceiverTiles::default(),
                drawn: vec![[SIZE, 0]; TILES],
            });
        }
        shadows.mark_receivers(visible_world);
        rasterize_casters(scene, &shadows.light_from_world(), &mut shadows.maps);
        shadows
    }

    fn mark_receivers(&mut self, visible_world: Option<&[Vec3]>) {
        // The last one stands for what is on no tile.
        let unseen = vec![if visible_world.is_none() { f32::NEG_INFINITY } else { f32::INFINITY }; TILES * TILES + 1];
        let mut lowest = [unseen.clone(), unseen];
        mark_tiles(&self.maps, [self.right, self.up, self.sun], visible_world.unwrap_or_default(), &mut lowest);
        for (map, lowest) in self.maps.iter_mut().zip(&lowest) {
            map.receivers = ReceiverTiles::around(lowest);
        }
    }

    /// The maps' memory, empty again: what an earlier frame drew must show nowhere, not even beside what is queried.
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
    /// Each map fades out at its rim, over what the next one knows; the last one's fades to light, which is what open
    /// ground and walls that face the sun show far away, and the same in every frame.
    ///
    /// `eye_world`: what the points are relative to. `texels`: memory for what is looked up.
    pub fn shadow_factors<const N: usize>(
        &self,
        eye_world: Vec3,
        query: &ShadowQuery<N>,
        texels: &mut PcfTexels<N>,
        factors: &mut [f32; N],
    ) {
        for i in 0..query.count.min(N) {
            factors[i] = if query.is_queried[i] { 1.0 } else { 0.0 };
        }
        texels.at.unknown = *factors;
        for map in &self.maps {
            if project(self, map, eye_world, query, &mut texels.at) {
                filter(map, query.count, texels, factors);
            }
        }
    }
}

/// The questions of [`ShadowMaps::shadow_factors`], axis by axis.
#[derive(Debug, Clone, Copy)]
pub struct ShadowQuery<'a, const N: usize> {
    /// Points, relative to the eye.
    pub points: &'a [[f32; N]; 3],
    /// Unit geometric normals towards the viewer's side.
    pub normals: &'a [[f32; N]; 3],
    /// Those of their faces ([`Flags`]).
    pub flags: &'a [u32; N],
    /// Their cosines to the sun.
    pub cos_sun: &'a [f32; N],
    /// The others get 0.
    pub is_queried: &'a [bool; N],
    /// Beyond these nothing is queried.
    pub count: usize,
}

/// Where points fall on a map: the first texel of the four by four about it, the shares of its column and row that lie
/// outside of the square, the height towards the sun, and how it rises from column to column and from row to row.
#[derive(Debug)]
struct MapCoordinates<const N: usize> {
    /// What this map says counts so much, and what it and those before it leave to the next ones.
    weight: [f32; N],
    unknown: [f32; N],
    first: [u32; N],
    x: [f32; N],
    y: [f32; N],
    z: [f32; N],
    rise: [[f32; N]; 2],
}

/// What [`ShadowMaps::shadow_factors`] looks at, four by four texels about each point; memory that is used again.
#[derive(Debug)]
pub struct PcfTexels<const N: usize> {
    at: MapCoordinates<N>,
    /// By rows: what is done goes over four neighbors of every point in turn.
    texels: [[[i16; SIDE]; N]; SIDE],
    heights: [[i16; SIDE]; N],
    /// What receivers' planes rise from the point to the columns of the first row, and from row to row.
    rises: [[i16; SIDE]; N],
    row_rises: [[i16; SIDE]; N],
    /// Shares of the first and the last row, and of the columns.
    top: [[f32; SIDE]; N],
    bottom: [[f32; SIDE]; N],
    columns: [[f32; SIDE]; N],
}

impl<const N: usize> Default for PcfTexels<N> {
    fn default() -> Self {
        let none = [[0.0; SIDE]; N];
        Self {
            at: MapCoordinates {
                weight: [0.0; N],
                unknown: [0.0; N],
                first: [0; N],
                x: [0.0; N],
                y: [0.0; N],
                z: [0.0; N],
                rise: [[0.0; N]; 2],
            },
            texels: [[[0; SIDE]; N]; SIDE],
            heights: [[0; SIDE]; N],
            rises: [[0; SIDE]; N],
            row_rises: [[0; SIDE]; N],
            top: none,
            bottom: none,
            columns: none,
        }
    }
}

/// Texels along a map's rim that are not looked up, and those within them over which the map fades out: 2 and 7 m.
const MARGIN: f32 = 8.0;
const FADE: f32 = 80.0;

/// How far a point is moved along its normal where the sun stands square to it, texels.
const NORMAL_OFFSET: f32 = 0.8;
/// How much further where the sun grazes, texels, and everywhere, meters.
const GRAZING_OFFSET: f32 = 2.2;
const LEAST_OFFSET_M: f32 = 0.006;
/// How much nearer to the sun points are taken to lie than they do, texels.
const DEPTH_BIAS: f32 = 0.8;
/// The plane of ground on which the sun grazes more is taken to rise no faster.
const LEAST_COS: f32 = 0.03;
/// Half the side of the square, texels.
const REACH: f32 = 1.5;
/// Texels along a side of the square that is filtered, its area, and how much of that counts as all.
const SIDE: usize = 4;
const AREA: f32 = 4.0 * REACH * REACH;
const ALL_LIT: f32 = 8.95;

/// Finds points on a map; true if it shows any that the finer ones leave to it.
#[apply(for_wide_registers)]
fn project<const N: usize>(
    shadows: &ShadowMaps,
    map: &Map,
    eye_world: Vec3,
    query: &ShadowQuery<N>,
    out: &mut MapCoordinates<N>,
) -> bool {
    let count = query.count.next_multiple_of(LANES).min(N);
    let axes = [shadows.right, shadows.up, shadows.sun];
    let eye = shadows.to_light(eye_world);
    let (min_x, min_y, to_z) = (eye.x - map.min_m[0], eye.y - map.min_m[1], eye.z - map.middle_z);
    let [px, py, pz] = query.points;
    let [nx, ny, nz] = query.normals;
    let (texel_m, texels_per_m) = (map.texel_m, map.texels_per_m);
    let mut any = [0_u8; N];
    for i in 0..count {
        let (point, normal) = (Vec3::new(px[i], py[i], pz[i]), Vec3::new(nx[i], ny[i], nz[i]));
        let cos_sun = query.cos_sun[i];
        // Level ground is on no map, so that nothing keeps it from shading itself but what stands out of it.
        let is_level = (query.flags[i] & Flags::GROUND > 0) & (normal.z * normal.z > LEVEL);
        // Normal offset: moves grazing surfaces off their own texels, where a depth bias alone leaks.
        let offset = texel_m * (NORMAL_OFFSET + GRAZING_OFFSET * (1.0 - cos_sun.abs())) + LEAST_OFFSET_M;
        let offset = if is_level { 0.0 } else { offset };
        let bias = if is_level { LEAST_OFFSET_M } else { texel_m * DEPTH_BIAS };
        let p = point + normal * if cos_sun < 0.0 { -offset } else { offset };
        let x = (axes[0].dot(p) + min_x) * texels_per_m;
        let y = (axes[1].dot(p) + min_y) * texels_per_m;
        let z = (axes[2].dot(p) + to_z + bias) * map.steps_per_m;
        let to_rim = lesser(lesser(x, y), lesser(SIZE as f32 - x, SIZE as f32 - y)) - MARGIN;
        let share = lesser(greater(to_rim * (1.0 / FADE), 0.0), 1.0);
        let weight = if z.abs() < HIGHEST_STEPS { out.unknown[i] * share } else { 0.0 };
        any[i] = u8::from((weight > 0.0) & (i < query.count));
        out.weight[i] = weight;
        out.unknown[i] -= weight;
        let ((column, in_column), (row, in_row)) = (split(x - REACH), split(y - REACH));
        out.first[i] = row.wrapping_mul(STRIDE as i32).wrapping_add(column) as u32;
        (out.x[i], out.y[i], out.z[i]) = (in_column, in_row, z);
        // From a texel to the next along the receiver's plane.
        let rise = if is_level { -texel_m * map.steps_per_m / greater(cos_sun, LEAST_COS) } else { 0.0 };
        out.rise[0][i] = axes[0].dot(normal) * rise;
        out.rise[1][i] = axes[1].dot(normal) * rise;
    }
    any.into_iter().fold(0, |all, one| all | one) != 0
}

/// The shares of squares of three by three texels that lie no higher than the points, and than the planes of those that
/// have one. A square begins in a point's first texel (the shares `x` and `y` of that one's column and row lie outside)
/// and ends in the third after it.
///
/// Copies what is looked at first: the processor waits for many texels at once, and not for one point's after another's.
#[apply(for_wide_registers)]
fn filter<const N: usize>(map: &Map, points: usize, found: &mut PcfTexels<N>, factors: &mut [f32; N]) {
    let PcfTexels { at, texels, heights, rises, row_rises, top, bottom, columns } = found;
    let mut which = [0_u16; N];
    let mut count = 0;
    for i in 0..points.min(N) {
        which[count] = i as u16;
        count += usize::from(at.weight[i] > 0.0);
    }
    for (k, i) in which[..count].iter().enumerate() {
        let i = usize::from(*i);
        let rows = &map.height[at.first[i] as usize..][..(SIDE - 1) * STRIDE + SIDE];
        for (row, texels) in texels.iter_mut().enumerate() {
            texels[k].copy_from_slice(&rows[row * STRIDE..row * STRIDE + SIDE]);
        }
        let (x, y) = (at.x[i], at.y[i]);
        (top[k], bottom[k], heights[k]) = ([1.0 - y; SIDE], [y; SIDE], [steps(at.z[i]) as i16; SIDE]);
        columns[k] = [1.0 - x, 1.0, 1.0, x];
        // The first texel's middle lies so far from the point.
        let [by_x, by_y] = [at.rise[0][i], at.rise[1][i]];
        let first = by_x * (0.5 - REACH - x) + by_y * (0.5 - REACH - y);
        rises[k] = array_of(|column| steps(first + by_x * column as i32 as f32) as i16);
        row_rises[k] = [steps(by_y) as i16; SIDE];
    }
    let [row_0, row_1, row_2, row_3]: [&[i16]; SIDE] = array_of(|row| texels[row].as_flattened());
    let (top, bottom, heights) = (top.as_flattened(), bottom.as_flattened(), heights.as_flattened());
    let (rises, row_rises) = (rises.as_flattened(), row_rises.as_flattened());
    let sums = columns.as_flattened_mut();
    for j in 0..(count * SIDE).next_multiple_of(2 * LANES).min(SIDE * N) {
        let (z, first, step) = (heights[j], rises[j], row_rises[j]);
        // Where a plane falls, the point's own height counts: a wall's foot does not darken the ground that it faces.
        let share = |texel: i16, row: i16, share: f32| {
            let rise = first.wrapping_add(step.wrapping_mul(row)).max(0);
            if texel <= z.saturating_add(rise) { share } else { 0.0 }
        };
        let ends = share(row_0[j], 0, top[j]) + share(row_3[j], 3, bottom[j]);
        sums[j] *= ends + (share(row_1[j], 1, 1.0) + share(row_2[j], 2, 1.0));
    }
    let mut shares = [0.0; N];
    for (share, [a, b, c, d]) in shares.iter_mut().zip(&columns[..count]) {
        let sum = (a + b) + (c + d);
        // Neither rounding nor the edge of a texel dims what is lit all over.
        *share = if sum > ALL_LIT { 1.0 } else { sum * (1.0 / AREA) };
    }
    for (i, share) in which[..count].iter().zip(shares) {
        let i = usize::from(*i);
        factors[i] = greater(factors[i] - at.weight[i] * (1.0 - share), 0.0);
    }
}

/// Marks the tiles of two maps that points fall on; the coarser one's are not marked within the rim of the finer one.
#[apply(for_wide_registers)]
fn mark_tiles(maps: &[Map], [right, up, sun]: [Vec3; 3], points_world: &[Vec3], lowest: &mut [Vec<f32>; 2]) {
    for points in points_world.chunks(LANES) {
        let mut world = [[0.0; LANES]; 3];
        for (i, p) in points.iter().enumerate() {
            (world[0][i], world[1][i], world[2][i]) = (p.x, p.y, p.z);
        }
        let [x, y, z] = &world;
        let mut is_finer = [false; LANES];
        for (map, lowest) in maps.iter().zip(lowest.iter_mut()) {
            let (mut tiles, mut heights) = ([0; LANES], [0.0; LANES]);
            for i in 0..LANES {
                let (u, v) =
                    (right.x * x[i] + right.y * y[i] + right.z * z[i], up.x * x[i] + up.y * y[i] + up.z * z[i]);
                let (u, v) = ((u - map.min_m[0]) * map.texels_per_m, (v - map.min_m[1]) * map.texels_per_m);
                let within = |rim: f32| {
                    let end = SIZE as f32 - rim;
                    (u >= rim) & (v >= rim) & (u < end) & (v < end)
                };
                // At a border it may be the neighbor: those around a marked one are drawn as well.
                let tile = |texel: f32| {
                    split(lesser(greater(texel, 0.0), SIZE as f32) * (1.0 / TILE as f32)).0.clamp(0, TILES as i32 - 1)
                };
                let (column, row) = (tile(u), tile(v));
                let is_marked = within(0.0) & !is_finer[i];
                tiles[i] = if is_marked {
                    row.wrapping_mul(TILES as i32).wrapping_add(column)
                } else {
                    (TILES * TILES) as i32
                };
                is_finer[i] |= within(2.0 * MARGIN + FADE);
                let w = sun.x * x[i] + sun.y * y[i] + sun.z * z[i];
                heights[i] = (w - map.middle_z - RECEIVERS_BELOW_M) * map.steps_per_m;
            }
            for (tile, height) in tiles[..points.len()].iter().zip(heights) {
                let lowest = &mut lowest[*tile as usize];
                *lowest = lesser(*lowest, height);
            }
        }
    }
}
