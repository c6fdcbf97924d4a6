use super::*;
use crate::rays::Target;
use cadet_base::geometry::{Bounds, Mesh};
use std::ops::Range;

const SEEDS: u64 = 200;

pub(super) fn is_pane(slot: u8) -> bool {
    (slot::SCREEN..=slot::REAR_GLASS).contains(&slot)
}

/// The outline of the car of a seed, which the model itself does not keep.
fn outline(class: ObjectClass, seed: u64) -> Outline {
    Outline::new(Dimensions::of_seed(class, seed).unwrap())
}

/// The cars of so many seeds.
fn cars(count: u64) -> impl Iterator<Item = VehicleModel> {
    (0..count).map(|seed| VehicleModel::generate(ObjectClass::Car, seed).unwrap())
}

/// Cars of some seeds and their outlines.
fn outlined_cars(count: u64) -> impl Iterator<Item = (VehicleModel, Outline)> {
    cars(count).zip((0..).map(|seed| outline(ObjectClass::Car, seed)))
}

/// Checks that the wheels stand on the ground at their corners of the vehicle, and how far to the side they reach.
pub(super) fn check_wheels(model: &VehicleModel, reach: Range<f32>) {
    let (name, r) = (&model.name, model.wheel_radius_m as f32);
    for (_, mesh) in &model.wheel.as_ref().unwrap().levels {
        assert!((mesh.bounds.min.z + r).abs() < 1e-4, "{name}: a corner at the lowest point");
        let outer = model.wheel_centers[0].y + mesh.bounds.max.y;
        assert!(reach.contains(&outer), "{name}: a wheel at {outer}, not in {reach:?}");
    }
    for (k, c) in model.wheel_centers.iter().enumerate() {
        assert!(c.z == r && (c.y > 0.0) == (k % 2 == 0) && (c.x > 0.0) == (k < 2), "{name}: {c}");
    }
}

/// Checks materials, normals, and bounds of all that a vehicle is made of.
pub(super) fn check_meshes(model: &VehicleModel) {
    for shape in [Some(&model.body), model.wheel.as_ref(), model.driver.as_ref()].into_iter().flatten() {
        assert_eq!(shape.bounds, shape.levels[0].1.bounds, "{}", model.name);
        for (_, mesh) in &shape.levels {
            assert!(mesh.slots().all(|s| usize::from(s) < model.palette.materials().len()), "{}", model.name);
            assert!(mesh.normals().all(|n| (n.length() - 1.0).abs() < 1e-3), "{}", model.name);
        }
    }
}

/// Checks quantiles at some shares of values against those of KITTI's labels.
pub(super) fn check_quantiles(
    what: &str,
    mut values: Vec<f64>,
    expected: impl IntoIterator<Item = (f64, f64)>,
    tolerance: impl Fn(f64) -> f64,
) {
    values.sort_by(f64::total_cmp);
    for (share, expected) in expected {
        let got = values[(share * values.len() as f64) as usize];
        assert!((got - expected).abs() < tolerance(expected), "{what} at {share}: {got}, labels {expected}");
    }
}

/// Checks by how much a vehicle exceeds what an annotator draws, in length and width.
pub(super) fn check_margins(model: &VehicleModel) {
    let over = model.size_lwh - model.annotated.size_lwh;
    assert!(over.x > -0.18 && over.x < 0.54 && over.y.abs() < 0.23, "{}: {over}", model.name);
}

/// The number of the design that a vehicle of traffic wears.
pub(super) fn design_number(model: &VehicleModel) -> u64 {
    model.name.rsplit('/').next().unwrap().parse().unwrap()
}

/// Bounds without mirrors and aerial: the width below the belt line, the height of paint and sunroof.
fn label_bounds(mesh: &Mesh, belt: f32) -> Bounds {
    let painted = mesh.triangles().filter(|(_, s)| matches!(*s, slot::PAINT | slot::DARK_GLASS));
    let roof = painted.flat_map(|(corners, _)| corners.map(|p| p.z)).fold(0.0, f32::max);
    let low = Bounds::of(mesh.places().filter(|v| v.z < 0.85 * belt));
    Bounds { min: low.min, max: Vec3::new(low.max.x, low.max.y, roof) }
}

