//! The visibility kernel: which triangle each beam of a grid meets first.

use macro_rules_attribute::apply;

use super::as_met::{AsMet, Still};
use super::coarse_depth::CoarseDepth;
use crate::sense::cluster_culling::{VisibleCluster, front_to_back, visible_clusters};
use crate::sense::grids::{BeamGrid, Hits, ToGrid, Window};
use crate::sense::scene::{PosedInstance, PosedScene};
use crate::wide_registers::array_of;
use cadet_base::geometry::{CLUSTER_FACES, CLUSTER_VERTICES, Cluster, LANES, Lanes, face_number};
use cadet_base::math::DVec3;

/// Which materials a beam notices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceFilter {
    /// Every triangle.
    All,
    /// All but transparent surfaces.
    Opaque,
    /// Transparent surfaces alone.
    Transparent,
}

/// Adds to `hits` what the beams of `grid` meet first among the triangles of the instances that `keep` accepts.
///
/// Hits that are already there stay where they are nearer, so several casts into one `Hits` add up. A `hits` of another
/// size is replaced by an empty one. Triangles have two sides, but for those of closed opaque surfaces around which all
/// beams start outside. The order of the work does not show in the outcome.
pub fn cast<G: BeamGrid>(
    scene: &PosedScene,
    grid: &G,
    filter: SurfaceFilter,
    keep: impl Fn(&PosedInstance) -> bool,
    hits: &mut Hits,
) {
    cast_filters(scene, (grid, &Still), [filter], keep, [hits]);
}

/// The first opaque and the first transparent surfaces; of the latter some that stand behind the former are left out.
/// `as_met` says where points have moved until beams meet them.
pub(crate) fn cast_layers<G: BeamGrid, M: AsMet>(
    scene: &PosedScene,
    grid: &G,
    as_met: &M,
    keep: impl Fn(&PosedInstance) -> bool,
) -> [Hits; 2] {
    let mut layers = [(); 2].map(|()| Hits::new(grid.rows(), grid.columns()));
    cast_filters(scene, (grid, as_met), [SurfaceFilter::Opaque, SurfaceFilter::Transparent], keep, layers.each_mut());
    layers
}

/// Casts into several `Hits`, each with its filter; what the first one has met hides all others'.
fn cast_filters<G: BeamGrid, M: AsMet, const N: usize>(
    scene: &PosedScene,
    (grid, as_met): (&G, &M),
    filters: [SurfaceFilter; N],
    keep: impl Fn(&PosedInstance) -> bool,
    hits: [&mut Hits; N],
) {
    if (hits[0].rows, hits[0].columns) != (grid.rows(), grid.columns()) {
        *hits[0] = Hits::new(grid.rows(), grid.columns());
    }
    let to_grid = ToGrid::new(grid);
    let slots: Vec<[u64; N]> = scene.instances.iter().map(|i| filters.map(|filter| noticed_slots(i, filter))).collect();
    let kept = (0..).zip(&scene.instances).zip(&slots).filter(|((_, instance), _)| keep(instance));
    let noticed = kept.map(|((index, _), slots)| (index, slots.iter().fold(0, |all, slots| all | slots)));
    let clusters = visible_clusters(scene, grid, &to_grid, |index| as_met.reach_m(index), noticed);
    let farthest = CoarseDepth::new(hits[0].rows, hits[0].columns);
    let scratch = Box::default();
    let mut caster = Caster { scene, grid, as_met, to_grid, filters, slots, farthest, scratch, hits };
    cast_clusters(&mut caster, &clusters);
}

/// Compiled once more for processors with wide registers. Every lane computes what the plain version does, operation by
/// operation and none of them fused, so that the outcome is the same to the bit.
#[apply(for_wide_registers)]
fn cast_clusters<G: BeamGrid, M: AsMet, const N: usize>(caster: &mut Caster<'_, G, M, N>, clusters: &[VisibleCluster]) {
    for item in front_to_back(clusters) {
        if !caster.is_hidden(&item.windows(), item.near_m) {
            caster.cast_cluster(&item);
        }
    }
}

struct Caster<'a, G: BeamGrid, M, const N: usize> {
    scene: &'a PosedScene,
    grid: &'a G,
    as_met: &'a M,
    to_grid: ToGrid,
    filters: [SurfaceFilter; N],
    /// The bits of the material slots that the beams notice, for each instance and filter.
    slots: Vec<[u64; N]>,
    farthest: CoarseDepth,
    scratch: Box<VerticesOnGrid<G::Footprint>>,
    hits: [&'a mut Hits; N],
}

/// The vertices of one cluster, in the grid's frame and on the grid, and the pieces that may meet a beam.
struct VerticesOnGrid<F> {
    x: [f64; CLUSTER_VERTICES],
    y: [f64; CLUSTER_VERTICES],
    z: [f64; CLUSTER_VERTICES],
    footprints: [F; CLUSTER_VERTICES],
    candidates: [u8; CLUSTER_FACES + 1],
}

impl<F: Copy + Default> Default for VerticesOnGrid<F> {
    fn default() -> Self {
        Self {
            x: [0.0; CLUSTER_VERTICES],
            y: [0.0; CLUSTER_VERTICES],
            z: [0.0; CLUSTER_VERTICES],
            footprints: [F::default(); CLUSTER_VERTICES],
            candidates: [0; CLUSTER_FACES + 1],
        }
    }
}

impl<F> VerticesOnGrid<F> {
    #[inline(always)]
    fn point(&self, i: u8) -> DVec3 {
        let i = usize::from(i);
        DVec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline(always)]
    fn triangle(&self, cluster: &Cluster<'_>, face: usize) -> [DVec3; 3] {
        array_of(|k| self.point(cluster.faces[face].corners[k]))
    }
}

