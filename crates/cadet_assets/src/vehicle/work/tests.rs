//! The bodies of trucks and trailers: they fill their boxes, stand on their wheels, and look as KITTI's are large.

use super::super::levels::LEVELS;
use super::super::paint;
use super::super::tests::{check_margins, check_meshes, check_quantiles, check_wheels, design_number};
use super::body::{BODIES, Body, Room};
use super::*;
use crate::annotation::vehicle_size;
use crate::rays::Target;

const SEEDS: u64 = 120;

fn models() -> impl Iterator<Item = VehicleModel> {
    let classes = [ObjectClass::Truck, ObjectClass::Misc];
    classes.into_iter().flat_map(|c| (0..SEEDS).map(move |seed| VehicleModel::generate(c, seed).unwrap()))
}

fn kind(model: &VehicleModel) -> &str {
    model.name.split('/').next().unwrap()
}

#[test]
fn bodies_fill_their_boxes_at_every_level() {
    for model in models() {
        let size = model.size_lwh.as_vec3();
        for (_, mesh) in &model.body.levels {
            let b = mesh.bounds;
            let name = &model.name;
            assert!((b.max.x - size.x / 2.0).abs() < 2e-3 && (b.min.x + size.x / 2.0).abs() < 2e-3, "{name}: {b:?}");
            assert!((b.max.z - size.z).abs() < 2e-3, "{name} is {} high, not {}", b.max.z, size.z);
            // Mirrors stick out, to both sides alike.
            let out = b.max.y - size.y / 2.0;
            let most = if model.class == ObjectClass::Truck { 0.30 } else { 0.05 };
            assert!((-0.05..most).contains(&out) && (b.max.y + b.min.y).abs() < 0.06, "{name}: {b:?}");
            assert!(b.min.z > -0.03, "{name} reaches {} into the ground", b.min.z);
        }
    }
}

#[test]
fn every_kind_is_made_and_none_prevails() {
    let mut counts = std::collections::BTreeMap::new();
    for model in models() {
        *counts.entry(kind(&model).to_owned()).or_insert(0) += 1;
    }
    assert_eq!(counts.len(), 15, "{counts:?}");
    assert!(counts.values().all(|n| *n <= SEEDS as usize / 2), "{counts:?}");
}

/// The body of a plan, its room, and its seed; trucks and trailers by turns.
fn bodies() -> impl Iterator<Item = (&'static Body, Room, u64)> {
    (0..SEEDS).flat_map(|seed| {
        let stream = || Stream::from_seed("vehicle", seed);
        let (truck, trailer) = (Plan::draw(&mut stream()), TowedPlan::draw(&mut stream()));
        [truck.load(), trailer.load()].into_iter().filter_map(|load| Some((load.body?, load.room, load.seed)))
    })
}

#[test]
fn bodies_keep_to_their_rooms_at_every_level() {
    let mut left: std::collections::BTreeSet<&str> = BODIES.iter().map(|body| body.name.as_str()).collect();
    for (body, room, seed) in bodies() {
        left.remove(body.name.as_str());
        for level in 0..LEVELS {
            let b = body.draw(&room, seed, level).unwrap().bounds();
            let name = format!("{}/{seed} at level {level}: {b:?} in {room:?}", body.name);
            // Coolers and shields reach over the cab.
            assert!(b.min.x > room.rear_x - 0.01 && b.max.x < room.front_x + 0.51, "{name}");
            assert!(b.max.y.max(-b.min.y) < room.half_y + 0.01 && b.max.y > room.half_y - 0.06, "{name}");
            assert!(b.max.z < room.top_z + 0.01 && b.min.z > 0.25, "{name}");
        }
    }
    assert!(left.is_empty(), "no {left:?}");
}

/// Sheets have a front alone: from outside nobody sees the back of one.
#[test]
fn bodies_face_outwards_at_every_level() {
    for (body, room, seed) in bodies().take(60) {
        let (low, high) =
            (Vec3::new(room.rear_x, -room.half_y, room.floor_z), Vec3::new(room.front_x, room.half_y, room.top_z));
        for level in 0..LEVELS {
            let target = Target::new(&body.draw(&room, seed, level).unwrap().build("body", 0.5), |_| true);
            let (mut hits, mut backs) = (0, 0);
            for outwards in [Vec3::Y, Vec3::NEG_Y, Vec3::NEG_X, Vec3::Z] {
                for k in 0..300 {
                    let shares = Vec3::new(0.618, 0.414, 0.732) * k as f32;
                    let from = low + (high - low) * (shares - shares.floor()) + outwards * 20.0;
                    let Some(hit) = target.cast(from, -outwards) else { continue };
                    hits += 1;
                    backs += u32::from(!hit.is_outside);
                }
            }
            // Gaps at edges let some through.
            assert!(hits > 300 && 50 * backs < hits, "{}/{seed} level {level}: {backs} of {hits}", body.name);
        }
    }
}

