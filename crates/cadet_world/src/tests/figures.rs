//! People and riders of a user's: rigid, but upright and on their way as those that are built in.

use super::scripted::path;
use super::*;
use cadet_assets::imported::{MaterialRules, MeshAsset, UserModels};
use cadet_assets::source_mesh::{SourceMaterial, SourceMesh, SourceTriangle};
use cadet_base::frames::{upright, yaw_of};
use cadet_base::math::Vec3;
use cadet_base::plane::unit;

/// A wedge of a size, under the name of its class.
fn wedge(class: ObjectClass, [x, y, z]: [f32; 3]) -> MeshAsset {
    let corners = [[0.0, 0.0, 0.0], [x, 0.0, 0.0], [0.0, y, 0.0], [x, y, z]].map(Vec3::from_array);
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let triangles = faces.map(|face| SourceTriangle { corners: face.map(|i| corners[i]), material: 0, part: 0 });
    MeshAsset {
        name: class.kitti_name().to_owned(),
        class,
        file: "scan.obj".to_owned(),
        source: SourceMesh {
            triangles: triangles.to_vec(),
            materials: vec![SourceMaterial { name: String::new(), albedo: None, opacity: 1.0 }],
            parts: vec![vec![String::new()]],
        },
        scale: 1.0,
        yaw_rad: 0.0,
        y_up: false,
        size_lwh: None,
        rules: MaterialRules::default(),
        leave_out: None,
    }
}

const PEDESTRIAN: ObjectClass = ObjectClass::Pedestrian;
const SITTING: ObjectClass = ObjectClass::PersonSitting;
const CYCLIST: ObjectClass = ObjectClass::Cyclist;

/// A road that rises to the east, with the ego far from who is added.
fn world_of_figures(rise_per_m: f64) -> World {
    let meshes = [wedge(PEDESTRIAN, [0.4, 0.6, 1.8]), wedge(SITTING, [0.8, 0.6, 1.3]), wedge(CYCLIST, [1.8, 0.6, 1.7])];
    with_ego_at(slope(rise_per_m), 0, [-60.0, 0.0, 0.0]).with_user_models(UserModels::new(0.5, &meshes).unwrap())
}

fn put_named(world: &mut World, class: ObjectClass, course: &Course) -> i32 {
    world.add(class, ModelChoice::Named(class.kitti_name()), course, Overlap::Refuse).unwrap()
}

#[test]
fn figures_stand_upright_on_a_slope_in_the_boxes_of_their_meshes() {
    let mut world = world_of_figures(0.1);
    for (k, (class, size)) in [(PEDESTRIAN, [0.4, 0.6, 1.8]), (SITTING, [0.8, 0.6, 1.3])].into_iter().enumerate() {
        let id = put_named(&mut world, class, &Course::Stand { x_m: 10.0, y_m: 5.0 * k as f64, yaw_rad: 0.7 });
        world.step(SECOND);
        let now = actor(&world, id);
        let at = DVec3::new(10.0, 5.0 * k as f64, 1.0);
        assert!((now.world_from_box.translation - at).length() < 1e-5, "{}", now.world_from_box.translation);
        assert_eq!(now.world_from_box.rotation, upright(at, 0.7).rotation);
        assert_eq!(now.class, class);
        assert!((now.size_lwh - DVec3::from_array(size)).length() < 1e-6 && now.annotated.size_lwh == now.size_lwh);
        assert_eq!(now.annotated.bottom_center_in_box, DVec3::ZERO, "its box is the mesh's");
        let shown = world.snapshot().instances.into_iter().filter(|i| i.actor_id == id).collect::<Vec<_>>();
        let [instance] = &shown[..] else { panic!("{} parts", shown.len()) };
        assert_eq!((instance.world_from_local, instance.is_body), (now.world_from_box, true));
    }
    // Two wheels stand along the slope, and a crossfall does not tip them.
    for yaw_rad in [0.0, 0.7, math::PI / 2.0] {
        let mut world = world_of_figures(0.1);
        let id = put_named(&mut world, CYCLIST, &Course::Stand { x_m: 10.0, y_m: 0.0, yaw_rad });
        let pose = actor(&world, id).world_from_box;
        let (forward, left) = (pose.rotation * DVec3::X, pose.rotation * DVec3::Y);
        assert!(left.z.abs() < 1e-9, "rolled by {}", left.z);
        let rise = forward.z / forward.truncate().length();
        assert!((rise - 0.1 * unit(yaw_rad).x).abs() < 1e-4, "{rise} at {yaw_rad} rad");
        assert!((pose.translation.z - 1.0).abs() < 1e-4);
    }
}

