//! Local profiling.
#![allow(missing_docs, clippy::all)]
use cadet_core::camera::{Calibration, CameraModel};
use cadet_core::lidar::LidarSpec;
use cadet_core::math::DVec3;
use cadet_core::nalgebra::{Matrix3, Matrix3x4};
use cadet_core::rig::Rig;
use cadet_core::rng::StreamKey;
use cadet_core::scene::{Scene, SceneConfig, TownSource};
use cadet_core::weather::Weather;

fn kitti_rig() -> Rig {
    let p = |x: f64, y: f64, z: f64| {
        Matrix3x4::new(721.5377, 0.0, 609.5593, x, 0.0, 721.5377, 172.854, y, 0.0, 0.0, 1.0, z)
    };
    let calibration = Calibration {
        projections: [
            p(0.0, 0.0, 0.0),
            p(-387.57, 0.0, 0.0),
            p(44.857_28, 0.216_379_1, 0.002_745_884),
            p(-341.36, 0.0, 0.0),
        ],
        r0_rect: Matrix3::identity(),
        tr_velo_to_cam: Matrix3x4::new(0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, -0.08, 1.0, 0.0, 0.0, -0.27),
        tr_imu_to_velo: Matrix3x4::identity(),
    };
    Rig {
        name: "kitti".to_owned(),
        lidar: LidarSpec::hdl64e_kitti(),
        camera: CameraModel::new(1242, 375, calibration).expect("valid"),
        velo_in_ego: DVec3::new(0.0, 0.0, 1.73),
    }
}
fn cpu_ms() -> f64 {
    let t = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    t.split(' ').next().unwrap().parse::<f64>().unwrap() / 1e6
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: usize = args.get(1).map_or(10, |a| a.parse().unwrap());
    let seeds: u64 = args.get(2).map_or(2, |a| a.parse().unwrap());
    let mut lidars = vec![("default", LidarSpec::hdl64e_kitti())];
    variants(&mut lidars);
    for seed in 0..seeds {
        let mut s = Scene::random(
            StreamKey::scene(seed),
            &TownSource::Suburb,
            Weather::preset("clear_noon").unwrap(),
            kitti_rig(),
            &SceneConfig::default(),
        )
        .unwrap();
        s.step(0.0).unwrap();
        let _ = s.triangles();
        let ideal = (0..n)
            .map(|_| {
                let a = cpu_ms();
                let r = s.ideal_scan(None);
                let b = cpu_ms() - a;
                std::hint::black_box(r);
                b
            })
            .fold(f64::INFINITY, f64::min);
        print!("seed {seed} ideal {ideal:.1}");
        for (name, l) in &lidars {
            let mut count = 0;
            let t = (0..n)
                .map(|_| {
                    let a = cpu_ms();
                    let r = s.scan(Some(l), 0).unwrap();
                    let b = cpu_ms() - a;
                    count = r.ring.len();
                    b
                })
                .fold(f64::INFINITY, f64::min);
            print!("  {name} {t:.1} ms ({count})");
        }
        println!();
    }
}
fn variants(l: &mut Vec<(&'static str, LidarSpec)>) {
    l.push(("spread", LidarSpec::hdl64e_kitti().with_divergence(3e-3).unwrap()));
    let mut r = LidarSpec::hdl64e_kitti();
    r.rolling = true;
    l.push(("rolling", r));
}
