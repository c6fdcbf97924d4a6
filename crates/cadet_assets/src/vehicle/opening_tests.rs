//! What stands open hangs on its hinge, swings out to its side, and covers the hole that it leaves.

use super::*;

const ALL: [Opening; 3] = [Opening::LeftDoor, Opening::RightDoor, Opening::Tailgate];

fn vehicles() -> impl Iterator<Item = VehicleModel> {
    let cars = (0..40).map(|seed| VehicleModel::of_traffic(ObjectClass::Car, seed).unwrap());
    cars.chain((0..10).map(|seed| VehicleModel::generate(ObjectClass::Van, seed).unwrap()))
}

#[test]
fn doors_swing_out_to_their_side_and_tailgates_up() {
    let mut gates = 0;
    for model in vehicles() {
        let half = model.size_lwh.as_vec3() / 2.0;
        for opening in ALL {
            let Some(shape) = model.openings.as_ref().unwrap().opened(opening, model.size_lwh) else {
                assert_eq!(opening, Opening::Tailgate, "{} has doors", model.name);
                continue;
            };
            let mesh = shape.finest();
            assert_eq!(shape.bounds, mesh.bounds);
            assert!(mesh.num_faces() < 600 && mesh.slots().all(|s| usize::from(s) < 23), "{}", model.name);
            let reach = |along: Vec3| mesh.places().map(|v| v.dot(along)).fold(f32::MIN, f32::max);
            let side = if opening == Opening::RightDoor { -1.0 } else { 1.0 };
            if opening == Opening::Tailgate {
                gates += 1;
                assert!(reach(Vec3::NEG_X) > half.x + 0.15 && reach(Vec3::NEG_X) < half.x + 1.3, "{}", model.name);
                // The hole reaches down to where the tail is lowest; the leaf is high enough to stand under.
                let behind = mesh.places().filter(|v| -v.x > half.x + 0.1).map(|v| v.z);
                assert!(behind.fold(f32::MAX, f32::min) > 1.1, "{}", model.name);
            } else {
                let out = reach(Vec3::Y * side) - half.y;
                assert!((0.5..1.15).contains(&out), "{}: {out} beside it", model.name);
                assert!(reach(Vec3::Y * -side) < -0.3 * half.y, "{}: nothing on the other side", model.name);
                assert!(reach(Vec3::X) < half.x && reach(Vec3::Z) < 2.0 * half.z, "{}", model.name);
            }
        }
    }
    assert!(gates > 15, "{gates}");
}

#[test]
fn the_left_and_the_right_door_are_mirror_images() {
    for model in vehicles() {
        let [left, right] = [Opening::LeftDoor, Opening::RightDoor]
            .map(|side| model.openings.as_ref().unwrap().opened(side, model.size_lwh).unwrap().bounds);
        let turned = Vec3::new(1.0, -1.0, 1.0);
        assert!((left.min * turned).y - right.max.y < 1e-4 && (left.max - right.max).x.abs() < 1e-4);
        assert!((left.size() - right.size()).abs().max_element() < 1e-4, "{}", model.name);
    }
}
