//! Draws triangles into the visibility buffer of a camera.
//!
//! The inside test is that of [`super::BeamGrid::cover`], bit for bit. What differs from casting onto any grid: depths are
//! compared as 1 / z, which is affine on the image; rows find their spans together; a hierarchy of depths hides clusters
//! and triangles; and panes are drawn in the same pass as what is solid.

use multiversion::multiversion;

use super::edges::EdgePlanes;
use super::grid::{BeamGrid, Window};
use super::pinhole::PinholeGrid;
use super::posed::{PosedInstance, PosedScene};
use super::visibility_buffer::{BLOCK, Block, CLEARLY, DrawnFace, VisibilityBuffer};
use crate::geometry::{Cluster, LANES, slot_bit};
use crate::math::{DMat3, DVec3, Vec3};

/// [`draw_instances`], of every instance.
pub fn draw(scene: &PosedScene, grid: &PinholeGrid, buffer: &mut VisibilityBuffer) {
    draw_instances(scene, grid, 0..scene.instances.len(), buffer);
}

/// Draws the triangles of some instances (indices into [`PosedScene::instances`]) as the samples of `grid` see them;
/// `buffer` forgets what it held.
///
/// Of two surfaces at the same depth the earlier instance and face is seen. Triangles have two sides. The order of the
/// work does not show in the outcome.
pub fn draw_instances(
    scene: &PosedScene,
    grid: &PinholeGrid,
    instances: impl Iterator<Item = usize>,
    buffer: &mut VisibilityBuffer,
) {
    buffer.reset(grid.rows(), grid.columns());
    let pose = grid.world_from_grid();
    let cam_from_world = DMat3::from_quat(pose.rotation).transpose();
    let near_first = clusters_in_view(scene, grid, instances, cam_from_world, pose.translation);
    let mut drawer = Drawer {
        scene,
        grid,
        buffer,
        cam_from_world,
        eye_world: pose.translation,
        columns_x: grid.padded_columns_x(BLOCK),
        rows_y: grid.padded_rows_y(BLOCK),
        corners: Vec::new(),
    };
    draw_clusters(&mut drawer, &near_first);
}

/// A cluster in view.
struct InView {
    near_m: f32,
    instance: u32,
    cluster: u32,
    window: Window,
    /// Bits of the slots that are glass.
    glass: u64,
}

fn clusters_in_view(
    scene: &PosedScene,
    grid: &PinholeGrid,
    instances: impl Iterator<Item = usize>,
    cam_from_world: DMat3,
    eye_world: DVec3,
) -> Vec<InView> {
    let mut out = Vec::new();
    for (index, instance) in instances.map(|i| (i, &scene.instances[i])) {
        let center_cam = cam_from_world * (instance.center_world - eye_world);
        let radius_m = loosened(instance.radius_m as f32, center_cam.as_vec3());
        let ([window, _], _) = grid.sphere_windows(center_cam.as_vec3(), radius_m);
        if window.is_empty() {
            continue;
        }
        let slots = instance.palette.0.iter().zip(0_u8..);
        let glass = slots.filter(|(m, _)| m.is_glass()).fold(0, |bits, (_, slot)| bits | slot_bit(slot));
        let cam_from_local = cam_from_world * instance.placement.rotation;
        let origin_cam = center_cam - cam_from_local * instance.mesh.bounds.center().as_dvec3();
        let (linear, offset) = (cam_from_local.as_mat3(), origin_cam.as_vec3());
        for (number, cluster) in instance.mesh.clusters.iter().enumerate() {
            let center_cam = linear * cluster.center + offset;
            let ([window, _], near_m) = grid.sphere_windows(center_cam, loosened(cluster.radius_m, center_cam));
            if !window.is_empty() {
                out.push(InView { near_m, instance: index as u32, cluster: number as u32, window, glass });
            }
        }
    }
    out.sort_unstable_by(|a, b| {
        a.near_m.total_cmp(&b.near_m).then((a.instance, a.cluster).cmp(&(b.instance, b.cluster)))
    });
    out
}

