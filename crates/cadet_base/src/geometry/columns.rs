//! Where a mesh has surfaces, as columns over a level grid: for light, which needs no more than heights.

use std::sync::OnceLock;

use super::cluster::{Cluster, Clusters};
use crate::math::Vec3;

/// Side of a grid's cells, meters: whichever way the grid is turned, each square meter that it covers has a cell's middle.
const PITCH_M: f32 = 0.7;
/// The most cells along a grid; what is larger has larger cells.
const MAX_CELLS: f32 = 512.0;

/// What a cluster has in a cell, local coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceColumn {
    /// Where it stands.
    pub x: f32,
    /// Where it stands.
    pub y: f32,
    /// The lowest surface.
    pub low_m: f32,
    /// The highest surface.
    pub high_m: f32,
}

/// Those of one cluster, found when they are first needed: of open country few clusters are ever near a camera.
type OfCluster = OnceLock<Box<[SurfaceColumn]>>;

/// The columns of a mesh, cluster by cluster. They follow from the mesh, so that all are equal.
#[derive(Debug, Clone, Default)]
pub(super) struct LazyColumns(OnceLock<Box<[OfCluster]>>);

impl PartialEq for LazyColumns {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl LazyColumns {
    /// The columns of a cluster.
    pub fn of(&self, clusters: &Clusters, cluster: usize) -> &[SurfaceColumn] {
        let all = self.0.get_or_init(|| vec![OfCluster::new(); clusters.len()].into());
        all[cluster].get_or_init(|| columns_of(&clusters.get(cluster)))
    }

    /// How many clusters have theirs.
    #[cfg(test)]
    fn num_found(&self) -> usize {
        self.0.get().map_or(0, |all| all.iter().filter(|columns| columns.get().is_some()).count())
    }
}

fn columns_of(cluster: &Cluster<'_>) -> Box<[SurfaceColumn]> {
    let mut grid = ColumnGrid::about(cluster);
    for face in cluster.faces {
        grid.mark_face(face.corners.map(|corner| cluster.place(corner)));
    }
    grid.columns.into_iter().filter(|c| c.low_m <= c.high_m).collect()
}

/// A grid about a cluster, seen from above.
struct ColumnGrid {
    min: [f32; 2],
    pitch_m: f32,
    cells: usize,
    columns: Vec<SurfaceColumn>,
}

impl ColumnGrid {
    fn about(cluster: &Cluster<'_>) -> Self {
        let (c, r) = (cluster.center, cluster.radius_m);
        let pitch_m = PITCH_M.max(2.0 * r / MAX_CELLS);
        let cells = (2.0 * r / pitch_m) as usize + 1;
        let half = cells as f32 * pitch_m * 0.5;
        let none = SurfaceColumn { x: 0.0, y: 0.0, low_m: f32::INFINITY, high_m: f32::NEG_INFINITY };
        Self { min: [c.x - half, c.y - half], pitch_m, cells, columns: vec![none; cells * cells] }
    }

    /// Something at a place in a cell; its first place stays, but for the middle, which goes before all others.
    fn mark(&mut self, x: usize, y: usize, low: f32, high: f32, at: Vec3) {
        let middle = self.center(x, y);
        let column = &mut self.columns[y * self.cells + x];
        if column.low_m > column.high_m || (at.x, at.y) == (middle.x, middle.y) {
            (column.x, column.y) = (at.x, at.y);
        }
        (column.low_m, column.high_m) = (column.low_m.min(low), column.high_m.max(high));
    }

    fn center(&self, x: usize, y: usize) -> Vec3 {
        let at = |i: usize, axis: usize| self.min[axis] + (i as f32 + 0.5) * self.pitch_m;
        Vec3::new(at(x, 0), at(y, 1), 0.0)
    }

    /// The cell of a coordinate.
    fn cell(&self, v: f32, axis: usize) -> usize {
        (((v - self.min[axis]) / self.pitch_m).max(0.0) as usize).min(self.cells - 1)
    }

