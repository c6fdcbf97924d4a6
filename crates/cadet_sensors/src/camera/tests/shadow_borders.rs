//! Where shadows begin and end, near and far, and how they end with the maps.

use super::shadow_maps::{sunlit, sunlit_ground};
use super::{EYE_HEIGHT_M, clear_sun_from, cuboid, gray, ground};
use crate::camera::light::{ShadowMaps, Sky};
use crate::sense::PosedScene;
use cadet_base::material::Semantic;
use cadet_base::math::{self, DVec3, Vec3};

/// Shadows of a box and the direction to a sun that stands `azimuth_deg` from x, before an eye that looks along x.
fn shadows_of_box(min: Vec3, max: Vec3, azimuth_deg: f64, elevation_deg: f64) -> (ShadowMaps, Vec3) {
    let mut weather = clear_sun_from(azimuth_deg);
    weather.sun_elevation_rad = elevation_deg.to_radians();
    let s = Sky::new(&weather).sun_world;
    let scene = PosedScene::new(&[ground(), cuboid(min, max, gray(Semantic::Fence, 0.5), 0)], DVec3::ZERO);
    (ShadowMaps::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, s, None, Vec::new()), s)
}

/// Where light turns to shade along a line of points, linear between those a centimeter apart.
fn crossing(lit: impl Fn(f32) -> f32, from: f32, to: f32) -> f32 {
    let steps = ((to - from) * 100.0) as i32;
    let at = |i: i32| from + 0.01 * i as f32;
    let i = (0..steps).find(|i| (lit(at(*i)) < 0.5) != (lit(at(i + 1)) < 0.5)).expect("light and shade");
    at(i) + 0.01 * (lit(at(i)) - 0.5) / (lit(at(i)) - lit(at(i + 1)))
}

#[test]
fn a_boxs_shadow_begins_at_its_foot_and_ends_where_its_edge_casts_it() {
    // A low box and a high one; near, far, and where the maps meet.
    for (x, height) in [10.0, 28.0, 33.5, 60.0, 90.0].into_iter().flat_map(|x| [(x, 0.12_f32), (x, 1.5)]) {
        for elevation in [15.0_f64, 30.0, 55.0] {
            // The sun stands to the left: the shadow falls along -y from the box's side at y = 0.
            let (low, high) = (Vec3::new(x - 2.0, 0.0, 0.0), Vec3::new(x + 2.0, 1.0, height));
            let (shadows, s) = shadows_of_box(low, high, 90.0, elevation);
            let lit = |y: f32| sunlit_ground(&shadows, Vec3::new(x, y, 0.0), s);
            let length = height / math::tan(elevation.to_radians()) as f32;
            // Half a texel of the map, on the ground: what the far one's size permits.
            let texel_m = if x < 33.0 { 40.0 } else { 136.0 } / 1536.0;
            let half = 0.5 * texel_m / s.z;
            let end = -crossing(|along| lit(-along), 0.03, 9.0);
            assert!((end + length).abs() < half + 0.01, "{x} {height} {elevation}: {end} {length}");
            // From its foot on it is dark, and the ground before the sunlit side is not.
            if length > 4.0 * texel_m / s.z {
                assert_eq!(lit(-0.02), 0.0, "{x} {height} {elevation}");
            }
            assert!(lit(1.1) > 0.85, "{x} {height} {elevation}: {}", lit(1.1));
            assert_eq!(lit(1.0 + 4.0 * texel_m), 1.0, "{x} {height} {elevation}");
        }
    }
}

#[test]
fn a_shadow_across_the_maps_borders_has_no_step() {
    // A wall on the left shades a road as far as both maps and beyond.
    let (low, high) = (Vec3::new(-20.0, 4.0, 0.0), Vec3::new(190.0, 5.0, 9.0));
    let (shadows, s) = shadows_of_box(low, high, 90.0, 35.0);
    let road: Vec<f32> = (0..1700).map(|i| sunlit_ground(&shadows, Vec3::new(i as f32 * 0.1, 0.0, 0.0), s)).collect();
    assert!(road[..1160].iter().all(|lit| *lit == 0.0), "no light between the maps");
    assert!(road.windows(2).all(|lit| lit[1] >= lit[0] && lit[1] - lit[0] < 0.02), "{road:?}");
    assert_eq!(road[1699], 1.0);
    // So does the sunlit side of the road, and a wall that faces the sun.
    for i in 0..1700 {
        let x = i as f32 * 0.1;
        assert_eq!(sunlit_ground(&shadows, Vec3::new(x, 14.0, 0.0), s), 1.0);
        assert_eq!(sunlit(&shadows, Vec3::new(x, 5.0, 1.5), Vec3::Y, s.y), 1.0);
    }
}

#[test]
fn edges_of_shadows_run_on_from_map_to_map() {
    // The edge of a long shadow, which lies beside the road, 3.2 m from the wall.
    let (low, high) = (Vec3::new(-20.0, 0.0, 0.0), Vec3::new(90.0, 0.4, 2.0));
    let (shadows, s) = shadows_of_box(low, high, 90.0, 32.0);
    let edge = |x: f32| crossing(|along| sunlit_ground(&shadows, Vec3::new(x, -along, 0.0), s), 1.0, 6.0);
    let edges: Vec<f32> = (20..80).map(|x| edge(x as f32)).collect();
    let expected = 2.0 / math::tan(32.0_f64.to_radians()) as f32;
    assert!(edges.iter().all(|edge| (edge - expected).abs() < 0.09), "{expected} {edges:?}");
}

#[test]
fn kerbs_do_not_darken_the_sidewalks_behind_them() {
    for x in [10.0_f32, 70.0] {
        // The face of a kerb toward the sun; the sidewalk lies behind it.
        let (low, high) = (Vec3::new(x - 5.0, -6.0, 0.0), Vec3::new(x + 5.0, 0.0, 0.12));
        for elevation in [12.0, 30.0, 60.0] {
            let (shadows, s) = shadows_of_box(low, high, 90.0, elevation);
            for i in 1..60 {
                let lit = sunlit_ground(&shadows, Vec3::new(x, -0.01 * i as f32, 0.12), s);
                assert_eq!(lit, 1.0, "{x} {elevation}: {i} cm behind");
            }
        }
    }
}