/// A radius that covers the rounding of vertices to single precision, world coordinates of some kilometres included.
#[inline]
fn loosened(radius_m: f32, center_cam: Vec3) -> f32 {
    radius_m * 1.000_01 + 1e-3 + 1e-6 * center_cam.abs().max_element()
}

/// A vertex of the cluster at hand.
#[derive(Clone, Copy)]
struct Corner {
    cam: DVec3,
    /// Column and row, clamped to just outside of the image; NaN where it is not clearly in front.
    footprint: [f32; 2],
    /// A little less than its z.
    z_m: f32,
}

struct Drawer<'a> {
    scene: &'a PosedScene,
    grid: &'a PinholeGrid,
    buffer: &'a mut VisibilityBuffer,
    cam_from_world: DMat3,
    eye_world: DVec3,
    /// As the grid's, to the ends of the last blocks.
    columns_x: [Vec<f64>; 2],
    rows_y: Vec<f64>,
    corners: Vec<Corner>,
}

#[multiversion(targets("x86_64+avx2"))]
fn draw_clusters(drawer: &mut Drawer<'_>, near_first: &[InView]) {
    for item in near_first {
        if !drawer.buffer.is_hidden(&item.window, item.near_m) {
            drawer.draw_cluster(item);
        }
    }
}

