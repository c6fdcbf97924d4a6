use std::collections::BTreeMap;

use strum::VariantArray;

use super::*;
use crate::person::PersonModel;
use cadet_base::geometry::Mesh;

const STICKS: [Thing; 3] = [Thing::Stick, Thing::Crutch, Thing::Crutches];

/// Adults with a thing, half of them walking and more.
fn owners(thing: Thing, n: u64) -> impl Iterator<Item = PersonModel> {
    let adults = (0..n).map(PersonModel::generate).filter(|p| !p.is_child());
    adults.map(move |p| p.carrying(thing, if p.seed() % 2 == 0 { 1.0 } else { -1.0 }))
}

fn of(person: &PersonModel) -> &Belonging {
    person.belonging.as_ref().expect("has one")
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [Vec3; 3]> {
    mesh.triangles().map(|(corners, _)| corners)
}

#[test]
fn meshes_are_closed_outward_and_of_few_faces() {
    for &thing in Thing::VARIANTS {
        for person in owners(thing, 40) {
            for phase in [0.0, 0.4] {
                let shape = of(&person).pose(phase);
                assert_eq!(shape.bounds, shape.levels[0].1.bounds);
                let faces: Vec<usize> = shape.levels.iter().map(|(_, mesh)| mesh.num_faces()).collect();
                assert!(faces[0] < 3600 && faces[1] < 1500 && faces[2] < 700, "{}: {faces:?}", person.name);
                assert!(faces[0] > faces[1] && faces[1] > faces[2], "{}: {faces:?}", person.name);
                for (_, mesh) in &shape.levels {
                    assert!(mesh.slots().all(|s| usize::from(s) < of(&person).palette.materials().len()));
                    // Every edge is passed as often one way as the other, and the whole encloses something.
                    let mut edges: BTreeMap<([u32; 3], [u32; 3]), i32> = BTreeMap::new();
                    for ends in corners(mesh) {
                        let [a, b, c] = ends.map(|p| p.to_array().map(f32::to_bits));
                        for (p, q) in [(a, b), (b, c), (c, a)].into_iter().filter(|(p, q)| p != q) {
                            *edges.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { -1 };
                        }
                    }
                    assert!(edges.values().all(|sum| *sum == 0), "{} is open", person.name);
                    let volume: f32 = corners(mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
                    let least = if STICKS.contains(&thing) { 0.000_15 } else { 0.0005 };
                    assert!((least..0.2).contains(&volume), "{}: {volume}", person.name);
                }
            }
        }
    }
}

#[test]
fn sizes_boxes_and_places_stay_those_of_the_person() {
    for &thing in Thing::VARIANTS {
        for person in owners(thing, 20) {
            let alone = PersonModel::generate(person.seed());
            assert_eq!((alone.size_lwh, alone.annotated), (person.size_lwh, person.annotated));
            assert_eq!(alone.walking_speed_mps, person.walking_speed_mps);
            let named = format!(" with {}/{}", thing.as_ref(), person.seed());
            assert!(person.name.ends_with(&named), "{}", person.name);
            let (a, b) = (alone.pose(0.3), person.pose(0.3));
            let soles = |shape: &LodSet| shape.levels[0].1.bounds.min.z;
            assert!((soles(&a) - soles(&b)).abs() < 1e-6);
        }
    }
}

#[test]
fn hands_are_where_they_hold_at_every_phase() {
    for &thing in Thing::VARIANTS {
        for person in owners(thing, 30) {
            for phase in [0.0, 0.2, 0.45, 0.7, 0.9] {
                let (body, held) = (person.pose(phase), of(&person).pose(phase));
                let (skin, held) = (&body.levels[0].1, &held.levels[0].1);
                for hand in of(&person).hands.into_iter().flatten() {
                    let walks = person.walking_speed_mps > 0.0;
                    let shown = if walks { (phase * 48.0).floor() / 48.0 } else { 0.0 };
                    let hand = hand.at(shown as f32) + of(&person).offset;
                    let gap = |mesh: &Mesh| {
                        let middles = corners(mesh).map(|[a, b, c]| (a + b + c) / 3.0);
                        middles.chain(mesh.places()).map(|v| (v - hand).length()).fold(f32::MAX, f32::min)
                    };
                    assert!(gap(skin) < 0.05, "{} at {phase}: the hand is {} away", person.name, gap(skin));
                    // Long straight bars have no corner beside the hand.
                    let near = if thing == Thing::Pram { 0.25 } else { 0.10 };
                    assert!(gap(held) < near, "{}: {} away from what it holds", person.name, gap(held));
                }
            }
        }
    }
}

#[test]
fn what_stands_on_the_ground_does_and_umbrellas_are_over_their_heads() {
    for &thing in Thing::VARIANTS {
        for person in owners(thing, 40) {
            for (level, (_, mesh)) in of(&person).pose(0.3).levels.iter().enumerate() {
                let (low, high) = (mesh.bounds.min.z, mesh.bounds.max.z);
                if thing == Thing::Umbrella {
                    let top = person.size_lwh.z as f32;
                    assert!(high > top + 0.1 && high < top + 0.45, "{}: {high} over {top}", person.name);
                    // Under the canopy's middle part is the head.
                    let middle = mesh.bounds.center().truncate();
                    assert!(middle.length() < 0.35, "{}: {middle}", person.name);
                } else if STICKS.contains(&thing) {
                    // In the hand of a side it may just be lifted.
                    assert!((-0.012..0.06).contains(&low) && high < 1.4, "{}: {low} to {high}", person.name);
                } else {
                    let slack = [0.012, 0.02, 0.035][level];
                    assert!(low.abs() < slack, "{} at level {level}: {low} over the ground", person.name);
                    assert!(high < 1.45, "{}: {high}", person.name);
                }
            }
        }
    }
}

#[test]
fn paws_on_the_ground_stay_where_they_are() {
    let mut seen = 0;
    for person in owners(Thing::Dog, 60).filter(|p| p.walking_speed_mps > 0.0) {
        let step = 1.0 / NUM_PHASES as f64;
        for k in 0..NUM_PHASES {
            let at = |k: usize| {
                let tubes = of(&person).design.tubes((k % NUM_PHASES) as f32 / NUM_PHASES as f32, 0);
                tubes.vertices.into_iter().map(|v| v + of(&person).offset)
            };
            let pairs = at(k).zip(at(k + 1)).filter(|(a, b)| a.z < 0.004 && b.z < 0.004);
            let moves: Vec<f32> = pairs.map(|(a, b)| a.x - b.x).collect();
            let walked = (person.cycle_length_m * step) as f32;
            // Who is about to lift a paw is let off.
            let slips = moves.iter().filter(|m| (**m - walked).abs() > 0.25 * walked).count();
            assert!(10 * slips <= 3 * moves.len(), "{}: {slips} of {} slip", person.name, moves.len());
            seen += moves.len();
        }
    }
    assert!(seen > 1000, "{seen}");
}

/// The lowest vertices of a shape on one side of its owner's middle.
fn foot(person: &PersonModel, phase: f64, is_left: bool) -> Vec3 {
    let shape = of(person).pose(phase);
    let offset = of(person).offset;
    let vertices = shape.levels[0].1.places().map(|v| v - offset).filter(|v| (v.y > 0.0) == is_left);
    vertices.min_by(|a, b| a.z.total_cmp(&b.z)).expect("a stick")
}

#[test]
fn tips_of_sticks_are_put_down_with_the_other_foot_and_stay_where_they_are() {
    let (mut walking, mut standing) = (0, 0);
    for thing in STICKS {
        for person in owners(thing, 60) {
            for (is_left, strikes_at) in [(true, 0.5), (false, 0.0)] {
                if of(&person).hands[usize::from(!is_left)].is_none() {
                    continue;
                }
                let at = |k: usize| foot(&person, strikes_at + (k as f64 + 0.5) / NUM_STICK_PHASES as f64, is_left);
                if person.walking_speed_mps == 0.0 {
                    assert!(at(0).z.abs() < 0.005 && at(0) == at(20), "{}: {}", person.name, at(0));
                    standing += 1;
                    continue;
                }
                // 0.6 of the cycle on the ground, over which the body walks on; then through the air.
                let (first, last) = (at(1), at(27));
                assert!((0..28).all(|k| at(k).z.abs() < 0.01), "{} floats", person.name);
                let walked = person.cycle_length_m as f32 * 26.0 / NUM_STICK_PHASES as f32;
                assert!((first.x - last.x - walked).abs() < 0.04, "{}: {} of {walked}", person.name, first.x - last.x);
                assert!((0.03..0.08).contains(&at(38).z), "{}: {} high", person.name, at(38).z);
                walking += 1;
            }
        }
    }
    assert!(walking > 60 && standing > 15, "{walking} {standing}");
}

#[test]
fn grips_are_where_arms_reach_them() {
    for thing in STICKS {
        for person in owners(thing, 60) {
            for hold in of(&person).hands.iter().flatten() {
                for k in 0..NUM_STICK_PHASES {
                    let hand = hold.at(k as f32 / NUM_STICK_PHASES as f32);
                    let height = hand.z / person.size_lwh.z as f32;
                    assert!((0.40..0.52).contains(&height), "{} at {k}: {height}", person.name);
                }
            }
        }
    }
}
