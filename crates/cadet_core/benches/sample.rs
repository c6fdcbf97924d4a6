//! Whole samples of generated suburbs: what `cadet-gen` does a frame, and its parts.

use std::hint::black_box;
use std::time::{Duration, Instant};

use cadet_core::camera::png::encode_rgb8;
use cadet_core::camera::{Calibration, CameraModel, View, look, paint};
use cadet_core::lidar::LidarSpec;
use cadet_core::math::DVec3;
use cadet_core::nalgebra::{Matrix3, Matrix3x4};
use cadet_core::rig::Rig;
use cadet_core::rng::StreamKey;
use cadet_core::scene::{Scene, SceneConfig, TownSource};
use cadet_core::weather::Weather;
use criterion::{Criterion, criterion_group, criterion_main};

const SEEDS: [u64; 3] = [0, 1, 2];

/// `cadet.Rig.kitti()`.
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

fn suburb(seed: u64, weather: &str) -> Scene {
    let weather = Weather::preset(weather).expect("a preset");
    let config = SceneConfig::default();
    Scene::random(StreamKey::scene(seed), &TownSource::Suburb, weather, kitti_rig(), &config).expect("a suburb")
}

fn bench(c: &mut Criterion) {
    let uniform = LidarSpec::hdl64e_uniform();
    for seed in SEEDS {
        let mut group = c.benchmark_group(format!("suburb {seed}"));
        let _ = group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
        let _ = group.bench_function("build, dress and settle", |b| b.iter(|| black_box(suburb(seed, "clear_noon"))));
        let mut scene = suburb(seed, "clear_noon");
        let _ = group.bench_function("ideal uniform scan, posing included", |b| {
            b.iter(|| {
                scene.step(0.0).expect("no time passes");
                black_box(scene.ideal_scan(Some(&uniform)))
            });
        });
        let _ = group.bench_function("choose levels and place instances", |b| {
            b.iter(|| {
                scene.step(0.0).expect("no time passes");
                black_box(scene.triangles().num_triangles())
            });
        });
        let _ = group.bench_function("scan with returns", |b| b.iter(|| black_box(scene.scan(None, 0))));
        let _ = group.bench_function("capture: image, scan, labels", |b| b.iter(|| black_box(scene.capture(0, false))));
        let image = scene.capture(0, false).expect("a frame").rendered.image;
        let _ = group.bench_function("encode the image", |b| b.iter(|| black_box(encode_rgb8(1242, 375, &image))));
        let _ = group.bench_function("whole sample: drive 10 m, capture, encode", |b| {
            b.iter(|| {
                scene.drive(10.0, 2.0).expect("a road");
                let frame = scene.capture(0, false).expect("a frame");
                black_box((encode_rgb8(1242, 375, &frame.rendered.image), frame.scan, frame.labels))
            });
        });
        group.finish();
    }
}

/// Suburbs and weathers whose images docs/performance.md compares.
const VIEWS: [(u64, &str); 6] = [
    (0, "clear_noon"),
    (1, "clear_noon"),
    (2, "clear_sunset"),
    (3, "clear_noon"),
    (4, "clear_noon"),
    (5, "soft_rain_noon"),
];

fn images(c: &mut Criterion) {
    for (seed, weather) in VIEWS {
        let mut group = c.benchmark_group(format!("image of suburb {seed}, {weather}"));
        let _ = group.sample_size(20).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
        let mut scene = suburb(seed, weather);
        let mut stream = StreamKey::scene(seed).indexed("camera", 0);
        scene.step(0.1).expect("drives");
        let place = |scene: &mut Scene| {
            let (_, world_from_cam) = scene.sensor_poses();
            (scene.triangles(), View::new(&scene.rig().camera, &world_from_cam))
        };
        let (posed, view) = place(&mut scene);
        let seen = look(&posed, &view).expect("looks");
        let _ = group.bench_function("look", |b| b.iter(|| black_box(look(&posed, &view))));
        let _ = group.bench_function("paint", |b| {
            b.iter(|| black_box(paint(&posed, &view, scene.weather(), &seen, &mut stream)));
        });
        // New streets are not in the caches.
        let _ = group.bench_function("both, driving: each view once, a second apart", |b| {
            b.iter_custom(|views| {
                let mut taken = Duration::ZERO;
                for _ in 0..views {
                    scene.step(1.0).expect("drives");
                    let (posed, view) = place(&mut scene);
                    let start = Instant::now();
                    let seen = look(&posed, &view).expect("looks");
                    black_box(paint(&posed, &view, scene.weather(), &seen, &mut stream));
                    taken += start.elapsed();
                }
                taken
            });
        });
        group.finish();
    }
}

criterion_group!(benches, bench, images);
criterion_main!(benches);
