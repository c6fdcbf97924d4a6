//! Vehicles made of a user's meshes: their box frame, their materials, their place in traffic, and what is refused.

#![allow(clippy::unwrap_used)]

#[path = "common/source.rs"]
mod source;

use std::sync::Arc;

use cadet_core::actor::ObjectClass;
use cadet_core::assets::imported::{MaterialRules, MeshAsset, Role, UserModels};
use cadet_core::assets::vehicle::VehicleModel;
use cadet_core::geometry::Bounds;
use cadet_core::material::{Material, Semantic};
use cadet_core::math::{DVec3, Vec3};
use cadet_core::rng::{Stream, StreamKey};
use cadet_core::town::{PropConfig, SuburbConfig, Town};
use cadet_core::world::{TrafficConfig, World};
use source::mesh_of;

/// A block of an OBJ file from `min` to `max`, its faces counter-clockwise from outside.
fn block(obj: &mut String, num_blocks: &mut usize, material: &str, min: [f32; 3], max: [f32; 3]) {
    let base = *num_blocks * 8;
    *num_blocks += 1;
    for i in 0..8 {
        let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        obj.push_str(&format!("v {} {} {}\n", pick(0), pick(1), pick(2)));
    }
    obj.push_str(&format!("usemtl {material}\n"));
    for face in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        let [a, b, c, d] = face.map(|k| base + k);
        obj.push_str(&format!("f {a} {b} {c} {d}\n"));
    }
}

const LIBRARY: [(&str, [f32; 3], f32); 4] = [
    ("Lack", [0.6, 0.05, 0.04], 1.0),
    ("Window_All", [0.2; 3], 0.2),
    ("Seats", [0.1; 3], 1.0),
    ("Wheel", [0.6; 3], 1.0),
];

/// A car in centimeters that looks along -y: 4.2 x 1.8 x 1.5 m, its axles 1.3 m before and 1.2 m behind the middle, a
/// cabin of panes with a seat inside. It floats 7 cm above the file's zero, beside its origin.
fn car_text() -> String {
    let (mut obj, mut n) = (String::new(), 0);
    let (x, y, z) = (300.0, 1000.0, 7.0);
    let mut part = |material: &str, min: [f32; 3], max: [f32; 3]| {
        block(&mut obj, &mut n, material, [min[0] + x, min[1] + y, min[2] + z], [max[0] + x, max[1] + y, max[2] + z]);
    };
    part("Lack", [-90.0, -210.0, 25.0], [90.0, 210.0, 90.0]);
    part("Window_All", [-75.0, -60.0, 90.0], [75.0, 170.0, 150.0]);
    part("Seats", [-60.0, -20.0, 90.0], [60.0, 40.0, 130.0]);
    for (side, axle) in [(-75.0, -130.0), (75.0, -130.0), (-75.0, 120.0), (75.0, 120.0)] {
        part("Wheel", [side - 10.0, axle - 30.0, 0.0], [side + 10.0, axle + 30.0, 60.0]);
    }
    obj
}

fn car() -> MeshAsset {
    car_of(&car_text())
}

fn car_of(text: &str) -> MeshAsset {
    MeshAsset {
        name: "mine".to_owned(),
        class: ObjectClass::Car,
        file: "car.obj".to_owned(),
        source: mesh_of(text, &LIBRARY),
        scale: 0.01,
        yaw_rad: std::f64::consts::FRAC_PI_2,
        y_up: false,
        size_lwh: None,
        rules: MaterialRules::default(),
        leave_out: None,
    }
}

/// Bounds of the faces of a material that fits.
fn bounds_of(model: &VehicleModel, keep: impl Fn(&Material) -> bool) -> Bounds {
    let mesh = model.body.select(0.0, 1.0).expect("near enough to be drawn");
    let faces = mesh.triangles().filter(|(_, slot)| keep(&model.palette.materials()[usize::from(*slot)]));
    Bounds::of(faces.flat_map(|(corners, _)| corners))
}

#[track_caller]
fn assert_near(a: Vec3, b: Vec3) {
    assert!((a - b).abs().max_element() < 1e-4, "{a} is not {b}");
}

#[test]
fn the_box_frame_is_centered_on_the_ground_with_the_front_forward() {
    let model = VehicleModel::from_asset(&car()).unwrap();
    let bounds = model.body.select(0.0, 1.0).expect("near enough to be drawn").bounds;
    assert_near(bounds.min, Vec3::new(-2.1, -0.9, 0.0));
    assert_near(bounds.max, Vec3::new(2.1, 0.9, 1.5));
    assert!((model.size_lwh - DVec3::new(4.2, 1.8, 1.5)).abs().max_element() < 1e-4);
    // The file's -y is ahead: the cabin reaches from 0.6 m before the middle to 1.7 m behind it.
    let panes = bounds_of(&model, Material::is_transparent);
    assert_near(panes.min, Vec3::new(-1.7, -0.75, 0.9));
    assert_near(panes.max, Vec3::new(0.6, 0.75, 1.5));
    assert_eq!((model.name.as_str(), model.class), ("mine", ObjectClass::Car));
    assert!(model.wheel.is_none() && model.driver.is_none());
}

