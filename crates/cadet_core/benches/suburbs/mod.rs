//! Generated suburbs that several benches look at.

use std::sync::Arc;

use cadet_core::camera::{Calibration, CameraModel, View};
use cadet_core::frames;
use cadet_core::lidar::LidarSpec;
use cadet_core::math::DVec3;
use cadet_core::nalgebra::{Matrix3, Matrix3x4};
use cadet_core::rig::Rig;
use cadet_core::rng::StreamKey;
use cadet_core::scene::{Scene, SceneConfig, TownSource};
use cadet_core::sense::PosedScene;
use cadet_core::weather::Weather;

/// Suburbs and weathers whose images docs/performance.md compares.
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
        r0_rect: Matrix3::new(
            0.999_923_9,
            0.009_837_76,
            -0.007_445_048,
            -0.009_869_795,
            0.999_942_1,
            -0.004_278_459,
            0.007_402_527,
            0.004_351_614,
            0.999_963_1,
        ),
        tr_velo_to_cam: Matrix3x4::new(
            0.007_533_745,
            -0.999_971_4,
            -0.000_616_602,
            -0.004_069_766,
            0.014_802_49,
            0.000_728_073_3,
            -0.999_890_2,
            -0.076_316_18,
            0.999_862_1,
            0.007_523_79,
            0.014_807_55,
            -0.271_780_6,
        ),
        tr_imu_to_velo: Matrix3x4::identity(),
    };
    Rig {
        name: "kitti".to_owned(),
        lidar: LidarSpec::hdl64e_kitti(),
        camera: CameraModel::new(1242, 375, calibration).expect("valid"),
        ego_from_velo: frames::mounted(DVec3::new(0.0, 0.0, 1.73), 0.0, 0.37_f64.to_radians(), 0.0),
    }
}

/// A suburb with traffic.
pub fn suburb(seed: u64, weather: &str) -> Scene {
    let weather = Weather::preset(weather).expect("a preset");
    let config = SceneConfig::default();
    Scene::random(StreamKey::scene(seed), &TownSource::Suburb, weather, kitti_rig(), &config).expect("a suburb")
}

/// The triangles of the present instant, and the camera's view.
pub fn place(scene: &mut Scene) -> (Arc<PosedScene>, View) {
    let (_, world_from_cam) = scene.sensor_poses();
    (scene.triangles(), View::new(&scene.rig().camera, &world_from_cam))
}
