//! The sensors and where they sit on the ego vehicle.

use crate::camera::CameraModel;
use crate::lidar::LidarSpec;
use cadet_base::error::{Error, Result};
use cadet_base::math::DPose3;

/// Where a sensor's frame stands in the ego's (x forward, y left, z up from the road under the middle of the car): a
/// chain of poses from the ego outwards, such as that of a LIDAR and of a camera that was calibrated against it.
#[derive(Debug, Clone)]
pub struct Mount(Vec<DPose3>);

impl Mount {
    /// A sensor at the end of a chain: each pose stands in the frame of the one before, the first in the ego's.
    #[must_use]
    pub fn new(chain: Vec<DPose3>) -> Self {
        Self(chain)
    }

    /// The pose of the sensor's frame in the ego's.
    #[must_use]
    pub fn ego_from_sensor(&self) -> DPose3 {
        self.0.iter().copied().reduce(|outer, inner| outer * inner).unwrap_or(DPose3::IDENTITY)
    }

    /// The pose of the sensor's frame.
    #[must_use]
    pub fn world_from_sensor(&self, world_from_ego: &DPose3) -> DPose3 {
        self.0.iter().fold(*world_from_ego, |outer, inner| outer * *inner)
    }
}

/// A sensor with its name and its place.
#[derive(Debug, Clone)]
pub struct Mounted<T> {
    /// Names its captures.
    pub name: String,
    /// The sensor.
    pub sensor: T,
    /// Where its frame stands.
    pub mount: Mount,
}

/// Cameras and LIDARs on the ego vehicle. The first camera's frame is the one that labels are given in.
///
/// ```
/// use cadet_base::frames;
/// use cadet_base::math::{DPose3, DVec3, PI};
/// use cadet_sensors::camera::CameraModel;
/// use cadet_sensors::lidar::LidarSpec;
/// use cadet_sensors::rig::{Mount, Mounted, Rig};
/// use nalgebra::Matrix3x4;
///
/// let projection = Matrix3x4::new(700.0, 0.0, 320.0, 0.0, 0.0, 700.0, 120.0, 0.0, 0.0, 0.0, 1.0, 0.0);
/// let sensor = CameraModel::new(640, 240, projection, None)?;
/// // Its z axis points ahead, its x axis to the right.
/// let ego_from_cam = frames::mounted(DVec3::new(0.0, 0.0, 1.65), -PI / 2.0, 0.0, -PI / 2.0);
/// let camera = Mounted { name: "front".to_owned(), sensor, mount: Mount::new(vec![ego_from_cam]) };
/// let ego_from_velo = frames::mounted(DVec3::new(-0.3, 0.0, 1.73), 0.0, 0.0, 0.0);
/// let lidar = Mounted { name: "top".to_owned(), sensor: LidarSpec::cadet(), mount: Mount::new(vec![ego_from_velo]) };
/// let rig = Rig::new("mine".to_owned(), vec![camera], vec![lidar])?;
///
/// let world_from_cam = rig.world_from_cam(&DPose3::IDENTITY);
/// assert!((world_from_cam.rotation * DVec3::Z - DVec3::X).length() < 1e-12);
/// # Ok::<_, cadet_base::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Rig {
    /// For the metadata.
    pub name: String,
    cameras: Vec<Mounted<CameraModel>>,
    lidars: Vec<Mounted<LidarSpec>>,
}

