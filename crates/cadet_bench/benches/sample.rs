//! Whole samples of generated suburbs: what `cadet-gen` does a frame, and its parts.

mod suburbs;

use std::hint::black_box;
use std::time::{Duration, Instant};

use cadet_core::camera::png::encode_rgb8;
use cadet_core::camera::{render, visibility_pass};
use cadet_core::lidar::LidarSpec;
use cadet_core::rng::StreamKey;
use cadet_core::scene::CaptureRequest;
use criterion::{Criterion, criterion_group, criterion_main};

use suburbs::{VIEWS, place, suburb};

const SEEDS: [u64; 3] = [0, 1, 2];

fn bench(c: &mut Criterion) {
    let uniform = LidarSpec::hdl64e_uniform();
    for seed in SEEDS {
        let mut group = c.benchmark_group(format!("suburb {seed}"));
        let _ = group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
        let _ = group.bench_function("build and settle", |b| b.iter(|| black_box(suburb(seed, "clear_noon"))));
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
        let _ = group.bench_function("capture: image, scan, labels", |b| {
            b.iter(|| black_box(scene.capture(&CaptureRequest::default())))
        });
        let image = scene.capture(&CaptureRequest::default()).expect("a frame").images.remove(0).rendered.image;
        let _ = group.bench_function("encode the image", |b| b.iter(|| black_box(encode_rgb8(1242, 375, &image))));
        let _ = group.bench_function("whole sample: drive 10 m, capture, encode", |b| {
            b.iter(|| {
                scene.drive(10.0, 2.0).expect("a road");
                let frame = scene.capture(&CaptureRequest::default()).expect("a frame");
                black_box((encode_rgb8(1242, 375, &frame.images[0].rendered.image), frame.scans))
            });
        });
        group.finish();
    }
}

fn images(c: &mut Criterion) {
    for (seed, weather) in VIEWS {
        let mut group = c.benchmark_group(format!("image of suburb {seed}, {weather}"));
        let _ = group.sample_size(20).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
        let mut scene = suburb(seed, weather);
        let mut stream = StreamKey::scene(seed).indexed("camera", 0);
        scene.step(0.1).expect("drives");
        let (posed, view) = place(&mut scene);
        let seen = visibility_pass(&posed, &view).expect("looks");
        let _ = group.bench_function("visibility_pass", |b| b.iter(|| black_box(visibility_pass(&posed, &view))));
        let _ = group.bench_function("render", |b| {
            b.iter(|| black_box(render(&posed, &view, scene.weather(), &seen, &mut stream)));
        });
        // New streets are not in the caches.
        let _ = group.bench_function("both, driving: each view once, a second apart", |b| {
            b.iter_custom(|views| {
                let mut taken = Duration::ZERO;
                for _ in 0..views {
                    scene.step(1.0).expect("drives");
                    let (posed, view) = place(&mut scene);
                    let start = Instant::now();
                    let seen = visibility_pass(&posed, &view).expect("looks");
                    black_box(render(&posed, &view, scene.weather(), &seen, &mut stream));
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
