//! Draws triangles into the visibility buffer of a camera.
//!
//! The inside test is that of [`crate::sense::BeamGrid::cover`], bit for bit. What differs from casting onto any grid: depths
//! are compared as 1 / z, which is affine on the image; blocks of 8 x 8 samples are drawn together; a hierarchy of depths
//! hides clusters and triangles; and transparent surfaces are drawn in the same pass as opaque ones.

use std::ops::Range;

use macro_rules_attribute::{apply, derive};

use super::block_rasterization::{ExactBlock, FaceOnImage};
use super::outline::FacePlanes;
use super::visibility_buffer::{BLOCK, CLEARLY_NEARER_RATIO, VisibilityBuffer, within_block};
use crate::sense::cluster_culling::{VisibleCluster, sort_by_depth, visible_clusters};
use crate::sense::grids::{BeamGrid, PinholeGrid, ToGrid, Window};
use crate::sense::scene::{PosedInstance, PosedScene};
use crate::wide_registers::array_of;
use crate::zeros::DefaultZeros;
use cadet_base::geometry::{CLUSTER_VERTICES, Cluster, LANES, face_number};
use cadet_base::math::{DVec3, greater, lesser};

/// [`rasterize_instances`], of every instance.
pub fn rasterize(scene: &PosedScene, grid: &PinholeGrid, buffer: &mut VisibilityBuffer) {
    rasterize_instances(scene, grid, 0..scene.instances.len(), buffer);
}

/// Draws the triangles of some instances (indices into [`PosedScene::instances`]) as the samples of `grid` see them;
/// `buffer` forgets what it held.
///
/// Of two surfaces at the same depth the one drawn first is seen: that of the nearer cluster, then of the earlier instance,
/// cluster and face. Triangles have two sides, but for those of closed surfaces around which the camera is outside.
pub fn rasterize_instances(
    scene: &PosedScene,
    grid: &PinholeGrid,
    instances: impl Iterator<Item = usize>,
    buffer: &mut VisibilityBuffer,
) {
    buffer.reset(grid.rows(), grid.columns());
    let to_grid = ToGrid::new(grid);
    let mut clusters = visible_clusters(scene, grid, &to_grid, |_| 0.0, instances.map(|index| (index, u64::MAX)));
    sort_by_depth(&mut clusters);
    let mut rasterizer = Rasterizer {
        scene,
        grid,
        buffer,
        to_grid,
        columns_x: grid.padded_columns_x(BLOCK),
        rows_y: grid.padded_rows_y(BLOCK),
        corners: Box::default(),
    };
    draw_clusters(&mut rasterizer, &clusters);
}

/// Share of a point's coordinates by which single precision may err in its z.
const SLACK: f32 = 1e-6;

/// The vertices of the cluster at hand, axis by axis.
#[derive(DefaultZeros!)]
struct VerticesOnImage {
    cam: [[f64; CLUSTER_VERTICES]; 3],
    /// Clamped to just outside of the image; NaN where a vertex is not clearly in front.
    column: [f32; CLUSTER_VERTICES],
    row: [f32; CLUSTER_VERTICES],
    /// A little less than z.
    z_m: [f32; CLUSTER_VERTICES],
}

struct Rasterizer<'a> {
    scene: &'a PosedScene,
    grid: &'a PinholeGrid,
    buffer: &'a mut VisibilityBuffer,
    to_grid: ToGrid,
    /// As the grid's, to the ends of the last blocks.
    columns_x: [Vec<f64>; 2],
    rows_y: Vec<f64>,
    corners: Box<VerticesOnImage>,
}

/// A face that may be seen.
struct FaceCandidate {
    instance: u32,
    face: u32,
    is_transparent: bool,
    has_one_side: bool,
    window: Window,
    least_z_m: f32,
    most_z_m: f32,
}

#[apply(for_wide_registers)]
fn draw_clusters(rasterizer: &mut Rasterizer<'_>, front_to_back: &[VisibleCluster]) {
    for item in front_to_back {
        let [window, _] = item.windows();
        if !rasterizer.buffer.is_hidden(&window, item.near_m) {
            rasterizer.draw_cluster(item);
        }
    }
}

