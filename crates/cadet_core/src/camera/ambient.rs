//! How much of the sky a place sees: a coarse height map of the scene, probes over it, and the boxes of cars near the
//! ground.

use multiversion::multiversion;

use crate::material::Semantic;
use crate::math::{DVec3, Vec3};
use crate::sense::PosedScene;

/// Cells along a side of the height map.
const CELLS: usize = 144;
/// Side of a cell, metres.
const CELL_M: f32 = 1.0;
/// Heights of the probes over the lowest surface of their cell, metres.
const LEVELS_M: [f32; 4] = [0.3, 1.6, 4.0, 9.0];
/// Distances at which a probe looks for what stands in the way, in cells.
const STEPS: [f32; 7] = [1.2, 2.2, 3.5, 5.5, 9.0, 15.0, 26.0];
const AZIMUTHS: usize = 8;
/// What still comes through a cover such as a crown.
const COVER_LEAK: f32 = 0.55;
/// Crowns are not solid: they stand for lower obstacles.
const CROWN_SHARE: f32 = 0.6;

/// Openness per level.
type Probes = [[f32; 8]; LEVELS_M.len()];

/// Openness towards +x, -x, +y, -y, +z, -z, each 0..1.
pub type Openness = [f32; 6];

/// A box that shades the ground under and beside it: a vehicle's body.
#[derive(Debug, Clone)]
struct Blocker {
    center: Vec3,
    axis_x: Vec3,
    axis_y: Vec3,
    half: [f32; 2],
    bottom_z: f32,
    height: f32,
    reach: f32,
}

/// The sky's visibility around a camera.
#[derive(Debug, Clone)]
pub struct SkyView {
    min: [f32; 2],
    /// Lowest surface of each cell.
    floor: Vec<f32>,
    /// Openness per cell and level; padded, so that it is one load.
    probes: Vec<Probes>,
    blockers: Vec<Blocker>,
    /// Blockers that reach each cell of a grid of `GRID_M`.
    grid: Vec<Vec<u16>>,
    /// Cells of the grid that some blocker reaches.
    reached: BlockSums,
}

const GRID_M: f32 = 4.0;
const GRID: usize = (CELLS as f32 * CELL_M / GRID_M) as usize;

