//! Contact occlusion: what vehicles and people leave of the sky's light to the ground under and beside them.

use std::ops::Range;

use macro_rules_attribute::apply;

use super::block_sums::BlockSums;
use crate::sense::{PosedInstance, PosedScene};
use cadet_base::math::{DVec3, Vec3};

/// Cells along a side of the map.
const CELLS: usize = 72;
/// Side of a cell, meters.
const CELL_M: f32 = 2.0;
/// How far a body darkens what is about it, in its heights.
const REACH: f32 = 1.5;
/// Half of a body's extents, less what is rounded off.
const HALF_BODY: f32 = 0.47;
/// Half the diagonal of a cell, in cells.
const HALF_DIAGONAL: f32 = 0.71;
/// Height of the gap under a body, meters.
const GAP_M: f32 = 0.22;
/// Light under the middle of a body, and how much more there is at its edges.
const UNDER: f32 = 0.03;
const UNDER_EDGES: f32 = 0.42;
/// The gap darkens what is nearer to the body than this, by so much.
const GAP_SHADOW_M: f32 = 0.35;
const GAP_SHADOW: f32 = 0.18;
/// Heights over a body's bottom at which a point lies on the ground beside it, meters.
const ON_GROUND_M: Range<f32> = -0.6..0.45;

/// The boxes of a scene's actors, which occlude the sky.
#[derive(Debug, Clone)]
pub struct ContactOcclusion {
    min: [f32; 2],
    occluders: Vec<Occluder>,
    /// Occluders that reach a cell, cell by cell, and where each cell's begin.
    reaching: Vec<u16>,
    starts: Vec<u32>,
    /// Cells that some occluder reaches.
    reached: BlockSums,
}

/// A box that shades the ground under and beside it: a vehicle's body.
#[derive(Debug, Clone)]
pub(crate) struct Occluder {
    pub(crate) center: Vec3,
    axis_x: Vec3,
    axis_y: Vec3,
    half: [f32; 2],
    bottom_z: f32,
    height: f32,
}

impl ContactOcclusion {
    /// The vehicles and people of a scene, on a map that begins at `min_world_m` of the world.
    #[must_use]
    pub fn new(scene: &PosedScene, min_world_m: [f32; 2]) -> Self {
        let (mut occluders, mut reached_cells) = (Vec::new(), Vec::new());
        for instance in &scene.instances {
            let Some(occluder) = Occluder::of(instance) else { continue };
            let (center, size) = (occluder.center, instance.mesh.bounds.size());
            let (dx, dy) = (center.x - min_world_m[0], center.y - min_world_m[1]);
            // Half a cell's diagonal more: the distance is that of the cells' middles.
            let reach = REACH * size.z + HALF_DIAGONAL * CELL_M;
            let r = 0.5 * (size.x * size.x + size.y * size.y).sqrt() + reach;
            let side = CELLS as f32 * CELL_M;
            if dx + r < 0.0 || dy + r < 0.0 || dx - r >= side || dy - r >= side {
                continue;
            }
            let range = |d: f32| {
                let lo = ((d - r) / CELL_M).max(0.0) as usize;
                let hi = (((d + r) / CELL_M).max(0.0) as usize).min(CELLS - 1);
                lo..=hi
            };
            let index = occluders.len().min(usize::from(u16::MAX)) as u16;
            for y in range(dy) {
                for x in range(dx) {
                    let middle = |i: usize| (i as f32 + 0.5) * CELL_M;
                    let d = Vec3::new(middle(x) - dx, middle(y) - dy, 0.0);
                    if occluder.distance(d) <= reach {
                        reached_cells.push(((y * CELLS + x) as u16, index));
                    }
                }
            }
            occluders.push(occluder);
        }
        reached_cells.sort_unstable();
        let mut starts = vec![0; CELLS * CELLS + 1];
        for (cell, _) in &reached_cells {
            starts[usize::from(*cell) + 1] += 1;
        }
        for cell in 0..CELLS * CELLS {
            starts[cell + 1] += starts[cell];
        }
        let reached = BlockSums::of(CELLS, CELL_M, |x, y| starts[y * CELLS + x] < starts[y * CELLS + x + 1]);
        let reaching = reached_cells.into_iter().map(|(_, index)| index).collect();
        Self { min: min_world_m, occluders, reaching, starts, reached }
    }