#[test]
fn wheels_are_found_by_their_tyres_and_touch_the_ground() {
    let model = VehicleModel::from_asset(&car()).unwrap();
    assert!((model.wheel_radius_m - 0.3).abs() < 1e-4);
    let expected = [(1.3, 1.0), (1.3, -1.0), (-1.2, 1.0), (-1.2, -1.0)];
    for (center, (x, side)) in model.wheel_centers.iter().zip(expected) {
        assert_near(*center, Vec3::new(x, side * 0.75, 0.3));
    }
    // Without materials that tell, the lowest faces do.
    let unnamed = car_of(&car_text().replace("usemtl Wheel", "usemtl Lack"));
    let found = VehicleModel::from_asset(&unnamed).unwrap();
    for (a, b) in found.wheel_centers.iter().zip(&model.wheel_centers) {
        assert!((a.truncate() - b.truncate()).length() < 1e-3, "{a} {b}");
    }
}

#[test]
fn a_size_that_is_asked_for_is_met() {
    let wanted = DVec3::new(3.9, 1.7, 1.6);
    let model = VehicleModel::from_asset(&MeshAsset { size_lwh: Some(wanted), scale: 40.0, ..car() }).unwrap();
    let bounds = model.body.select(0.0, 1.0).expect("near enough to be drawn").bounds;
    assert_near(bounds.max - bounds.min, wanted.as_vec3());
    assert!(bounds.min.z.abs() < 1e-6 && bounds.center().truncate().length() < 1e-5);
    assert_eq!(model.size_lwh, wanted);
}

#[test]
fn a_file_with_y_up_is_stood_upright() {
    // (x, y, z) as the file of a modeller with y up has it: (x, z, -y).
    let turn = |line: &str| {
        let v: Vec<f32> = line.split_whitespace().skip(1).map(|t| t.parse().unwrap()).collect();
        format!("v {} {} {}", v[0], v[2], -v[1])
    };
    let text = car_text();
    let lines = text.lines().map(|l| if l.starts_with("v ") { turn(l) } else { l.to_owned() });
    let upright = VehicleModel::from_asset(&car()).unwrap();
    let asset = MeshAsset { y_up: true, ..car_of(&lines.collect::<Vec<_>>().join("\n")) };
    let turned = VehicleModel::from_asset(&asset).unwrap();
    let panes = [&upright, &turned].map(|m| bounds_of(m, Material::is_transparent));
    assert_near(panes[0].min, panes[1].min);
    assert_near(panes[0].max, panes[1].max);
}

#[test]
fn materials_are_glass_rubber_cloth_and_paint() {
    let model = VehicleModel::from_asset(&car()).unwrap();
    let [paint, pane, seat, tyre, unnamed] = model.palette.materials()[..] else { panic!("{:?}", model.palette) };
    assert!(model.palette.materials().iter().all(|m| m.semantic == Semantic::Car));
    assert!(pane.is_transparent() && pane.transmission > 0.6 && pane.lidar.transmission > 0.6);
    assert!([paint, seat, tyre, unnamed].iter().all(|m| !m.is_transparent() && m.lidar.transmission == 0.0));
    assert_eq!(paint.albedo, [0.6, 0.05, 0.04]);
    assert!(paint.lidar.reflectance > 0.4 && paint.lidar.coat_index > 1.0, "red paint is bright at 905 nm");
    assert!(tyre.lidar.reflectance < 0.1 && tyre.albedo[0] < 0.1, "tyres are black whatever the file says");
    assert_eq!(seat.specular, 0.0);
    let rules = MaterialRules(vec![(Role::Plate, vec!["lack".to_owned()])]);
    let model = VehicleModel::from_asset(&MeshAsset { rules, ..car() }).unwrap();
    assert!(model.palette.materials()[0].lidar.retro);
}