impl Drawer<'_> {
    #[inline(always)]
    fn draw_cluster(&mut self, item: &InView) {
        let instance = &self.scene.instances[item.instance as usize];
        let cluster = &instance.mesh.clusters[item.cluster as usize];
        self.project(instance, cluster);
        // Bit 63 may stand for several slots.
        let is_mixed =
            (cluster.slots & item.glass != 0 && cluster.slots & !item.glass != 0) || cluster.slots >> 63 != 0;
        for (corners, face) in cluster.corners.iter().zip(&cluster.faces) {
            let corners = corners.map(|i| self.corners[usize::from(i)]);
            let ([window, _], z_m) = (
                self.grid.windows(&corners.map(|c| c.cam), &corners.map(|c| c.footprint)),
                corners[0].z_m.min(corners[1].z_m).min(corners[2].z_m),
            );
            if window.is_empty() || self.buffer.is_hidden(&window, z_m) {
                continue;
            }
            let planes = EdgePlanes::new(corners.map(|c| c.cam));
            if planes.volume == 0.0 {
                continue;
            }
            let is_pane = if is_mixed { instance.material(*face).is_glass() } else { cluster.slots & item.glass != 0 };
            self.draw_face(&planes, &window, z_m, item.instance, *face, is_pane);
        }
    }

    /// Poses a cluster's vertices and finds where they fall on the image.
    #[inline(always)]
    fn project(&mut self, instance: &PosedInstance, cluster: &Cluster) {
        self.corners.clear();
        let (r, o) = (&self.cam_from_world, self.eye_world);
        for local in &cluster.lanes {
            let world = instance.placement.pose_lanes(local);
            let mut cam = [[0.0_f64; LANES]; 3];
            let mut lanes = [[0.0_f32; LANES]; 3];
            for i in 0..LANES {
                let [x, y, z] =
                    [f64::from(world[0][i]) - o.x, f64::from(world[1][i]) - o.y, f64::from(world[2][i]) - o.z];
                cam[0][i] = r.x_axis.x * x + r.y_axis.x * y + r.z_axis.x * z;
                cam[1][i] = r.x_axis.y * x + r.y_axis.y * y + r.z_axis.y * z;
                cam[2][i] = r.x_axis.z * x + r.y_axis.z * y + r.z_axis.z * z;
                (lanes[0][i], lanes[1][i], lanes[2][i]) = (cam[0][i] as f32, cam[1][i] as f32, cam[2][i] as f32);
            }
            let mut footprints = [[0.0; 2]; LANES];
            self.grid.footprints(&lanes, &mut footprints);
            self.corners.extend((0..LANES).map(|i| Corner {
                cam: DVec3::new(cam[0][i], cam[1][i], cam[2][i]),
                footprint: footprints[i],
                z_m: lanes[2][i] - 1e-6 * (lanes[0][i].abs() + lanes[1][i].abs() + lanes[2][i].abs()),
            }));
        }
    }

    #[inline(always)]
    fn draw_face(&mut self, planes: &EdgePlanes, window: &Window, z_m: f32, instance: u32, face: u32, is_pane: bool) {
        let sign = if planes.volume > 0.0 { 1.0 } else { -1.0 };
        let edges = planes.cross.map(|n| n * sign);
        let normal = planes.normal * sign;
        let volume = planes.volume.abs();
        let id = self.buffer.faces.len() as u32;
        self.buffer.faces.push(DrawnFace { instance, face, normal: normal.to_array(), volume });
        let plane = normal * (1.0 / volume);
        // A block's nearness changes by so much from its middle to a corner.
        let half = (BLOCK - 1) as f64 / 2.0;
        let half_across = half + self.grid.odd_shift * 0.5;
        let reach =
            half_across * (plane.x.abs() / self.grid.column_scale) + half * (plane.y.abs() / self.grid.row_scale);
        let spans = Spans::new(&edges, self.grid, window);
        for block_row in window.rows.start / BLOCK..=(window.rows.end - 1) / BLOCK {
            let top = block_row * BLOCK;
            let Some(rows_y) = self.rows_y[top..].first_chunk::<BLOCK>() else { return };
            let mut batch = spans.of_rows(top);
            batch.settle_doubts(self.grid, &edges, window, top);
            let (start, end) = batch.columns(window, top);
            if start >= end {
                continue;
            }
            let mut rests = [0.0; BLOCK];
            for i in 0..BLOCK {
                rests[i] = plane.y * rows_y[i] + plane.z;
            }
            let middle = (rests[0] + rests[BLOCK - 1]) * 0.5 + reach;
            for block_column in start as usize / BLOCK..=(end as usize - 1) / BLOCK {
                let left = block_column * BLOCK;
                let [Some(even), Some(odd)] = self.columns_x.each_ref().map(|x| x[left..].first_chunk::<BLOCK>())
                else {
                    return;
                };
                let x = [even, odd];
                let number = block_row * self.buffer.blocks_across + block_column;
                // The largest nearness of the plane on the block.
                let most = (plane.x * (even[0] + odd[BLOCK - 1]) * 0.5 + middle) as f32;
                if self.buffer.floors[number] > most * CLEARLY || self.buffer.is_block_hidden(number, z_m) {
                    continue;
                }
                let layer = if is_pane { &mut self.buffer.panes } else { &mut self.buffer.solid };
                let outcome = draw_block(&mut layer[number], &batch, left as u32, x, plane.x, &rests, id);
                if Outcome::any(&outcome.equal) {
                    settle_ties(&mut layer[number], &batch, left as u32, x, plane.x, &rests, id, &self.buffer.faces);
                }
                if is_pane {
                    self.buffer.has_panes[number] = true;
                } else {
                    self.buffer.stale[number] |= Outcome::any(&outcome.nearer);
                }
            }
        }
    }
}

/// Where the edges of a triangle cut the rows of its window.
struct Spans {
    /// Column plus one where each edge cuts the first row, and how much further it does a row below.
    at: [f64; 3],
    step: [f64; 3],
    bounds_left: [bool; 3],
    /// How far the samples of each row of a block lie further right: in a quincunx, those of odd rows.
    shift: [f64; LANES],
    /// The first row of the window's first block.
    first_row: usize,
    least: f64,
    most: f64,
    /// A cut so near to a sample is looked at exactly.
    doubt: f64,
}

/// The spans of eight rows: `start..end`, unless in doubt.
struct Batch {
    start: [u32; LANES],
    end: [u32; LANES],
    doubt: [u32; LANES],
}

/// Adding it to a number below 2^31 rounds it to the nearest integer, which then stands in the low bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