impl<G: BeamGrid, M: AsMet, const N: usize> Caster<'_, G, M, N> {
    /// True if all beams of the windows have met something nearer than `near_m`.
    #[inline(always)]
    fn is_hidden(&mut self, windows: &[Window; 2], near_m: f32) -> bool {
        let [a, b] = windows;
        (a.is_empty() || self.farthest.hides(self.grid, &self.hits[0].depth_m, a, near_m))
            && (b.is_empty() || self.farthest.hides(self.grid, &self.hits[0].depth_m, b, near_m))
    }

    /// True if every beam starts behind one of a cluster's faces.
    #[inline(always)]
    fn is_turned_away(&self, cluster: &Cluster<'_>, face: usize) -> bool {
        self.grid.is_turned_away(&self.scratch.triangle(cluster, face))
    }

    #[inline(always)]
    fn cast_cluster(&mut self, item: &VisibleCluster) {
        let instance = &self.scene.instances[item.instance as usize];
        let cluster = &instance.mesh.clusters.get(item.cluster as usize);
        self.project(item.instance, cluster);
        let num_candidates = self.find_candidates(cluster);
        let slots = self.slots[item.instance as usize];
        // Bit 63 may stand for several slots.
        let is_all = |slots: &u64| cluster.slots & !slots == 0 && cluster.slots >> 63 == 0;
        let of_all = slots.iter().position(is_all);
        let one_sided = if item.is_solid { cluster.closed_faces } else { 0 };
        for candidate in 0..num_candidates {
            let piece = &cluster.pieces[usize::from(self.scratch.candidates[candidate])];
            let first = usize::from(piece.first);
            let noticed = of_all.or_else(|| notices(&self.filters, instance, cluster.faces[first].slot));
            let Some(layer) = noticed else { continue };
            let has_one_side = one_sided >> first & 1 == 1;
            let may_be_seen = |face: usize| !(has_one_side && self.is_turned_away(cluster, face));
            let may_be_seen = [may_be_seen(first), piece.is_quad() && may_be_seen(first + 1)];
            if may_be_seen == [false; 2] {
                continue;
            }
            let corners = array_of(|k| self.scratch.point(piece.corners[k]));
            let footprints = array_of(|k| self.scratch.footprints[usize::from(piece.corners[k])]);
            let windows = self.grid.windows(&corners, &footprints);
            if windows.iter().all(Window::is_empty) {
                continue;
            }
            if self.is_hidden(&windows, self.grid.near_m(&corners).max(item.near_m)) {
                continue;
            }
            for (face, _) in (first..).zip(may_be_seen).filter(|(_, may_be_seen)| *may_be_seen) {
                let triangle = self.scratch.triangle(cluster, face);
                for window in windows.iter().filter(|w| !w.is_empty()) {
                    self.grid.cast(
                        &triangle,
                        window,
                        self.hits[layer],
                        [item.instance, face_number(item.cluster, face)],
                    );
                }
            }
        }
    }

    /// Poses the vertices and finds where they fall on the grid.
    #[inline(always)]
    fn project(&mut self, index: u32, cluster: &Cluster<'_>) {
        let instance = &self.scene.instances[index as usize];
        let VerticesOnGrid { x, y, z, footprints, .. } = &mut *self.scratch;
        let places = x.chunks_exact_mut(LANES).zip(y.chunks_exact_mut(LANES)).zip(z.chunks_exact_mut(LANES));
        for ((local, ((x, y), z)), out) in cluster.lanes.iter().zip(places).zip(footprints.chunks_exact_mut(LANES)) {
            let mut points = self.to_grid.lanes(&instance.placement.pose_lanes(local));
            self.as_met.move_lanes(index as usize, &mut points);
            x.copy_from_slice(&points[0]);
            y.copy_from_slice(&points[1]);
            z.copy_from_slice(&points[2]);
            let rounded: Lanes = array_of(|axis| array_of(|i| points[axis][i] as f32));
            self.grid.footprints(&rounded, out.try_into().expect("a chunk of that length"));
        }
    }

    /// Lists the pieces between whose corners there is a beam; most of them meet none.
    #[inline(always)]
    fn find_candidates(&mut self, cluster: &Cluster<'_>) -> usize {
        let VerticesOnGrid { footprints, candidates, .. } = &mut *self.scratch;
        let mut n = 0;
        for (number, piece) in cluster.pieces.iter().enumerate() {
            let footprints = array_of(|k| footprints[usize::from(piece.corners[k])]);
            // Written whether it is wanted or not: a branch would be guessed wrong too often.
            candidates[n] = number as u8;
            n += usize::from(self.grid.may_meet(&footprints));
        }
        n
    }
}

/// The bits of the material slots that a filter lets beams notice.
fn noticed_slots(instance: &PosedInstance, filter: SurfaceFilter) -> u64 {
    match filter {
        SurfaceFilter::All => u64::MAX,
        SurfaceFilter::Transparent => instance.palette.transparent_slots(),
        SurfaceFilter::Opaque => instance.palette.opaque_slots(),
    }
}

/// Which filter notices a face.
fn notices(filters: &[SurfaceFilter], instance: &PosedInstance, slot: u8) -> Option<usize> {
    let is_transparent = instance.palette.materials()[usize::from(slot)].is_transparent();
    filters.iter().position(|filter| match filter {
        SurfaceFilter::All => true,
        SurfaceFilter::Opaque => !is_transparent,
        SurfaceFilter::Transparent => is_transparent,
    })
}
