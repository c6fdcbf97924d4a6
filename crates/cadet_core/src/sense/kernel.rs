//! The visibility kernel: which triangle each beam of a grid meets first.

use super::edges::EdgePlanes;
use super::grid::{BeamGrid, Window};
use super::posed::{PosedInstance, PosedScene};
use crate::geometry::{Cluster, LANES, Lanes, slot_bit};
use crate::math::{DMat3, Mat3, Vec3};

/// The instance and the face of a beam that meets nothing.
pub const NO_HIT: u32 = u32::MAX;

/// Which materials a beam notices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Every triangle.
    All,
    /// All but panes.
    Opaque,
    /// Panes alone.
    Glass,
}

/// What the beams of a grid met, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Hits {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// The grid's depth in metres: range for a LIDAR, z along the optical axis for a camera; infinite for a miss.
    pub depth: Vec<f32>,
    /// Index into [`PosedScene::instances`], [`NO_HIT`] for a miss.
    pub instance: Vec<u32>,
    /// Face of the instance's mesh, [`NO_HIT`] for a miss.
    pub face: Vec<u32>,
}

impl Hits {
    /// No hit yet.
    #[must_use]
    pub fn new(rows: usize, columns: usize) -> Self {
        let n = rows * columns;
        Self { rows, columns, depth: vec![f32::INFINITY; n], instance: vec![NO_HIT; n], face: vec![NO_HIT; n] }
    }

    /// Forgets every hit.
    pub fn clear(&mut self) {
        self.depth.fill(f32::INFINITY);
        self.instance.fill(NO_HIT);
        self.face.fill(NO_HIT);
    }

    /// Keeps the nearer hit; of two equal ones the earlier instance and face.
    #[inline]
    fn keep_nearer(&mut self, at: usize, depth: f32, instance: u32, face: u32) {
        let nearest = self.depth[at];
        if depth < nearest || (depth == nearest && (instance, face) < (self.instance[at], self.face[at])) {
            self.depth[at] = depth;
            self.instance[at] = instance;
            self.face[at] = face;
        }
    }
}

/// Adds to `hits` what the beams of `grid` meet first among the triangles of the instances that `keep` accepts.
///
/// Hits that are already there stay where they are nearer, so several casts into one `Hits` add up. A `hits` of another
/// size is replaced by an empty one. Triangles have two sides. The order of the work does not show in the outcome.
pub fn cast<G: BeamGrid>(
    scene: &PosedScene,
    grid: &G,
    layer: Layer,
    keep: impl Fn(&PosedInstance) -> bool,
    hits: &mut Hits,
) {
    if (hits.rows, hits.columns) != (grid.rows(), grid.columns()) {
        *hits = Hits::new(grid.rows(), grid.columns());
    }
    let to_grid = ToGrid::new(grid);
    let mut near_first = visible_clusters(scene, grid, &to_grid, layer, keep);
    near_first.sort_unstable_by(|a, b| {
        a.near_depth.total_cmp(&b.near_depth).then((a.instance, a.cluster).cmp(&(b.instance, b.cluster)))
    });
    let mut caster = Caster { scene, grid, to_grid, layer, scratch: Scratch::default(), hits };
    for item in &near_first {
        if !caster.is_hidden(&item.windows, item.near_depth) {
            caster.cast_cluster(item);
        }
    }
}

/// A cluster in view.
struct Visible {
    near_depth: f32,
    instance: u32,
    cluster: u32,
    windows: [Window; 2],
}

fn visible_clusters<G: BeamGrid>(
    scene: &PosedScene,
    grid: &G,
    to_grid: &ToGrid,
    layer: Layer,
    keep: impl Fn(&PosedInstance) -> bool,
) -> Vec<Visible> {
    let mut out = Vec::new();
    for (index, instance) in scene.instances.iter().enumerate() {
        if !keep(instance) {
            continue;
        }
        let slots = slots_of_layer(instance, layer);
        let center_grid = to_grid.rotation * (instance.center_world - to_grid.origin_world);
        let (windows, _) =
            grid.sphere_windows(center_grid.as_vec3(), loosened(instance.radius_m as f32, center_grid.as_vec3()));
        if slots == 0 || windows.iter().all(Window::is_empty) {
            continue;
        }
        let grid_from_local = to_grid.rotation * instance.placement.rotation;
        let origin_grid = center_grid - grid_from_local * instance.mesh.bounds.center().as_dvec3();
        let (linear, offset) = (grid_from_local.as_mat3(), origin_grid.as_vec3());
        for (number, cluster) in instance.mesh.clusters.iter().enumerate() {
            if cluster.slots & slots == 0 {
                continue;
            }
            let center_grid = linear * cluster.center + offset;
            let (windows, near_depth) = grid.sphere_windows(center_grid, loosened(cluster.radius_m, center_grid));
            if windows.iter().any(|w| !w.is_empty()) {
                out.push(Visible { near_depth, instance: index as u32, cluster: number as u32, windows });
            }
        }
    }
    out
}

/// A radius that covers the rounding of vertices to single precision, world coordinates of some kilometres included.
#[inline]
fn loosened(radius_m: f32, center_grid: Vec3) -> f32 {
    radius_m * 1.000_01 + 1e-3 + 1e-6 * center_grid.abs().max_element()
}

struct Caster<'a, G: BeamGrid> {
    scene: &'a PosedScene,
    grid: &'a G,
    to_grid: ToGrid,
    layer: Layer,
    scratch: Scratch<G::Footprint>,
    hits: &'a mut Hits,
}

/// The vertices of one cluster, in the grid's frame and on the grid.
#[derive(Default)]
struct Scratch<F> {
    points_world: Vec<Vec3>,
    points_grid: Vec<Vec3>,
    footprints: Vec<F>,
}

