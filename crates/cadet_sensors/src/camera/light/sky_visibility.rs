//! Directional sky visibility (ambient occlusion): a coarse height map of the scene, and probes over it.

use macro_rules_attribute::apply;

use super::block_sums::BlockSums;
use super::contact_occlusion::ContactOcclusion;
use crate::sense::PosedScene;
use crate::wide_registers::array_of;
use cadet_base::math::{DVec3, Vec3};

/// Cells along a side of the height map.
const CELLS: usize = 144;
/// Side of a cell, meters.
const CELL_M: f32 = 1.0;
/// Heights of the probes over the lowest surface of their cell, meters.
const LEVELS_M: [f32; 4] = [0.3, 1.6, 4.0, 9.0];
/// Distances at which a probe looks for what stands in the way, in cells.
const STEPS: [f32; 7] = [1.2, 2.2, 3.5, 5.5, 9.0, 15.0, 26.0];
const AZIMUTHS: usize = 8;
/// What still comes through a cover such as a crown.
const COVER_LEAK: f32 = 0.55;
/// Crowns are not solid: they stand for lower obstacles.
const CROWN_SHARE: f32 = 0.6;
/// How far ahead of the camera the map's middle lies, and how high the camera stands over a road where nothing is known,
/// meters.
const AHEAD_M: f64 = 50.0;
const EYE_HEIGHT_M: f64 = 1.65;
/// Clusters of smaller radius lie in one cell; those of plants below the second are squares of cells. In cells.
const ONE_CELL: f32 = 0.6;
const LEAF_CLUSTER: f32 = 1.5;
/// What stands so much over a probe begins to cover it, and covers it faster by the meter than this.
const COVER_FROM_M: f32 = 0.8;
const COVER_PER_M: f32 = 0.7;
/// Of a cover, the shares of a probe's own cell and of each of the four beside it.
const COVER_HERE: f32 = 0.4;
const COVER_BESIDE: f32 = 0.15;
/// What the azimuths beside a side's own count, and the sum of all three.
const NEIGHBOR_AZIMUTH: f32 = 0.7;
const AZIMUTH_SUM: f32 = 2.4;
/// What faces down sees the sky by way of the ground: at least, and by the sky above.
const DOWN_LEAST: f32 = 0.4;
const DOWN_BY_ZENITH: f32 = 0.6;
/// How far off the surface a point is taken to lie, in cells: else a wall would sit in its own house.
const OFF_SURFACE: f32 = 1.7;
/// The last places between two cells, with room for rounding.
const LAST_CELL: f32 = CELLS as f32 - 1.001;
/// Beyond the map, and how wide its rim is in which what is known turns to that, in cells.
const UNKNOWN: SkyVisibility = [0.85; 6];
const RIM: f32 = 12.0;

/// Sky visibility per level.
type Probes = [[f32; 8]; LEVELS_M.len()];

/// Sky visibility towards +x, -x, +y, -y, +z, -z, each 0..1.
pub type SkyVisibility = [f32; 6];

/// The sky visibility around a camera.
#[derive(Debug, Clone)]
pub struct SkyProbes {
    min: [f32; 2],
    /// Lowest surface of each cell.
    floor: Vec<f32>,
    /// Sky visibility per cell and level; padded, so that it is one load.
    probes: Vec<Probes>,
    /// What vehicles and people leave of it to the ground.
    pub contacts: ContactOcclusion,
}

const GRID_M: f32 = 4.0;
const GRID: usize = (CELLS as f32 * CELL_M / GRID_M) as usize;

impl SkyProbes {
    /// Measures a scene around a camera that looks along `forward_world`, where `visible_world` has points.
    #[must_use]
    pub fn new(scene: &PosedScene, eye_world: DVec3, forward_world: DVec3, visible_world: &[Vec3]) -> Self {
        let flat = DVec3::new(forward_world.x, forward_world.y, 0.0).normalize_or_zero();
        let middle = eye_world + flat * AHEAD_M;
        let half = f64::from(CELLS as f32 * CELL_M) / 2.0;
        // Whole cells, so that nothing flickers from frame to frame.
        let min = [(middle.x - half).floor() as f32, (middle.y - half).floor() as f32];
        let mut view = Self { min, floor: Vec::new(), probes: Vec::new(), contacts: ContactOcclusion::new(scene, min) };
        let needed = view.needed_blocks(visible_world);
        let top = view.measure_heights(scene, (eye_world.z - EYE_HEIGHT_M) as f32, &near_blocks(&needed));
        view.place_probes(&top, &needed);
        view
    }

