//! A whole turn of the LIDAR over a made-up suburb of about 400,000 triangles.
#![allow(missing_docs)]

use std::hint::black_box;
use std::sync::Arc;

use cadet_core::geometry::{LodSet, Mesh, MeshBuilder};
use cadet_core::instance::Instance;
use cadet_core::lidar::{LidarSpec, SceneInMotion, ideal_scan, scan, scan_in_motion};
use cadet_core::material::{Material, Palette, Pattern, Semantic};
use cadet_core::math::{self, DPose3, DQuat, DVec3, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{FaceTrees, Hits, PinholeGrid, PosedScene, RayCaster, RigidMotion, SurfaceFilter, cast};
use cadet_core::spray::Spray;
use cadet_core::weather::Weather;
use criterion::{Criterion, criterion_group, criterion_main};

/// A closed ellipsoid of `4 * n * n` triangles.
fn ellipsoid(half: Vec3, n: u32) -> Mesh {
    let mut b = MeshBuilder::new();
    let point = |i: u32, j: u32| {
        let (polar, turn) =
            (i as f32 * std::f32::consts::PI / n as f32, (j % (2 * n)) as f32 * std::f32::consts::PI / n as f32);
        let s = math::sinf(polar);
        Vec3::new(s * math::cosf(turn), s * math::sinf(turn), math::cosf(polar)) * half
    };
    for i in 0..n {
        for j in 0..2 * n {
            b.quad(point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1), 0);
        }
    }
    b.build("ellipsoid", 3.0)
}

fn slab(half: Vec3, n: i32) -> Mesh {
    let mut b = MeshBuilder::new();
    let p = |i: i32, j: i32| Vec3::new(half.x * i as f32 / n as f32, half.y * j as f32 / n as f32, half.z);
    for i in -n..n {
        for j in -n..n {
            b.quad(p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1), 0);
        }
    }
    b.build("slab", 0.5)
}

/// Ground, 60 cars, 60 trees, 40 houses, 29 bushes along a road on x.
fn suburb() -> Vec<Instance> {
    let mut s = Stream::from_seed("bench", 0);
    let palette = Arc::new(Palette::new(vec![Material::matt(Semantic::Building, [0.5; 3], Pattern::Plain, 0.3)]));
    let shape = |mesh| Arc::new(LodSet::single(mesh));
    let (car, crown) = (shape(ellipsoid(Vec3::new(2.0, 0.8, 0.7), 24)), shape(ellipsoid(Vec3::new(2.5, 2.5, 2.5), 36)));
    let (bush, house) =
        (shape(ellipsoid(Vec3::new(1.0, 0.7, 0.9), 20)), shape(ellipsoid(Vec3::new(5.0, 4.0, 4.0), 10)));
    let ground = shape(slab(Vec3::new(120.0, 120.0, 0.0), 40));
    let mut instances = Vec::new();
    let mut add = |shape: &Arc<LodSet>, x: f64, y: f64, z: f64, id: i32| {
        let world_from_local =
            DPose3 { rotation: DQuat::from_rotation_z(s.normal() * 0.1), translation: DVec3::new(x, y, z) };
        instances.push(Instance::new(Arc::clone(shape), Arc::clone(&palette), world_from_local, id));
    };
    add(&ground, 0.0, 0.0, 0.0, 0);
    for i in 0..60 {
        let (x, side) = (f64::from(i / 2) * 5.5 - 80.0, f64::from(i % 2) * 2.0 - 1.0);
        add(&car, x, side * 4.5, 0.75, i + 1);
        add(&crown, x + 2.0, side * 8.0, 5.0, 0);
        if i < 40 {
            add(&house, x * 1.5 + 20.0, side * 16.0, 3.5, 0);
        }
        if i < 29 {
            add(&bush, x * 2.0 + 40.0, side * 10.0, 0.8, 0);
        }
    }
    instances
}

fn benches(c: &mut Criterion) {
    let instances = suburb();
    let sensor = DPose3 { rotation: DQuat::from_rotation_z(0.1), translation: DVec3::new(0.3, -1.6, 1.73) };
    let scene = Arc::new(PosedScene::new(&instances, sensor.translation));
    let uniform = LidarSpec::hdl64e_uniform();
    let kitti = LidarSpec::hdl64e_kitti();
    let weather = Weather::preset("clear_noon").expect("exists");
    let mut group = c.benchmark_group(format!("{} triangles in {} instances", scene.num_triangles(), instances.len()));
    let _ = group.sample_size(20);
    let _ = group.bench_function("choose levels and place instances", |b| {
        b.iter(|| PosedScene::new(black_box(&instances), sensor.translation));
    });
    let _ =
        group.bench_function("ideal scan, uniform", |b| b.iter(|| ideal_scan(black_box(&scene), &sensor, &uniform)));
    let _ = group.bench_function("ideal scan, kitti", |b| b.iter(|| ideal_scan(black_box(&scene), &sensor, &kitti)));
    let _ = group.bench_function("scan, kitti", |b| {
        b.iter(|| scan(black_box(&scene), &sensor, &kitti, &weather, &mut Stream::from_seed("bench", 1)));
    });
    let mut trees = FaceTrees::default();
    let driving = |mps: f64| RigidMotion { velocity_world: DVec3::X * mps, ..RigidMotion::default() };
    let _ = group.bench_function("scan in motion, kitti", |b| {
        b.iter(|| {
            let still = Arc::clone(black_box(&scene));
            let moving = SceneInMotion::new(still, &mut trees, &kitti, sensor, driving(14.0), |_| driving(-8.0));
            scan_in_motion(&moving, &kitti, (&weather, &Spray::default()), &mut Stream::from_seed("bench", 1))
        });
    });
    let axes = cadet_core::frames::cam_axes_from_velo_axes().transpose();
    let camera = DPose3 { rotation: sensor.rotation * DQuat::from_mat3(&axes), translation: sensor.translation };
    let grid = PinholeGrid::new(camera, [721.5, 721.5, 609.6, 172.9], [0.0, 0.0, 1.0, 1.0], 375, 1242).expect("valid");
    let mut hits = Hits::new(375, 1242);
    let _ = group.bench_function("pinhole, 1242 x 375", |b| {
        b.iter(|| {
            hits.clear();
            cast(black_box(&scene), &grid, SurfaceFilter::All, |_| true, &mut hits);
        });
    });
    let _ = group.bench_function("parry, build", |b| b.iter(|| RayCaster::new(Arc::clone(&scene))));
    let caster = RayCaster::new(Arc::clone(&scene));
    let rays = uniform.rays();
    let _ = group.sample_size(10).bench_function("parry, uniform", |b| {
        b.iter(|| {
            let cast = |d: &DVec3| caster.cast(sensor.translation, sensor.rotation * *d).expect("finite");
            rays.directions_velo.iter().filter_map(cast).map(|h| h.range_m).sum::<f64>()
        });
    });
    group.finish();
}

criterion_group!(scan_benches, benches);
criterion_main!(scan_benches);