const HAY: &str = r#"let = ["h = range(0.5, 0.9)", "rows = by_level(9, 6, 3, 1)"]
parts = [
    { of = "board", box = "rear_x, front_x, -half_y, half_y, floor_z, floor_z + 0.1" },
    { of = "cargo", when = "hay_wagon", along = "i in 0..rows + 1", sheet = "rear_x + i / rows, y, floor_z + h for y in -1, 1" },
]

[kinds]
hay_wagon = { low = 0.5 }
empty_wagon = { low = 0.1, flat = 0.2 }
"#;

#[test]
fn a_file_is_a_body_for_each_of_its_kinds() {
    let room = Room { front_x: 2.0, rear_x: -2.0, half_y: 1.2, floor_z: 1.0, top_z: 2.5 };
    let bodies = Body::parse("hay.toml", HAY).unwrap();
    let drawn = |name: &str, seed: u64, level: usize| {
        bodies.iter().find(|body| body.name == name).unwrap().draw(&room, seed, level).unwrap()
    };
    for (level, rows) in [9, 6, 3, 1].into_iter().enumerate() {
        assert_eq!(drawn("empty_wagon", 0, level).num_faces(), 12);
        let hay = drawn("hay_wagon", 0, level);
        assert_eq!(hay.num_faces(), 12 + 2 * rows);
        assert_eq!(hay.bounds(), drawn("hay_wagon", 0, 0).bounds());
        assert_ne!(hay.bounds(), drawn("hay_wagon", 1, level).bounds());
    }
    for (from, to, line, part) in [
        ("\"board\"", "\"left_signal\"", 3, "of: unknown name \"left_signal\"; known: load, frame"),
        ("rear_x, front_x", "back_x, front_x", 3, "unknown name \"back_x\"; known here: level, front_x"),
        ("\"hay_wagon\"", "\"straw_wagon\"", 4, "unknown name \"straw_wagon\""),
        ("low = 0.5", "low = 2", 8, "low: expected a number from 0 to 1"),
        ("low = 0.5", "lw = 0.5", 8, "unknown key \"lw\"; known: short, medium"),
        ("[kinds]", "[kind]", 1, "missing key \"kinds\""),
        ("let =", "roof = \"round\"\nlet =", 1, "roof: unknown name \"round\"; known: flat, none, uneven"),
    ] {
        assert!(HAY.contains(from), "{from}");
        let fault = Body::parse("hay.toml", &HAY.replacen(from, to, 1)).expect_err(to);
        assert!(fault.line == line && fault.reason.contains(part), "{to}: {fault:?}");
    }
    let low = Body::parse("hay.toml", &HAY.replace("floor_z + 0.1\"", "floor_z - h\"")).unwrap();
    let error = low[0].draw(&room, 0, 0).unwrap_err().to_string();
    assert!(error.starts_with("hay.toml:3: a size is -"), "{error}");
    let box_of_boards = "box = \"rear_x, front_x, -half_y, half_y, floor_z, floor_z + 0.1\"";
    assert!(HAY.contains(box_of_boards));
    let planted = Body::parse("hay.toml", &HAY.replace(box_of_boards, "bush = \"1, 1, 1, 2\"")).unwrap();
    let error = planted[0].draw(&room, 0, 0).unwrap_err().to_string();
    assert_eq!(error, "hay.toml:3: only props have leaves");
}

#[test]
fn wheels_stand_on_the_ground_below_the_body() {
    for model in models() {
        if model.wheel.is_none() {
            let low = model.body.levels[0].1.bounds.min.z;
            assert!(low.abs() < 0.03, "{} ends {low} over the ground", model.name);
            continue;
        }
        let width = model.size_lwh.y as f32;
        check_wheels(&model, 0.36 * width..width / 2.0 + 1e-3);
        assert!((0.38..0.75).contains(&(model.wheelbase_m() / model.size_lwh.x)), "{}", model.name);
    }
}

#[test]
fn one_sees_through_below_the_load_and_through_the_windows() {
    let (mut gaps, mut trucks) = (0, 0);
    for seed in 0..40 {
        let model = VehicleModel::generate(ObjectClass::Truck, seed).unwrap();
        let size = model.size_lwh.as_vec3();
        let [near, distant] = [0, 3].map(|level: usize| Target::new(&model.body.levels[level].1, |_| true));
        let is_bus = kind(&model) == "bus";
        // Into the windscreen: a pane first.
        let ahead = |z: f32| Vec3::new(size.x, 0.3, if is_bus { 1.7 } else { z });
        let mut hits = (0..40).filter_map(|k| near.cast(ahead(1.2 + 0.05 * k as f32), Vec3::NEG_X));
        assert!(hits.any(|hit| hit.slot == paint::slot::SCREEN), "{}: no windscreen", model.name);
        assert!(distant.cast(ahead(0.6), Vec3::new(0.0, 0.3, 0.6) - ahead(0.6)).is_some());
        if !is_bus {
            trucks += 1;
            // From the side, between the axles at the height of the hubs: free but for tanks and posts.
            let (front, rear) = (model.wheel_centers[0].x, model.wheel_centers[2].x);
            let free = (1..30).filter(|k| {
                let x = rear + (front - rear) * *k as f32 / 30.0;
                near.cast(Vec3::new(x, 4.0, 0.42), Vec3::NEG_Y).is_none()
            });
            gaps += usize::from(free.count() >= 5);
        }
    }
    assert!(2 * gaps > trucks, "{gaps} of {trucks} can be looked through below");
}