#[test]
fn the_body_fills_its_box_at_every_level() {
    for seed in 0..SEEDS {
        for class in [ObjectClass::Car, ObjectClass::Van] {
            let (model, belt) = (VehicleModel::generate(class, seed).unwrap(), outline(class, seed).d.belt_z);
            let size = model.size_lwh.as_vec3();
            for (_, mesh) in &model.body.levels {
                let bounds = label_bounds(mesh, belt);
                assert!((bounds.size().x - size.x).abs() < 1e-3, "{} length {} of {size}", model.name, bounds.size().x);
                assert!((bounds.size().y - size.y).abs() < 1e-3, "{} width {} of {size}", model.name, bounds.size().y);
                assert!((bounds.max.z - size.z).abs() < 1e-3, "{} height {} of {size}", model.name, bounds.max.z);
                assert!(bounds.center().truncate().length() < 1e-3, "{} is off center", model.name);
                assert!(mesh.bounds.max.x <= size.x / 2.0 + 1e-3 && mesh.bounds.min.x >= -size.x / 2.0 - 1e-3);
                assert!(mesh.bounds.min.z > 0.1 && mesh.bounds.max.y < size.y / 2.0 + 0.30, "{}", model.name);
            }
        }
    }
}

#[test]
fn sizes_follow_the_labels_of_kitti() {
    let n = 4000;
    let draws: Vec<Dimensions> = (0..n).map(|seed| Dimensions::of_seed(ObjectClass::Car, seed).unwrap()).collect();
    assert!(draws.iter().all(|d| d.length_m > d.width_m && d.height_m > 1.1));
    let sizes: Vec<DVec3> = draws.iter().map(Dimensions::size_lwh).collect();
    let over = Margins::mean_of_vehicles();
    let quantiles = [([3.20, 3.89, 4.53], 0.12), ([1.46, 1.63, 1.81], 0.04), ([1.37, 1.50, 1.78], 0.05)];
    for (axis, (expected, tolerance)) in quantiles.into_iter().enumerate() {
        let values = sizes.iter().map(|size| size[axis] - over[axis]).collect();
        check_quantiles(&format!("axis {axis}"), values, [0.05, 0.5, 0.95].into_iter().zip(expected), |_| tolerance);
    }
}

#[test]
fn wheels_stand_on_the_ground_inside_the_flanks() {
    for model in cars(SEEDS) {
        let half_y = model.size_lwh.y as f32 / 2.0;
        check_wheels(&model, half_y - 0.09..half_y - 0.005);
    }
}

#[test]
fn arches_are_cut_and_lined() {
    for model in cars(40) {
        let side = model.size_lwh.y as f32 / 2.0;
        for (_, mesh) in &model.body.levels[..2] {
            let body = Target::new(mesh, |s| !is_pane(s));
            for c in model.wheel_centers {
                let sign = c.y.signum();
                for (dx, dz) in [(0.0, 0.0), (0.6, 0.0), (-0.6, 0.3), (0.0, 1.02)] {
                    let r = model.wheel_radius_m as f32;
                    let at = Vec3::new(c.x + dx * r, 3.0 * sign, c.z + dz * r);
                    let hit = body.cast(at, Vec3::Y * -sign).expect("the liner closes the arch");
                    assert_eq!(hit.slot, slot::LINER, "{} at {dx} {dz}: {}", model.name, hit.point);
                    assert!(hit.point.y * sign < side - 0.15, "{} at {}", model.name, hit.point);
                }
            }
        }
    }
}

