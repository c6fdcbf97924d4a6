//! Draws triangles into the visibility buffer of a camera.
//!
//! The inside test is that of [`super::BeamGrid::cover`], bit for bit. What differs from casting onto any grid: depths are
//! compared as 1 / z, which is affine on the image; rows find their spans together; a hierarchy of depths hides clusters
//! and triangles; and panes are drawn in the same pass as what is solid.

use std::ops::Range;

use multiversion::multiversion;

use super::edges::EdgePlanes;
use super::grid::{BeamGrid, Window};
use super::pinhole::PinholeGrid;
use super::posed::{PosedInstance, PosedScene};
use super::visibility_buffer::{DrawnFace, LANES, Surfaces, VisibilityBuffer};
use crate::geometry::{Cluster, slot_bit};
use crate::math::{DMat3, DVec3, Vec3};

/// Draws all triangles of a scene as the samples of `grid` see them; `buffer` forgets what it held.
///
/// Of two surfaces at the same depth the earlier instance and face is seen. Triangles have two sides. The order of the
/// work does not show in the outcome.
pub fn draw(scene: &PosedScene, grid: &PinholeGrid, buffer: &mut VisibilityBuffer) {
    buffer.reset(grid.rows(), grid.columns());
    let pose = grid.world_from_grid();
    let cam_from_world = DMat3::from_quat(pose.rotation).transpose();
    let near_first = clusters_in_view(scene, grid, cam_from_world, pose.translation);
    let mut drawer = Drawer {
        scene,
        grid,
        buffer,
        cam_from_world,
        eye_world: pose.translation,
        columns_x: grid.padded_columns_x(LANES),
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

fn clusters_in_view(scene: &PosedScene, grid: &PinholeGrid, cam_from_world: DMat3, eye_world: DVec3) -> Vec<InView> {
    let mut out = Vec::new();
    for (index, instance) in scene.instances.iter().enumerate() {
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
    /// As the grid's, and [`LANES`] more.
    columns_x: Vec<f64>,
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
        let is_mixed = (cluster.slots & item.glass != 0 && cluster.slots & !item.glass != 0) || cluster.slots >> 63 != 0;
        for (corners, face) in cluster.corners.iter().zip(&cluster.faces) {
            let corners = corners.map(|i| self.corners[usize::from(i)]);
            let ([window, _], z_m) = (
                self.grid.windows(|| corners.map(|c| c.cam.as_vec3()), &corners.map(|c| c.footprint)),
                corners[0].z_m.min(corners[1].z_m).min(corners[2].z_m),
            );
            if window.is_empty() || self.buffer.is_hidden(&window, z_m) {
                continue;
            }
            let planes = EdgePlanes::new(corners.map(|c| c.cam));
            if planes.volume == 0.0 {
                continue;
            }
            let is_pane =
                if is_mixed { instance.material(*face).is_glass() } else { cluster.slots & item.glass != 0 };
            self.draw_face(&planes, &window, item.instance, *face, is_pane);
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
                let [x, y, z] = [
                    f64::from(world[0][i]) - o.x,
                    f64::from(world[1][i]) - o.y,
                    f64::from(world[2][i]) - o.z,
                ];
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
    fn draw_face(&mut self, planes: &EdgePlanes, window: &Window, instance: u32, face: u32, is_pane: bool) {
        let sign = if planes.volume > 0.0 { 1.0 } else { -1.0 };
        let edges = planes.cross.map(|n| n * sign);
        let normal = planes.normal * sign;
        let volume = planes.volume.abs();
        let per_volume = 1.0 / volume;
        let id = self.buffer.faces.len() as u32;
        self.buffer.faces.push(DrawnFace { instance, face, normal: normal.to_array(), volume });
        let (slope, down, rest) = (normal.x * per_volume, normal.y * per_volume, normal.z * per_volume);
        let spans = Spans::new(&edges, self.grid, window);
        let stride = self.buffer.stride;
        let layer = if is_pane { &mut self.buffer.panes } else { &mut self.buffer.solid };
        let mut drawn = false;
        let mut first = window.rows.start;
        while first < window.rows.end {
            let batch = spans.of_rows(first);
            for i in 0..LANES.min(window.rows.end - first) {
                let row = first + i;
                let mut columns = batch.start[i] as usize..batch.end[i] as usize;
                let y = self.grid.row_y(row);
                if batch.doubt[i] != 0 {
                    columns = self.grid.span(&edges, y, window.columns.clone());
                }
                if columns.start < columns.end {
                    let rest = down * y + rest;
                    let span = Span { base: row * stride, columns, slope, rest, id };
                    drawn |= draw_span(layer, &span, &self.columns_x, &self.buffer.faces);
                }
            }
            first += LANES;
        }
        if drawn && is_pane {
            self.buffer.mark_panes(window);
        } else if drawn {
            self.buffer.mark_stale(window);
        }
    }
}

/// Where the edges of a triangle cut the rows of its window.
struct Spans {
    /// Column plus one where each edge cuts the window's first row, and how much further it does a row below. Edges that
    /// bound the left come first.
    at: [f64; 3],
    step: [f64; 3],
    bounds_left: [bool; 3],
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
        let y = grid.row_y(window.rows.start);
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
            first_row: window.rows.start,
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
                    let cut = at + self.step[k] * i as f64;
                    left[i] = if cut > left[i] { cut } else { left[i] };
                }
            } else {
                for i in 0..LANES {
                    let cut = at + self.step[k] * i as f64;
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
            let is_sure = ((start - (start_rounded - ROUNDER)).abs() <= sure)
                & ((end - (end_rounded - ROUNDER)).abs() <= sure);
            batch.doubt[i] = u32::from(!is_sure);
        }
        batch
    }
}

/// A piece of a row that a face covers.
struct Span {
    /// Where the row starts.
    base: usize,
    columns: Range<usize>,
    /// Nearness = slope * x + rest.
    slope: f64,
    rest: f64,
    id: u32,
}

#[inline(always)]
fn draw_span(layer: &mut Surfaces, span: &Span, columns_x: &[f64], faces: &[DrawnFace]) -> bool {
    let mut drawn = false;
    let mut column = span.columns.start;
    while column < span.columns.end {
        let at = span.base + column;
        let (Some(x), Some(nearness), Some(id)) = (
            columns_x[column..].first_chunk::<LANES>(),
            layer.nearness[at..].first_chunk_mut::<LANES>(),
            layer.face[at..].first_chunk_mut::<LANES>(),
        ) else {
            return drawn;
        };
        let left = (span.columns.end - column) as u32;
        let mut value = [0.0_f32; LANES];
        let mut nearer = [0_u32; LANES];
        let mut equal = [0_u32; LANES];
        for i in 0..LANES {
            value[i] = (span.slope * x[i] + span.rest) as f32;
            let inside = (i as u32) < left;
            nearer[i] = if inside & (value[i] > nearness[i]) { u32::MAX } else { 0 };
            equal[i] = if inside & (value[i] == nearness[i]) { u32::MAX } else { 0 };
        }
        if equal.iter().fold(0, |all, e| all | e) != 0 {
            let key = |id: u32| (faces[id as usize].instance, faces[id as usize].face);
            for i in 0..LANES {
                if equal[i] != 0 && key(span.id) < key(id[i]) {
                    nearer[i] = u32::MAX;
                }
            }
        }
        let mut any = 0;
        for i in 0..LANES {
            any |= nearer[i];
            nearness[i] = if nearer[i] != 0 { value[i] } else { nearness[i] };
            id[i] = if nearer[i] != 0 { span.id } else { id[i] };
        }
        drawn |= any != 0;
        column += LANES;
    }
    drawn
}
