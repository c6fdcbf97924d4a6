use super::*;
use cadet_base::geometry::Mesh;
use cadet_base::material::Semantic;

fn cyclists(n: u64) -> impl Iterator<Item = CyclistModel> {
    (0..n).map(CyclistModel::generate)
}

fn phases() -> impl Iterator<Item = f64> {
    (0..12).map(|k| (f64::from(k) + 0.01) / 12.0)
}

/// Corners of the faces of a material.
fn corners(mesh: &Mesh, slot: u8) -> Vec<[Vec3; 3]> {
    mesh.triangles().filter(|(_, s)| *s == slot).map(|(corners, _)| corners).collect()
}

/// Distance of a place from the surface of some faces, by sampling them.
fn distance(faces: &[[Vec3; 3]], at: Vec3) -> f32 {
    let mut best = f32::INFINITY;
    for [a, b, c] in faces {
        for i in 0..=10 {
            for k in 0..=(10 - i) {
                let (u, v) = (i as f32 / 10.0, k as f32 / 10.0);
                best = best.min((*a + (*b - *a) * u + (*c - *a) * v - at).length());
            }
        }
    }
    best
}

const SHOES: u8 = crate::person::clothes::slot::SHOES;
const SKIN: u8 = crate::person::clothes::slot::SKIN;

#[test]
fn feet_stay_on_the_pedals_through_a_turn_of_the_crank_at_every_level() {
    for cyclist in cyclists(12) {
        for phase in phases() {
            let b = &cyclist.design.bicycle;
            // Two shapes a meter apart are told by the crank's turn alone.
            let turn = (phase * NUM_PHASES as f64).floor() / NUM_PHASES as f64 * std::f64::consts::TAU;
            let [x, z] = b.bottom_bracket;
            let (sin, cos) = (cadet_base::math::sin(turn) as f32, cadet_base::math::cos(turn) as f32);
            let legs = cyclist.pedaling(phase);
            for (level, (_, mesh)) in legs.levels.iter().enumerate() {
                let shoes = corners(mesh, SHOES);
                for side in [1.0, -1.0] {
                    let pedal = Vec3::new(x + side * b.crank_m * sin, side * b.pedal_y, z + side * b.crank_m * cos);
                    // The sole lies on the pedal's upper side, 1.2 cm over its middle.
                    let gap = distance(&shoes, pedal + Vec3::Z * 0.012);
                    assert!(gap < 0.01, "{}: level {level}, {phase}, side {side}: {gap} m", cyclist.name);
                }
            }
        }
    }
}

#[test]
fn hands_are_on_the_grips_riding_and_standing() {
    for cyclist in cyclists(40) {
        let grip = cyclist.design.bicycle.grip;
        for stands in [false, true] {
            for (level, (_, mesh)) in cyclist.body(stands).levels.iter().enumerate() {
                let skin = corners(mesh, SKIN);
                for side in [1.0, -1.0] {
                    // The hand is round the grip: its surface is half a hand's thickness away.
                    let gap = distance(&skin, grip * Vec3::new(1.0, side, 1.0));
                    assert!(gap < 0.035, "{}: level {level}, stands {stands}: {gap} m", cyclist.name);
                }
            }
        }
        let lean_deg = cyclist.design.riding.lean_rad.to_degrees();
        assert!((2.0..52.0).contains(&lean_deg), "{}: trunk at {lean_deg} degrees", cyclist.name);
    }
}

#[test]
fn who_stands_has_one_foot_on_the_ground_and_the_other_on_a_pedal() {
    for cyclist in cyclists(40) {
        let (b, side) = (&cyclist.design.bicycle, cyclist.design.foot);
        let other = b.pedal(-side, Legs::Stand(side).crank_phase());
        for (_, mesh) in &cyclist.standing().levels {
            let shoes = corners(mesh, SHOES);
            let low = shoes.iter().flatten().filter(|v| v.y * side > 0.0).fold(1.0_f32, |a, v| a.min(v.z));
            assert!(low.abs() < 0.01, "{}: the foot is {low} m above the ground", cyclist.name);
            assert!(distance(&shoes, other + Vec3::Z * 0.012) < 0.01, "{}", cyclist.name);
        }
    }
}

