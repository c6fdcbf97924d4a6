use super::*;

const PHASES: usize = 24;

fn people(n: u64) -> impl Iterator<Item = PersonModel> {
    (0..n).map(PersonModel::generate)
}

fn phases() -> impl Iterator<Item = f64> {
    (0..PHASES).map(|k| k as f64 / PHASES as f64)
}

#[test]
fn the_lower_sole_is_on_the_ground_and_the_box_holds_the_body() {
    for person in people(60) {
        let half = person.size_lwh.as_vec3() * 0.5;
        for phase in phases() {
            for (_, mesh) in &person.pose(phase).levels {
                let b = mesh.bounds;
                assert!(b.min.z.abs() < 0.005, "{} at {phase}: sole at {}", person.name, b.min.z);
                assert!(b.max.z < 2.0 * half.z + 0.02, "{} at {phase}: {} high", person.name, b.max.z);
                let over = (b.max - half).max(-b.min - half);
                assert!(over.x < 0.02 && over.y < 0.02, "{} at {phase}: {over} outside", person.name);
            }
        }
    }
}

#[test]
fn the_box_is_no_larger_than_the_cycle() {
    for person in people(60) {
        let empty = Bounds::EMPTY;
        let b = phases()
            .map(|p| person.pose(p).levels[0].1.bounds)
            .fold(empty, |a, b| Bounds { min: a.min.min(b.min), max: a.max.max(b.max) });
        let slack = person.size_lwh.as_vec3() - b.size();
        assert!(slack.abs().max_element() < 0.02, "{}: {slack}", person.name);
    }
}

/// Lowest vertices of the foot on one side: the sole's rear half, which is on the ground while the foot is flat.
fn heel(person: &PersonModel, phase: f64, is_left: bool) -> Vec3 {
    let posture = gait::walking(&person.proportions, phase as f32);
    let leg = posture.legs[usize::from(!is_left)];
    let p = &*person.proportions;
    let x = p.thigh_m * cadet_base::math::sinf(leg.thigh_rad) + p.shank_m * cadet_base::math::sinf(leg.shank_rad);
    Vec3::new(x, 0.0, leg.sole_rad)
}

#[test]
fn the_standing_foot_stays_where_it_was_put() {
    // Flat on the ground the ankle moves backwards by just the way that the body walks.
    for person in people(80).filter(|p| p.walking_speed_mps > 0.0) {
        for is_left in [true, false] {
            let at = |t: f64| heel(&person, t + if is_left { 0.0 } else { 0.5 }, is_left);
            let (from, to) = (0.12, 0.40);
            assert!(at(from).z.abs() < 0.06 && at(to).z.abs() < 0.06, "{}: the foot is flat", person.name);
            let moved = f64::from(at(from).x - at(to).x);
            let walked = (to - from) * person.cycle_length_m;
            assert!((moved / walked - 1.0).abs() < 0.1, "{}: {moved} of {walked}", person.name);
        }
    }
}

#[test]
fn the_meshes_own_soles_do_not_skate() {
    // Independent of the skeleton: the way of the vertices that stay within 1 cm of the ground, at mid-stance.
    for person in people(40).filter(|p| p.walking_speed_mps > 0.0) {
        let at = |k: usize| grounded(&person.proportions, None, k, 0).vertices.into_iter().map(|v| v + person.offset);
        // The right foot swings meanwhile; vertices keep their number over the cycle.
        let pairs = at(9).zip(at(17)).filter(|(a, b)| a.z < 0.01 && b.z < 0.01 && a.y > -0.02);
        let moves: Vec<f32> = pairs.map(|(a, b)| a.x - b.x).filter(|d| *d > 0.0).collect();
        assert!(moves.len() > 20, "{}: a foot's sole is on the ground", person.name);
        let moved = f64::from(moves.iter().sum::<f32>() / moves.len() as f32);
        let walked = 8.0 / 48.0 * person.cycle_length_m;
        assert!((moved / walked - 1.0).abs() < 0.2, "{}: {moved} of {walked}", person.name);
    }
}

#[test]
fn heights_and_speeds_follow_the_specification() {
    let (mut heights, mut walkers, mut children) = (Vec::new(), Vec::new(), 0);
    for person in people(300) {
        heights.push(person.size_lwh.z);
        children += usize::from(person.name.starts_with("child"));
        if person.walking_speed_mps > 0.0 {
            let step = person.cycle_length_m / 2.0;
            let cadence = 60.0 * person.walking_speed_mps / step;
            assert!((80.0..170.0).contains(&cadence), "{}: {cadence} steps a minute", person.name);
            walkers.push(person.walking_speed_mps);
        }
    }
    let moments = |v: &[f64]| {
        let mean = v.iter().sum::<f64>() / v.len() as f64;
        (mean, (v.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / v.len() as f64).sqrt())
    };
    let (mean, sd) = moments(&heights);
    assert!((mean - 1.75).abs() < 0.05 && (0.08..0.15).contains(&sd), "height {mean} +- {sd}");
    let (speed, _) = moments(&walkers);
    assert!((speed - 1.34).abs() < 0.08, "speed {speed}");
    assert!((190..=255).contains(&walkers.len()), "{} of 300 walk", walkers.len());
    // One in a hundred of KITTI's boxes of people is lower than 1.5 m.
    assert!((1..=9).contains(&children), "{children} children");
}

#[test]
fn a_walker_swings_its_arms_against_its_legs() {
    let person = people(50).find(|p| p.walking_speed_mps > 1.2 && p.proportions.arms == [ArmPose::Swing; 2]);
    let p = person.expect("somebody walks with free arms").proportions;
    let posture = gait::walking(&p, 0.0);
    assert!(posture.legs[0].thigh_rad > 0.2 && posture.legs[1].thigh_rad < 0.0, "the left heel strikes");
    assert!(posture.arms[0].swing_rad < -0.2 && posture.arms[1].swing_rad > 0.2, "the left arm is back");
}

