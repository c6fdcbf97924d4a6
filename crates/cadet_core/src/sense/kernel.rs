//! The visibility kernel: which triangle each beam of a grid meets first.

use super::edges::EdgePlanes;
use super::grid::{BeamGrid, LANES, Lanes};
use super::posed::{PosedInstance, PosedScene};
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
    let mut near_first: Vec<(f64, usize)> = Vec::with_capacity(scene.instances.len());
    for (index, instance) in scene.instances.iter().enumerate() {
        let center_grid = to_grid.rotation * (instance.center_world - to_grid.origin_world);
        if keep(instance) && grid.sees_sphere(center_grid, instance.radius_m) {
            near_first.push((center_grid.length() - instance.radius_m, index));
        }
    }
    near_first.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut scratch = Scratch { points_grid: Vec::new(), footprints: Vec::new() };
    for (_, index) in near_first {
        cast_instance(scene, index, grid, &to_grid, layer, &mut scratch, hits);
    }
}

struct Scratch<F> {
    points_grid: Vec<Vec3>,
    footprints: Vec<F>,
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
    fn lanes(&self, vertices_world: &[Vec3; LANES]) -> Lanes {
        let mut d = [[0.0_f32; LANES]; 3];
        for i in 0..LANES {
            d[0][i] = (vertices_world[i].x - self.origin_high.x) - self.origin_low.x;
            d[1][i] = (vertices_world[i].y - self.origin_high.y) - self.origin_low.y;
            d[2][i] = (vertices_world[i].z - self.origin_high.z) - self.origin_low.z;
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

fn cast_instance<G: BeamGrid>(
    scene: &PosedScene,
    index: usize,
    grid: &G,
    to_grid: &ToGrid,
    layer: Layer,
    scratch: &mut Scratch<G::Footprint>,
    hits: &mut Hits,
) {
    let instance = &scene.instances[index];
    let Some(slots) = SlotFilter::new(instance, layer) else { return };
    let vertices_world = &scene.vertices_world[instance.vertices.clone()];
    project(grid, to_grid, vertices_world, scratch);
    let (points_grid, footprints) = (&scratch.points_grid[..], &scratch.footprints[..]);
    for (face, corners) in instance.mesh.faces.iter().enumerate() {
        let corners = corners.map(|i| i as usize);
        let windows = grid.windows(|| corners.map(|i| points_grid[i]), &corners.map(|i| footprints[i]));
        if windows[0].is_empty() && windows[1].is_empty() {
            continue;
        }
        if !slots.accepts(instance.mesh.slots[face]) {
            continue;
        }
        let exact = corners.map(|i| to_grid.rotation * (vertices_world[i].as_dvec3() - to_grid.origin_world));
        let planes = EdgePlanes::new(exact);
        for window in windows.iter().filter(|w| !w.is_empty()) {
            grid.cover(&planes, window, |at, depth| {
                hits.keep_nearer(at, depth as f32, index as u32, face as u32);
            });
        }
    }
}

/// Fills the scratch with the instance's vertices, in the grid's frame and on the grid.
fn project<G: BeamGrid>(grid: &G, to_grid: &ToGrid, vertices_world: &[Vec3], scratch: &mut Scratch<G::Footprint>) {
    scratch.points_grid.clear();
    scratch.footprints.clear();
    let mut project_chunk = |chunk: &[Vec3; LANES], n: usize| {
        let lanes = to_grid.lanes(chunk);
        let mut footprints = [G::Footprint::default(); LANES];
        grid.footprints(&lanes, &mut footprints);
        scratch.footprints.extend_from_slice(&footprints[..n]);
        scratch.points_grid.extend((0..n).map(|i| Vec3::new(lanes[0][i], lanes[1][i], lanes[2][i])));
    };
    let (chunks, rest) = vertices_world.as_chunks::<LANES>();
    for chunk in chunks {
        project_chunk(chunk, LANES);
    }
    if let Some(first) = rest.first() {
        let mut padded = [*first; LANES];
        padded[..rest.len()].copy_from_slice(rest);
        project_chunk(&padded, rest.len());
    }
}

/// Which material slots of an instance belong to the layer.
enum SlotFilter {
    Every,
    Some(Vec<bool>),
}

impl SlotFilter {
    /// None where no slot does.
    fn new(instance: &PosedInstance, layer: Layer) -> Option<Self> {
        let accepts: Vec<bool> = match layer {
            Layer::All => return Some(Self::Every),
            Layer::Opaque => instance.palette.0.iter().map(|m| !m.is_glass()).collect(),
            Layer::Glass => instance.palette.0.iter().map(crate::material::Material::is_glass).collect(),
        };
        match (accepts.iter().any(|a| *a), accepts.iter().all(|a| *a)) {
            (false, _) => None,
            (true, true) => Some(Self::Every),
            (true, false) => Some(Self::Some(accepts)),
        }
    }

    #[inline]
    fn accepts(&self, slot: u8) -> bool {
        match self {
            Self::Every => true,
            Self::Some(accepts) => accepts[usize::from(slot)],
        }
    }
}