#[test]
fn wheels_stand_on_the_ground_and_are_as_far_apart_as_the_box_is_long() {
    for cyclist in cyclists(40) {
        let [rear, front] = cyclist.axles();
        for (level, (_, mesh)) in cyclist.wheel.levels.iter().enumerate() {
            let bounds = mesh.bounds;
            let radius = f64::from(-bounds.min.z);
            assert!((radius - rear.z).abs() < 0.006, "{}: level {level}: {radius} of {}", cyclist.name, rear.z);
        }
        let long = front.x - rear.x + 2.0 * cyclist.wheel_radius_m;
        assert!((cyclist.size_lwh.x - long).abs() < 0.09, "{}: {} of {long}", cyclist.name, cyclist.size_lwh.x);
        assert!((1.35..1.95).contains(&long), "{}: {long} m", cyclist.name);
    }
}

#[test]
fn cyclists_are_about_as_large_as_the_boxes_drawn_round_them() {
    let (mut off, mut lean, mut children) = ([Vec::new(), Vec::new(), Vec::new()], Vec::new(), 0);
    for cyclist in cyclists(200) {
        let annotated = cyclist.annotated;
        for (k, off) in off.iter_mut().enumerate() {
            let low = if k == 2 { annotated.bottom_center_in_box.z } else { 0.0 };
            off.push(cyclist.size_lwh[k] - annotated.size_lwh[k] - low);
        }
        lean.push(cyclist.design.riding.lean_rad);
        children += usize::from(cyclist.name.starts_with("child"));
    }
    for (k, off) in off.iter_mut().enumerate() {
        off.sort_by(f64::total_cmp);
        let (low, middle, high) = (off[20], off[100], off[180]);
        let within = [0.13, 0.22, 0.06][k];
        assert!(low > -within && high < within && middle.abs() < 0.05, "axis {k}: {low} {middle} {high}");
    }
    lean.sort_by(f32::total_cmp);
    assert!(lean[20] < lean[100] && lean[180] - lean[20] > 0.2, "city bicycles and sporty ones: {lean:?}");
    assert!((1..=30).contains(&children), "{children} children");
}

#[test]
fn meshes_are_sound_and_every_material_is_a_cyclists() {
    for cyclist in cyclists(40) {
        assert!(cyclist.palette.materials().iter().all(|m| m.semantic == Semantic::Cyclist));
        let shapes = [cyclist.body(false), cyclist.body(true), cyclist.pedaling(0.3), cyclist.standing()];
        let mut faces = [0; 3];
        for shape in shapes.iter().chain([&cyclist.wheel]) {
            for (_, mesh) in &shape.levels {
                assert!(mesh.places().all(|v| v.is_finite()), "{}", cyclist.name);
                assert!(mesh.slots().all(|s| usize::from(s) < cyclist.palette.materials().len()));
                let inside = mesh.bounds.max.cmple(cyclist.size_lwh.as_vec3() + Vec3::splat(0.12)).all();
                assert!(inside && mesh.bounds.min.z > -0.36, "{}: {:?}", cyclist.name, mesh.bounds);
            }
        }
        for shape in [&shapes[0], &shapes[2], &cyclist.wheel, &cyclist.wheel] {
            for (level, (_, mesh)) in shape.levels.iter().enumerate() {
                faces[level] += mesh.num_faces();
            }
        }
        assert!(faces[0] < 12_000 && faces[1] < 4200 && faces[2] < 1500, "{faces:?}");
    }
}

#[test]
fn a_phase_is_made_once_and_cranks_turn_forward() {
    let cyclist = CyclistModel::generate(0);
    assert!(Arc::ptr_eq(&cyclist.pedaling(0.30), &cyclist.clone().pedaling(1.30)));
    // From the top a pedal moves forward.
    let b = &cyclist.design.bicycle;
    assert!(b.pedal(1.0, 0.05).x > b.pedal(1.0, 0.0).x);
}