#[test]
fn meshes_are_sound_closed_and_outward() {
    for person in people(300) {
        let shape = person.pose(0.3);
        let faces: Vec<usize> = shape.levels.iter().map(|l| l.1.num_faces()).collect();
        assert_eq!(shape.bounds, shape.levels[0].1.bounds, "{}", person.name);
        assert!((3000..5000).contains(&faces[0]) && (700..1500).contains(&faces[1]) && faces[2] < 400, "{faces:?}");
        for (_, mesh) in &shape.levels {
            assert!(mesh.slots().all(|s| usize::from(s) < person.palette.materials().len()));
            // Every tube is closed, so its signed volume is its own, and people displace 12 to 280 litres with coats and bags.
            let volume: f32 = mesh.triangles().map(|([a, b, c], _)| a.dot(b.cross(c)) / 6.0).sum();
            assert!((0.012..0.28).contains(&volume), "{}: {volume}", person.name);
        }
    }
}

#[test]
fn cloth_is_bright_at_905_nm_whatever_its_color() {
    for person in people(100) {
        for cloth in [clothes::slot::TOP, clothes::slot::LEGS] {
            let m = person.palette.materials()[usize::from(cloth)];
            assert!((0.3..=0.7).contains(&m.lidar.reflectance));
            assert_eq!(m.semantic, cadet_base::material::Semantic::Person);
        }
    }
}

#[test]
fn a_phase_is_made_once() {
    let person = PersonModel::generate(0);
    let (a, b) = (person.pose(0.30), person.clone().pose(1.30));
    assert!(Arc::ptr_eq(&a.levels[0].1, &b.levels[0].1));
    let again = PersonModel::generate(0).pose(0.30);
    assert_eq!(*a.levels[1].1, *again.levels[1].1);
}

#[test]
fn people_who_sit_rest_on_their_seat_with_their_feet_on_the_ground() {
    for seat_m in [0.44, 0.46, 0.475] {
        for person in (0..60).map(|seed| PersonModel::sitting(seed, seat_m)) {
            let origin = person.seat_from_box().as_vec3();
            for (level, (_, mesh)) in person.pose(0.0).levels.iter().enumerate() {
                // Buttocks and the upper half of the thighs; at the seat's front edge those of short people slope.
                let on_seat = mesh.places().map(|v| v + origin);
                let on_seat = on_seat.filter(|v| v.x.abs() < 0.08 && v.y.abs() < 0.2 && v.z > 0.35);
                let low = on_seat.map(|v| v.z).fold(f32::INFINITY, f32::min);
                let slack = [0.02, 0.025, 0.05][level];
                assert!((low - seat_m as f32).abs() < slack, "{}: {low} on a seat of {seat_m}", person.name);
                let sole = mesh.bounds.min.z;
                // Feet of short people hang a little.
                assert!((-0.02..0.06).contains(&sole), "{} at level {level}: soles at {sole}", person.name);
                assert!(mesh.bounds.max.z < person.size_lwh.z as f32 + 0.02, "{}", person.name);
            }
        }
    }
}

#[test]
fn people_who_sit_are_about_as_large_as_their_boxes() {
    let people: Vec<PersonModel> = (0..200).map(|seed| PersonModel::sitting(seed, 0.46)).collect();
    let mean = |of: &dyn Fn(&PersonModel) -> f64| people.iter().map(of).sum::<f64>() / people.len() as f64;
    let over = |k: usize| mean(&|p| p.size_lwh[k] - p.annotated.size_lwh[k]);
    // KITTI's boxes: length 0.80, width 0.60, height 1.27 in the mean.
    assert!((mean(&|p| p.annotated.size_lwh.x) - 0.80).abs() < 0.04);
    assert!((mean(&|p| p.annotated.size_lwh.z) - 1.275).abs() < 0.02);
    assert!(
        over(0).abs() < 0.15 && over(1).abs() < 0.12 && over(2).abs() < 0.08,
        "{} {} {}",
        over(0),
        over(1),
        over(2)
    );
    // Long boxes are those of stretched legs.
    let (short, long): (Vec<&PersonModel>, Vec<&PersonModel>) =
        people.iter().partition(|p| p.annotated.size_lwh.x < 0.75);
    let length = |of: &[&PersonModel]| of.iter().map(|p| p.size_lwh.x).sum::<f64>() / of.len() as f64;
    assert!(length(&long) > length(&short) + 0.01, "{} {}", length(&long), length(&short));
}

#[test]
fn people_fill_the_boxes_that_are_drawn_around_them() {
    let (walkers, standers): (Vec<PersonModel>, Vec<PersonModel>) =
        people(1500).partition(|p| p.walking_speed_mps > 0.0);
    // Axis, mean excess over the box, and a bound of its standard deviation. The boxes' own are 0.13 and 0.14 m for walkers,
    // 0.11 and 0.14 m for others, whose bags on the back do not fit into short boxes.
    for (of, axis, over_m, sd_m) in
        [(&walkers, 0, 0.085, 0.05), (&walkers, 1, 0.0, 0.07), (&standers, 0, 0.04, 0.13), (&standers, 1, 0.02, 0.09)]
    {
        let over: Vec<f64> = of.iter().map(|p| p.size_lwh[axis] - p.annotated.size_lwh[axis]).collect();
        let mean = over.iter().sum::<f64>() / over.len() as f64;
        let sd = (over.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / over.len() as f64).sqrt();
        assert!((mean - over_m).abs() < 0.015 && sd < sd_m, "axis {axis}: {mean} +- {sd}");
    }
}
