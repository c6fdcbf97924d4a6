//! An actor's outline alone, as the camera would see it with nothing else in the world.

use crate::camera::{CameraModel, Seen};
use crate::math::{DPose3, DVec3};
use crate::sense::{PinholeGrid, PosedInstance, PosedScene, VisibilityBuffer, draw};

use super::box_cam::Rect;

/// Samples a pixel side: 2 x 2 = four samples a pixel.
pub(super) const SUPERSAMPLING: usize = 2;

/// How much of an actor there is in the image, and how much of it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Silhouette {
    /// Samples of the outline inside the image.
    pub samples: usize,
    /// Those where nothing is in front.
    pub visible_samples: usize,
    /// Rectangle round the outline inside the image.
    pub bounds: Option<Rect>,
}

/// Draws the actor alone over the part of the supersampled image that its bounds cover; of an actor of which nothing is
/// seen only if `even_if_hidden`.
pub(super) fn silhouette(
    scene: &PosedScene,
    actor_id: i32,
    camera: &CameraModel,
    world_from_cam: &DPose3,
    seen: &Seen,
    even_if_hidden: bool,
    buffer: &mut VisibilityBuffer,
) -> Silhouette {
    let mut found = Silhouette { samples: 0, visible_samples: 0, bounds: None };
    let Some([u1, v1, u2, v2]) = pixel_bounds(scene, actor_id, camera, world_from_cam) else { return found };
    // Sample (r, c) of the image lies at v = r / n, u = c / n.
    let n = SUPERSAMPLING as f64;
    let (width, height) = (camera.width * SUPERSAMPLING, camera.height * SUPERSAMPLING);
    let to_sample = |p: f64| p * n;
    let lo = |p: f64| to_sample(p).floor().max(0.0) as usize;
    let hi = |p: f64, end: usize| (to_sample(p).ceil() + 1.0).clamp(0.0, end as f64) as usize;
    let (c1, c2, r1, r2) = (lo(u1), hi(u2, width), lo(v1), hi(v2, height));
    if c1 >= c2 || r1 >= r2 {
        return found;
    }
    let of_row = |row| (c1..c2).filter(|column| seen.actor_at_sample(row, *column) == actor_id).count();
    found.visible_samples = (r1..r2).map(of_row).sum();
    if found.visible_samples == 0 && !even_if_hidden {
        return found;
    }
    let from_sample = |i: usize| i as f64 / n;
    let (rows, columns) = (r2 - r1, c2 - c1);
    let window = [from_sample(c1), from_sample(r1), 1.0 / n, 1.0 / n];
    let grid = PinholeGrid::new(camera.optical_pose(world_from_cam), camera.intrinsics(), window, rows, columns)
        .expect("a checked camera and a window that is not empty");
    draw(scene, &grid, |i| i.actor_id == actor_id, buffer);
    for r in 0..rows {
        for c in 0..columns {
            if buffer.front_number(r, c).is_none() {
                continue;
            }
            found.samples += 1;
            let (u, v) = (from_sample(c1 + c), from_sample(r1 + r));
            let b = found.bounds.unwrap_or(Rect { u1: u, v1: v, u2: u, v2: v });
            found.bounds = Some(Rect { u1: b.u1.min(u), v1: b.v1.min(v), u2: b.u2.max(u), v2: b.v2.max(v) });
        }
    }
    found
}

/// Pixels that hold the actor's bounds; the whole image where some of them are beside or behind the camera.
fn pixel_bounds(scene: &PosedScene, actor_id: i32, camera: &CameraModel, world_from_cam: &DPose3) -> Option<[f64; 4]> {
    let cam_from_world = world_from_cam.inverse();
    let mut bounds: Option<[f64; 4]> = None;
    let (mut any_behind, mut any_in_front) = (false, false);
    for corner in scene.instances.iter().filter(|i| i.actor_id == actor_id).flat_map(corners_world) {
        let p = cam_from_world.rotation * corner + cam_from_world.translation;
        match camera.project(p).filter(|_| p.z > 0.05) {
            Some(pixel) => {
                any_in_front = true;
                let (u, v) = (pixel.uv.x, pixel.uv.y);
                let b = bounds.unwrap_or([u, v, u, v]);
                bounds = Some([b[0].min(u), b[1].min(v), b[2].max(u), b[3].max(v)]);
            }
            None => any_behind = true,
        }
    }
    match (any_in_front, any_behind) {
        (false, _) => None,
        (true, true) => Some([0.0, 0.0, camera.width as f64, camera.height as f64]),
        (true, false) => bounds,
    }
}

/// The corners of a box round an instance, widened by what rounding vertices to single precision may move them.
fn corners_world(instance: &PosedInstance) -> [DVec3; 8] {
    let bounds = &instance.mesh.bounds;
    let (center, half) = (bounds.center().as_dvec3(), bounds.size().as_dvec3() * 0.5 + 1e-3);
    std::array::from_fn(|i| {
        let side = |axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let local = center + half * DVec3::new(side(0), side(1), side(2));
        instance.placement.rotation * local + instance.placement.translation
    })
}
