//! Bird's-eye-view maps of as many points as KITTI's image sees (19,000), one thread, and beside them the zeros of their
//! memory alone. AVOD's own NumPy code takes about 20 ms for `default`.

use std::hint::black_box;

use cadet_core::bev::{BevSpec, Feature, HeightRule, maps};
use cadet_core::math::{self, TAU};
use cadet_core::rng::Stream;
use criterion::{Criterion, criterion_group, criterion_main};

/// Points of a street in the frame of camera 0: rings on the road, some of their points raised to walls and cars.
fn street() -> Vec<[f64; 3]> {
    let mut stream = Stream::from_seed("bev bench", 0);
    (0..19_000)
        .map(|i| {
            let ring_m = 4.0 + 60.0 * math::pow(f64::from(i / 300) / 63.0, 2.0);
            let azimuth = TAU / 8.8 * (f64::from(i % 300) / 150.0 - 1.0);
            let raised_m = if stream.unit() < 0.5 { 2.5 * stream.unit() } else { 0.02 * stream.unit() };
            [ring_m * math::sin(azimuth), 1.65 - raised_m, ring_m * math::cos(azimuth)]
        })
        .collect()
}

fn bev(c: &mut Criterion) {
    use Feature::{Density, MaxHeight, MinHeight};
    let points = street();
    let plane = [0.01, -0.9999, 0.002, 1.65];
    let spec = |slice_maps: &[Feature], cloud_maps: &[Feature], num_slices, height_rule| BevSpec {
        slice_maps: slice_maps.to_vec(),
        cloud_maps: cloud_maps.to_vec(),
        num_slices,
        height_m: [-0.2, 2.3],
        range_cam_m: [[-40.0, 40.0], [-5.0, 3.0], [0.0, 70.0]],
        cell_m: 0.1,
        height_rule,
    };
    let mut group = c.benchmark_group("bev");
    for (name, spec) in [
        ("default", spec(&[MaxHeight], &[Density], 5, HeightRule::Max)),
        ("default_reference", spec(&[MaxHeight], &[Density], 5, HeightRule::Reference)),
        ("max3_density3", spec(&[MaxHeight, Density], &[], 3, HeightRule::Max)),
        ("max_min_density", spec(&[], &[MaxHeight, MinHeight, Density], 1, HeightRule::Max)),
    ] {
        let mut out = vec![0.0_f32; spec.shape().into_iter().product()];
        group.bench_function(name, |b| {
            b.iter(|| {
                out.fill(0.0);
                maps(black_box(&points).iter().copied(), plane, &spec, &mut out).expect("a good specification");
                black_box(&out);
            });
        });
    }
    // What the maps' memory costs by itself, where the allocator has it at hand.
    let size: usize = spec(&[MaxHeight], &[Density], 5, HeightRule::Max).shape().into_iter().product();
    group.bench_function("zeros", |b| {
        b.iter(|| {
            let mut out: Vec<f32> = black_box(Vec::with_capacity(size));
            out.resize(size, 0.0);
            black_box(&out);
        });
    });
    group.finish();
}

criterion_group!(benches, bev);
criterion_main!(benches);
