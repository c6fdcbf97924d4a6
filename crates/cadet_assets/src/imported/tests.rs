//! People and riders made of meshes: their boxes, their materials, and what is refused.

use super::{FigureModel, MaterialRules, MeshAsset, Role, UserModels};
use crate::source_mesh::{SourceMaterial, SourceMesh, SourceTriangle};
use cadet_base::actor::ObjectClass;
use cadet_base::geometry::Bounds;
use cadet_base::material::{Pattern, Semantic};
use cadet_base::math::{DVec3, PI, Vec3};
use cadet_base::rng::Stream;

/// The faces of a cuboid, of a material.
fn cuboid(min: Vec3, max: Vec3, material: u32) -> Vec<SourceTriangle> {
    let pick = |i: usize, bit: usize, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
    let corner = |i: usize| Vec3::new(pick(i, 0, min.x, max.x), pick(i, 1, min.y, max.y), pick(i, 2, min.z, max.z));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|face| SourceTriangle { corners: face.map(corner), material, part: 0 }).collect()
}

/// Somebody of a size in centimeters with a shirt and wheels, who floats beside the file's origin and looks along -y.
fn figure(class: ObjectClass, [length, width, height]: [f32; 3]) -> MeshAsset {
    let (low, high) = (Vec3::new(300.0, -50.0, 7.0), Vec3::new(300.0 + width, length - 50.0, 7.0 + height));
    let middle = low.lerp(high, 0.5);
    let names = [("Light_Blue_Shirt", 0.4), ("Wheels", 1.0)];
    let material = |(name, opacity): (&str, f32)| SourceMaterial {
        name: name.to_owned(),
        albedo: Some([0.6, 0.05, 0.04]),
        opacity,
    };
    let mut triangles = cuboid(low, high, 0);
    triangles.extend(cuboid(low, middle, 1));
    MeshAsset {
        name: "mine".to_owned(),
        class,
        file: "scan.obj".to_owned(),
        source: SourceMesh { triangles, materials: names.map(material).to_vec(), parts: vec![vec![String::new()]] },
        scale: 0.01,
        yaw_rad: PI / 2.0,
        y_up: false,
        size_lwh: None,
        rules: MaterialRules::default(),
        leave_out: None,
    }
}

const SIZES: [(ObjectClass, [f32; 3], Semantic); 3] = [
    (ObjectClass::Pedestrian, [40.0, 160.0, 180.0], Semantic::Person),
    (ObjectClass::PersonSitting, [80.0, 60.0, 130.0], Semantic::Person),
    (ObjectClass::Cyclist, [175.0, 60.0, 175.0], Semantic::Cyclist),
];

fn made(asset: &MeshAsset) -> FigureModel {
    FigureModel::with_assumptions(asset).unwrap().0
}

#[test]
fn the_box_of_a_figure_is_the_bounds_of_its_mesh() {
    for (class, size, _) in SIZES {
        let model = made(&figure(class, size)).annotated_by(3);
        let wanted = Vec3::from_array(size) / 100.0;
        let Bounds { min, max } = model.body.finest().bounds;
        assert!((min - Vec3::new(-wanted.x / 2.0, -wanted.y / 2.0, 0.0)).abs().max_element() < 1e-5, "{min}");
        assert!((max - Vec3::new(wanted.x / 2.0, wanted.y / 2.0, wanted.z)).abs().max_element() < 1e-5, "{max}");
        assert!((model.size_lwh - wanted.as_dvec3()).abs().max_element() < 1e-5);
        let annotated = model.annotated;
        assert_eq!((annotated.size_lwh, annotated.bottom_center_in_box), (model.size_lwh, DVec3::ZERO));
        assert!(annotated.farthest_m < 120.0 && annotated.least_points > 0, "annotators see no farther than of others");
        assert_eq!((model.name.as_str(), model.class), ("mine", class));
    }
}

