//! The camera's model: KITTI's calibration and what follows from it.

use nalgebra::{Matrix3, Matrix3x4, Vector4};

use crate::error::{Error, Result, finite};
use crate::math::{DMat3, DPose3, DQuat, DVec2, DVec3};

/// KITTI's calibration of one recording day: the matrices of a `calib` file.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Projections P0-P3 of the rectified cameras, from the frame of camera 0 to pixels.
    pub projections: [Matrix3x4<f64>; 4],
    /// Rectifying rotation of camera 0.
    pub r0_rect: Matrix3<f64>,
    /// From the LIDAR to the unrectified camera 0.
    pub tr_velo_to_cam: Matrix3x4<f64>,
    /// From the inertial unit to the LIDAR.
    pub tr_imu_to_velo: Matrix3x4<f64>,
}

impl Calibration {
    /// The rigid pose `cam_from_velo` = `R0_rect` x `Tr_velo_to_cam` of the rectified camera 0.
    #[must_use]
    pub fn cam_from_velo(&self) -> DPose3 {
        let m = self.r0_rect * self.tr_velo_to_cam;
        let column = |j: usize| DVec3::new(m[(0, j)], m[(1, j)], m[(2, j)]);
        // Files carry seven digits: make the rotation orthonormal again, x first.
        let x = column(0).normalize();
        let y = (column(1) - x * x.dot(column(1))).normalize();
        let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)));
        DPose3 { rotation, translation: column(3) }
    }
}

/// The left colour camera (P2): its image is rendered, and labels are projected with it.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraModel {
    /// Image width in pixels.
    pub width: usize,
    /// Image height in pixels.
    pub height: usize,
    /// The matrices.
    pub calibration: Calibration,
}

/// A point seen by the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Column and row; (0, 0) is the centre of the top-left pixel.
    pub uv: DVec2,
    /// Depth along the optical axis of P2, metres.
    pub depth_m: f64,
}

impl CameraModel {
    /// Checks the numbers and makes a camera.
    ///
    /// # Errors
    /// A size outside 16..=8192 pixels, a matrix entry that is not finite, focal lengths that are not positive, skew,
    /// or a velo-to-camera matrix that is no rotation.
    pub fn new(width: usize, height: usize, calibration: Calibration) -> Result<Self> {
        for (what, value) in [("image width", width), ("image height", height)] {
            if !(16..=8192).contains(&value) {
                let expected = "16 to 8192 pixels".to_owned();
                return Err(Error::OutOfRange { what, value: value.to_string(), expected });
            }
        }
        let c = &calibration;
        let matrices = c.projections.iter().chain([&c.tr_velo_to_cam, &c.tr_imu_to_velo]);
        for value in matrices.flat_map(|m| m.iter()).chain(c.r0_rect.iter()) {
            let _ = finite("calibration entry", *value)?;
        }
        let p2 = &c.projections[2];
        if p2[(0, 0)] <= 0.0 || p2[(1, 1)] <= 0.0 || p2[(0, 1)] != 0.0 || p2[(1, 0)] != 0.0 {
            return Err(Error::OutOfRange {
                what: "P2",
                value: format!("fx {}, fy {}, skew {}", p2[(0, 0)], p2[(1, 1)], p2[(0, 1)]),
                expected: "positive focal lengths and no skew".to_owned(),
            });
        }
        if (p2[(2, 0)], p2[(2, 1)], p2[(2, 2)]) != (0.0, 0.0, 1.0) {
            return Err(Error::OutOfRange {
                what: "P2's last row",
                value: format!("{} {} {}", p2[(2, 0)], p2[(2, 1)], p2[(2, 2)]),
                expected: "0 0 1".to_owned(),
            });
        }
        let m = c.r0_rect * c.tr_velo_to_cam;
        let r = m.fixed_columns::<3>(0);
        let rigid = (r * r.transpose() - Matrix3::identity()).abs().max() < 1e-4 && r.determinant() > 0.0;
        if !rigid {
            return Err(Error::OutOfRange {
                what: "R0_rect x Tr_velo_to_cam",
                value: format!("determinant {:.6}", r.determinant()),
                expected: "a rotation".to_owned(),
            });
        }
        Ok(Self { width, height, calibration })
    }

    /// (fx, fy, cx, cy) of P2.
    #[must_use]
    pub fn intrinsics(&self) -> [f64; 4] {
        let p = &self.calibration.projections[2];
        [p[(0, 0)], p[(1, 1)], p[(0, 2)], p[(1, 2)]]
    }