impl<G: BeamGrid> Caster<'_, G> {
    /// True if all beams of the windows have met something nearer than `near_depth`.
    #[inline]
    fn is_hidden(&self, windows: &[Window; 2], near_depth: f32) -> bool {
        windows.iter().filter(|w| !w.is_empty()).all(|window| {
            window.rows.clone().all(|row| {
                let start = self.grid.row_start(row);
                let depths = &self.hits.depth[start + window.columns.start..start + window.columns.end];
                // Eight at a time without a branch between them: vector registers do that.
                let mut eights = depths.chunks_exact(8);
                eights.all(|d| d.iter().fold(true, |all, d| all & (*d < near_depth)))
                    && depths[depths.len() & !7..].iter().all(|d| *d < near_depth)
            })
        })
    }

    fn cast_cluster(&mut self, item: &Visible) {
        let instance = &self.scene.instances[item.instance as usize];
        let cluster = &instance.mesh.clusters[item.cluster as usize];
        self.project(instance, cluster);
        let slots = slots_of_layer(instance, self.layer);
        // Bit 63 may stand for several slots.
        let uniform = cluster.slots & !slots == 0 && cluster.slots >> 63 == 0;
        for (corners, face) in cluster.corners.iter().zip(&cluster.faces) {
            let [i, j, k] = corners.map(usize::from);
            let (points, footprints) = (&self.scratch.points_grid, &self.scratch.footprints);
            let windows =
                self.grid.windows(|| [points[i], points[j], points[k]], &[footprints[i], footprints[j], footprints[k]]);
            if windows.iter().all(Window::is_empty) {
                continue;
            }
            if !uniform && !in_layer(instance, *face, self.layer) {
                continue;
            }
            // Most far sides of closed meshes end here.
            if self.is_hidden(&windows, item.near_depth) {
                continue;
            }
            let exact = |i: usize| {
                let p = self.scratch.points_world[i].as_dvec3();
                self.to_grid.rotation * (p - self.to_grid.origin_world)
            };
            let exact = [exact(i), exact(j), exact(k)];
            let planes = EdgePlanes::new(exact);
            for window in windows.iter().filter(|w| !w.is_empty()) {
                self.grid.cover(&planes, window, |at, depth| {
                    self.hits.keep_nearer(at, depth as f32, item.instance, *face);
                });
            }
        }
    }

    fn project(&mut self, instance: &PosedInstance, cluster: &Cluster) {
        self.scratch.points_world.clear();
        self.scratch.points_grid.clear();
        self.scratch.footprints.clear();
        for local in &cluster.lanes {
            let world = instance.placement.pose_lanes(local);
            let lanes = self.to_grid.lanes(&world);
            let mut footprints = [G::Footprint::default(); LANES];
            self.grid.footprints(&lanes, &mut footprints);
            self.scratch.footprints.extend_from_slice(&footprints);
            let points = |[x, y, z]: Lanes| (0..LANES).map(move |i| Vec3::new(x[i], y[i], z[i]));
            self.scratch.points_world.extend(points(world));
            self.scratch.points_grid.extend(points(lanes));
        }
    }
}

/// The bits of the material slots that belong to a layer.
fn slots_of_layer(instance: &PosedInstance, layer: Layer) -> u64 {
    if layer == Layer::All {
        return u64::MAX;
    }
    let slots = instance.palette.0.iter().zip(0_u8..);
    slots.filter(|(m, _)| m.is_glass() == (layer == Layer::Glass)).fold(0, |bits, (_, slot)| bits | slot_bit(slot))
}

fn in_layer(instance: &PosedInstance, face: u32, layer: Layer) -> bool {
    layer == Layer::All || instance.material(face).is_glass() == (layer == Layer::Glass)
}

/// World to grid: in double precision for the exact test, in single for the bounds.
struct ToGrid {
    rotation: DMat3,
    origin_world: crate::math::DVec3,
    rotation_f32: Mat3,
    origin_high: Vec3,
    origin_low: Vec3,
}

impl ToGrid {
    fn new<G: BeamGrid>(grid: &G) -> Self {
        let world_from_grid = grid.world_from_grid();
        let rotation = DMat3::from_quat(world_from_grid.rotation).transpose();
        let origin_world = world_from_grid.translation;
        let origin_high = origin_world.as_vec3();
        let origin_low = (origin_world - origin_high.as_dvec3()).as_vec3();
        Self { rotation, origin_world, rotation_f32: rotation.as_mat3(), origin_high, origin_low }
    }

    /// [`LANES`] points; the origin in two parts keeps the difference of large coordinates exact.
    #[inline]
    fn lanes(&self, [x, y, z]: &Lanes) -> Lanes {
        let mut d = [[0.0_f32; LANES]; 3];
        for i in 0..LANES {
            d[0][i] = (x[i] - self.origin_high.x) - self.origin_low.x;
            d[1][i] = (y[i] - self.origin_high.y) - self.origin_low.y;
            d[2][i] = (z[i] - self.origin_high.z) - self.origin_low.z;
        }
        let [cx, cy, cz] = [self.rotation_f32.x_axis, self.rotation_f32.y_axis, self.rotation_f32.z_axis];
        let mut out = [[0.0_f32; LANES]; 3];
        for i in 0..LANES {
            out[0][i] = cx.x * d[0][i] + cy.x * d[1][i] + cz.x * d[2][i];
            out[1][i] = cx.y * d[0][i] + cy.y * d[1][i] + cz.y * d[2][i];
            out[2][i] = cx.z * d[0][i] + cy.z * d[1][i] + cz.z * d[2][i];
        }
        out
    }
}
