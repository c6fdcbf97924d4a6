//! The camera's model: how points become pixels.

use std::sync::Arc;

use nalgebra::{Matrix3x4, Vector4};

use super::development::Development;
use super::distortion::{Distortion, Warp};
use super::fisheye::{Fisheye, Side};
use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{DPose3, DVec2, DVec3};

/// Sides of an image, pixels.
pub const SIDES_PX: std::ops::RangeInclusive<usize> = 16..=8192;
/// The longest time from the first row's exposure to the last's, seconds.
pub const MAX_ROLLING_SHUTTER_S: f64 = 0.1;
/// The longest time for which a row gathers light, seconds.
pub const MAX_MOTION_BLUR_S: f64 = 0.05;
/// Points nearer to the camera's plane than this are not projected, meters.
const LEAST_DEPTH_M: f64 = 1e-9;

/// A camera: the size of its image, and how points of its frame (x right, y down, z forward) are projected into it.
///
/// The optical center need not be the frame's origin: KITTI's cameras share the frame of camera 0, and the fourth column
/// of a projection says where each of them stands.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraModel {
    /// Image width in pixels.
    pub width: usize,
    /// Image height in pixels.
    pub height: usize,
    /// From the frame to pixels.
    projection: Matrix3x4<f64>,
    /// A lens that bends straight lines.
    lens: Option<Lens>,
    rolling_shutter_s: f64,
    motion_blur_s: f64,
    development: Development,
    /// In place of a lens.
    fisheye: Option<Arc<Fisheye>>,
}

#[derive(Debug, Clone, PartialEq)]
struct Lens {
    distortion: Distortion,
    warp: Arc<Warp>,
}

/// A point seen by the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Column and row; (0, 0) is the center of the top-left pixel.
    pub uv: DVec2,
    /// Depth along the optical axis, meters.
    pub depth_m: f64,
}

impl CameraModel {
    /// Checks the numbers and makes a camera.
    ///
    /// # Errors
    /// A size outside [`SIDES_PX`], a matrix entry that is not finite, focal lengths that are not positive, skew, or
    /// a lens that folds the image.
    pub fn new(
        width: usize,
        height: usize,
        projection: Matrix3x4<f64>,
        distortion: Option<Distortion>,
    ) -> Result<Self> {
        for (what, value) in [("image width", width), ("image height", height)] {
            if !SIDES_PX.contains(&value) {
                let expected = format!("{} to {} pixels", SIDES_PX.start(), SIDES_PX.end());
                return Err(Error::OutOfRange { what, value: value.to_string(), expected });
            }
        }
        let p = &projection;
        for value in p.iter() {
            let _ = finite("projection entry", *value)?;
        }
        if p[(0, 0)] <= 0.0 || p[(1, 1)] <= 0.0 || p[(0, 1)] != 0.0 || p[(1, 0)] != 0.0 {
            return Err(Error::OutOfRange {
                what: "projection",
                value: format!("fx {}, fy {}, skew {}", p[(0, 0)], p[(1, 1)], p[(0, 1)]),
                expected: "positive focal lengths and no skew".to_owned(),
            });
        }
        if (p[(2, 0)], p[(2, 1)], p[(2, 2)]) != (0.0, 0.0, 1.0) {
            return Err(Error::OutOfRange {
                what: "the projection's last row",
                value: format!("{} {} {}", p[(2, 0)], p[(2, 1)], p[(2, 2)]),
                expected: "0 0 1".to_owned(),
            });
        }
        let development = Development::default();
        let mut camera = Self {
            width,
            height,
            projection,
            lens: None,
            rolling_shutter_s: 0.0,
            motion_blur_s: 0.0,
            development,
            fisheye: None,
        };
        if let Some(distortion) = distortion {
            let warp = Arc::new(Warp::new(&distortion, camera.intrinsics_px(), width, height)?);
            camera.lens = Some(Lens { distortion, warp });
        }
        Ok(camera)
    }

    /// Checks the numbers and makes an equidistant fisheye: the projection's focal lengths are pixels a radian.
    ///
    /// # Errors
    /// Those of [`CameraModel::new`] and [`Fisheye::new`].
    pub fn fisheye_of(width: usize, height: usize, projection: Matrix3x4<f64>) -> Result<Self> {
        let mut camera = Self::new(width, height, projection, None)?;
        camera.fisheye = Some(Arc::new(Fisheye::new(camera.intrinsics_px(), width, height)?));
        Ok(camera)
    }

    /// How the image of a fisheye is taken; `None` of other cameras.
    #[must_use]
    pub fn fisheye(&self) -> Option<&Arc<Fisheye>> {
        self.fisheye.as_ref()
    }