impl Rasterizer<'_> {
    #[inline(always)]
    fn draw_cluster(&mut self, item: &VisibleCluster) {
        let instance = &self.scene.instances[item.instance as usize];
        let cluster = &instance.mesh.clusters.get(item.cluster as usize);
        self.project(instance, cluster);
        let transparent_slots = instance.palette.transparent_slots();
        // Bit 63 may stand for several slots.
        let is_mixed = (cluster.slots & transparent_slots != 0 && cluster.slots & !transparent_slots != 0)
            || cluster.slots >> 63 != 0;
        let one_sided = if item.is_solid { cluster.closed_pieces } else { 0 };
        for (pieces, first) in cluster.pieces.chunks(LANES).zip((0..).step_by(LANES)) {
            let mut places = [[[0.0_f32; LANES]; 3]; 4];
            for (i, piece) in pieces.iter().enumerate() {
                for (place, corner) in places.iter_mut().zip(piece.corners) {
                    let corner = usize::from(corner);
                    place[0][i] = self.corners.column[corner];
                    place[1][i] = self.corners.row[corner];
                    place[2][i] = self.corners.z_m[corner];
                }
            }
            let [a, b, c, d] = &places;
            let windows = self.grid.window_lanes([&a[0], &b[0], &c[0], &d[0]], [&a[1], &b[1], &c[1], &d[1]]);
            let [least_z_m, most_z_m] = z_bounds(&places);
            let one_sided = one_sided >> first & 0xFF;
            let is_turned_away = if one_sided == 0 { [false; LANES] } else { self.turned_away(&places) };
            for (i, piece) in pieces.iter().enumerate() {
                let has_one_side = one_sided >> i & 1 == 1;
                if !windows.may_meet[i] || is_turned_away[i] & has_one_side {
                    continue;
                }
                let [x, y, z] = &self.corners.cam;
                let corners: [DVec3; 4] = array_of(|k| {
                    let i = usize::from(piece.corners[k]);
                    DVec3::new(x[i], y[i], z[i])
                });
                let window = windows.of_lane(i, self.grid, &corners);
                if window.is_empty() || self.buffer.is_hidden(&window, least_z_m[i]) {
                    continue;
                }
                let first = usize::from(piece.first);
                let face = face_number(item.cluster, first);
                let is_transparent = if is_mixed {
                    instance.palette.materials()[usize::from(cluster.faces[first].slot)].is_transparent()
                } else {
                    cluster.slots & transparent_slots != 0
                };
                let (least_z_m, most_z_m) = (least_z_m[i], most_z_m[i]);
                let mut candidate = FaceCandidate {
                    instance: item.instance,
                    face,
                    is_transparent,
                    has_one_side,
                    window,
                    least_z_m,
                    most_z_m,
                };
                let [a, b, c, d] = corners;
                if !piece.is_quad() {
                    self.draw_face(&candidate, &FacePlanes::triangle([a, b, c]));
                } else if let Some(outline) = FacePlanes::quad(corners) {
                    self.draw_face(&candidate, &outline);
                } else {
                    self.draw_face(&candidate, &FacePlanes::triangle([a, b, c]));
                    candidate.face = face_number(item.cluster, first + 1);
                    self.draw_face(&candidate, &FacePlanes::triangle([a, c, d]));
                }
            }
        }
    }

    /// True for faces that show their backs for certain; needs no more than where their corners fall on the image.
    #[inline(always)]
    fn turned_away(&self, [a, b, c, _]: &[[[f32; LANES]; 3]; 4]) -> [bool; LANES] {
        let (right, bottom) = (self.grid.columns() as f32, self.grid.rows() as f32);
        let mut is_turned_away = [false; LANES];
        for i in 0..LANES {
            // Beyond the image corners are moved to its rim.
            let is_known =
                |p: &[[f32; LANES]; 3]| (p[0][i] > -2.0) & (p[1][i] > -2.0) & (p[0][i] <= right) & (p[1][i] <= bottom);
            let (ux, uy) = (b[0][i] - a[0][i], b[1][i] - a[1][i]);
            let (vx, vy) = (c[0][i] - a[0][i], c[1][i] - a[1][i]);
            // Corners err by less than a hundredth of a sample.
            let doubt = 0.02 * (ux.abs() + uy.abs() + vx.abs() + vy.abs() + 0.01);
            let area = ux * vy - uy * vx;
            is_turned_away[i] = (area > doubt) & is_known(a) & is_known(b) & is_known(c);
        }
        is_turned_away
    }

    /// Poses a cluster's vertices and finds where they fall on the image.
    #[inline(always)]
    fn project(&mut self, instance: &PosedInstance, cluster: &Cluster<'_>) {
        let corners = &mut *self.corners;
        for (local, at) in cluster.lanes.iter().zip((0..CLUSTER_VERTICES).step_by(LANES)) {
            let cam = self.to_grid.lanes(&instance.placement.pose_lanes(local));
            for (axis, cam) in corners.cam.iter_mut().zip(&cam) {
                axis[at..at + LANES].copy_from_slice(cam);
            }
            let at_once: [[f32; LANES]; 3] = array_of(|axis| array_of(|i| cam[axis][i] as f32));
            let (Some(column), Some(row), Some(z_m)) = (
                corners.column[at..].first_chunk_mut::<LANES>(),
                corners.row[at..].first_chunk_mut::<LANES>(),
                corners.z_m[at..].first_chunk_mut::<LANES>(),
            ) else {
                return;
            };
            self.grid.footprint_lanes(&at_once, column, row);
            let [x, y, z] = &at_once;
            for i in 0..LANES {
                z_m[i] = z[i] - SLACK * (x[i].abs() + y[i].abs() + z[i].abs());
            }
        }
    }

    #[inline(always)]
    fn draw_face(&mut self, candidate: &FaceCandidate, outline: &FacePlanes) {
        if outline.volume6_m3 > 0.0 && candidate.has_one_side {
            return;
        }
        let Some(on_image) = FaceOnImage::new(outline, self.grid, candidate.most_z_m) else {
            return;
        };
        let (window, z_m) = (&candidate.window, candidate.least_z_m);
        let id = self.buffer.faces.len() as u32;
        let mut is_drawn = false;
        for block_row in window.rows.start / BLOCK..=(window.rows.end - 1) / BLOCK {
            let Some(rows_y) = self.rows_y[block_row * BLOCK..].first_chunk::<BLOCK>() else { break };
            let rows = within_block(&window.rows, block_row);
            let y = (rows_y[0] + rows_y[BLOCK - 1]) * 0.5;
            for block_column in self.block_columns(&on_image, window, y) {
                let left = block_column * BLOCK;
                let [evens, odds] = &self.columns_x;
                let (Some(even), Some(odd)) =
                    (evens[left..].first_chunk::<BLOCK>(), odds[left..].first_chunk::<BLOCK>())
                else {
                    break;
                };
                let exact = ExactBlock { columns_x: [even, odd], rows_y };
                let at = on_image.at((even[0] + odd[BLOCK - 1]) * 0.5, y);
                let number = block_row * self.buffer.blocks_across + block_column;
                if on_image.misses(&at)
                    || self.buffer.states[number].least_inverse_depth_per_m
                        > on_image.most_inverse_depth_per_m(&at) * CLEARLY_NEARER_RATIO
                    || self.buffer.is_block_hidden(number, z_m)
                {
                    continue;
                }
                let drawn =
                    on_image.draw(self.buffer.block_mut(number, candidate.is_transparent), &rows, &at, id, &exact);
                self.buffer.note_drawn(number, candidate.is_transparent, id, drawn);
                is_drawn |= drawn != 0;
            }
        }
        if is_drawn {
            self.buffer.faces.push(on_image.drawn([candidate.instance, candidate.face]));
        }
    }

    /// The columns of blocks that a triangle may meet in the row of blocks whose middles lie at this y / z.
    #[inline(always)]
    fn block_columns(&self, on_image: &FaceOnImage, window: &Window, y: f64) -> Range<usize> {
        let (mut first, mut end) = (window.columns.start / BLOCK, (window.columns.end - 1) / BLOCK + 1);
        if end - first > WIDE {
            let column = |x: f64| (x * self.grid.column_scale + self.grid.offset_columns) / BLOCK as f64;
            let [from, to] = on_image.span(y);
            // The middle of a block lies less than one block right of its first column.
            first = first.max(column(from).max(1.0) as usize - 1);
            end = end.min((column(to) + 1.0).max(0.0) as usize);
        }
        first..end
    }
}

/// Windows of more blocks than this side by side are narrowed row by row.
const WIDE: usize = 3;

/// The least and the largest z of faces' corners.
#[inline(always)]
fn z_bounds(corners: &[[[f32; LANES]; 3]; 4]) -> [[f32; LANES]; 2] {
    let (mut least, mut most) = (corners[0][2], corners[0][2]);
    for corner in &corners[1..] {
        least = array_of(|i| lesser(corner[2][i], least[i]));
        most = array_of(|i| greater(corner[2][i], most[i]));
    }
    [least, most]
}