impl SkyView {
    /// Measures a scene around a camera that looks along `forward_world`, where `seen_world` has points.
    #[must_use]
    pub fn new(scene: &PosedScene, eye_world: DVec3, forward_world: DVec3, seen_world: &[Vec3]) -> Self {
        let flat = DVec3::new(forward_world.x, forward_world.y, 0.0).normalize_or_zero();
        let middle = eye_world + flat * 50.0;
        let half = f64::from(CELLS as f32 * CELL_M) / 2.0;
        // Whole cells, so that nothing flickers from frame to frame.
        let min = [(middle.x - half).floor() as f32, (middle.y - half).floor() as f32];
        let mut view = Self {
            min,
            floor: Vec::new(),
            probes: Vec::new(),
            blockers: Vec::new(),
            grid: vec![Vec::new(); GRID * GRID],
            reached: BlockSums::default(),
        };
        let asked = view.asked_blocks(seen_world);
        let top = view.measure_heights(scene, (eye_world.z - 1.65) as f32, &BlockSums::near(&asked));
        view.place_probes(&top, &asked);
        view.collect_blockers(scene);
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
            let is_plant = instance.palette.0.iter().any(|m| m.semantic == Semantic::Vegetation);
            let share = if is_plant { CROWN_SHARE } else { 1.0 };
            let mut mark = |x: usize, y: usize, low: f32, high: f32| {
                let i = y * CELLS + x;
                floor[i] = floor[i].min(low);
                top[i] = top[i].max(foot_z + (high - foot_z) * share);
            };
            let mesh = &instance.mesh;
            let linear = instance.placement.rotation.as_mat3();
            let origin = instance.placement.translation.as_vec3();
            for (number, cluster) in mesh.clusters.iter().enumerate() {
                let c = origin + linear * cluster.center;
                let (dx, dy, r) = (c.x - self.min[0], c.y - self.min[1], cluster.radius_m);
                if dx + r < 0.0 || dy + r < 0.0 || dx - r > side || dy - r > side || !near.any([dx - r, dy - r], [dx + r, dy + r])
                {
                    continue;
                }
                let cell = |d: f32| ((d / CELL_M).max(0.0) as usize).min(CELLS - 1);
                if r < 0.6 * CELL_M {
                    // Smaller than a cell: no need to look at the faces.
                    mark(cell(dx), cell(dy), c.z - 0.5 * r, c.z + 0.5 * r);
                    continue;
                }
                if is_plant && r < 1.5 * CELL_M {
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
                    let half = 0.5 * (column.high - column.low);
                    let p = linear * Vec3::new(column.x, column.y, column.low + half) + origin;
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

    /// Blocks of `GRID_M` in which some probe may be asked for: those of the points and their neighbours, as
    /// [`SkyView::openness`] looks up to 2.7 m aside.
    fn asked_blocks(&self, seen_world: &[Vec3]) -> Vec<bool> {
        let mut seen = vec![false; GRID * GRID];
        for p in seen_world.iter().step_by(3) {
            let (x, y) = ((p.x - self.min[0]) / GRID_M, (p.y - self.min[1]) / GRID_M);
            if x >= 0.0 && y >= 0.0 && x < GRID as f32 && y < GRID as f32 {
                seen[y as usize * GRID + x as usize] = true;
            }
        }
        let near = |i: usize| i.saturating_sub(1)..(i + 2).min(GRID);
        let asked = |i: usize| near(i / GRID).any(|y| near(i % GRID).any(|x| seen[y * GRID + x]));
        (0..GRID * GRID).map(asked).collect()
    }

    fn place_probes(&mut self, top: &[f32], asked_blocks: &[bool]) {
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
            let asked = &asked_blocks[y / CELLS_PER_BLOCK * GRID..][..GRID];
            let (Some(first), Some(last)) = (asked.iter().position(|a| *a), asked.iter().rposition(|a| *a)) else {
                continue;
            };
            let columns = first * CELLS_PER_BLOCK..(last + 1) * CELLS_PER_BLOCK;
            for (level, over) in LEVELS_M.iter().enumerate() {
                let floor = &self.floor[y * CELLS..][columns.clone()];
                for (line, free) in offsets.iter().zip(&mut free) {
                    padded.free_share(y, columns.start, line, floor, *over, &mut free[columns.clone()]);
                }
                for x in columns.clone() {
                    if !asked[x / CELLS_PER_BLOCK] {
                        continue;
                    }
                    let cell = y * CELLS + x;
                    let z = self.floor[cell] + over;
                    let free = free.each_ref().map(|f| f[x]);
                    let zenith: f32 = free.iter().sum::<f32>() / AZIMUTHS as f32;
                    let around = |dx: isize, dy: isize| {
                        let near = |v: usize, d: isize| v.saturating_add_signed(d).min(CELLS - 1);
                        ((top[near(y, dy) * CELLS + near(x, dx)] - z - 0.8) * 0.7).clamp(0.0, 1.0)
                    };
                    let covered =
                        0.4 * around(0, 0) + 0.15 * (around(1, 0) + around(-1, 0) + around(0, 1) + around(0, -1));
                    let cover = 1.0 - (1.0 - COVER_LEAK) * covered;
                    let side = |k: usize| {
                        let (a, b) = (free[(k + 7) % 8], free[(k + 1) % 8]);
                        (free[k] + 0.7 * (a + b)) * (1.0 / 2.4)
                    };
                    let sides = [side(0), side(4), side(2), side(6)].map(|s| s * (0.5 + 0.5 * cover));
                    let up_and_down = [zenith * cover, (0.4 + 0.6 * zenith) * cover];
                    self.probes[cell][level] =
                        [sides[0], sides[1], sides[2], sides[3], up_and_down[0], up_and_down[1], 0.0, 0.0];
                }
            }
        }
    }

    fn collect_blockers(&mut self, scene: &PosedScene) {
        let side = CELLS as f32 * CELL_M;
        for instance in scene.instances.iter().filter(|i| i.actor_id >= 1) {
            let size = instance.mesh.bounds.size();
            if size.x < 0.25 || size.y < 0.25 || size.z < 0.5 || size.x > 30.0 {
                continue; // wheels and limbs
            }
            let center = instance.center_world.as_vec3();
            let axis = |v: DVec3| (instance.placement.rotation * v).as_vec3();
            let blocker = Blocker {
                center,
                axis_x: axis(DVec3::X),
                axis_y: axis(DVec3::Y),
                half: [size.x * 0.47, size.y * 0.47],
                bottom_z: center.z - size.z / 2.0,
                height: size.z,
                reach: 0.5 * (size.x * size.x + size.y * size.y).sqrt() + 1.5 * size.z,
            };
            let (dx, dy) = (center.x - self.min[0], center.y - self.min[1]);
            let r = blocker.reach;
            if dx + r < 0.0 || dy + r < 0.0 || dx - r >= side || dy - r >= side {
                continue;
            }
            let range = |d: f32| {
                let lo = ((d - r) / GRID_M).max(0.0) as usize;
                let hi = (((d + r) / GRID_M).max(0.0) as usize).min(GRID - 1);
                lo..=hi
            };
            let index = self.blockers.len().min(usize::from(u16::MAX)) as u16;
            for gy in range(dy) {
                for gx in range(dx) {
                    self.grid[gy * GRID + gx].push(index);
                }
            }
            self.blockers.push(blocker);
        }
        self.reached = BlockSums::of(|x, y| !self.grid[y * GRID + x].is_empty());
    }

    /// Openness of a surface point with the given unit normal.
    #[must_use]
    pub fn openness(&self, point_world: Vec3, normal: Vec3) -> Openness {
        // Off the surface, else a wall would sit in its own house.
        let p = point_world + normal * (1.7 * CELL_M);
        let gx = (p.x - self.min[0]) / CELL_M - 0.5;
        let gy = (p.y - self.min[1]) / CELL_M - 0.5;
        let limit = CELLS as f32 - 1.001;
        if !(0.0..limit).contains(&gx) || !(0.0..limit).contains(&gy) {
            return [0.85; 6];
        }
        let (ix, iy) = (gx as usize, gy as usize);
        let (fx, fy) = (gx - ix as f32, gy - iy as f32);
        let mut sum = [0.0; 8];
        for (cell, weight) in [
            (iy * CELLS + ix, (1.0 - fx) * (1.0 - fy)),
            (iy * CELLS + ix + 1, fx * (1.0 - fy)),
            ((iy + 1) * CELLS + ix, (1.0 - fx) * fy),
            ((iy + 1) * CELLS + ix + 1, fx * fy),
        ] {
            let over = point_world.z - self.floor[cell];
            // Between which levels, without branches.
            let upper: usize = LEVELS_M.iter().map(|l| usize::from(over >= *l)).sum();
            let (low, high) = BETWEEN[upper];
            let t = (over - LEVELS_M[low]) * PER_RISE[upper];
            let probes = &self.probes[cell];
            let (a, b) = (&probes[low], &probes[high]);
            for k in 0..8 {
                sum[k] += weight * (a[k] + (b[k] - a[k]) * t);
            }
        }
        let [a, b, c, d, e, f, _, _] = sum;
        [a, b, c, d, e, f]
    }

    /// Share of the sky's light that vehicles leave to points on the ground under or beside them, 0..1; 1 where it is not
    /// asked. `points` are relative to the eye; the first `count` of them matter.
    pub fn contact<const N: usize>(
        &self,
        eye_world: Vec3,
        points: &[[f32; N]; 3],
        is_asked: &[bool; N],
        count: usize,
        near: &mut [f32; N],
    ) {
        near[..count].fill(1.0);
        let mut reaching: Vec<u16> = Vec::new();
        for start in (0..count).step_by(TOGETHER) {
            let end = (start + TOGETHER).min(count);
            let [xs, ys] = [0, 1].map(|axis| span(&points[axis][start..end], &is_asked[start..end]));
            let [x, y] = [(xs, 0), (ys, 1)].map(|([low, high], axis)| {
                let to_map = eye_world.to_array()[axis] - self.min[axis];
                [low + to_map, high + to_map]
            });
            if xs[0] > xs[1] || !self.reached.any([x[0], y[0]], [x[1], y[1]]) {
                continue;
            }
            reaching.clear();
            let mut last = usize::MAX;
            for i in (start..end).filter(|i| is_asked[*i]) {
                let gx = (points[0][i] + eye_world.x - self.min[0]) * (1.0 / GRID_M);
                let gy = (points[1][i] + eye_world.y - self.min[1]) * (1.0 / GRID_M);
                if gx < 0.0 || gy < 0.0 || gx >= GRID as f32 || gy >= GRID as f32 {
                    continue;
                }
                let cell = gy as usize * GRID + gx as usize;
                if cell != last {
                    last = cell;
                    for index in &self.grid[cell] {
                        if !reaching.contains(index) {
                            reaching.push(*index);
                        }
                    }
                }
            }
            // One order for all groups, so that a point's light does not depend on its neighbours.
            reaching.sort_unstable();
            for index in &reaching {
                let axes = points.each_ref().map(|axis| &axis[start..end]);
                self.blockers[usize::from(*index)].darken(
                    eye_world,
                    axes,
                    &is_asked[start..end],
                    &mut near[start..end],
                );
            }
        }
    }
}

/// The levels about a height that reaches so many of them, and the inverse of their distance.
const BETWEEN: [(usize, usize); LEVELS_M.len() + 1] = [(0, 0), (0, 1), (1, 2), (2, 3), (3, 3)];
const PER_RISE: [f32; LEVELS_M.len() + 1] = [
    0.0,
    1.0 / (LEVELS_M[1] - LEVELS_M[0]),
    1.0 / (LEVELS_M[2] - LEVELS_M[1]),
    1.0 / (LEVELS_M[3] - LEVELS_M[2]),
    0.0,
];

/// Points that are looked at together.
const TOGETHER: usize = 16;

impl Blocker {
    /// Multiplies what the other blockers leave to some points by what this one leaves: 1 beyond `reach`.
    fn darken(&self, eye_world: Vec3, points: [&[f32]; 3], is_asked: &[bool], near: &mut [f32]) {
        darken(self, self.center - eye_world, points, is_asked, near);
    }

    #[inline(always)]
    fn leaves(&self, d: Vec3) -> f32 {
        let over = d.z + (self.center.z - self.bottom_z);
        let (x, y) = (d.dot(self.axis_x).abs() - self.half[0], d.dot(self.axis_y).abs() - self.half[1]);
        // Under the body: light comes in flat through the gap at the nearest edges.
        let gap = 0.22;
        let nearest = x.max(y).min(0.0);
        let under = 0.03 + 0.42 * (gap * gap / (gap * gap + nearest * nearest));
        let (ox, oy) = (x.max(0.0), y.max(0.0));
        let distance = (ox * ox + oy * oy).sqrt();
        // A wall of the body's height and of finite width hides up to half of the sky.
        let wall = distance / (distance * distance + self.height * self.height).sqrt();
        let width = 0.5 * (self.half[0] + self.half[1]);
        let share = width / (width + distance);
        let fade = (3.0 - 2.0 * distance / self.height).clamp(0.0, 1.0);
        // The gap under the body darkens the last decimetres further.
        let near = 0.18 * (1.0 - distance * (1.0 / 0.35)).max(0.0);
        let beside = 1.0 - 0.5 * (1.0 - wall) * share * fade - near;
        let left = if (x < 0.0) & (y < 0.0) { under } else { beside };
        if (-0.6..0.45).contains(&over) { left } else { 1.0 }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn darken(blocker: &Blocker, center: Vec3, [x, y, z]: [&[f32]; 3], is_asked: &[bool], near: &mut [f32]) {
    for ((near, is_asked), ((x, y), z)) in near.iter_mut().zip(is_asked).zip(x.iter().zip(y).zip(z)) {
        let left = blocker.leaves(Vec3::new(*x, *y, *z) - center);
        *near *= if *is_asked { left } else { 1.0 };
    }
}

/// The least and the greatest of the asked numbers.
#[inline]
fn span(values: &[f32], is_asked: &[bool]) -> [f32; 2] {
    let mut span = [f32::INFINITY, f32::NEG_INFINITY];
    for (v, is_asked) in values.iter().zip(is_asked) {
        let (low, high) = if *is_asked { (*v, *v) } else { (f32::INFINITY, f32::NEG_INFINITY) };
        span = [if low < span[0] { low } else { span[0] }, if high > span[1] { high } else { span[1] }];
    }
    span
}

/// Blocks of `GRID_M` that have something, counted so that many are asked at once.
#[derive(Debug, Clone, Default)]
struct BlockSums {
    /// Their number over all blocks before a row and a column.
    sums: Vec<u16>,
}

impl BlockSums {
    fn of(has: impl Fn(usize, usize) -> bool) -> Self {
        let mut sums = vec![0; (GRID + 1) * (GRID + 1)];
        for y in 0..GRID {
            let mut row = 0;
            for x in 0..GRID {
                row += u16::from(has(x, y));
                sums[(y + 1) * (GRID + 1) + x + 1] = sums[y * (GRID + 1) + x + 1] + row;
            }
        }
        Self { sums }
    }

    /// The blocks within the probes' longest step of some that are asked for.
    fn near(asked: &[bool]) -> Self {
        const REACH: usize = 7;
        let near = |i: usize| i.saturating_sub(REACH)..(i + REACH + 1).min(GRID);
        // Along rows first, then along columns.
        let rows: Vec<bool> = (0..GRID * GRID).map(|i| near(i % GRID).any(|x| asked[i / GRID * GRID + x])).collect();
        Self::of(|x, y| near(y).any(|y| rows[y * GRID + x]))
    }

    /// True if there is one between two places; metres from the map's corner.
    #[inline]
    fn any(&self, low: [f32; 2], high: [f32; 2]) -> bool {
        let block = |v: f32| ((v * (1.0 / GRID_M)).max(0.0) as usize).min(GRID - 1);
        let (x0, x1) = (block(low[0]), block(high[0]) + 1);
        let (y0, y1) = (block(low[1]), block(high[1]) + 1);
        let at = |x: usize, y: usize| self.sums[y * (GRID + 1) + x];
        at(x1, y1) + at(x0, y0) != at(x1, y0) + at(x0, y1)
    }
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

    /// For a row of cells: the squared cosine of the horizon's elevation in one direction, seen from `over` metres above
    /// the floor. `line` has the steps to look at, in cells, with the inverse of their lengths in metres.
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
#[multiversion(targets("x86_64+avx2"))]
fn raise(slopes: &mut [f32], top: &[f32], floor: &[f32], over: f32, per_m: f32) {
    for ((slope, top), floor) in slopes.iter_mut().zip(top).zip(floor) {
        *slope = slope.max((top - (floor + over)) * per_m);
    }
}
