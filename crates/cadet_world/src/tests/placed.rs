//! Nobody is put where another stands.

use super::towns::slope;
use super::*;

fn reason(refused: Result<i32>) -> String {
    refused.expect_err("somebody stands there").to_string()
}

#[test]
fn nobody_is_put_where_another_stands_unless_that_is_allowed() {
    let mut world = with_ego_at(slope(0.0), 0, [0.0, 0.0, 0.0]);
    let car = add(&mut world, ObjectClass::Car, 12.0, 0.0, 0.0, 1).unwrap();
    let person = add(&mut world, ObjectClass::Pedestrian, 20.0, 4.0, 0.0, 1).unwrap();
    let num_agents = world.arena.agents.len();
    let wanted = "scene: a Van at (13, 1) would overlap the Car of id 1; overlap=\"allow\" puts it there";
    assert_eq!(reason(add(&mut world, ObjectClass::Van, 13.0, 1.0, 1.0, 2)), wanted);
    for (class, x, y, whom) in [
        (ObjectClass::Pedestrian, 12.0, 0.5, format!("the Car of id {car}")),
        (ObjectClass::Pedestrian, 20.3, 4.2, format!("the Pedestrian of id {person}")),
        (ObjectClass::Car, 21.5, 4.5, format!("the Pedestrian of id {person}")),
        (ObjectClass::Car, 3.0, 1.0, "the ego (id 0)".to_owned()),
    ] {
        let found = reason(add(&mut world, class, x, y, 0.0, 3));
        assert!(found.contains(&whom), "{found}");
    }
    let moved = world.move_ego(11.0, 0.4, 0.1, Overlap::Refuse).expect_err("a car stands there").to_string();
    assert_eq!(moved, "scene: the ego at (11, 0.4) would overlap the Car of id 1; overlap=\"allow\" puts it there");
    assert_eq!(world.ego().world_from_ego.translation.x, 0.0);
    assert_eq!((world.arena.agents.len(), world.arena.next_id()), (num_agents, 3), "who is refused leaves nothing");
    // Beside each other there is room.
    add(&mut world, ObjectClass::Car, 12.0, 2.3, 0.0, 1).unwrap();
    add(&mut world, ObjectClass::Pedestrian, 20.0, 4.5, 0.0, 4).unwrap();
    let course = Course::Stand { x_m: 12.0, y_m: 0.0, yaw_rad: 0.5 };
    assert_eq!(world.add(ObjectClass::Car, ModelChoice::Seed(1), &course, Overlap::Allow).unwrap(), 5);
    world.move_ego(11.0, 0.4, 0.1, Overlap::Allow).unwrap();
    // Where it stands already there is nobody else.
    world.move_ego(-20.0, 0.0, 0.0, Overlap::Refuse).unwrap();
    world.move_ego(-20.5, 0.0, 0.0, Overlap::Refuse).unwrap();
}

#[test]
fn a_path_begins_where_nobody_stands() {
    let mut world = with_ego_at(slope(0.0), 0, [0.0, 0.0, 0.0]);
    let path = |y_m| Course::Path([0.0, 4.0].map(|t_s| Waypoint { t_s, x_m: 2.0 + 5.0 * t_s, y_m }).to_vec());
    let seed = ModelChoice::Seed(0);
    assert!(reason(world.add(ObjectClass::Car, seed, &path(0.5), Overlap::Refuse)).contains("the ego (id 0)"));
    assert!(world.add(ObjectClass::Car, seed, &path(0.5), Overlap::Allow).is_ok());
    assert!(world.add(ObjectClass::Car, seed, &path(4.0), Overlap::Refuse).is_ok());
}