impl Spans {
    #[inline(always)]
    fn new(edges: &[DVec3; 3], grid: &PinholeGrid, window: &Window) -> Self {
        let first_row = window.rows.start / BLOCK * BLOCK;
        let y = grid.row_y(first_row);
        let (mut at, mut step, mut bounds_left) = ([0.0; 3], [0.0; 3], [false; 3]);
        let mut doubt = 1e-6_f64;
        for k in 0..3 {
            let e = edges[k];
            let scale = grid.column_scale / -e.x;
            at[k] = (e.y * y + e.z) * scale + grid.column_offset + 1.0;
            step[k] = e.y * scale / grid.row_scale;
            bounds_left[k] = e.x > 0.0;
            let slack = 1e-14 * scale.abs() * (e.y.abs() + e.z.abs());
            // Keeps NaN, which an upright edge through the eye would be.
            doubt = if slack <= doubt { doubt } else { slack };
        }
        Self {
            at,
            step,
            bounds_left,
            shift: std::array::from_fn(|i| if i % 2 == 1 { grid.odd_shift } else { 0.0 }),
            first_row,
            least: window.columns.start as f64 + 0.5,
            most: window.columns.end as f64 + 0.5,
            doubt,
        }
    }

    #[inline(always)]
    fn of_rows(&self, row: usize) -> Batch {
        let mut batch = Batch { start: [0; LANES], end: [0; LANES], doubt: [0; LANES] };
        let below = (row - self.first_row) as f64;
        let (mut left, mut right) = ([self.least; LANES], [self.most; LANES]);
        for k in 0..3 {
            let at = self.at[k] + self.step[k] * below;
            if self.bounds_left[k] {
                for i in 0..LANES {
                    let cut = at + self.step[k] * i as f64 - self.shift[i];
                    left[i] = if cut > left[i] { cut } else { left[i] };
                }
            } else {
                for i in 0..LANES {
                    let cut = at + self.step[k] * i as f64 - self.shift[i];
                    right[i] = if cut < right[i] { cut } else { right[i] };
                }
            }
        }
        let sure = 0.5 - self.doubt;
        for i in 0..LANES {
            let start = if left[i] < self.most { left[i] } else { self.most } + 0.5;
            let end = if right[i] > self.least { right[i] } else { self.least } - 0.5;
            let (start_rounded, end_rounded) = (start + ROUNDER, end + ROUNDER);
            // Both count columns plus one.
            batch.start[i] = (start_rounded.to_bits() as u32).wrapping_sub(1);
            batch.end[i] = end_rounded.to_bits() as u32;
            let is_sure =
                ((start - (start_rounded - ROUNDER)).abs() <= sure) & ((end - (end_rounded - ROUNDER)).abs() <= sure);
            batch.doubt[i] = u32::from(!is_sure);
        }
        batch
    }
}

impl Batch {
    /// Looks exactly where a cut lies too near to a sample.
    #[inline(always)]
    fn settle_doubts(&mut self, grid: &PinholeGrid, edges: &[DVec3; 3], window: &Window, top: usize) {
        if self.doubt.iter().fold(0, |all, d| all | d) == 0 {
            return;
        }
        for i in 0..BLOCK {
            if self.doubt[i] != 0 && window.rows.contains(&(top + i)) {
                let columns = grid.span(edges, top + i, window.columns.clone());
                (self.start[i], self.end[i]) = (columns.start as u32, columns.end as u32);
            }
        }
    }

    /// Empties the rows outside of the window and finds the columns of the others.
    #[inline(always)]
    fn columns(&mut self, window: &Window, top: usize) -> (u32, u32) {
        let (first, last) = (window.rows.start.max(top) - top, window.rows.end.min(top + BLOCK) - top);
        let (mut start, mut end) = (u32::MAX, 0);
        for i in 0..BLOCK {
            let is_out = (i as u32) < first as u32 || i as u32 >= last as u32 || self.start[i] >= self.end[i];
            self.start[i] |= u32::from(is_out).wrapping_neg();
            self.end[i] &= u32::from(!is_out).wrapping_neg();
        }
        for i in 0..BLOCK {
            start = start.min(self.start[i]);
            end = end.max(self.end[i]);
        }
        (start, end)
    }
}

