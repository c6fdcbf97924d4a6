//! The 2019 paper's occlusion: which corners of the 3D box the depth map hides.

use crate::camera::{CameraModel, Visibility};
use cadet_base::math::DVec3;

/// Which corners are in view and not hidden.
///
/// A corner is hidden where all four diagonal neighbors in the depth map are nearer than it by more than
/// `tolerance_m`; outside the image or behind the camera it counts as hidden. (The paper's wording, *any* neighbor,
/// would hide the lower corners of every car behind the ground in front of it.)
pub(super) fn visible_corners(
    corners_cam: &[DVec3; 8],
    camera: &CameraModel,
    seen: &Visibility,
    tolerance_m: f64,
) -> [bool; 8] {
    corners_cam.map(|corner| {
        let Some(pixel) = camera.project(corner) else { return false };
        let (u, v) = (pixel.uv.x.round(), pixel.uv.y.round());
        let inside =
            |u: f64, v: f64| (0.0..camera.width as f64).contains(&u) && (0.0..camera.height as f64).contains(&v);
        if !inside(u, v) {
            return false;
        }
        let neighbors = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        neighbors
            .into_iter()
            .map(|(du, dv)| (u + du, v + dv))
            .filter(|(u, v)| inside(*u, *v))
            .any(|(u, v)| f64::from(seen.depth_m_at(v as usize, u as usize)) >= pixel.depth_m - tolerance_m)
    })
}