#[test]
fn flanks_and_roof_are_closed_and_face_outward() {
    for (model, o) in outlined_cars(40) {
        let (d, size) = (&o.d, model.size_lwh.as_vec3());
        for (level, (_, mesh)) in model.body.levels.iter().enumerate() {
            let body = Target::new(mesh, |s| !is_pane(s));
            let (mut rays, mut outside) = (0, 0);
            for i in 0..30 {
                let x = size.x * (-0.42 + 0.84 * i as f32 / 29.0);
                let is_arch = d.axles_x.iter().any(|a| (x - a).abs() < d.arch_radius_m + 0.03);
                for k in 0..12 {
                    let z = d.clearance_m + 0.03 + (0.80 * d.belt_z - d.clearance_m - 0.03) * k as f32 / 11.0;
                    if is_arch && z < d.wheel_radius_m + d.arch_radius_m + 0.03 || z > 0.9 * d.bonnet_edge_z {
                        continue;
                    }
                    let hit = body.cast(Vec3::new(x, 3.0, z), Vec3::NEG_Y).expect("flank");
                    let depth = size.y / 2.0 - hit.point.y;
                    let allowed = 0.14 + if x.abs() > 0.3 * size.x { 0.40 } else { 0.0 };
                    assert!(depth < allowed, "{} level {level}: {} lies {depth} inside", model.name, hit.point);
                    rays += 1;
                    outside += usize::from(hit.is_outside);
                }
            }
            for i in 0..20 {
                for j in 0..9 {
                    let (x, y) = (size.x * (-0.48 + 0.96 * i as f32 / 19.0), size.y * (-0.3 + 0.6 * j as f32 / 8.0));
                    // The corners of nose and tail are round.
                    let y = if x.abs() > 0.38 * size.x { 0.5 * y } else { y };
                    // A ray along the edge between two faces may miss both: only a hole lets its neighbor pass, too.
                    let down = |aside| body.cast(Vec3::new(x + aside, y + aside, 4.0), Vec3::NEG_Z);
                    let Some(hit) = down(0.0).or_else(|| down(1e-3)) else {
                        panic!("{} level {level}: open to the ground at {x} {y}", model.name)
                    };
                    rays += 1;
                    outside += usize::from(hit.is_outside);
                }
            }
            assert!(outside as f32 > 0.99 * rays as f32, "{} level {level}: {outside} of {rays}", model.name);
            let house = Glasshouse::new(&o, slot::REAR_SIDE_GLASS);
            let x = 0.5 * (house.header_x + house.rear_header_x);
            let roof = body.cast(Vec3::new(x, 0.2, 4.0), Vec3::NEG_Z).expect("roof");
            assert!(roof.point.z > size.z - 0.12, "{}: roof at {}", model.name, roof.point.z);
        }
    }
}

#[test]
fn panes_lie_over_real_openings() {
    for (model, o) in outlined_cars(60) {
        let house = Glasshouse::new(&o, slot::REAR_SIDE_GLASS);
        for (level, (_, mesh)) in model.body.levels[..3].iter().enumerate() {
            let (glass, body) = (Target::new(mesh, is_pane), Target::new(mesh, |s| !is_pane(s)));
            let through = |name: &str, from: Vec3, to: Vec3, first: u8| {
                let pane = glass.cast(from, to - from).unwrap_or_else(|| panic!("{} {name}: no pane", model.name));
                assert_eq!(pane.slot, first, "{} {name} at level {level}", model.name);
                assert!(pane.is_outside, "{} {name} faces inward at {}", model.name, pane.point);
                if let Some(hit) = body.cast(from, to - from) {
                    let deep = hit.range_m - pane.range_m;
                    assert!(deep > 0.15, "{} {name} at level {level}: slot {} {deep} behind", model.name, hit.slot);
                }
            };
            let x = house.b_pillar_x + 0.22;
            let z = 0.55 * o.d.belt_z + 0.45 * house.cant(x).z;
            through("left door", Vec3::new(x, 3.0, z + 0.1), Vec3::new(x, 0.0, z - 0.1), slot::SIDE_GLASS);
            through("right door", Vec3::new(x, -3.0, z + 0.1), Vec3::new(x, 0.0, z - 0.1), slot::SIDE_GLASS);
            let screen = house.on_screen(0.3, 0.5);
            through("windscreen", screen + Vec3::new(3.0, 0.0, 0.3), screen, slot::SCREEN);
            let back = house.on_backlight(0.35, 0.5);
            through("backlight", back + Vec3::new(-3.0, 0.0, 0.6), back, slot::REAR_GLASS);
        }
    }
}