#[test]
fn flanks_of_closed_bodies_have_no_holes() {
    for model in
        models().filter(|m| ["box_truck", "curtain_sider", "bus", "box_trailer", "caravan"].contains(&kind(m))).take(60)
    {
        let size = model.size_lwh.as_vec3();
        for (level, (_, mesh)) in model.body.levels.iter().enumerate() {
            let target = Target::new(mesh, |_| true);
            for k in 0..12 {
                // The half behind the cab and the drawbar.
                let x = size.x * (-0.46 + 0.5 * k as f32 / 11.0);
                for z in [0.55, 0.7, 0.85] {
                    let hit = target.cast(Vec3::new(x + 0.003, 4.0, z * size.z), Vec3::NEG_Y);
                    let at = hit.unwrap_or_else(|| panic!("{} level {level}: open at {x} {z}", model.name)).point;
                    assert!(at.y > 0.5 * size.y - 0.25, "{} level {level}: {at} lies deep inside", model.name);
                }
            }
        }
    }
}

#[test]
fn occupants_sit_inside_of_what_is_driven() {
    for model in models() {
        let Some(driver) = &model.driver else {
            assert_eq!(model.class, ObjectClass::Misc);
            continue;
        };
        let (b, size) = (driver.levels[0].1.bounds, model.size_lwh.as_vec3());
        assert!(b.max.z < size.z && b.max.y < size.y / 2.0 && b.max.x < size.x / 2.0 - 0.3, "{}: {b:?}", model.name);
        assert!(b.max.x > size.x / 2.0 - 2.2 && b.min.z > 0.5, "{}: {b:?}", model.name);
    }
}

#[test]
fn faces_are_sound_and_few() {
    for model in models() {
        check_meshes(&model);
        let faces = [0, 1, 2, 3].map(|level: usize| model.body.levels[level].1.num_faces());
        let is_few = faces.iter().zip([9000, 5200, 2400, 1500]).all(|(n, most)| *n < most);
        assert!(is_few && faces[3] < faces[1] && faces[1] <= faces[0], "{}: {faces:?}", model.name);
    }
}

/// Quantiles of KITTI's 1,094 labels of trucks and 973 of Misc.
#[test]
fn sizes_follow_the_labels_of_kitti() {
    const SHARES: [f64; 5] = [0.05, 0.16, 0.5, 0.84, 0.95];
    type Quantiles = [[f64; 5]; 3];
    let cases: [(ObjectClass, Quantiles, f64); 2] = [
        (
            ObjectClass::Truck,
            [[6.08, 7.05, 10.81, 12.34, 16.44], [2.19, 2.39, 2.63, 2.89, 2.89], [2.60, 2.85, 3.34, 3.57, 4.05]],
            0.25,
        ),
        (
            ObjectClass::Misc,
            [[1.47, 1.75, 2.52, 5.57, 11.68], [0.51, 0.71, 1.51, 2.22, 2.57], [0.93, 1.04, 1.65, 2.85, 3.48]],
            0.30,
        ),
    ];
    for (class, quantiles, tolerance) in cases {
        let sizes: Vec<DVec3> =
            (0..6000).map(|k| vehicle_size(class, &mut Stream::from_seed("size", k)).unwrap()).collect();
        for (axis, expected) in quantiles.iter().enumerate() {
            let (values, expected) = (sizes.iter().map(|s| s[axis]).collect(), SHARES.into_iter().zip(*expected));
            check_quantiles(&format!("{class:?} axis {axis}"), values, expected, |v| tolerance.max(0.06 * v));
        }
    }
}

#[test]
fn traffic_wears_designs_near_its_size() {
    for class in [ObjectClass::Truck, ObjectClass::Misc] {
        let mut far = 0;
        for seed in 0..300 {
            let model = VehicleModel::of_traffic(class, seed).unwrap();
            let ratio = model.size_lwh / size_of_seed(class, design_number(&model));
            far += usize::from(ratio.max_element() > 1.12 || ratio.min_element() < 0.89);
            check_margins(&model);
        }
        assert!(far < 36, "{class:?}: {far} of 300 are stretched by more than 12 %");
    }
}