    /// The pinhole camera whose image the lens distorts: this one without a lens, wide enough to hold all that it sees.
    #[must_use]
    pub fn pinhole(&self) -> Self {
        let Some(lens) = &self.lens else { return self.clone() };
        let [right, down] = lens.warp.before_px;
        let mut projection = self.projection;
        let z = projection[(2, 3)];
        projection[(0, 2)] += right;
        projection[(1, 2)] += down;
        projection[(0, 3)] += right * z;
        projection[(1, 3)] += down * z;
        Self { width: lens.warp.width, height: lens.warp.height, projection, lens: None, ..self.clone() }
    }

    /// The pinhole cameras that look where this one does, with the poses of their frames: one, or the sides of a cube that a
    /// fisheye's image is taken from.
    #[must_use]
    pub fn pinholes(&self, world_from_cam: &DPose3) -> Vec<(Self, DPose3)> {
        let Some(fisheye) = &self.fisheye else { return vec![(self.pinhole(), *world_from_cam)] };
        let optical = self.optical_pose(world_from_cam);
        let of_side = |side: &Side| {
            let [fx, fy, cx, cy] = side.intrinsics_px;
            let projection = Matrix3x4::new(fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0);
            let camera = Self { width: side.width, height: side.height, projection, fisheye: None, ..self.clone() };
            (camera, DPose3 { rotation: optical.rotation * side.cam_from_side, translation: optical.translation })
        };
        fisheye.sides.iter().map(of_side).collect()
    }

    /// Returns this camera with rows that are exposed from the top to the bottom within so many seconds, from the first
    /// row's instant to the last's; 0 for all at once.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] beyond 0 to [`MAX_ROLLING_SHUTTER_S`], [`Error::NotFinite`].
    pub fn with_rolling_shutter(mut self, rolling_shutter_s: f64) -> Result<Self> {
        if !(0.0..=MAX_ROLLING_SHUTTER_S).contains(&finite("rolling shutter", rolling_shutter_s)?) {
            let (what, value) = ("rolling shutter", rolling_shutter_s.to_string());
            return Err(Error::OutOfRange { what, value, expected: format!("0 to {MAX_ROLLING_SHUTTER_S} s") });
        }
        self.rolling_shutter_s = rolling_shutter_s;
        Ok(self)
    }

    /// Seconds between the first row's exposure and the last's.
    #[must_use]
    pub fn rolling_shutter_s(&self) -> f64 {
        self.rolling_shutter_s
    }

    /// Returns this camera with rows that gather light for so many seconds, so that what moves is blurred; 0 for an instant.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] beyond 0 to [`MAX_MOTION_BLUR_S`], [`Error::NotFinite`].
    pub fn with_motion_blur(mut self, motion_blur_s: f64) -> Result<Self> {
        if !(0.0..=MAX_MOTION_BLUR_S).contains(&finite("motion blur", motion_blur_s)?) {
            let (what, value) = ("motion blur", motion_blur_s.to_string());
            return Err(Error::OutOfRange { what, value, expected: format!("0 to {MAX_MOTION_BLUR_S} s") });
        }
        self.motion_blur_s = motion_blur_s;
        Ok(self)
    }

    /// Seconds for which each row gathers light, about its time.
    #[must_use]
    pub fn motion_blur_s(&self) -> f64 {
        self.motion_blur_s
    }

    /// Whether all of the image is taken at one instant.
    #[must_use]
    pub fn is_instantaneous(&self) -> bool {
        self.rolling_shutter_s == 0.0 && self.motion_blur_s == 0.0
    }

    /// Returns this camera with values that are made otherwise of its light.
    #[must_use]
    pub fn with_development(mut self, development: Development) -> Self {
        self.development = development;
        self
    }

    /// How values are made of the light.
    #[must_use]
    pub fn development(&self) -> &Development {
        &self.development
    }

    /// How the image is taken from the pinhole camera's; `None` without distortion.
    #[must_use]
    pub fn warp(&self) -> Option<&Warp> {
        self.lens.as_ref().map(|lens| &*lens.warp)
    }

    /// (fx, fy, cx, cy).
    #[must_use]
    pub fn intrinsics_px(&self) -> [f64; 4] {
        let p = &self.projection;
        [p[(0, 0)], p[(1, 1)], p[(0, 2)], p[(1, 2)]]
    }

    /// The optical center in the camera's frame: where the projection maps to (0, 0, 0).
    #[must_use]
    pub fn optical_center_cam(&self) -> DVec3 {
        let p = &self.projection;
        let [fx, fy, cx, cy] = self.intrinsics_px();
        let z = p[(2, 3)];
        -DVec3::new((p[(0, 3)] - cx * z) / fx, (p[(1, 3)] - cy * z) / fy, z)
    }

