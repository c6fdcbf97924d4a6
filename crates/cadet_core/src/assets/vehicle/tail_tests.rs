//! Tails have the shape of real ones.

use super::*;
use crate::math::Vec3;

/// Real bumpers stand out of the tailgate: of 20 cars seen from behind, by 7 to 9 cm.
#[test]
fn rear_bumpers_stand_out_of_the_tail() {
    let mut depths = Vec::new();
    for seed in 0..200 {
        let model = VehicleModel::generate(ObjectClass::Car, seed).unwrap();
        // At the finest level and at that for middle distances.
        for level in [0, 1] {
            let mesh = &model.body.levels[level].1;
            let is_body = |slot: u8| slot == slot::PAINT || slot == slot::PLASTIC;
            let painted = mesh.faces.iter().zip(&mesh.slots).filter(|(_, slot)| is_body(**slot));
            let places: Vec<Vec3> = painted.flat_map(|(f, _)| f.map(|i| mesh.vertices[i as usize])).collect();
            let rear = |from: f32, to: f32| {
                let near = places.iter().filter(|p| p.y.abs() < 0.25 && (from..to).contains(&p.z));
                near.map(|p| p.x).fold(f32::INFINITY, f32::min)
            };
            let (bumper, tailgate) = (rear(0.25, 0.60), rear(0.64, 0.90));
            depths.push(tailgate - bumper);
        }
    }
    depths.sort_by(f32::total_cmp);
    assert!(depths[depths.len() / 20] > 0.03, "{:?}", depths[depths.len() / 20]);
    assert!((0.06..0.10).contains(&depths[depths.len() / 2]), "{:?}", depths[depths.len() / 2]);
}
