//! The sensors and where they sit on the ego vehicle.

use crate::camera::CameraModel;
use crate::lidar::LidarSpec;
use crate::math::DPose3;

/// A LIDAR and a camera on the ego vehicle.
#[derive(Debug, Clone)]
pub struct Rig {
    /// For the metadata: `kitti`, `paper` or `custom`.
    pub name: String,
    /// The LIDAR.
    pub lidar: LidarSpec,
    /// The camera and its calibration.
    pub camera: CameraModel,
    /// The LIDAR's pose in the ego's frame (x forward, y left, z up from the road under the middle of the car); the
    /// camera's follows from the calibration.
    pub ego_from_velo: DPose3,
}

impl Rig {
    /// The LIDAR's pose.
    #[must_use]
    pub fn world_from_velo(&self, world_from_ego: &DPose3) -> DPose3 {
        *world_from_ego * self.ego_from_velo
    }

    /// The pose of the rectified camera 0.
    #[must_use]
    pub fn world_from_cam(&self, world_from_ego: &DPose3) -> DPose3 {
        self.world_from_velo(world_from_ego) * self.camera.calibration.cam_from_velo().inverse()
    }
}
