//! The ground plane of a frame.

use std::ops::Range;

use nalgebra::{Matrix3, SymmetricEigen};

use cadet_base::math::{DPose3, DVec2, DVec3};

/// Where the plane is fitted: ahead of the camera, and to either side.
const AHEAD_M: Range<f64> = 2.0..30.0;
const ASIDE_M: f64 = 5.0;
const STEP_M: f64 = 1.0;
/// Fewer samples of road than this do not make a plane: sidewalks and verges join in.
const MIN_SAMPLES: usize = 20;

/// The least-squares plane a x + b y + c z + d = 0 of the road 2-30 m ahead, 5 m to either side, in the frame of
/// camera 0: unit normal, b < 0. `None` where there is no ground ahead.
///
/// `road_height_m` and `ground_height_m` give the height of the carriageway and of any ground at a place of the world.
#[must_use]
pub fn road_plane_cam(
    world_from_cam: &DPose3,
    road_height_m: impl Fn(DVec2) -> Option<f64>,
    ground_height_m: impl Fn(DVec2) -> Option<f64>,
) -> Option<[f64; 4]> {
    let ahead = (world_from_cam.rotation * DVec3::Z).truncate().normalize();
    let aside = DVec2::new(ahead.y, -ahead.x);
    let origin = world_from_cam.translation.truncate();
    let steps = |from: f64, to: f64| (0..=((to - from) / STEP_M) as usize).map(move |i| from + i as f64 * STEP_M);
    let sample = |height_m: &dyn Fn(DVec2) -> Option<f64>| -> Vec<DVec3> {
        steps(AHEAD_M.start, AHEAD_M.end)
            .flat_map(|x| steps(-ASIDE_M, ASIDE_M).map(move |y| origin + ahead * x + aside * y))
            .filter_map(|p| height_m(p).map(|z| p.extend(z)))
            .collect()
    };
    let mut points = sample(&road_height_m);
    if points.len() < MIN_SAMPLES {
        points = sample(&ground_height_m);
    }
    let cam_from_world = world_from_cam.inverse();
    for p in &mut points {
        *p = cam_from_world.rotation * *p + cam_from_world.translation;
    }
    fit_plane(&points)
}

/// The plane through the points' centroid with the least squared distances; unit normal, b < 0.
fn fit_plane(points: &[DVec3]) -> Option<[f64; 4]> {
    if points.len() < 3 {
        return None;
    }
    let mean = points.iter().copied().sum::<DVec3>() / points.len() as f64;
    let scatter = points.iter().map(|p| *p - mean).fold(Matrix3::zeros(), |m: Matrix3<f64>, d| {
        let d = nalgebra::Vector3::new(d.x, d.y, d.z);
        m + d * d.transpose()
    });
    let eigen = SymmetricEigen::new(scatter);
    let least = eigen.eigenvalues.imin();
    let n = eigen.eigenvectors.column(least);
    let sign = if n[1] > 0.0 { -1.0 } else { 1.0 };
    let normal = DVec3::new(n[0], n[1], n[2]) * (sign / n.norm());
    Some([normal.x, normal.y, normal.z, -normal.dot(mean)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::frames;
    use cadet_base::math::DQuat;

    fn camera(pitch_rad: f64) -> DPose3 {
        let axes = DQuat::from_mat3(&frames::cam_axes_from_velo_axes().transpose());
        let tilt = DQuat::from_rotation_y(pitch_rad);
        DPose3 { rotation: DQuat::from_rotation_z(0.7) * tilt * axes, translation: DVec3::new(3.0, 4.0, 2.65) }
    }

    #[test]
    fn a_level_road_gives_the_cameras_height() {
        let road = |_| Some(1.0);
        let [a, b, c, d] = road_plane_cam(&camera(0.0), road, road).expect("ground");
        assert!(a.abs() < 1e-9 && (b + 1.0).abs() < 1e-9 && c.abs() < 1e-9 && (d - 1.65).abs() < 1e-9);
    }

    #[test]
    fn pitch_turns_the_plane_and_not_the_height() {
        let road = |_| Some(1.0);
        let pitch = 0.05;
        let [a, b, c, d] = road_plane_cam(&camera(pitch), road, road).expect("ground");
        // Nose down: the road's normal leans toward the camera's view axis less.
        assert!(a.abs() < 1e-9 && (b + cadet_base::math::cos(pitch)).abs() < 1e-9, "{b}");
        assert!((c.abs() - cadet_base::math::sin(pitch)).abs() < 1e-9 && (d - 1.65).abs() < 1e-9, "{c} {d}");
    }

    #[test]
    fn without_road_the_ground_serves_and_without_ground_nothing() {
        let ground = |p: DVec2| Some(0.1 * p.x);
        let [a, b, c, d] = road_plane_cam(&camera(0.0), |_| None, ground).expect("ground");
        let cam = camera(0.0).inverse();
        let p = cam.rotation * DVec3::new(20.0, 20.0, 2.0) + cam.translation;
        assert!((a * p.x + b * p.y + c * p.z + d).abs() < 1e-9);
        assert!(road_plane_cam(&camera(0.0), |_| None, |_| None).is_none());
    }
}