    /// The pose of the optical center, given that of the camera's frame; the axes are the same.
    #[must_use]
    pub fn optical_pose(&self, world_from_cam: &DPose3) -> DPose3 {
        let offset_world = world_from_cam.rotation * self.optical_center_cam();
        DPose3 { rotation: world_from_cam.rotation, translation: world_from_cam.translation + offset_world }
    }

    /// The homogeneous pixel (u z, v z, z) of a point of the camera's frame, as a pinhole sees it.
    #[must_use]
    pub fn homogeneous(&self, point_cam: DVec3) -> DVec3 {
        let h = self.projection * Vector4::new(point_cam.x, point_cam.y, point_cam.z, 1.0);
        DVec3::new(h.x, h.y, h.z)
    }

    /// Projects a point of the camera's frame. `None` at or behind the optical center.
    #[must_use]
    pub fn project(&self, point_cam: DVec3) -> Option<Pixel> {
        let h = self.homogeneous(point_cam);
        if h.z <= LEAST_DEPTH_M {
            return None;
        }
        let (u, v) = (h.x / h.z, h.y / h.z);
        let uv = match &self.lens {
            None => DVec2::new(u, v),
            Some(_) => {
                let [fx, fy, cx, cy] = self.intrinsics_px();
                self.pixel_of_slopes([(u - cx) / fx, (v - cy) / fy])
            }
        };
        Some(Pixel { uv, depth_m: h.z })
    }

    /// Where a ray of a pinhole camera's axes meets its image, through the lens; `None` from behind.
    #[must_use]
    pub fn pixel_of_ray(&self, ray: DVec3) -> Option<DVec2> {
        (ray.z > LEAST_DEPTH_M).then(|| self.pixel_of_slopes([ray.x / ray.z, ray.y / ray.z]))
    }

    fn pixel_of_slopes(&self, slopes: [f64; 2]) -> DVec2 {
        let [fx, fy, cx, cy] = self.intrinsics_px();
        let [x, y] = self.lens.as_ref().map_or(slopes, |lens| lens.distortion.apply_within_reach(slopes));
        DVec2::new(x * fx + cx, y * fy + cy)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A camera like KITTI's camera 2 of 2011-09-26 (rounded), for tests.
    pub(crate) fn kitti_like() -> CameraModel {
        CameraModel::new(1242, 375, kitti_p2(), None).expect("valid")
    }

    fn kitti_p2() -> Matrix3x4<f64> {
        let (x, y, z) = (44.857_28, 0.216_379_1, 0.002_745_884);
        Matrix3x4::new(721.5377, 0.0, 609.5593, x, 0.0, 721.5377, 172.854, y, 0.0, 0.0, 1.0, z)
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
    fn a_lens_moves_pixels_but_not_the_center_and_its_pinhole_sees_the_same_rays() {
        let lens = Distortion::from_opencv([-0.3, 0.09, 0.0, 0.0, 0.0]);
        let (straight, bent) = (kitti_like(), CameraModel::new(1242, 375, kitti_p2(), lens).expect("valid"));
        let center = bent.optical_center_cam();
        assert_eq!(center, straight.optical_center_cam());
        let pinhole = bent.pinhole();
        assert!((pinhole.optical_center_cam() - center).length() < 1e-9);
        assert!(pinhole.width > 1242 && pinhole.height > 375 && pinhole.warp().is_none());
        let beside = center + DVec3::new(-3.0, 0.4, 5.0);
        let pixel = |camera: &CameraModel| camera.project(beside).expect("in front").uv;
        // r^2 is 0.3664, so that the image shrinks by 1 - 0.3 r^2 + 0.09 r^4.
        let shrunk = (pixel(&bent) - DVec2::new(609.5593, 172.854)).length()
            / (pixel(&straight) - DVec2::new(609.5593, 172.854)).length();
        assert!((shrunk - (1.0 - 0.3 * 0.3664 + 0.09 * 0.3664 * 0.3664)).abs() < 1e-9, "{shrunk}");
        let before = DVec2::from_array(bent.warp().expect("a lens").before_px);
        assert!((pixel(&pinhole) - pixel(&straight) - before).length() < 1e-9);
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(CameraModel::new(0, 375, kitti_p2(), None).is_err());
        for (at, value) in [((0, 0), f64::NAN), ((0, 0), -1.0), ((0, 1), 0.1), ((2, 2), 2.0)] {
            let mut bad = kitti_p2();
            bad[at] = value;
            assert!(CameraModel::new(1242, 375, bad, None).is_err(), "{at:?} {value}");
        }
    }
}