#[test]
fn figures_follow_a_path_and_go_straight_on() {
    let mut world = world_of_figures(0.05);
    let walks = path(&[(1.0, 0.0, 5.0), (5.0, 6.0, 5.0), (9.0, 6.0, 11.0)]);
    let (walker, rider) = (put_named(&mut world, PEDESTRIAN, &walks), {
        let straight = Course::Straight { x_m: 0.0, y_m: -6.0, yaw_rad: 0.3, speed_mps: 5.0 };
        put_named(&mut world, CYCLIST, &straight)
    });
    for t in 1..=10 {
        world.step(SECOND);
        let (t, now) = (f64::from(t), actor(&world, walker));
        let along = |from: f64, to: f64| 1.5 * (t.clamp(from, to) - from);
        let p = now.world_from_box.translation;
        let wanted = DVec2::new(along(1.0, 5.0), 5.0 + along(5.0, 9.0));
        assert!((p.truncate() - wanted).length() < 1e-9 && (p.z - 0.05 * p.x).abs() < 1e-5, "{p} after {t} s");
        let yaw_rad = yaw_of(&now.world_from_box);
        if t == 3.0 || t == 8.0 {
            assert!((yaw_rad - if t < 5.0 { 0.0 } else { math::PI / 2.0 }).abs() < 1e-6, "{yaw_rad} after {t} s");
            assert!((now.velocity_world.truncate() - unit(yaw_rad) * 1.5).length() < 1e-6);
        }
        let now = actor(&world, rider);
        let p = now.world_from_box.translation;
        assert!((p.truncate() - DVec2::new(0.0, -6.0) - unit(0.3) * 5.0 * t).length() < 1e-9, "{p} after {t} s");
        assert!((yaw_of(&now.world_from_box) - 0.3).abs() < 1e-6 && (now.velocity_world.length() - 5.0).abs() < 0.01);
    }
}

#[test]
fn drivers_brake_for_figures() {
    let stops_at = |class, course: &Course| {
        let mut world = world_of_figures(0.0);
        put_named(&mut world, class, course);
        world.drive(300.0, 6.0).unwrap();
        world.ego().world_from_ego.translation.x
    };
    let crosses = path(&[(0.0, 20.0, 6.0), (5.0, 20.0, 0.0)]);
    let stands = Course::Stand { x_m: 20.0, y_m: 0.0, yaw_rad: 1.0 };
    for (class, course) in
        [(PEDESTRIAN, &crosses), (CYCLIST, &crosses), (PEDESTRIAN, &stands), (SITTING, &stands), (CYCLIST, &stands)]
    {
        let found = stops_at(class, course);
        assert!((8.0..17.5).contains(&found), "the ego stopped at {found} for a {class:?} on {course:?}");
    }
}

#[test]
fn figures_have_the_limits_of_their_class() {
    let mut world = world_of_figures(0.0);
    let mut refused = |class, name: &str, course: &Course| {
        world.add(class, ModelChoice::Named(name), course, Overlap::Refuse).unwrap_err().to_string()
    };
    let stand = Course::Stand { x_m: 5.0, y_m: 5.0, yaw_rad: 0.0 };
    let at_speed = |speed_mps| Course::Straight { x_m: 5.0, y_m: 5.0, yaw_rad: 0.0, speed_mps };
    assert_eq!(refused(PEDESTRIAN, "Cyclist", &stand), "scene: model \"Cyclist\" is a Cyclist, not a Pedestrian");
    assert_eq!(refused(ObjectClass::Car, "Cyclist", &stand), "scene: model \"Cyclist\" is a Cyclist, not a Car");
    assert_eq!(refused(PEDESTRIAN, "Pedestrian", &at_speed(13.0)), "speed is 13, expected 0 to 12 m/s");
    assert_eq!(refused(CYCLIST, "Cyclist", &at_speed(21.0)), "speed is 21, expected 0 to 20 m/s");
    let moves = "scene: a Person_sitting does not move: no path and no speed";
    assert_eq!(refused(SITTING, "Person_sitting", &at_speed(1.0)), moves);
    let far = Course::Stand { x_m: 500.0, y_m: 0.0, yaw_rad: 0.0 };
    assert_eq!(
        refused(SITTING, "Person_sitting", &far),
        "scene: a person at (500, 0) would stand beyond the ground's edge"
    );
    assert_eq!(world.arena.agents.len(), 1, "who is refused leaves nothing");
    put_named(&mut world, CYCLIST, &stand);
    let near = Course::Stand { x_m: 5.5, y_m: 5.0, yaw_rad: 0.0 };
    let taken =
        world.add(SITTING, ModelChoice::Named("Person_sitting"), &near, Overlap::Refuse).unwrap_err().to_string();
    assert!(taken.contains("would overlap the Cyclist of id 1"), "{taken}");
}