    /// The occluders that reach a cell.
    fn reaching(&self, cell: usize) -> &[u16] {
        &self.reaching[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Share of the sky's light that vehicles leave to points on the ground under or beside them, 0..1; 1 where it is not
    /// queried. `points` are relative to the eye; the first `count` of them matter. There is room for whole groups of 16.
    pub fn shade<const N: usize>(
        &self,
        eye_world: Vec3,
        points: &[[f32; N]; 3],
        is_queried: &[bool; N],
        count: usize,
        factor: &mut [f32; N],
    ) {
        const { assert!(N.is_multiple_of(TOGETHER), "groups are whole") };
        factor.fill(1.0);
        let ([xs, ys, _], queried) =
            (points.each_ref().map(|axis| axis.as_chunks::<TOGETHER>().0), is_queried.as_chunks::<TOGETHER>().0);
        let (to_x, to_y) = (eye_world.x - self.min[0], eye_world.y - self.min[1]);
        let is_reached = |groups: Range<usize>| {
            let [left, right, low, high] = bounds(&xs[groups.clone()], &ys[groups.clone()], &queried[groups]);
            left <= right && self.reached.any([left + to_x, low + to_y], [right + to_x, high + to_y])
        };
        let groups = count.div_ceil(TOGETHER);
        // Most are far from all vehicles: all are tested with one query first.
        if groups == 0 || !is_reached(0..groups) {
            return;
        }
        let mut reaching: Vec<u16> = Vec::new();
        for group in (0..groups).filter(|group| is_reached(*group..group + 1)) {
            let (start, end) = (group * TOGETHER, ((group + 1) * TOGETHER).min(count));
            reaching.clear();
            let mut last = usize::MAX;
            for i in (start..end).filter(|i| is_queried[*i]) {
                let gx = (points[0][i] + eye_world.x - self.min[0]) * (1.0 / CELL_M);
                let gy = (points[1][i] + eye_world.y - self.min[1]) * (1.0 / CELL_M);
                if gx < 0.0 || gy < 0.0 || gx >= CELLS as f32 || gy >= CELLS as f32 {
                    continue;
                }
                let cell = gy as usize * CELLS + gx as usize;
                if cell != last {
                    last = cell;
                    for index in self.reaching(cell) {
                        if !reaching.contains(index) {
                            reaching.push(*index);
                        }
                    }
                }
            }
            // One order for all groups, so that a point's light does not depend on its neighbors.
            reaching.sort_unstable();
            for index in &reaching {
                let axes = points.each_ref().map(|axis| &axis[start..end]);
                self.occluders[usize::from(*index)].darken(
                    eye_world,
                    axes,
                    &is_queried[start..end],
                    &mut factor[start..end],
                );
            }
        }
    }
}

/// Points that are looked at together.
const TOGETHER: usize = 16;

impl Occluder {
    /// An actor's body.
    pub(crate) fn of(instance: &PosedInstance) -> Option<Self> {
        if !instance.is_body {
            return None;
        }
        let size = instance.mesh.bounds.size();
        let center = instance.center_world.as_vec3();
        let axis = |v: DVec3| (instance.placement.rotation * v).as_vec3();
        Some(Self {
            center,
            axis_x: axis(DVec3::X),
            axis_y: axis(DVec3::Y),
            half: [size.x * HALF_BODY, size.y * HALF_BODY],
            bottom_z: center.z - size.z / 2.0,
            height: size.z,
        })
    }

    /// From the body seen from above to a point, relative to the middle.
    fn distance(&self, d: Vec3) -> f32 {
        let ox = (d.dot(self.axis_x).abs() - self.half[0]).max(0.0);
        let oy = (d.dot(self.axis_y).abs() - self.half[1]).max(0.0);
        (ox * ox + oy * oy).sqrt()
    }

    /// Multiplies what the other occluders leave to some points by what this one leaves: 1 beyond `REACH`.
    fn darken(&self, eye_world: Vec3, points: [&[f32]; 3], is_queried: &[bool], factor: &mut [f32]) {
        darken(self, self.center - eye_world, points, is_queried, factor);
    }

    /// What it leaves to a point, relative to the middle.
    #[inline(always)]
    pub(crate) fn share_left(&self, d: Vec3) -> f32 {
        let over = d.z + (self.center.z - self.bottom_z);
        let (x, y) = (d.dot(self.axis_x).abs() - self.half[0], d.dot(self.axis_y).abs() - self.half[1]);
        // Under the body: light comes in flat through the gap at the nearest edges.
        let nearest = x.max(y).min(0.0);
        let under = UNDER + UNDER_EDGES * (GAP_M * GAP_M / (GAP_M * GAP_M + nearest * nearest));
        let (ox, oy) = (x.max(0.0), y.max(0.0));
        let distance = (ox * ox + oy * oy).sqrt();
        // A wall of the body's height and of finite width hides up to half of the sky.
        let wall = distance / (distance * distance + self.height * self.height).sqrt();
        let width = 0.5 * (self.half[0] + self.half[1]);
        let share = width / (width + distance);
        let fade = (2.0 * (REACH - distance / self.height)).clamp(0.0, 1.0);
        // The gap under the body darkens the last decimetres further.
        let gap_shadow = GAP_SHADOW * (1.0 - distance * (1.0 / GAP_SHADOW_M)).max(0.0);
        let beside = 1.0 - 0.5 * (1.0 - wall) * share * fade - gap_shadow;
        let left = if (x < 0.0) & (y < 0.0) { under } else { beside };
        if ON_GROUND_M.contains(&over) { left } else { 1.0 }
    }
}

#[apply(for_wide_registers)]
fn darken(occluder: &Occluder, center: Vec3, [x, y, z]: [&[f32]; 3], is_queried: &[bool], factor: &mut [f32]) {
    for ((factor, is_queried), ((x, y), z)) in factor.iter_mut().zip(is_queried).zip(x.iter().zip(y).zip(z)) {
        let left = occluder.share_left(Vec3::new(*x, *y, *z) - center);
        *factor *= if *is_queried { left } else { 1.0 };
    }
}

/// The least and the greatest x, the least and the greatest y of the queried points; infinite the wrong way round without any.
#[apply(for_wide_registers)]
fn bounds(xs: &[[f32; TOGETHER]], ys: &[[f32; TOGETHER]], is_queried: &[[bool; TOGETHER]]) -> [f32; 4] {
    let (none, most) = ([f32::INFINITY; TOGETHER], [f32::NEG_INFINITY; TOGETHER]);
    let (mut left, mut right, mut low, mut high) = (none, most, none, most);
    for ((x, y), is_queried) in xs.iter().zip(ys).zip(is_queried) {
        for i in 0..TOGETHER {
            left[i] = if is_queried[i] & (x[i] < left[i]) { x[i] } else { left[i] };
            right[i] = if is_queried[i] & (x[i] > right[i]) { x[i] } else { right[i] };
            low[i] = if is_queried[i] & (y[i] < low[i]) { y[i] } else { low[i] };
            high[i] = if is_queried[i] & (y[i] > high[i]) { y[i] } else { high[i] };
        }
    }
    let least = |side: [f32; TOGETHER]| side.into_iter().fold(f32::INFINITY, f32::min);
    let greatest = |side: [f32; TOGETHER]| side.into_iter().fold(f32::NEG_INFINITY, f32::max);
    [least(left), greatest(right), least(low), greatest(high)]
}