    /// Fills the floor, and returns the highest surface of each cell.
    fn measure_heights(&mut self, scene: &PosedScene, default_z: f32, near: &BlockSums) -> Vec<f32> {
        let mut top = vec![f32::NEG_INFINITY; CELLS * CELLS];
        let mut floor = vec![f32::INFINITY; CELLS * CELLS];
        let side = CELLS as f32 * CELL_M;
        for instance in &scene.instances {
            let (c, r) = (instance.center_world.as_vec3(), instance.radius_m as f32);
            if c.x + r < self.min[0]
                || c.y + r < self.min[1]
                || c.x - r > self.min[0] + side
                || c.y - r > self.min[1] + side
            {
                continue;
            }
            let (dx, dy) = (c.x - self.min[0], c.y - self.min[1]);
            if !near.any([dx - r, dy - r], [dx + r, dy + r]) {
                continue;
            }
            let foot_z = c.z - 0.5 * instance.mesh.bounds.size().z;
            let is_plant = instance.palette.has_vegetation();
            let share = if is_plant { CROWN_SHARE } else { 1.0 };
            let mut mark = |x: usize, y: usize, low: f32, high: f32| {
                let i = y * CELLS + x;
                let high = foot_z + (high - foot_z) * share;
                floor[i] = if low < floor[i] { low } else { floor[i] };
                top[i] = if high > top[i] { high } else { top[i] };
            };
            let mesh = &instance.mesh;
            let linear = instance.placement.rotation.as_mat3();
            let origin = instance.placement.translation.as_vec3();
            for (number, cluster) in mesh.clusters.summaries().iter().enumerate() {
                let c = origin + linear * cluster.center;
                let (dx, dy, r) = (c.x - self.min[0], c.y - self.min[1], cluster.radius_m);
                if dx + r < 0.0
                    || dy + r < 0.0
                    || dx - r > side
                    || dy - r > side
                    || !near.any([dx - r, dy - r], [dx + r, dy + r])
                {
                    continue;
                }
                let cell = |d: f32| ((d / CELL_M).max(0.0) as usize).min(CELLS - 1);
                if r < ONE_CELL * CELL_M {
                    // Smaller than a cell: no need to look at the faces.
                    mark(cell(dx), cell(dy), c.z - 0.5 * r, c.z + 0.5 * r);
                    continue;
                }
                if is_plant && r < LEAF_CLUSTER * CELL_M {
                    // Leaves lie anywhere within.
                    let core = 0.5 * r;
                    for y in cell(dy - core)..=cell(dy + core) {
                        for x in cell(dx - core)..=cell(dx + core) {
                            mark(x, y, c.z - core, c.z + core);
                        }
                    }
                    continue;
                }
                for column in mesh.columns_of(number) {
                    let half = 0.5 * (column.high_m - column.low_m);
                    let p = linear * Vec3::new(column.x, column.y, column.low_m + half) + origin;
                    let (x, y) = ((p.x - self.min[0]) / CELL_M, (p.y - self.min[1]) / CELL_M);
                    if x >= 0.0 && y >= 0.0 && x < CELLS as f32 && y < CELLS as f32 {
                        mark(x as usize, y as usize, p.z - half, p.z + half);
                    }
                }
            }
        }
        for (f, t) in floor.iter_mut().zip(&mut top) {
            if !f.is_finite() {
                (*f, *t) = (default_z, default_z);
            }
        }
        self.floor = floor;
        top
    }

    /// Blocks of `GRID_M` in which some probe may be needed: those of the points and their neighbors, as
    /// [`SkyProbes::sky_visibility`] looks up to 2.7 m aside.
    fn needed_blocks(&self, visible_world: &[Vec3]) -> Vec<bool> {
        let mut seen = vec![false; GRID * GRID];
        for p in visible_world.iter().step_by(3) {
            let (x, y) = ((p.x - self.min[0]) / GRID_M, (p.y - self.min[1]) / GRID_M);
            if x >= 0.0 && y >= 0.0 && x < GRID as f32 && y < GRID as f32 {
                seen[y as usize * GRID + x as usize] = true;
            }
        }
        let near = |i: usize| i.saturating_sub(1)..(i + 2).min(GRID);
        let needed = |i: usize| near(i / GRID).any(|y| near(i % GRID).any(|x| seen[y * GRID + x]));
        (0..GRID * GRID).map(needed).collect()
    }

