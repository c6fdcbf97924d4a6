//! The clusters that a grid may see, the near ones first.

use crate::sense::grids::{BeamGrid, ToGrid, Window};
use crate::sense::scene::PosedScene;
use cadet_base::math::Vec3;

/// A cluster in view.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct VisibleCluster {
    /// A depth below that of its every point, meters.
    pub near_m: f32,
    /// Of the middle: what is large reaches far beyond its nearest point, and hides little.
    order_m: f32,
    pub instance: u32,
    pub cluster: u32,
    /// All beams start outside of the mesh, and closed surfaces hide their inner sides.
    pub is_solid: bool,
    /// First row, end of rows, first column, end of columns: half as long as [`Window`]s, as there are many.
    windows: [[u32; 4]; 2],
}

impl VisibleCluster {
    #[inline(always)]
    pub(super) fn windows(&self) -> [Window; 2] {
        self.windows.map(|w| {
            let [first_row, end_row, first_column, end_column] = w.map(|v| v as usize);
            Window { rows: first_row..end_row, columns: first_column..end_column }
        })
    }
}

fn compact(window: &Window) -> [u32; 4] {
    [window.rows.start, window.rows.end, window.columns.start, window.columns.end].map(|v| v as u32)
}

/// Finds the clusters in view of some instances, each given by its index and the bits of its material slots that are
/// noticed. `moves_m` says how far an instance may move until it is met.
pub(super) fn visible_clusters<G: BeamGrid>(
    scene: &PosedScene,
    grid: &G,
    to_grid: &ToGrid,
    moves_m: impl Fn(usize) -> f32,
    instances: impl Iterator<Item = (usize, u64)>,
) -> Vec<VisibleCluster> {
    let mut out = Vec::with_capacity(4 * scene.instances.len());
    for (index, slots) in instances {
        let (instance, moves_m) = (&scene.instances[index], moves_m(index));
        let reach_m = grid.most_offset_m() as f32 + OUTSIDE_M + moves_m;
        let center_grid = to_grid.rotation * (instance.center_world - to_grid.origin_world);
        let radius_m = loosened(instance.radius_m as f32, center_grid.as_vec3()) + moves_m;
        let (windows, _) = grid.sphere_windows(center_grid.as_vec3(), radius_m);
        if slots == 0 || windows.iter().all(Window::is_empty) {
            continue;
        }
        let grid_from_local = to_grid.rotation * instance.placement.rotation;
        let origin_grid = center_grid - grid_from_local * instance.mesh.bounds.center().as_dvec3();
        let (linear, offset) = (grid_from_local.as_mat3(), origin_grid.as_vec3());
        let origin_local =
            instance.placement.rotation.transpose() * (to_grid.origin_world - instance.placement.translation);
        let origin_local = origin_local.as_vec3();
        let is_outside = !instance.mesh.bounds.grown(reach_m).contains(origin_local);
        let transparent_slots = instance.palette.transparent_slots();
        for (number, cluster) in instance.mesh.clusters.summaries().iter().enumerate() {
            let is_solid = is_outside && cluster.is_of_solid(transparent_slots);
            if cluster.slots & slots == 0
                || is_solid
                    && cluster.normal_cone.is_turned_away(cluster.center, cluster.radius_m, origin_local, reach_m)
            {
                continue;
            }
            let center_grid = linear * cluster.center + offset;
            let (windows, near_m) = grid.sphere_windows(center_grid, loosened(cluster.radius_m, center_grid) + moves_m);
            if windows.iter().any(|w| !w.is_empty()) {
                out.push(VisibleCluster {
                    near_m,
                    order_m: near_m + cluster.radius_m,
                    instance: index as u32,
                    cluster: number as u32,
                    is_solid,
                    windows: [compact(&windows[0]), compact(&windows[1])],
                });
            }
        }
    }
    out
}

/// How far outside of a mesh's bounds a beam's origin is sure to be outside of the mesh.
const OUTSIDE_M: f32 = 1e-3;

/// Depths beyond these have no order among themselves.
const NEAREST_M: f32 = 0.03;
const FARTHEST_M: f32 = 131_072.0;

/// Sorts clusters by depth, and those of one depth by their numbers.
pub(super) fn sort_by_depth(clusters: &mut [VisibleCluster]) {
    let numbers = |v: &VisibleCluster| (v.instance, v.cluster);
    clusters.sort_unstable_by(|a, b| a.order_m.total_cmp(&b.order_m).then(numbers(a).cmp(&numbers(b))));
}

/// The clusters in the order of depth, so nearly that it makes no difference: in steps of 1/128 of the depth, equal ones
/// as they come.
pub(super) fn front_to_back(clusters: &[VisibleCluster]) -> Vec<VisibleCluster> {
    // The high bits of a positive number rise with it: its exponent and the first bits of its fraction.
    let high_bits = |depth: f32| (depth.to_bits() >> 16) as usize;
    let least = high_bits(NEAREST_M);
    let key = |v: &VisibleCluster| high_bits(v.order_m.clamp(NEAREST_M, FARTHEST_M)) - least;
    let mut starts = vec![0_u32; high_bits(FARTHEST_M) - least + 2];
    clusters.iter().for_each(|v| starts[key(v) + 1] += 1);
    let mut sum = 0;
    for start in &mut starts {
        sum += *start;
        *start = sum;
    }
    let mut sorted = vec![VisibleCluster::default(); clusters.len()];
    for v in clusters {
        let place = &mut starts[key(v)];
        sorted[*place as usize] = *v;
        *place += 1;
    }
    sorted
}

/// A radius that covers the rounding of vertices to single precision, world coordinates of some kilometres included.
#[inline]
fn loosened(radius_m: f32, center_grid: Vec3) -> f32 {
    radius_m * 1.000_01 + 1e-3 + 1e-6 * center_grid.abs().max_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_that_of_depth_to_a_hundredth() {
        let depth = |i: u32| (i * 7919 % 1000) as f32 * 0.3 - 20.0;
        let item = |i| VisibleCluster { order_m: depth(i), instance: i, ..VisibleCluster::default() };
        let mut clusters: Vec<VisibleCluster> = (0..1000).map(item).collect();
        clusters[3].order_m = f32::INFINITY;
        let order = front_to_back(&clusters);
        let mut seen: Vec<u32> = order.iter().map(|v| v.instance).collect();
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(i, n)| i as u32 == *n));
        for pair in order.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|v| v.order_m.max(NEAREST_M));
            assert!(a <= b * 1.008, "{a} before {b}");
        }
        assert_eq!(order[999].instance, 3);
    }
}