    /// Marks the cells that a face covers.
    fn mark_face(&mut self, [a, b, c]: [Vec3; 3]) {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let (x0, x1) = (self.cell(low.x, 0), self.cell(high.x, 0));
        let (y0, y1) = (self.cell(low.y, 1), self.cell(high.y, 1));
        if x1 <= x0 + 1 && y1 <= y0 + 1 {
            let middle = (a + b + c) * (1.0 / 3.0);
            return self.mark(self.cell(middle.x, 0), self.cell(middle.y, 1), middle.z, middle.z, middle);
        }
        let normal = (b - a).cross(c - a);
        let flat_normal = Vec3::new(normal.x, normal.y, 0.0);
        if normal.z.abs() < 0.2 * normal.length() {
            // A wall: cells that its line passes.
            let reach = 0.7 * self.pitch_m * normal.length();
            for y in y0..=y1 {
                for x in x0..=x1 {
                    let middle = self.center(x, y);
                    if flat_normal.dot(middle - a).abs() <= reach {
                        // Not beyond the wall's ends and sides.
                        self.mark(x, y, low.z, high.z, middle.clamp(low, high));
                    }
                }
            }
            return;
        }
        // The plane's height at the middle of each cell inside of the triangle.
        for y in y0..=y1 {
            let Some([from, to]) = span_at(&[a, b, c], self.center(0, y).y) else { continue };
            for x in self.cell(from, 0)..=self.cell(to, 0) {
                let at = self.center(x, y);
                if at.x >= from && at.x < to {
                    let z = (a.z - flat_normal.dot(at - a) / normal.z).clamp(low.z, high.z);
                    self.mark(x, y, z, z, at);
                }
            }
        }
    }
}

/// Where a level line of the given y enters and leaves a triangle seen from above.
fn span_at(corners: &[Vec3; 3], y: f32) -> Option<[f32; 2]> {
    let mut span = [f32::INFINITY, f32::NEG_INFINITY];
    for (p, q) in [(corners[0], corners[1]), (corners[1], corners[2]), (corners[2], corners[0])] {
        if (p.y <= y) != (q.y <= y) {
            let x = p.x + (y - p.y) * (q.x - p.x) / (q.y - p.y);
            span = [span[0].min(x), span[1].max(x)];
        }
    }
    (span[0] <= span[1]).then_some(span)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::MeshBuilder;

    #[test]
    fn only_clusters_that_somebody_asks_for_have_columns() {
        let mut b = MeshBuilder::new();
        for (x, y) in (0..40).flat_map(|x| (0..40).map(move |y| (x as f32 * 30.0, y as f32 * 30.0))) {
            b.quad(
                Vec3::new(x, y, 0.0),
                Vec3::new(x + 30.0, y, 0.0),
                Vec3::new(x + 30.0, y + 30.0, 0.0),
                Vec3::new(x, y + 30.0, 0.0),
                0,
            );
        }
        let mesh = b.build("a plain of 1.4 square kilometers", 0.5);
        let lazy = LazyColumns::default();
        let columns = lazy.of(&mesh.clusters, 7).len();
        let made = || lazy.num_found();
        assert!(columns > 1000 && mesh.clusters.len() > 20 && made() == 1, "{columns}, {}", made());
        let again = lazy.of(&mesh.clusters, 7).len();
        assert!(again == columns && made() == 1);
    }

    #[test]
    fn a_slope_has_columns_at_its_height_over_all_of_its_area() {
        let mut b = MeshBuilder::new();
        let height = |x: f32, y: f32| 0.3 * x - 0.1 * y + 2.0;
        let corner = |x: f32, y: f32| Vec3::new(x, y, height(x, y));
        b.quad(corner(-10.0, -6.0), corner(10.0, -6.0), corner(10.0, 6.0), corner(-10.0, 6.0), 0);
        let mesh = b.build("slope", 0.5);
        let columns = mesh.columns_of(0);
        assert!((columns.len() as f32 * PITCH_M * PITCH_M - 240.0).abs() < 24.0, "{}", columns.len());
        for c in columns {
            assert!(c.x.abs() <= 10.0 && c.y.abs() <= 6.0, "{c:?}");
            assert!((c.low_m - height(c.x, c.y)).abs() < 1e-4 && c.low_m == c.high_m, "{c:?}");
        }
        // Turned by any angle, each square meter well inside has one.
        for turn in [0.0_f32, 0.3, 0.785, 1.2] {
            let (s, c) = (crate::math::sinf(turn), crate::math::cosf(turn));
            let turned: Vec<_> = columns.iter().map(|p| [c * p.x - s * p.y, s * p.x + c * p.y]).collect();
            for (x, y) in (-3..3).flat_map(|x| (-3..3).map(move |y| (x as f32, y as f32))) {
                let has = turned.iter().any(|p| p[0] >= x && p[0] < x + 1.0 && p[1] >= y && p[1] < y + 1.0);
                assert!(has, "{turn} {x} {y}");
            }
        }
    }

    #[test]
    fn a_wall_stands_on_its_line_from_foot_to_top() {
        let mut b = MeshBuilder::new();
        let p = |t: f32, z: f32| Vec3::new(8.0 * t, 6.0 * t, z);
        b.quad(p(-1.0, 0.0), p(1.0, 0.0), p(1.0, 5.0), p(-1.0, 5.0), 0);
        let mesh = b.build("wall", 0.5);
        let columns = mesh.columns_of(0);
        assert!(!columns.is_empty());
        for c in columns {
            let aside = (0.6 * c.x - 0.8 * c.y).abs();
            assert!(aside <= 0.71 * PITCH_M && (c.low_m, c.high_m) == (0.0, 5.0), "{c:?}");
        }
        // Without gaps along the wall.
        let mut along: Vec<f32> = columns.iter().map(|c| 0.8 * c.x + 0.6 * c.y).collect();
        along.sort_by(f32::total_cmp);
        assert!(along.windows(2).all(|w| w[1] - w[0] < 1.0), "{along:?}");
        assert!(along[0] < -9.0 && along[along.len() - 1] > 9.0);
    }
}
