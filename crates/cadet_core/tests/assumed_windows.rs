//! Meshes that name no windows: where glass is assumed, where not, and what the user hears of it.

#![allow(clippy::unwrap_used)]
#![allow(clippy::print_stderr)]

#[path = "common/source.rs"]
mod source;

use cadet_core::actor::ObjectClass;
use cadet_core::assets::imported::{MaterialRules, MeshAsset, Role};
use cadet_core::assets::vehicle::VehicleModel;
use cadet_core::geometry::Bounds;
use cadet_core::material::Material;
use cadet_core::math::{DVec3, Vec3};
use source::mesh_of;

/// A closed shell of 4.2 x 1.8 x 1.5 m that looks along +x: a body up to 0.9 m, over it a cabin whose walls lean in, and
/// mirrors beside it. No face names a material.
fn shell_text() -> String {
    let mut obj = String::new();
    let mut n = 0;
    let mut frustum = |low: ([f32; 2], [f32; 2], f32), high: ([f32; 2], [f32; 2], f32)| {
        for ((x, y), z) in [((low.0, low.1), low.2), ((high.0, high.1), high.2)] {
            for (x, y) in [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])] {
                obj.push_str(&format!("v {x} {y} {z}\n"));
            }
        }
        for face in [[1, 4, 3, 2], [5, 6, 7, 8], [1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [4, 1, 5, 8]] {
            let [a, b, c, d] = face.map(|k| n + k);
            obj.push_str(&format!("f {a} {b} {c} {d}\n"));
        }
        n += 8;
    };
    frustum(([-2.1, 2.1], [-0.9, 0.9], 0.0), ([-2.1, 2.1], [-0.9, 0.9], 0.9));
    frustum(([-1.9, 1.0], [-0.9, 0.9], 0.9), ([-1.5, 0.3], [-0.6, 0.6], 1.5));
    for side in [-1.0, 1.0] {
        frustum(([0.5, 0.7], [side - 0.06, side + 0.06], 1.0), ([0.5, 0.7], [side - 0.06, side + 0.06], 1.2));
    }
    obj
}

fn shell() -> MeshAsset {
    MeshAsset {
        name: "shell".to_owned(),
        class: ObjectClass::Car,
        file: "shell.obj".to_owned(),
        source: mesh_of(&shell_text(), &[]),
        scale: 1.0,
        yaw_rad: 0.0,
        y_up: false,
        size_lwh: None,
        rules: MaterialRules::default(),
        leave_out: None,
    }
}

/// Corners of the faces whose material fits, and their area.
fn faces_of(model: &VehicleModel, keep: impl Fn(&Material) -> bool) -> (Vec<[Vec3; 3]>, f32) {
    let mesh = model.body.finest();
    let kept = mesh.triangles().filter(|(_, s)| keep(&model.palette.materials()[usize::from(*s)]));
    let faces: Vec<[Vec3; 3]> = kept.map(|(corners, _)| corners).collect();
    let area_m2 = faces.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length() / 2.0).sum();
    (faces, area_m2)
}

#[test]
fn a_shell_without_materials_gets_windows_on_all_sides_and_keeps_its_pillars() {
    let (model, assumed) = VehicleModel::with_assumptions(&shell()).unwrap();
    assert_eq!(
        assumed.concat(),
        "shell.obj: no materials: gray paint is assumed; glass is assumed where windows usually are, with seats behind it \
         (materials.glass in assets.toml names windows, [] says that there are none)"
    );
    assert!((model.size_lwh - DVec3::new(4.2, 2.12, 1.5)).abs().max_element() < 1e-4, "{}", model.size_lwh);
    let (windows, area_m2) = faces_of(&model, Material::is_transparent);
    let bounds = Bounds::of(windows.iter().flatten().copied());
    assert!(bounds.min.z > 0.6 * 1.5 && bounds.max.z < 0.95 * 1.5, "{bounds:?}");
    assert!(bounds.max.y.abs() < 0.9 && bounds.min.y.abs() < 0.9, "mirrors stay: {bounds:?}");
    let steepest = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a).normalize();
    let toward = |axis: Vec3| windows.iter().filter(|f| steepest(f).dot(axis) > 0.5).count();
    for axis in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y] {
        assert!(toward(axis) > 0, "no window toward {axis}");
    }
    // The cabin's walls are 0.6 m high and about 2.3 m and 1.5 m long.
    let walls_m2 = 2.0 * 0.6 * (2.35 + 1.5);
    assert!((0.25..0.75).contains(&(area_m2 / walls_m2)), "{area_m2} of {walls_m2} square meters");
    // Between the two side windows stands a pillar, and at the windscreen's ends too.
    let sides = windows.iter().filter(|f| steepest(f).y > 0.5).flatten();
    let (rear, front): (Vec<f32>, Vec<f32>) = sides.map(|p| p.x).partition(|x| *x < -0.52);
    let gap_m = front.iter().copied().fold(9.0, f32::min) - rear.iter().copied().fold(-9.0, f32::max);
    assert!((0.05..0.2).contains(&gap_m), "{gap_m}");
    let (seats, _) = faces_of(&model, |m| !m.is_transparent() && m.specular == 0.0);
    let seats = Bounds::of(seats.into_iter().flatten());
    assert!(seats.min.z > 0.3 && seats.max.z < 1.35 && seats.max.y < 0.7, "{seats:?}");
}

