//! How far the fine levels of crowns reach: so far that a scene has its share of triangles near the ego, and no more.

use crate::geometry::NEAR_M;
use crate::instance::Instance;
use crate::math::DVec3;

/// Triangles that a scene should have within [`NEAR_M`] of the ego. Streets with many trees have more than they need to look
/// right, and cost every sensor half as much again; bare ones can afford finer crowns.
const BUDGET: usize = 305_000;
/// Limits of levels are moved by these factors: with the first, leaf cards are up to 12 pixels of KITTI's camera wide where a
/// level begins.
const LEAST: f32 = 0.75;
const MOST: f32 = 1.6;

/// The least detail ([`crate::geometry::LodSet::select`]) with which a scene fills its budget.
pub(super) fn detail_for(instances: &[Instance], distances: &[Distances]) -> f32 {
    let mut count = 0;
    // Where a shape becomes finer, and by how many triangles.
    let mut steps: Vec<(f32, usize)> = Vec::new();
    for (instance, at) in instances.iter().zip(distances).filter(|(_, at)| at.middle_m <= NEAR_M) {
        let Some(mesh) = instance.shape.select(at.nearest_m, LEAST) else { continue };
        let mut last = mesh.faces.len();
        count += last;
        for (detail, mesh) in instance.shape.steps(at.nearest_m).filter(|(at, _)| (LEAST..MOST).contains(at)) {
            let faces = mesh.faces.len();
            steps.push((detail, faces.saturating_sub(last)));
            last = faces;
        }
    }
    steps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut detail = LEAST;
    for (at, more) in steps {
        if count >= BUDGET {
            return detail;
        }
        count += more;
        // A little further, for rounding.
        detail = at * 1.000_01;
    }
    detail
}

/// How far an instance is from the viewer, by the bounds of its finest level, so that the choice of a level does not depend
/// on the choice; metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distances {
    /// To the middle.
    middle_m: f32,
    /// To the sphere around the bounds.
    pub nearest_m: f32,
}

impl Distances {
    pub fn of(instance: &Instance, viewer_world: DVec3) -> Self {
        let bounds = &instance.shape.bounds;
        let middle = instance.world_from_local.transform_point(bounds.center().as_dvec3());
        let middle_m = (middle - viewer_world).length();
        let nearest_m = (middle_m - f64::from(bounds.size().length()) / 2.0).max(0.0);
        Self { middle_m: middle_m as f32, nearest_m: nearest_m as f32 }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::frames::upright;
    use crate::geometry::{LazyMesh, LodSet, Mesh, MeshBuilder};
    use crate::material::Palette;
    use crate::math::Vec3;
    use crate::sense::PosedScene;

    /// Cubes side by side, 12 triangles each.
    fn cubes(count: usize) -> Mesh {
        let mut b = MeshBuilder::new();
        for i in 0..count {
            let at = Vec3::new(i as f32 * 1e-3, 0.0, 0.0);
            b.cuboid(at, at + Vec3::splat(5e-4), 0);
        }
        b.build("cubes", 0.5)
    }

    /// Shapes of 24,000 triangles up to 20 m, 12,000 up to 40 m and 1,200 beyond that, at some distances.
    fn trees(at_m: impl Iterator<Item = f64>, is_elastic: bool) -> Vec<Instance> {
        let coarser = [(40.0, 1000), (f32::INFINITY, 100)].map(|(to_m, n)| (to_m, LazyMesh::new(move || cubes(n))));
        let shape = Arc::new(LodSet { is_elastic, ..LodSet::new((20.0, cubes(2000)), coarser) });
        let palette = Arc::new(Palette::default());
        at_m.map(|x| Instance {
            shape: Arc::clone(&shape),
            palette: Arc::clone(&palette),
            world_from_local: upright(DVec3::new(x, 0.0, 0.0), 0.0),
            actor_id: 0,
        })
        .collect()
    }

    fn detail_of(instances: &[Instance]) -> f32 {
        let distances: Vec<_> = instances.iter().map(|i| Distances::of(i, DVec3::ZERO)).collect();
        detail_for(instances, &distances)
    }

    fn count(instances: &[Instance]) -> usize {
        PosedScene::new(instances, DVec3::ZERO).num_triangles()
    }

    #[test]
    fn crowns_become_finer_until_the_budget_is_met_and_no_further() {
        let instances = trees((0..30).map(|i| 10.0 + 1.2 * f64::from(i)), true);
        let detail = detail_of(&instances);
        assert!(detail > LEAST && detail < MOST, "{detail}");
        // One step at most: 12,000 triangles, as the finest level has more than the next.
        assert!((BUDGET..BUDGET + 12_000).contains(&count(&instances)), "{}", count(&instances));
    }

    #[test]
    fn full_and_bare_streets_keep_within_the_limits() {
        let full = trees((0..120).map(|i| 10.0 + f64::from(i) * 0.2), true);
        assert_eq!(detail_of(&full), LEAST);
        assert!(count(&full) > BUDGET);
        let bare = trees([25.0, 70.0].into_iter(), true);
        let detail = detail_of(&bare);
        assert!(detail <= MOST);
        // The near one takes its finest level, as 25 m are less than 1.6 x 20; the far one is beyond 1.6 x 40.
        assert_eq!(count(&bare), 24_000 + 1_200);
        assert_eq!(detail_of(&[]), LEAST);
    }

    #[test]
    fn what_is_not_elastic_goes_by_its_own_limits() {
        let instances = trees([19.0, 21.0, 39.0, 41.0].into_iter(), false);
        assert_eq!(count(&instances), 24_000 + 12_000 + 12_000 + 1_200);
        // Neither does what lies beyond the distance that counts.
        assert_eq!(count(&trees([81.0].into_iter(), true)), 1_200);
    }
}
