//! One KITTI-sized image of a made-up street, one thread.

use strum::VariantArray;

use std::hint::black_box;
use std::sync::Arc;

use cadet_core::actor::ObjectClass;
use cadet_core::assets::scenery::{HouseKind, TreeKind, house, tree};
use cadet_core::assets::vehicle::VehicleModel;
use cadet_core::camera::{View, png, render, visibility_pass};
use cadet_core::frames::upright;
use cadet_core::geometry::{LodSet, MeshBuilder};
use cadet_core::instance::Instance;
use cadet_core::material::{Material, Palette, Pattern, Semantic};
use cadet_core::math::{DMat3, DPose3, DQuat, DVec3, PI, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::PosedScene;
use cadet_core::weather::Weather;
use criterion::{Criterion, criterion_group, criterion_main};

const EYE: DVec3 = DVec3::new(0.0, 0.0, 1.65);

fn street() -> PosedScene {
    let mut ground = MeshBuilder::new();
    for i in -4..30 {
        let p = |x: i32, y: f32| Vec3::new(x as f32 * 5.0, y, 0.0);
        for (right, left, slot) in [(-60.0, -4.0, 1), (-4.0, 4.0, 0), (4.0, 60.0, 1)] {
            ground.quad(p(i, right), p(i + 1, right), p(i + 1, left), p(i, left), slot);
        }
    }
    let palette = Palette::new(vec![
        Material::matt(Semantic::Road, [0.115; 3], Pattern::Asphalt, 0.2),
        Material::matt(Semantic::Terrain, [0.07, 0.10, 0.04], Pattern::Grass, 0.2),
    ]);
    let mut instances = vec![Instance::new(
        Arc::new(LodSet::single(ground.build("ground", 0.5))),
        Arc::new(palette),
        DPose3::IDENTITY,
        0,
    )];
    for k in 0..20_usize {
        let (x, side) = (k as f64 * 6.0 + 6.0, if k % 2 == 0 { 1.0 } else { -1.0 });
        let yaw = -side * PI / 2.0;
        instances.push(
            house(HouseKind::VARIANTS[k % HouseKind::VARIANTS.len()], 0)
                .model
                .at(upright(DVec3::new(x, side * 16.0, 0.0), yaw)),
        );
        instances.push(tree(TreeKind::Street, k % 2).at(upright(DVec3::new(x + 3.0, side * 5.5, 0.0), k as f64)));
        let car = VehicleModel::generate(ObjectClass::Car, k as u64).expect("a car has a shape");
        instances.push(Instance::new(
            Arc::clone(&car.body),
            Arc::clone(&car.palette),
            upright(DVec3::new(x, side * 2.8, 0.0), 0.0),
            k as i32 + 1,
        ));
    }
    PosedScene::new(&instances, EYE)
}

fn images(c: &mut Criterion) {
    let scene = street();
    let axes = DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X);
    let view = View {
        intrinsics_px: [721.5377, 721.5377, 609.5593, 172.854],
        width: 1242,
        height: 375,
        world_from_cam: DPose3 { rotation: DQuat::from_mat3(&axes), translation: EYE },
    };
    let picture = |weather: &Weather| {
        let seen = visibility_pass(&scene, &view).expect("looks");
        render(&scene, &view, weather, &seen, &mut Stream::from_seed("bench", 0))
    };
    c.bench_function("visibility pass: what the samples see", |b| {
        b.iter(|| black_box(visibility_pass(&scene, &view).expect("looks")))
    });
    for name in ["clear_noon", "soft_rain_noon"] {
        let weather = Weather::preset(name).expect("a preset");
        c.bench_function(&format!("image {name}"), |b| b.iter(|| black_box(picture(&weather))));
    }
    let image = picture(&Weather::preset("clear_noon").expect("a preset"));
    c.bench_function("png", |b| b.iter(|| png::encode_rgb8(1242, 375, black_box(&image)).expect("encodes")));
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = images }
criterion_main!(benches);