#[test]
fn far_away_windows_are_dark_and_wheels_stand_in_dark_arches() {
    for (model, o) in outlined_cars(60) {
        let house = Glasshouse::new(&o, slot::REAR_SIDE_GLASS);
        let body = Target::new(&model.body.levels[3].1, |_| true);
        let seen = |from: Vec3, to: Vec3| {
            let hit = body.cast(from, to - from).unwrap_or_else(|| panic!("{}: nothing at {to}", model.name));
            assert!(hit.is_outside, "{} faces inward at {}", model.name, hit.point);
            hit.slot
        };
        let (x, belt) = (house.b_pillar_x + 0.22, o.d.belt_z);
        for side in [1.0, -1.0] {
            let z = 0.55 * belt + 0.45 * house.cant(x).z;
            assert_eq!(seen(Vec3::new(x, 3.0 * side, z), Vec3::new(x, 0.0, z)), slot::DARK_GLASS, "{}", model.name);
            for axle in o.d.axles_x {
                let z = o.d.wheel_radius_m + 0.1;
                let arch = seen(Vec3::new(axle, 3.0 * side, z), Vec3::new(axle, 0.0, z));
                assert_eq!(arch, slot::LINER, "{}", model.name);
            }
        }
        let screen = house.on_screen(0.3, 0.5);
        assert_eq!(seen(screen + Vec3::new(3.0, 0.0, 0.3), screen), slot::DARK_GLASS, "{}", model.name);
        let back = house.on_backlight(0.35, 0.5);
        assert_eq!(seen(back + Vec3::new(-3.0, 0.0, 0.6), back), slot::DARK_GLASS, "{}", model.name);
    }
}

#[test]
fn three_hundred_seeds_give_sound_meshes() {
    for seed in 0..300 {
        for class in [ObjectClass::Car, ObjectClass::Van] {
            let model = VehicleModel::generate(class, seed).unwrap();
            check_meshes(&model);
            let shapes = [Some(&model.body), model.wheel.as_ref(), model.driver.as_ref()];
            for (_, mesh) in shapes.into_iter().flatten().flat_map(|s| &s.levels) {
                for ([a, b, c], _) in mesh.triangles() {
                    assert!((b - a).cross(c - a).length() > 1e-9, "{}: a face without area", model.name);
                }
            }
            let wheel = model.wheel.as_ref().unwrap();
            let total = |level: usize| model.body.levels[level].1.num_faces() + 4 * wheel.levels[level].1.num_faces();
            assert!((5000..9000).contains(&total(0)), "{} {}", model.name, total(0));
            assert!((1500..3400).contains(&total(1)), "{} {}", model.name, total(1));
            assert!((400..950).contains(&total(2)), "{} {}", model.name, total(2));
            assert!((150..420).contains(&total(3)), "{} {}", model.name, total(3));
        }
    }
}

#[test]
fn occupants_sit_inside() {
    for model in cars(SEEDS) {
        let size = model.size_lwh.as_vec3();
        let driver = model.driver.expect("cars have a driver").levels[0].1.bounds;
        assert!(driver.max.z < size.z - 0.01, "{}: head at {} of {}", model.name, driver.max.z, size.z);
        assert!(driver.max.y < size.y / 2.0 - 0.05 && driver.max.y > 0.1, "{} {}", model.name, driver.max);
        assert!(driver.min.z > 0.3 && driver.max.x < 0.4 * size.x && driver.min.x > -0.4 * size.x);
    }
}

#[test]
fn a_seed_names_one_vehicle() {
    let make = |seed| VehicleModel::generate(ObjectClass::Car, seed).unwrap();
    let (a, b, c) = (make(5), make(5), make(6));
    assert_eq!(a.body.levels[0].1, b.body.levels[0].1);
    assert_eq!((a.name, a.palette), (b.name, b.palette.clone()));
    assert_ne!(b.body.levels[0].1, c.body.levels[0].1);
}

#[test]
fn glass_passes_light_and_plates_are_retroreflective() {
    for model in cars(50) {
        for (i, m) in model.palette.materials().iter().enumerate() {
            assert_eq!(m.is_transparent(), is_pane(i as u8), "slot {i}");
            assert_eq!(m.lidar.transmission > 0.0, is_pane(i as u8), "slot {i}");
            assert_eq!(m.lidar.retro, i as u8 == slot::PLATE, "slot {i}");
            assert_eq!(m.semantic, cadet_base::material::Semantic::Car);
        }
    }
}