    fn place_probes(&mut self, top: &[f32], needed_blocks: &[bool]) {
        const CELLS_PER_BLOCK: usize = CELLS / GRID;
        let directions: [(f32, f32); AZIMUTHS] = {
            let d = std::f32::consts::FRAC_1_SQRT_2;
            [(1.0, 0.0), (d, d), (0.0, 1.0), (-d, d), (-1.0, 0.0), (-d, -d), (0.0, -1.0), (d, -d)]
        };
        let offsets: Vec<Vec<(i32, i32, f32)>> = directions
            .iter()
            .map(|(dx, dy)| {
                STEPS.iter().map(|s| ((dx * s).round() as i32, (dy * s).round() as i32, 1.0 / (s * CELL_M))).collect()
            })
            .collect();
        self.probes = vec![[[1.0; 8]; LEVELS_M.len()]; CELLS * CELLS];
        let padded = PaddedTop::new(top);
        let mut free = [[0.0_f32; CELLS]; AZIMUTHS];
        for y in 0..CELLS {
            let needed = &needed_blocks[y / CELLS_PER_BLOCK * GRID..][..GRID];
            let (Some(first), Some(last)) = (needed.iter().position(|a| *a), needed.iter().rposition(|a| *a)) else {
                continue;
            };
            let columns = first * CELLS_PER_BLOCK..(last + 1) * CELLS_PER_BLOCK;
            for (level, over) in LEVELS_M.iter().enumerate() {
                let floor = &self.floor[y * CELLS..][columns.clone()];
                for (line, free) in offsets.iter().zip(&mut free) {
                    padded.free_share(y, columns.start, line, floor, *over, &mut free[columns.clone()]);
                }
                for x in columns.clone() {
                    if !needed[x / CELLS_PER_BLOCK] {
                        continue;
                    }
                    let cell = y * CELLS + x;
                    let z = self.floor[cell] + over;
                    let free = free.each_ref().map(|f| f[x]);
                    let zenith: f32 = free.iter().sum::<f32>() / AZIMUTHS as f32;
                    let around = |dx: isize, dy: isize| {
                        let near = |v: usize, d: isize| v.saturating_add_signed(d).min(CELLS - 1);
                        ((top[near(y, dy) * CELLS + near(x, dx)] - z - COVER_FROM_M) * COVER_PER_M).clamp(0.0, 1.0)
                    };
                    let covered = COVER_HERE * around(0, 0)
                        + COVER_BESIDE * (around(1, 0) + around(-1, 0) + around(0, 1) + around(0, -1));
                    let cover = 1.0 - (1.0 - COVER_LEAK) * covered;
                    let side = |k: usize| {
                        let (a, b) = (free[(k + AZIMUTHS - 1) % AZIMUTHS], free[(k + 1) % AZIMUTHS]);
                        (free[k] + NEIGHBOR_AZIMUTH * (a + b)) * (1.0 / AZIMUTH_SUM)
                    };
                    let sides = [side(0), side(AZIMUTHS / 2), side(AZIMUTHS / 4), side(3 * AZIMUTHS / 4)]
                        .map(|s| s * (0.5 + 0.5 * cover));
                    let up_and_down = [zenith * cover, (DOWN_LEAST + DOWN_BY_ZENITH * zenith) * cover];
                    self.probes[cell][level] =
                        [sides[0], sides[1], sides[2], sides[3], up_and_down[0], up_and_down[1], 0.0, 0.0];
                }
            }
        }
    }

    /// Sky visibility of a surface point with the given unit normal.
    #[must_use]
    pub fn sky_visibility(&self, point_world: Vec3, normal: Vec3) -> SkyVisibility {
        let p = point_world + normal * (OFF_SURFACE * CELL_M);
        let gx = (p.x - self.min[0]) / CELL_M - 0.5;
        let gy = (p.y - self.min[1]) / CELL_M - 0.5;
        if !(0.0..LAST_CELL).contains(&gx) || !(0.0..LAST_CELL).contains(&gy) {
            return UNKNOWN;
        }
        let known = between(&self.floor, &self.probes, [gx, gy], point_world.z);
        let to_border = gx.min(gy).min(LAST_CELL - gx).min(LAST_CELL - gy);
        let share = (to_border * (1.0 / RIM)).min(1.0);
        array_of(|k| UNKNOWN[k] + (known[k] - UNKNOWN[k]) * share)
    }
}