#[test]
fn the_shell_outside_of_its_windows_is_what_it_was() {
    let closed = MeshAsset { rules: MaterialRules(vec![(Role::Glass, Vec::new())]), ..shell() };
    let (closed, nothing) = VehicleModel::with_assumptions(&closed).unwrap();
    assert_eq!(nothing, Vec::<String>::new(), "who says that there are no windows is asked no more");
    let (glazed, _) = VehicleModel::with_assumptions(&shell()).unwrap();
    let (_, whole_m2) = faces_of(&closed, |_| true);
    assert_eq!(faces_of(&closed, Material::is_transparent).0, Vec::<[Vec3; 3]>::new());
    let (_, rest_m2) = faces_of(&glazed, |m| m.is_transparent() || m.specular > 0.0);
    assert!((whole_m2 - rest_m2).abs() < 1e-3 * whole_m2, "{whole_m2} {rest_m2}");
    let [a, b] = [&closed, &glazed].map(|m| m.body.finest().bounds);
    assert_eq!(a, b);
}

#[test]
fn windows_of_their_own_material_are_left_alone() {
    let named = format!("usemtl Lack\n{}", shell_text().replacen("f ", "usemtl Window\nf ", 2));
    let library = [("Lack", [1.0, 0.0, 0.0], 1.0), ("Window", [0.0; 3], 1.0)];
    let asset = MeshAsset { source: mesh_of(&named, &library), ..shell() };
    assert_eq!(VehicleModel::with_assumptions(&asset).unwrap().1, Vec::<String>::new());
    let unnamed = mesh_of(&named.replace("usemtl Window", "usemtl Lack"), &library);
    let (_, assumed) = VehicleModel::with_assumptions(&MeshAsset { source: unnamed, ..shell() }).unwrap();
    assert!(assumed.concat().starts_with("shell.obj: no material for windows among Lack; glass is assumed"));
}

#[test]
fn trucks_have_windows_at_the_cab_alone_and_walls_none() {
    let truck = MeshAsset { class: ObjectClass::Truck, size_lwh: Some(DVec3::new(8.0, 2.5, 3.2)), ..shell() };
    let (model, _) = VehicleModel::with_assumptions(&truck).unwrap();
    let (windows, _) = faces_of(&model, Material::is_transparent);
    let bounds = Bounds::of(windows.into_iter().flatten());
    assert!(bounds.min.x > 4.0 - 2.0, "{bounds:?}");
    let wall = "v -3 -.2 0\nv 3 -.2 0\nv 3 .2 0\nv -3 .2 0\nv -3 -.2 4\nv 3 -.2 4\nv 3 .2 4\nv -3 .2 4\n\
                f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let wall = MeshAsset { class: ObjectClass::Truck, source: mesh_of(wall, &[]), ..shell() };
    let (model, assumed) = VehicleModel::with_assumptions(&wall).unwrap();
    assert_eq!(faces_of(&model, Material::is_transparent).0.len(), 0);
    assert!(assumed.concat().contains("; no glass is assumed, since nothing is where windows usually are"));
}

#[test]
fn other_peoples_meshes_get_windows_of_a_cars_size() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/meshes");
    if !std::path::Path::new(folder).is_dir() {
        eprintln!("skipped: no ../shared/meshes");
        return;
    }
    for (name, scale, yaw_deg, glazed_m2) in
        [("hatchback", 0.0254, 90.0_f64, 1.5..4.5), ("suv", 0.06, -90.0, 2.0..6.0), ("bus", 0.01, 90.0, 2.0..9.0)]
    {
        let path = std::path::Path::new(folder).join(name).join(format!("{name}.obj"));
        let text = std::fs::read_to_string(&path).unwrap();
        let materials: Vec<&str> =
            text.lines().filter_map(|line| line.strip_prefix("usemtl ")).map(str::trim).collect();
        let library: Vec<_> = materials.into_iter().map(|name| (name, [0.4; 3], 1.0)).collect();
        let asset = MeshAsset {
            class: if name == "bus" { ObjectClass::Truck } else { ObjectClass::Car },
            source: mesh_of(&text, &library),
            scale,
            yaw_rad: yaw_deg.to_radians(),
            ..shell()
        };
        let (model, assumed) = VehicleModel::with_assumptions(&asset).unwrap();
        assert!(assumed.concat().contains("; glass is assumed"), "{name}");
        let (_, area_m2) = faces_of(&model, Material::is_transparent);
        assert!(glazed_m2.contains(&area_m2), "{name}: {area_m2} square meters of glass");
    }
}