#[test]
fn what_makes_no_vehicle_is_refused_by_name() {
    let refuse = |change: &dyn Fn(&mut MeshAsset)| {
        let mut asset = car();
        change(&mut asset);
        VehicleModel::from_asset(&asset).unwrap_err().to_string()
    };
    assert_eq!(refuse(&|a| a.scale = 1.0), "car.obj: 420.000 m long, expected 1 to 30 m for a Car: check scale");
    assert_eq!(
        refuse(&|a| a.size_lwh = Some(DVec3::new(0.5, 0.4, 0.4))),
        "car.obj: 0.500 m long, expected 1 to 30 m for a Car: check size_lwh"
    );
    assert_eq!(
        refuse(&|a| a.yaw_rad = 0.0),
        "car.obj: wider (4.20 m) than long (1.80 m): turn its front to +x with yaw_deg"
    );
    assert_eq!(refuse(&|a| a.source = Default::default()), "car.obj: no triangle with an area");
    assert_eq!(
        refuse(&|a| a.source = mesh_of("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3", &[])),
        "car.obj: no triangle with an area"
    );
    let nan = car_text().replacen("v ", "v nan ", 1);
    assert!(refuse(&|a| a.source = mesh_of(&nan, &LIBRARY)).starts_with("car.obj: a coordinate is not finite"));
    assert_eq!(refuse(&|a| a.source.materials.clear()), "car.obj: a face of material 0 of 0 and part 0 of 1");
    let fan: String = (0..1200).map(|i| format!("v {} {i} 1\n", i % 2)).collect();
    let corners: String = (1..1200).map(|i| format!(" {i}")).collect();
    let fan = mesh_of(&format!("{fan}f{corners}"), &[]);
    assert!(
        refuse(&|a| (a.source, a.scale) = (fan.clone(), 1.0)).contains("more than 1000 triangles meet in one place")
    );
    assert!(refuse(&|a| a.yaw_rad = f64::NAN).contains("not finite"));
    assert!(refuse(&|a| a.size_lwh = Some(DVec3::NAN)).contains("check size_lwh"));
    assert_eq!(refuse(&|a| a.scale = -1.0), "mesh scale is -1, expected above 0 and finite");
    assert_eq!(
        refuse(&|a| a.rules = MaterialRules(vec![(Role::Glass, vec!["Fenster*".to_owned()])])),
        "car.obj: materials.glass: no material is named \"Fenster*\"; known: Lack, Window_All, Seats, Wheel"
    );
    let person = "scene: no vehicle is of class Pedestrian: Car, Van, Truck, Tram or Misc";
    assert_eq!(refuse(&|a| a.class = ObjectClass::Pedestrian), person);
    let flat = "v 0 0 0\nv 4 0 0\nv 4 2 0\nf 1 2 3\n";
    assert_eq!(
        refuse(&|a| (a.source, a.scale) = (mesh_of(flat, &[]), 1.0)),
        "car.obj: no body: its bounds are 2.000 x 4.000 x 0.000"
    );
}

#[test]
fn shares_and_names_are_checked() {
    assert!(UserModels::new(1.5, &[car()]).unwrap_err().to_string().contains("1.5, expected 0 to 1"));
    assert!(UserModels::new(f64::NAN, &[car()]).is_err());
    let twice = UserModels::new(0.5, &[car(), car()]).unwrap_err();
    assert_eq!(twice.to_string(), "car.obj: the name \"mine\" is taken");
    let unknown = UserModels::default().by_name(ObjectClass::Car, "x").unwrap_err();
    assert_eq!(unknown.to_string(), "unknown model \"x\"; known: none, the scene has no assets");
}

#[test]
fn draws_keep_the_share_and_the_mix_of_classes() {
    let named = |name: &str, class| MeshAsset { name: name.to_owned(), class, ..car() };
    let assets = [named("a", ObjectClass::Car), named("b", ObjectClass::Car), named("t", ObjectClass::Truck)];
    let vehicles = UserModels::new(0.4, &assets).unwrap();
    let mix = [(ObjectClass::Car, 0.7), (ObjectClass::Van, 0.2), (ObjectClass::Truck, 0.1)];
    let mut stream = Stream::from_seed("draws", 1);
    let num = 8000;
    let drawn: Vec<_> = (0..num).filter_map(|_| vehicles.draw(&mut stream, &mix, |_| true)).collect();
    let share = |name: &str| drawn.iter().filter(|m| m.name == name).count() as f64 / f64::from(num);
    assert!((drawn.len() as f64 / f64::from(num) - 0.4).abs() < 0.025);
    assert!((share("a") - 0.4 * 0.4375).abs() < 0.02 && (share("b") - 0.4 * 0.4375).abs() < 0.02);
    assert!((share("t") - 0.4 * 0.125).abs() < 0.012);
    assert!(vehicles.draw(&mut stream, &mix[1..2], |_| true).is_none(), "no van among them");
}

