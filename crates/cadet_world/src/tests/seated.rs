//! People who sit: on their seats, in the way of nobody.

use super::*;
use cadet_town::{PropConfig, SuburbConfig};

#[test]
fn sitting_people_stay_on_the_seats_of_the_town() {
    let mut seen = 0;
    for seed in [3, 4] {
        let key = StreamKey::scene(seed);
        let props = PropConfig { clutter: 2.0, ..Default::default() };
        let town = Arc::new(Town::suburb(&key, &SuburbConfig::default(), &props).unwrap());
        let config = TrafficConfig { num_cars: 4, num_pedestrians: 12, seat_occupancy: 0.8, ..Default::default() };
        let mut world = filled_as(Arc::clone(&town), seed, &config);
        let sitters = |world: &World| {
            let actors = world.snapshot().actors;
            let sitters = actors.into_iter().filter(|a| a.class == ObjectClass::PersonSitting);
            sitters.map(|a| (a.id, a.world_from_box.translation)).collect::<Vec<_>>()
        };
        let before = sitters(&world);
        for (id, at) in &before {
            let nearest = town.seats.iter().map(|s| s.world_from_seat.translation);
            let nearest = nearest.min_by(|a, b| (*a - *at).length().total_cmp(&(*b - *at).length())).unwrap();
            // The box reaches from behind the back to the feet: its middle is before the seat's.
            assert!((nearest - *at).truncate().length() < 0.55, "{id} sits {at}, the seat is at {nearest}");
            assert!((nearest.z - at.z).abs() < 0.02, "{id} sits {} over the seat's ground", at.z - nearest.z);
        }
        seen += before.len();
        world.step(240);
        let after = sitters(&world);
        // The ego has driven on, and farther people are left out of snapshots.
        let stays = |(id, at): &(i32, _)| before.iter().all(|(other, place)| other != id || place == at);
        assert!(!after.is_empty() && after.iter().all(stays), "somebody moved");
    }
    assert!(seen > 10, "{seen}");
}

#[test]
fn nobody_sits_where_no_seat_is_taken() {
    let key = StreamKey::scene(3);
    let town = Arc::new(Town::suburb(&key, &SuburbConfig::default(), &PropConfig::default()).unwrap());
    let world = filled_as(town, 3, &TrafficConfig { seat_occupancy: 0.0, ..Default::default() });
    assert!(world.snapshot().actors.iter().all(|a| a.class != ObjectClass::PersonSitting));
}

#[test]
fn a_sitting_person_is_added_by_name_and_never_moves() {
    let mut world = World::new(Arc::new(Town::flat()), StreamKey::scene(0)).unwrap();
    let id = add(&mut world, ObjectClass::PersonSitting, 12.0, 3.0, 1.0, 5).unwrap();
    let sitter = actor(&world, id);
    assert!((1.0..1.6).contains(&sitter.size_lwh.z) && sitter.class == ObjectClass::PersonSitting);
    let again = add(&mut world, ObjectClass::PersonSitting, 12.0, 3.0, 1.0, 5).unwrap_err();
    assert!(again.to_string().contains("would overlap the Person_sitting"), "{again}");
    let walk = Course::Straight { x_m: 5.0, y_m: 3.0, yaw_rad: 1.0, speed_mps: 1.0 };
    let error = world.add(ObjectClass::PersonSitting, ModelChoice::Seed(5), &walk, Overlap::Refuse).unwrap_err();
    assert!(error.to_string().contains("does not move"), "{error}");
}
