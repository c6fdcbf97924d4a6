//! Vehicles and people cast their shadows by their next coarser level: nobody may see that.

use std::sync::Arc;

use super::shadow_maps::sunlit;
use super::{EYE_HEIGHT_M, clear_sun_from, ground};
use crate::camera::light::{ShadowMaps, Sky};
use crate::sense::PosedScene;
use cadet_assets::person::PersonModel;
use cadet_assets::vehicle::VehicleModel;
use cadet_base::actor::ObjectClass;
use cadet_base::frames::upright;
use cadet_base::geometry::LodSet;
use cadet_base::instance::Instance;
use cadet_base::math::{DVec3, Vec3};

/// The light of the sun on some points in an instance's scene, with its own and with its shadow proxy.
fn lit_both_ways(instance: Instance, points: &[(Vec3, Vec3)]) -> Vec<[f32; 2]> {
    let s = Sky::new(&clear_sun_from(120.0)).sun_world;
    let own = Instance {
        shape: Arc::new(LodSet { coarse_shadow_proxies: 0, ..(*instance.shape).clone() }),
        ..instance.clone()
    };
    let shadows = [own, instance].map(|instance| {
        let scene = PosedScene::new(&[ground(), instance], DVec3::ZERO);
        ShadowMaps::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, s, None, Vec::new())
    });
    let at = |(point, normal): &(Vec3, Vec3)| {
        shadows.each_ref().map(|shadows| sunlit(shadows, *point, *normal, normal.dot(s)))
    };
    points.iter().map(at).collect()
}

/// Points of the ground, 5 cm apart, about a place at some distance ahead.
fn ground_about(x: f32, half_m: f32) -> Vec<(Vec3, Vec3)> {
    let steps = (half_m / 0.05) as i32;
    let line = move || (-steps..=steps).map(|i| i as f32 * 0.05);
    line().flat_map(|dx| line().map(move |y| (Vec3::new(x + dx, y, 0.0), Vec3::Z))).collect()
}

fn mean_difference(lit: &[[f32; 2]]) -> f32 {
    lit.iter().map(|[a, b]| (a - b).abs()).sum::<f32>() / lit.len() as f32
}

#[test]
fn a_coarse_shadow_lies_where_the_fine_one_does() {
    // In the near map, by the finest level's neighbor; in the far one, by that one's.
    for x in [7.0, 40.0] {
        // Of cars and of people, all seeds together: the shadow of one arm is a twentieth of a person's.
        let mut sums = [[0; 2]; 2];
        for seed in 0..6 {
            let car = VehicleModel::generate(ObjectClass::Car, seed).unwrap();
            let person = PersonModel::generate(seed);
            let pose = person.pose(0.3);
            let both = [(&*car.body, &car.palette, 3.5), (&pose, &person.palette, 1.5)];
            for ((shape, palette, half_m), sum) in both.into_iter().zip(&mut sums) {
                let (palette, shape_of) = (Arc::clone(palette), Arc::new(shape.clone()));
                let world_from_local = upright(DVec3::new(x, 0.0, 0.0), 0.7);
                let instance = Instance::new(shape_of, palette, world_from_local, 1);
                let lit = lit_both_ways(instance, &ground_about(x as f32, half_m));
                let shaded = lit.iter().filter(|[fine, _]| *fine < 0.5).count();
                let moved = lit.iter().filter(|[fine, coarse]| (*fine < 0.5) != (*coarse < 0.5)).count();
                assert!(shaded > 60, "seed {seed} at {x} m: {shaded} points in the shadow");
                assert!(moved * 16 < shaded, "seed {seed} at {x} m: {moved} of {shaded} points moved");
                *sum = [sum[0] + moved, sum[1] + shaded];
            }
        }
        for [moved, shaded] in sums {
            assert!(moved * 30 < shaded, "{x} m: {moved} of {shaded} points moved");
        }
    }
}

#[test]
fn a_vehicle_does_not_shade_itself_where_its_shadow_proxy_stands_out() {
    for seed in 0..6 {
        let car = VehicleModel::generate(ObjectClass::Car, seed).unwrap();
        for x in [7.0, 28.0] {
            let world_from_local = upright(DVec3::new(x, 0.0, 0.0), 0.7);
            let (shape, palette) = (Arc::clone(&car.body), Arc::clone(&car.palette));
            let instance = Instance::new(shape, palette, world_from_local, 1);
            let mesh = car.body.select(x as f32 - 3.0, 1.0).expect("near enough");
            let s = Sky::new(&clear_sun_from(120.0)).sun_world;
            // Painted faces that look to the sun, where the finest level is lit.
            let faces = mesh.triangles().filter(|(_, slot)| *slot == 0).map(|(corners, _)| {
                let corners = corners.map(|p| world_from_local.transform_point(p.as_dvec3()));
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
                (((corners[0] + corners[1] + corners[2]) / 3.0).as_vec3(), normal.as_vec3())
            });
            let points: Vec<(Vec3, Vec3)> = faces.filter(|(_, normal)| normal.dot(s) > 0.3).collect();
            let lit = lit_both_ways(instance, &points);
            assert!(points.len() > 100);
            assert!(mean_difference(&lit) < 0.03, "seed {seed} at {x} m: {}", mean_difference(&lit));
        }
    }
}