/// What the probes around a place say, which is given in cells and lies within them.
#[apply(for_wide_registers)]
fn between(floor: &[f32], probes: &[Probes], [gx, gy]: [f32; 2], z: f32) -> [f32; 8] {
    let (ix, iy) = (gx as usize, gy as usize);
    let (fx, fy) = (gx - ix as f32, gy - iy as f32);
    let mut sum = [0.0; 8];
    for (cell, weight) in [
        (iy * CELLS + ix, (1.0 - fx) * (1.0 - fy)),
        (iy * CELLS + ix + 1, fx * (1.0 - fy)),
        ((iy + 1) * CELLS + ix, (1.0 - fx) * fy),
        ((iy + 1) * CELLS + ix + 1, fx * fy),
    ] {
        let over = z - floor[cell];
        // Between which levels, without branches.
        let upper: usize = LEVELS_M.iter().map(|l| usize::from(over >= *l)).sum();
        let (low, high) = BETWEEN[upper];
        let t = (over - LEVELS_M[low]) * PER_RISE[upper];
        let probes = &probes[cell];
        let (a, b) = (&probes[low], &probes[high]);
        for k in 0..8 {
            sum[k] += weight * (a[k] + (b[k] - a[k]) * t);
        }
    }
    sum
}

/// The levels about a height that reaches so many of them, and the inverse of their distance.
const BETWEEN: [(usize, usize); LEVELS_M.len() + 1] = [(0, 0), (0, 1), (1, 2), (2, 3), (3, 3)];
const PER_RISE: [f32; LEVELS_M.len() + 1] =
    [0.0, 1.0 / (LEVELS_M[1] - LEVELS_M[0]), 1.0 / (LEVELS_M[2] - LEVELS_M[1]), 1.0 / (LEVELS_M[3] - LEVELS_M[2]), 0.0];

/// The blocks within the probes' longest step of those that are needed.
fn near_blocks(needed: &[bool]) -> BlockSums {
    const REACH: usize = 7;
    let near = |i: usize| i.saturating_sub(REACH)..(i + REACH + 1).min(GRID);
    // Along rows first, then along columns.
    let rows: Vec<bool> = (0..GRID * GRID).map(|i| near(i % GRID).any(|x| needed[i / GRID * GRID + x])).collect();
    BlockSums::of(GRID, GRID_M, |x, y| near(y).any(|y| rows[y * GRID + x]))
}

/// The highest surfaces with a rim where nothing is.
struct PaddedTop(Vec<f32>);

impl PaddedTop {
    /// The longest step.
    const RIM: usize = 26;
    const STRIDE: usize = CELLS + 2 * Self::RIM;

    fn new(top: &[f32]) -> Self {
        let mut padded = vec![f32::NEG_INFINITY; CELLS * Self::STRIDE];
        for (line, top) in padded.chunks_exact_mut(Self::STRIDE).zip(top.chunks_exact(CELLS)) {
            line[Self::RIM..Self::RIM + CELLS].copy_from_slice(top);
        }
        Self(padded)
    }

    /// For a row of cells: the squared cosine of the horizon's elevation in one direction, seen from `over` meters above
    /// the floor. `line` has the steps to look at, in cells, with the inverse of their lengths in meters.
    fn free_share(
        &self,
        y: usize,
        first_x: usize,
        line: &[(i32, i32, f32)],
        floor: &[f32],
        over: f32,
        out: &mut [f32],
    ) {
        out.fill(0.0);
        for (ox, oy, per_m) in line {
            let row = y as i32 + oy;
            if row < 0 || row >= CELLS as i32 {
                break;
            }
            let start = row as usize * Self::STRIDE + (Self::RIM + first_x).saturating_add_signed(*ox as isize);
            raise(out, &self.0[start..start + out.len()], floor, over, *per_m);
        }
        for slope in out {
            *slope = 1.0 / (1.0 + *slope * *slope);
        }
    }
}

/// Raises the slopes of the horizon to what stands at a step.
#[apply(for_wide_registers)]
fn raise(slopes: &mut [f32], top: &[f32], floor: &[f32], over: f32, per_m: f32) {
    for ((slope, top), floor) in slopes.iter_mut().zip(top).zip(floor) {
        *slope = slope.max((top - (floor + over)) * per_m);
    }
}