fn street(share: f64, assets: &[MeshAsset]) -> World {
    let key = StreamKey::scene(4);
    let town = Town::suburb(&key, &SuburbConfig::default(), &PropConfig::default()).unwrap();
    let vehicles = UserModels::new(share, assets).unwrap();
    let mut world = World::new(Arc::new(town), key).unwrap().with_user_models(vehicles);
    let config = TrafficConfig { num_cars: 8, num_pedestrians: 2, ..TrafficConfig::default() };
    world.spawn_traffic(&config).unwrap();
    world
}

/// Model and place of every vehicle but the ego.
fn vehicles(world: &World) -> Vec<(String, DVec3)> {
    let is_on_foot = |class| matches!(class, ObjectClass::Pedestrian | ObjectClass::PersonSitting);
    let actors = world.snapshot().actors.into_iter().filter(|a| !is_on_foot(a.class));
    actors.map(|a| (a.model, a.world_from_box.translation)).collect()
}

#[test]
fn they_drive_and_park_among_the_others_and_none_changes_nothing() {
    let without = vehicles(&street(0.5, &[]));
    assert_eq!(vehicles(&street(0.0, &[car()])), without, "a share of nothing is nothing");
    let all = vehicles(&street(1.0, &[car()]));
    assert!(all.len() > 20 && all.iter().all(|(name, _)| name == "mine"), "{all:?}");
    let mut world = street(0.5, &[car()]);
    let half = vehicles(&world);
    assert_eq!(vehicles(&street(0.5, &[car()])), half);
    let num_mine = half.iter().filter(|(name, _)| name == "mine").count();
    assert!(num_mine > half.len() / 4 && num_mine < half.len() * 3 / 4, "{num_mine} of {}", half.len());

    world.step(300);
    let mine: Vec<_> = world.snapshot().actors.into_iter().filter(|a| a.model == "mine").collect();
    assert!(mine.iter().any(|a| a.velocity_world.length() > 1.0), "some drive");
    for actor in &mine {
        // The mesh has its wheels' feet here, at z = 0.
        for (x, y) in [(1.3, 0.75), (1.3, -0.75), (-1.2, 0.75), (-1.2, -0.75)] {
            let foot = actor.world_from_box.transform_point(DVec3::new(x, y, 0.0));
            let above_m = foot.z - world.ground_height(foot.x, foot.y).unwrap();
            // Springs give under a car that brakes or turns; a curb under one wheel tilts a parked one.
            let limit_m = if actor.velocity_world.length() > 0.1 { 0.10 } else { 0.07 };
            assert!(above_m.abs() < limit_m, "{} {above_m} {}", actor.id, actor.velocity_world);
        }
    }
}

#[test]
fn what_lies_around_a_vehicle_is_named_and_left_out() {
    let mut text = format!("g car\n{}g shadow_plane\n", car_text());
    block(&mut text, &mut 7, "Lack", [-500.0, 300.0, 0.0], [1100.0, 1800.0, 1.0]);
    let wide = car_of(&text);
    let error = VehicleModel::from_asset(&wide).unwrap_err().to_string();
    assert_eq!(
        error,
        "car.obj: 16.000 m wide, expected 0.3 to 5 m for a Car: check scale; without \"shadow_plane\" it would do: \
         materials.leave_out = [\"shadow_plane\"] in assets.toml leaves that out"
    );
    let plain = VehicleModel::from_asset(&car()).unwrap();
    for pattern in ["shadow*", "*PLANE"] {
        let asset = MeshAsset { leave_out: Some(vec![pattern.to_owned()]), ..wide.clone() };
        let model = VehicleModel::from_asset(&asset).unwrap();
        assert_eq!((model.size_lwh, model.body.finest().bounds), (plain.size_lwh, plain.body.finest().bounds));
    }
    let lost = MeshAsset { leave_out: Some(vec!["Floor".to_owned()]), ..wide.clone() };
    assert!(VehicleModel::from_asset(&lost).unwrap_err().to_string().starts_with(
        "car.obj: materials.leave_out: no material, node, object or group is named \"Floor\"; known: Lack, Window_All"
    ));
    // A shadow as large as the car refuses nothing, but nobody wants it: who has not thought of it hears of it.
    let mut text = format!("g car\n{}g Shadow\n", car_text());
    block(&mut text, &mut 7, "Lack", [205.0, 780.0, 0.0], [395.0, 1220.0, 0.1]);
    let (_, said) = VehicleModel::with_assumptions(&car_of(&text)).unwrap();
    assert!(said[0].starts_with("car.obj: \"Shadow\" is taken as a part of the body"), "{said:?}");
    let kept = MeshAsset { leave_out: Some(Vec::new()), ..car_of(&text) };
    assert_eq!(VehicleModel::with_assumptions(&kept).unwrap().1, Vec::<String>::new());
}
