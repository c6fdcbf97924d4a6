//! Generated suburbs that several benches look at.

use std::sync::Arc;

use cadet_core::camera::{CameraModel, View};
use cadet_core::frames;
use cadet_core::lidar::LidarSpec;
use cadet_core::math::DVec3;
use cadet_core::nalgebra::Matrix3x4;
use cadet_core::rig::{Mount, Mounted, Rig};
use cadet_core::rng::StreamKey;
use cadet_core::scene::{Scene, SceneConfig, TownSource};
use cadet_core::sense::PosedScene;
use cadet_core::weather::Weather;

/// Suburbs and weathers whose images docs/measurements/performance.md compares.
pub const VIEWS: [(u64, &str); 6] = [
    (0, "clear_noon"),
    (1, "clear_noon"),
    (2, "clear_sunset"),
    (3, "clear_noon"),
    (4, "clear_noon"),
    (5, "soft_rain_noon"),
];

/// `cadet.Rig.kitti()`.
fn kitti_rig() -> Rig {
    let (x, y, z) = (44.857_28, 0.216_379_1, 0.002_745_884);
    let p2 = Matrix3x4::new(721.5377, 0.0, 609.5593, x, 0.0, 721.5377, 172.854, y, 0.0, 0.0, 1.0, z);
    // R0_rect times Tr_velo_to_cam.
    let cam_from_velo = [
        [0.000_234_774, -0.999_944_155, -0.010_563_478, -0.002_796_817],
        [0.010_449_407, 0.010_565_354, -0.999_889_574, -0.075_108_791],
        [0.999_945_389, 0.000_124_365, 0.010_451_303, -0.272_132_796],
    ];
    let velo = frames::mounted(DVec3::new(0.0, 0.0, 1.73), 0.0, 0.37_f64.to_radians(), 0.0);
    let cam = frames::rigid("cam_from_velo", &cam_from_velo).expect("a rotation").inverse();
    let camera = Mounted {
        name: "image_2".to_owned(),
        sensor: CameraModel::new(1242, 375, p2, None).expect("valid"),
        mount: Mount::new(vec![velo, cam]),
    };
    let lidar =
        Mounted { name: "velodyne".to_owned(), sensor: LidarSpec::hdl64e_kitti(), mount: Mount::new(vec![velo]) };
    Rig::new("kitti".to_owned(), vec![camera], vec![lidar]).expect("a rig")
}

/// A suburb with traffic.
pub fn suburb(seed: u64, weather: &str) -> Scene {
    let weather = Weather::preset(weather).expect("a preset");
    let config = SceneConfig::default();
    Scene::random(StreamKey::scene(seed), &TownSource::Suburb, weather, kitti_rig(), &config).expect("a suburb")
}

/// The triangles of the present instant, and the camera's view.
pub fn place(scene: &mut Scene) -> (Arc<PosedScene>, View) {
    let world_from_cam = scene.world_from_cam();
    (scene.triangles(), View::new(scene.rig().camera(), &world_from_cam))
}
