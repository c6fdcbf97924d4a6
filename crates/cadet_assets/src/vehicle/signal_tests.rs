//! Turn signals are where they can be seen, each on its side.

use super::paint::slot;
use super::*;
use crate::rays::hits;
use cadet_base::geometry::Mesh;

/// Places and normals of a slot's faces.
fn faces_of(mesh: &Mesh, of: u8) -> Vec<(Vec3, Vec3)> {
    let faces = mesh.triangles().filter(|(_, s)| *s == of);
    faces.map(|([a, b, c], _)| ((a + b + c) / 3.0, (b - a).cross(c - a).normalize())).collect()
}

/// Whether nothing of the mesh lies between a place on it and the open, along a direction.
fn is_open(mesh: &Mesh, from: Vec3, along: Vec3) -> bool {
    hits(mesh, from, along, |_| true).iter().all(|hit| hit.range_m <= 1e-3)
}

#[test]
fn signals_are_at_the_corners_of_both_sides_and_seen_from_ahead_and_behind_at_every_level() {
    for class in [ObjectClass::Car, ObjectClass::Van, ObjectClass::Truck] {
        for seed in 0..40 {
            let model = VehicleModel::generate(class, seed).unwrap();
            let half = model.size_lwh.as_vec3() / 2.0;
            for (level, (_, mesh)) in model.body.levels.iter().enumerate() {
                for (of, side) in [(slot::LEFT_SIGNAL, 1.0), (slot::RIGHT_SIGNAL, -1.0)] {
                    let faces = faces_of(mesh, of);
                    assert!(faces.iter().all(|(p, _)| p.y * side > 0.2), "{} {level}", model.name);
                    // Trucks' rear lamps are left out where they are smaller than a pixel.
                    let ends: &[f32] = if class == ObjectClass::Truck && level == 3 { &[1.0] } else { &[1.0, -1.0] };
                    for end in ends {
                        let seen = faces.iter().filter(|(p, n)| {
                            let (at_corner, away) = (p.y * side > 0.5 * half.y, Vec3::new(*end, 0.0, 0.0));
                            p.x * end > 0.8 * half.x && at_corner && n.dot(away) > 0.3 && is_open(mesh, *p, away)
                        });
                        assert!(seen.count() > 0, "{} at level {level}: side {side}, end {end}", model.name);
                    }
                }
            }
        }
    }
}

#[test]
fn each_side_is_lit_alone_and_nothing_else_changes() {
    let model = VehicleModel::generate(ObjectClass::Car, 3).unwrap();
    for signals in [[true, false], [false, true], [true, true]] {
        let lit = model.palette_lit(LitLamps { signals, ..LitLamps::default() });
        let pairs = model.palette.materials().iter().zip(lit.materials());
        let changed: Vec<u8> = (0..).zip(pairs).filter(|(_, (a, b))| a != b).map(|(k, _)| k).collect();
        let sides = [slot::LEFT_SIGNAL, slot::RIGHT_SIGNAL].into_iter().zip(signals);
        assert_eq!(changed, sides.filter(|(_, is_lit)| *is_lit).map(|(slot, _)| slot).collect::<Vec<u8>>());
    }
}