    /// The optical centre of P2 in the frame of camera 0: where P2 maps to (0, 0, 0).
    #[must_use]
    pub fn optical_center_cam(&self) -> DVec3 {
        let p = &self.calibration.projections[2];
        let [fx, fy, cx, cy] = self.intrinsics();
        let z = p[(2, 3)];
        -DVec3::new((p[(0, 3)] - cx * z) / fx, (p[(1, 3)] - cy * z) / fy, z)
    }

    /// The pose of P2's optical centre, given that of camera 0; the axes are the same.
    #[must_use]
    pub fn optical_pose(&self, world_from_cam: &DPose3) -> DPose3 {
        let offset_world = world_from_cam.rotation * self.optical_center_cam();
        DPose3 { rotation: world_from_cam.rotation, translation: world_from_cam.translation + offset_world }
    }

    /// The homogeneous pixel (u z, v z, z) of a point of the frame of camera 0.
    #[must_use]
    pub fn homogeneous(&self, point_cam: DVec3) -> DVec3 {
        let h = self.calibration.projections[2] * Vector4::new(point_cam.x, point_cam.y, point_cam.z, 1.0);
        DVec3::new(h.x, h.y, h.z)
    }

    /// Projects a point of the frame of camera 0 with the whole P2. `None` at or behind the optical centre.
    #[must_use]
    pub fn project(&self, point_cam: DVec3) -> Option<Pixel> {
        let h = self.homogeneous(point_cam);
        (h.z > 1e-9).then(|| Pixel { uv: DVec2::new(h.x / h.z, h.y / h.z), depth_m: h.z })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A camera like KITTI's of 2011-09-26 (rounded), for tests.
    pub(crate) fn kitti_like() -> CameraModel {
        let p = |x: f64, y: f64, z: f64| {
            Matrix3x4::new(721.5377, 0.0, 609.5593, x, 0.0, 721.5377, 172.854, y, 0.0, 0.0, 1.0, z)
        };
        let calibration = Calibration {
            projections: [
                p(0.0, 0.0, 0.0),
                p(-387.5744, 0.0, 0.0),
                p(44.857_28, 0.216_379_1, 0.002_745_884),
                p(-339.5242, 2.199_936, 0.002_729_905),
            ],
            r0_rect: Matrix3::identity(),
            tr_velo_to_cam: Matrix3x4::new(0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, -0.08, 1.0, 0.0, 0.0, -0.27),
            tr_imu_to_velo: Matrix3x4::identity(),
        };
        CameraModel::new(1242, 375, calibration).expect("valid")
    }

    #[test]
    fn the_optical_center_sees_along_the_axis() {
        let camera = kitti_like();
        let c = camera.optical_center_cam();
        assert!((c.x + 0.0598).abs() < 1e-3 && c.y.abs() < 1e-3, "{c}");
        let seen = camera.project(c + DVec3::new(0.0, 0.0, 7.0)).expect("in front");
        assert!((seen.uv - DVec2::new(609.5593, 172.854)).length() < 1e-9);
        assert!((seen.depth_m - 7.0).abs() < 1e-12);
        assert!(camera.project(c - DVec3::new(0.0, 0.0, 1.0)).is_none());
    }

    #[test]
    fn the_lidar_looks_along_the_camera() {
        let cam_from_velo = kitti_like().calibration.cam_from_velo();
        let ahead = cam_from_velo.rotation * DVec3::new(10.0, 2.0, 1.0) + cam_from_velo.translation;
        assert!((ahead - DVec3::new(-2.0, -1.08, 9.73)).length() < 1e-9, "{ahead}");
    }

    #[test]
    fn nonsense_is_refused() {
        let good = kitti_like();
        assert!(CameraModel::new(0, 375, good.calibration.clone()).is_err());
        let mut bad = good.calibration.clone();
        bad.tr_velo_to_cam[(0, 0)] = f64::NAN;
        assert!(CameraModel::new(1242, 375, bad).is_err());
        let mut bad = good.calibration.clone();
        bad.tr_velo_to_cam[(0, 1)] = 1.0;
        assert!(CameraModel::new(1242, 375, bad).is_err(), "a mirror is no rotation");
        let mut bad = good.calibration;
        bad.projections[2][(0, 0)] = -1.0;
        assert!(CameraModel::new(1242, 375, bad).is_err());
    }
}
