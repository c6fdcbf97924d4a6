//! How far the fine levels of crowns reach: so far that a scene has its share of triangles near the ego, and no more.

use crate::geometry::NEAR_M;
use crate::instance::Instance;
use crate::math::DVec3;

/// Triangles that a scene should have within [`NEAR_M`] of the ego. Streets with many trees have more than they need to look
/// right, and cost every sensor half as much again; bare ones can afford finer crowns.
const BUDGET: usize = 315_000;
/// Limits of levels are moved by these factors: with the first, leaf cards are up to 11 pixels of KITTI's camera wide.
const LEAST: f32 = 0.75;
const MOST: f32 = 1.6;

/// The least detail ([`crate::geometry::LodSet::select`]) with which a scene fills its budget.
#[must_use]
pub(super) fn detail_for(instances: &[Instance], viewer_world: DVec3) -> f32 {
    let mut count = 0;
    // Where a shape becomes finer, and by how many triangles.
    let mut steps: Vec<(f32, usize)> = Vec::new();
    for instance in instances {
        let (middle_m, distance_m) = distances(instance, viewer_world);
        if middle_m > NEAR_M {
            continue;
        }
        let Some(mesh) = instance.shape.select(distance_m, LEAST) else { continue };
        let mut last = mesh.faces.len();
        count += last;
        for (detail, mesh) in instance.shape.steps(distance_m).filter(|(at, _)| (LEAST..MOST).contains(at)) {
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

/// From the viewer to the middle of an instance's finest bounds, and to the sphere around them, so that the choice of a level
/// does not depend on the choice; metres.
pub(super) fn distances(instance: &Instance, viewer_world: DVec3) -> (f32, f32) {
    let bounds = &instance.shape.bounds;
    let middle = instance.world_from_local.transform_point(bounds.center().as_dvec3());
    let middle_m = (middle - viewer_world).length();
    (middle_m as f32, (middle_m - f64::from(bounds.size().length()) / 2.0).max(0.0) as f32)
}