#[test]
fn figures_are_cloth_and_riders_have_tyres() {
    for (class, size, semantic) in SIZES {
        let asset = figure(class, size);
        let model = made(&asset);
        let [shirt, wheels] = model.palette.materials()[..] else { panic!("{:?}", model.palette) };
        assert_eq!((shirt.semantic, wheels.semantic), (semantic, semantic));
        assert_eq!((shirt.pattern, shirt.albedo), (Pattern::Cloth, [0.6, 0.05, 0.04]), "hair is dissolved, too");
        assert!((0.3..=0.7).contains(&shirt.lidar.reflectance));
        assert!(shirt.lidar.coat_index == 1.0 && shirt.lidar.gloss == 0.0 && !shirt.is_transparent(), "no paint");
        assert_eq!(wheels.albedo[0] < 0.1, class == ObjectClass::Cyclist);
        let rules = MaterialRules(vec![(Role::Glass, vec!["*shirt".to_owned()]), (Role::Tyre, Vec::new())]);
        let named = made(&MeshAsset { rules, ..asset });
        assert!(named.palette.materials()[0].is_transparent(), "the user's names hold");
        assert_eq!(named.palette.materials()[1].pattern, Pattern::Cloth);
    }
}

#[test]
fn what_makes_no_figure_is_refused_by_name() {
    let refused = |class, size: [f32; 3], scale: f64| {
        let asset = MeshAsset { scale, ..figure(class, size) };
        FigureModel::with_assumptions(&asset).unwrap_err().to_string()
    };
    let person = [40.0, 60.0, 180.0];
    for (class, size, scale, reason) in [
        (ObjectClass::Pedestrian, person, 1.0, "40.000 m long, expected 0.1 to 2.5 m for a Pedestrian: check scale"),
        (
            ObjectClass::Pedestrian,
            [180.0, 60.0, 30.0],
            0.01,
            "0.300 m high, expected 0.4 to 2.5 m for a Pedestrian: check scale and up",
        ),
        (
            ObjectClass::PersonSitting,
            person,
            1e-3,
            "0.040 m long, expected 0.1 to 2.5 m for a Person_sitting: check scale",
        ),
        (ObjectClass::Cyclist, person, 0.01, "0.400 m long, expected 0.8 to 3.5 m for a Cyclist: check scale"),
        (
            ObjectClass::Cyclist,
            [90.0, 120.0, 170.0],
            0.01,
            "wider (1.20 m) than long (0.90 m): turn its front to +x with yaw_deg",
        ),
    ] {
        assert_eq!(refused(class, size, scale), format!("scan.obj: {reason}"));
    }
    assert_eq!(
        refused(ObjectClass::Car, [400.0, 170.0, 150.0], 0.01),
        "scene: nobody is of class Car: Pedestrian, Person_sitting or Cyclist"
    );
}

#[test]
fn a_set_of_people_gives_traffic_nothing_and_a_mixed_one_its_vehicles() {
    let named = |name: &str, class, size| MeshAsset { name: name.to_owned(), ..figure(class, size) };
    let walker = named("walker", ObjectClass::Pedestrian, [40.0, 60.0, 180.0]);
    let car = MeshAsset {
        rules: MaterialRules(vec![(Role::Glass, Vec::new())]),
        ..named("car", ObjectClass::Car, [400.0, 170.0, 150.0])
    };
    let mix = [(ObjectClass::Car, 0.9), (ObjectClass::Pedestrian, 0.1)];
    let mut stream = Stream::from_seed("draws", 1);
    let before = stream.clone().next_u64();
    let people = UserModels::new(1.0, std::slice::from_ref(&walker)).unwrap();
    assert!(people.draw(&mut stream, &mix, |_| true).is_none());
    assert_eq!(stream.next_u64(), before, "nothing is drawn");
    let mixed = UserModels::new(1.0, &[walker.clone(), car]).unwrap();
    for _ in 0..50 {
        assert_eq!(mixed.draw(&mut stream, &mix, |_| true).unwrap().name, "car");
    }
    let found = |class, name| mixed.by_name(class, name).map(|m| m.class()).map_err(|e| e.to_string());
    assert_eq!(found(ObjectClass::Pedestrian, "walker"), Ok(ObjectClass::Pedestrian));
    assert_eq!(found(ObjectClass::Car, "car"), Ok(ObjectClass::Car));
    let other = "scene: model \"walker\" is a Pedestrian, not a Cyclist";
    assert_eq!(found(ObjectClass::Cyclist, "walker"), Err(other.to_owned()));
    assert_eq!(found(ObjectClass::Car, "x"), Err("unknown model \"x\"; known: car, walker".to_owned()));
    let twice = UserModels::new(1.0, &[walker.clone(), walker]).unwrap_err();
    assert_eq!(twice.to_string(), "scan.obj: the name \"walker\" is taken");
}