impl Rig {
    /// A rig of at least one camera and one LIDAR, all of different names.
    ///
    /// # Errors
    /// None of a kind, or two of a name.
    pub fn new(name: String, cameras: Vec<Mounted<CameraModel>>, lidars: Vec<Mounted<LidarSpec>>) -> Result<Self> {
        for (what, is_empty) in [("cameras of a rig", cameras.is_empty()), ("LIDARs of a rig", lidars.is_empty())] {
            if is_empty {
                return Err(Error::OutOfRange { what, value: "0".to_owned(), expected: "at least 1".to_owned() });
            }
        }
        if cameras[0].sensor.fisheye().is_some() {
            let expected = "a pinhole camera, by which labels are made".to_owned();
            return Err(Error::OutOfRange { what: "first camera", value: "a fisheye".to_owned(), expected });
        }
        let mut names: Vec<&str> =
            cameras.iter().map(|c| c.name.as_str()).chain(lidars.iter().map(|l| l.name.as_str())).collect();
        names.sort_unstable();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            let (value, expected) = (twice[0].to_owned(), "a different name for each sensor".to_owned());
            return Err(Error::OutOfRange { what: "sensor's name", value, expected });
        }
        Ok(Self { name, cameras, lidars })
    }

    /// All cameras, at least one.
    #[must_use]
    pub fn cameras(&self) -> &[Mounted<CameraModel>] {
        &self.cameras
    }

    /// All LIDARs, at least one.
    #[must_use]
    pub fn lidars(&self) -> &[Mounted<LidarSpec>] {
        &self.lidars
    }

    /// The camera of `Frame.image`.
    #[must_use]
    pub fn camera(&self) -> &CameraModel {
        &self.cameras[0].sensor
    }

    /// The LIDAR of `Frame.points_velo`.
    #[must_use]
    pub fn lidar(&self) -> &LidarSpec {
        &self.lidars[0].sensor
    }

    /// The first LIDAR's pose.
    #[must_use]
    pub fn world_from_velo(&self, world_from_ego: &DPose3) -> DPose3 {
        self.lidars[0].mount.world_from_sensor(world_from_ego)
    }

    /// The pose of the first camera's frame.
    #[must_use]
    pub fn world_from_cam(&self, world_from_ego: &DPose3) -> DPose3 {
        self.cameras[0].mount.world_from_sensor(world_from_ego)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::kitti_like;
    use cadet_base::frames::mounted;
    use cadet_base::math::DVec3;

    fn at<T>(name: &str, sensor: T, x: f64) -> Mounted<T> {
        let mount = Mount::new(vec![mounted(DVec3::new(x, 0.0, 1.7), 0.0, 0.0, 0.0)]);
        Mounted { name: name.to_owned(), sensor, mount }
    }

    #[test]
    fn a_chain_leads_from_the_ego_outwards() {
        let turned = mounted(DVec3::new(1.0, 0.0, 1.5), 0.0, 0.0, 0.5 * cadet_base::math::PI);
        let ahead = mounted(DVec3::new(2.0, 0.0, 0.0), 0.0, 0.0, 0.0);
        let place = Mount::new(vec![turned, ahead]).ego_from_sensor().translation;
        assert!((place - DVec3::new(1.0, 2.0, 1.5)).length() < 1e-12, "{place}");
        let ego = mounted(DVec3::new(10.0, 5.0, 0.0), 0.0, 0.0, 0.0);
        let in_world = Mount::new(vec![turned, ahead]).world_from_sensor(&ego).translation;
        assert!((in_world - DVec3::new(11.0, 7.0, 1.5)).length() < 1e-12, "{in_world}");
        assert_eq!(Mount::new(Vec::new()).ego_from_sensor().translation, DVec3::ZERO);
    }

    #[test]
    fn rigs_have_one_of_each_kind_and_no_name_twice() {
        let camera = |name| at(name, kitti_like(), 0.0);
        let lidar = |name| at(name, LidarSpec::cadet(), 0.0);
        let refused = |cameras, lidars| Rig::new("r".to_owned(), cameras, lidars).expect_err("refused").to_string();
        assert!(refused(vec![], vec![lidar("top")]).contains("cameras of a rig is 0"));
        assert!(refused(vec![camera("front")], vec![]).contains("LIDARs of a rig is 0"));
        assert!(refused(vec![camera("a"), camera("b")], vec![lidar("b")]).contains("sensor's name is b"));
    }
}
