//! Some parked cars stand open, and their boxes stay those of closed ones.

use super::*;

#[test]
fn two_in_a_hundred_parked_cars_stand_open_with_the_boxes_of_closed_ones() {
    let (mut all, mut open) = (0, 0);
    for seed in 0..12 {
        let world = filled(suburb(seed), seed, [0, 0, 0]);
        for agent in parked(&world) {
            let VehicleLook { model, opened, .. } = &parked_car(agent).unwrap().look;
            all += 1;
            open += usize::from(opened.is_some());
            assert_eq!(opened.is_some(), model.name.contains(" with open "), "{}", model.name);
            assert_eq!(agent.actor().look.size_lwh(), model.size_lwh);
            assert_eq!(agent.actor().look.model().annotated, model.annotated);
        }
    }
    let share = f64::from(open as u32) / f64::from(all);
    assert!(all > 800 && (0.007..0.03).contains(&share), "{open} of {all}");
}