#[test]
fn traffic_wears_designs_stretched_by_little() {
    let n = 4000;
    for (class, most_share) in [(ObjectClass::Car, 0.15), (ObjectClass::Van, 0.30)] {
        let mut stretches: Vec<f64> = (0..n)
            .map(|seed| {
                let mut s = Stream::from_seed("traffic vehicle", seed);
                let annotated = annotation::vehicle_size(class, &mut s).unwrap();
                library::least_stretch(class, Margins::of_vehicle(class, &mut s).around(annotated)).unwrap()
            })
            .collect();
        stretches.sort_by(f64::total_cmp);
        let beyond = stretches.iter().filter(|s| **s > 1.06).count();
        assert!((beyond as f64) < most_share * n as f64, "{class:?}: {beyond} of {n} are stretched by more than 6 %");
        assert!(stretches[n as usize * 995 / 1000] < 1.25, "{class:?}: {}", stretches[n as usize * 995 / 1000]);
    }
}

/// Faces whose shading normals point to their inner side.
fn turned_inward(mesh: &Mesh) -> usize {
    let inward = mesh.face_numbers().filter(|number| {
        let [a, b, c] = mesh.corners(*number);
        let sum: Vec3 = mesh.corner_normals(*number).into_iter().sum();
        (b - a).cross(c - a).dot(sum) <= 0.0
    });
    inward.count()
}

#[test]
fn a_stretched_vehicle_fills_its_extents_on_round_wheels_that_touch_the_ground() {
    for seed in 0..12 {
        for class in [ObjectClass::Car, ObjectClass::Van] {
            let model = VehicleModel::of_traffic(class, seed).unwrap();
            let size = model.size_lwh.as_vec3();
            let design = VehicleModel::generate(class, design_number(&model)).unwrap();
            for ((_, mesh), (_, design)) in model.body.levels.iter().zip(&design.body.levels) {
                let (length, height) = (mesh.bounds.size().x, mesh.bounds.max.z);
                assert!((length - size.x).abs() < 2e-3, "{} is {length} long, not {}", model.name, size.x);
                assert!(height >= size.z - 2e-3 && mesh.bounds.min.z > 0.08, "{} is {height} high", model.name);
                assert!(mesh.normals().all(|n| (n.length() - 1.0).abs() < 1e-3));
                assert!(turned_inward(mesh) <= turned_inward(design) + mesh.num_faces() / 200, "{}", model.name);
                for cluster in mesh.clusters.iter() {
                    for v in cluster.places() {
                        assert!((v - cluster.center).length() <= cluster.radius_m, "{}", model.name);
                    }
                }
            }
            assert_eq!(model.body.bounds, model.body.levels[0].1.bounds);
            let wheel = &model.wheel.as_ref().unwrap().levels[0].1.bounds;
            let r = model.wheel_radius_m as f32;
            let of_design = &design.wheel.as_ref().unwrap().levels[0].1.bounds;
            let aspect = |b: &Bounds| b.size().x / b.size().z;
            assert!((wheel.min.z + r).abs() < 1e-3, "{}: on the ground", model.name);
            assert!((aspect(wheel) - aspect(of_design)).abs() < 1e-4, "{}: as round as the design's", model.name);
            assert!(model.wheel_centers.iter().all(|c| (c.z - r).abs() < 1e-5), "{}", model.name);
            check_margins(&model);
            let over_z = model.size_lwh.z - model.annotated.size_lwh.z;
            assert!((-0.045..0.14).contains(&over_z), "{over_z}");
        }
    }
}

#[test]
fn traffic_is_of_many_sizes_and_few_designs() {
    let make = |seed| VehicleModel::of_traffic(ObjectClass::Car, seed).unwrap();
    let (a, again, other) = (make(3), make(3), make(4));
    assert_eq!((a.size_lwh, a.annotated, &a.name), (again.size_lwh, again.annotated, &again.name));
    assert_ne!(a.size_lwh, other.size_lwh);
    let mut names: Vec<String> = (0..300).map(|seed| make(1000 + seed).name).collect();
    names.sort();
    names.dedup();
    assert!((30..=160).contains(&names.len()), "{} designs", names.len());
}

#[test]
fn no_shape_is_made_for_classes_that_have_none() {
    for class in [ObjectClass::PersonSitting, ObjectClass::Pedestrian] {
        let name = class.kitti_name();
        let errors = [VehicleModel::generate(class, 1).unwrap_err(), VehicleModel::of_traffic(class, 1).unwrap_err()];
        assert!(errors.iter().all(|e| e.to_string().contains(name)), "{errors:?}");
    }
    // Trams come as trains.
    assert!(VehicleModel::of_traffic(ObjectClass::Tram, 1).unwrap_err().to_string().contains("Tram"));
}