/// What came of drawing, by lanes: not 0 where something was nearer, and where something was at the same depth.
#[derive(Default)]
struct Outcome {
    nearer: [u32; BLOCK],
    equal: [u32; BLOCK],
}

impl Outcome {
    #[inline(always)]
    fn any(lanes: &[u32; BLOCK]) -> bool {
        lanes.iter().fold(0, |all, lane| all | lane) != 0
    }
}

/// Draws the spans of a batch on the block whose first column is `left`; nearness = slope * x + rest.
#[inline(always)]
fn draw_block(
    block: &mut Block,
    batch: &Batch,
    left: u32,
    x: [&[f64; BLOCK]; 2],
    slope: f64,
    rests: &[f64; BLOCK],
    id: u32,
) -> Outcome {
    let mut outcome = Outcome::default();
    for row in 0..BLOCK {
        let (start, end) = (batch.start[row].max(left) - left, batch.end[row].min(left + 8).saturating_sub(left));
        if start >= end {
            continue;
        }
        let outside = &OUTSIDE[(start & 7) as usize][(end & 15) as usize];
        let (old, old_ids) = (block.nearness[row], block.face[row]);
        let mut value = [0.0_f32; BLOCK];
        for i in 0..BLOCK {
            // NaN outside, which is neither nearer nor equal.
            value[i] = f32::from_bits(((slope * x[row % 2][i] + rests[row]) as f32).to_bits() | outside[i]);
        }
        let (mut nearer, mut new, mut new_ids) = ([0; BLOCK], [0.0; BLOCK], [0; BLOCK]);
        for i in 0..BLOCK {
            nearer[i] = u32::from(value[i] > old[i]).wrapping_neg();
        }
        for i in 0..BLOCK {
            new[i] = if value[i] > old[i] { value[i] } else { old[i] };
        }
        for i in 0..BLOCK {
            new_ids[i] = id & nearer[i] | old_ids[i] & !nearer[i];
        }
        (block.nearness[row], block.face[row]) = (new, new_ids);
        for i in 0..BLOCK {
            outcome.nearer[i] |= nearer[i];
        }
        for i in 0..BLOCK {
            outcome.equal[i] |= u32::from(value[i] == old[i]).wrapping_neg();
        }
    }
    outcome
}

/// Gives the samples of a block that two faces meet at the same depth to the earlier one.
#[cold]
fn settle_ties(
    block: &mut Block,
    batch: &Batch,
    left: u32,
    x: [&[f64; BLOCK]; 2],
    slope: f64,
    rests: &[f64; BLOCK],
    id: u32,
    faces: &[DrawnFace],
) {
    let key = |id: u32| (faces[id as usize].instance, faces[id as usize].face);
    for row in 0..BLOCK {
        for i in 0..BLOCK {
            let inside = (batch.start[row]..batch.end[row]).contains(&(left + i as u32));
            let value = (slope * x[row % 2][i] + rests[row]) as f32;
            let owner = &mut block.face[row][i];
            if inside && value == block.nearness[row][i] && value > 0.0 && key(id) < key(*owner) {
                *owner = id;
            }
        }
    }
}

/// For each start and end of a span, all bits of the lanes outside.
static OUTSIDE: [[[u32; BLOCK]; 16]; BLOCK] = {
    let mut out = [[[0; BLOCK]; 16]; BLOCK];
    let (mut start, mut end, mut lane) = (0, 0, 0);
    while start < BLOCK {
        out[start][end][lane] = if lane < start || lane >= end { u32::MAX } else { 0 };
        lane += 1;
        if lane == BLOCK {
            (lane, end) = (0, end + 1);
        }
        if end == 16 {
            (end, start) = (0, start + 1);
        }
    }
    out
};
