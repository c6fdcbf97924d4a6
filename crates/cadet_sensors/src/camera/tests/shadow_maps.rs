//! Shadow maps: where shadows fall, how soft their edges are, and what is not drawn.

use super::{EYE_HEIGHT_M, clear_sun_from, cuboid, gray, ground, instance, street};
use crate::camera::light::{PcfTexels, ShadowMaps, ShadowQuery, Sky};
use crate::camera::surfaces::Flags;
use crate::sense::PosedScene;
use cadet_base::frames::facing;
use cadet_base::geometry::MeshBuilder;
use cadet_base::material::{Material, Pattern, Semantic};
use cadet_base::math::{DPose3, DVec3, Vec3};
use cadet_base::rng::Stream;

#[test]
fn a_plates_shadow_falls_where_the_sun_ray_says() {
    let plate = cuboid(Vec3::new(8.0, -2.0, 3.0), Vec3::new(12.0, 2.0, 3.1), gray(Semantic::Fence, 0.5), 0);
    let scene = PosedScene::new(&[ground(), plate], DVec3::ZERO);
    for azimuth in [0.0, 75.0, 200.0, 310.0] {
        let sky = Sky::new(&clear_sun_from(azimuth));
        let s = sky.sun_world;
        let shadows = ShadowMaps::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, s, None, Vec::new());
        let (mut dark, mut bright) = (0, 0);
        for i in 0..120 {
            for j in 0..120 {
                let p = Vec3::new(i as f32 * 0.15 + 1.0, j as f32 * 0.15 - 9.0, 0.0);
                let meets = |z: f32| p + s * (z / s.z);
                let outside = |q: Vec3| (q.x - 10.0).abs().max(q.y.abs()) - 2.0;
                let (low, high) = (outside(meets(3.0)), outside(meets(3.1)));
                let lit = sunlit_ground(&shadows, p, s);
                if low.max(high) < -0.09 {
                    assert_eq!(lit, 0.0, "{azimuth}: {p}");
                    dark += 1;
                } else if low.min(high) > 0.09 {
                    assert_eq!(lit, 1.0, "{azimuth}: {p}");
                    bright += 1;
                }
            }
        }
        assert!(dark > 400 && bright > 5000, "{dark} {bright}");
    }
}

#[test]
fn surfaces_that_face_the_sun_do_not_shade_themselves() {
    let mut tilted = cuboid(Vec3::new(6.0, -2.0, 1.0), Vec3::new(10.0, 2.0, 2.0), gray(Semantic::Fence, 0.5), 0);
    tilted.world_from_local = facing(DVec3::new(12.0, 0.0, 2.0), DVec3::new(1.0, 0.4, 0.3), DVec3::Z);
    let scene = PosedScene::new(&[ground(), tilted], DVec3::ZERO);
    for (azimuth, elevation) in [(20.0, 12.0_f64), (130.0, 25.0), (250.0, 45.0)] {
        let mut weather = clear_sun_from(azimuth);
        weather.sun_elevation_rad = elevation.to_radians();
        let s = Sky::new(&weather).sun_world;
        let shadows = ShadowMaps::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, s, None, Vec::new());
        for face in scene.instances[1].mesh.face_numbers() {
            let [a, b, c] = scene.corners(1, face);
            let normal = (b - a).cross(c - a).normalize();
            if normal.dot(s) < 0.08 {
                continue;
            }
            for k in 1..200 {
                let (u, v) = (0.05 + 0.85 * (k as f32 * 0.618).fract(), 0.05 + 0.85 * (k as f32 * 0.377).fract());
                if u + v < 0.92 {
                    let lit = sunlit(&shadows, a + (b - a) * u + (c - a) * v, normal, normal.dot(s));
                    assert_eq!(lit, 1.0, "face {face} at {u} {v} under {azimuth} {elevation}");
                }
            }
        }
    }
}

/// The sun that reaches one point of something that stands.
pub(super) fn sunlit(shadows: &ShadowMaps, point_world: Vec3, normal: Vec3, cos_sun: f32) -> f32 {
    sunlit_as(0, shadows, point_world, normal, cos_sun)
}

/// The sun that reaches one point of level ground.
pub(super) fn sunlit_ground(shadows: &ShadowMaps, point_world: Vec3, sun_world: Vec3) -> f32 {
    sunlit_as(Flags::GROUND, shadows, point_world, Vec3::Z, sun_world.z)
}

fn sunlit_as(flags: u32, shadows: &ShadowMaps, point_world: Vec3, normal: Vec3, cos_sun: f32) -> f32 {
    let eye = Vec3::new(1.0, -2.0, 1.65);
    let mut lit = [f32::NAN; 16];
    let query = ShadowQuery {
        points: &(point_world - eye).to_array().map(|v| [v; 16]),
        normals: &normal.to_array().map(|v| [v; 16]),
        flags: &[flags; 16],
        cos_sun: &[cos_sun; 16],
        is_queried: &std::array::from_fn(|i| i != 3),
        count: 15,
    };
    shadows.shadow_factors(eye, &query, &mut PcfTexels::default(), &mut lit);
    assert!(lit[3] == 0.0 && lit[15].is_nan());
    assert!(lit[..15].iter().enumerate().all(|(i, l)| i == 3 || *l == lit[0]));
    lit[0]
}

#[test]
fn a_shadows_edge_is_as_soft_as_three_texels_and_rises_steadily() {
    let plate = cuboid(Vec3::new(8.0, -20.0, 3.0), Vec3::new(12.0, 20.0, 3.1), gray(Semantic::Fence, 0.5), 0);
    let scene = PosedScene::new(&[ground(), plate], DVec3::ZERO);
    // The sun stands in the plane y = 0, so that light falls square to the plate's edge.
    let s = Sky::new(&clear_sun_from(180.0)).sun_world;
    let shadows = ShadowMaps::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, s, None, Vec::new());
    // Meters of level ground for a texel of the near map.
    let step = 40.0 / 1536.0 / s.z;
    let edge = 12.0 - s.x * 3.0 / s.z;
    let at = |texels: f32| sunlit_ground(&shadows, Vec3::new(edge + texels * step, 0.3, 0.0), s);
    let profile: Vec<f32> = (-40..=40).map(|i| at(i as f32 * 0.125)).collect();
    assert!(profile[0] == 0.0 && profile[80] == 1.0);
    assert!(profile.windows(2).all(|p| p[1] >= p[0] && p[1] - p[0] < 0.06), "{profile:?}");
    let width = profile.iter().filter(|lit| (0.01..0.99).contains(*lit)).count() as f32 * 0.125;
    assert!((2.7..3.2).contains(&width), "{width}");
    // What no map shows is lit.
    assert_eq!(sunlit_ground(&shadows, Vec3::new(400.0, 0.0, 0.0), s), 1.0);
}

/// The mean of what the sun's light leaves of level points about (x, y), up to `half` meters beside it.
fn mean_sunlit(shadows: &ShadowMaps, s: Vec3, (x, y): (f32, f32), half: f32, per_side: i32) -> f32 {
    let at = |i: i32| (2.0 * (i as f32 + 0.5) / per_side as f32 - 1.0) * half;
    let points = (0..per_side * per_side).map(|k| Vec3::new(x + at(k / per_side), y + at(k % per_side), 0.0));
    points.map(|p| sunlit_ground(shadows, p, s)).sum::<f32>() / (per_side * per_side) as f32
}

#[test]
fn a_plates_shadow_has_the_plates_area_in_both_maps() {
    let s = Sky::new(&clear_sun_from(40.0)).sun_world;
    for x in [10.0, 70.0] {
        // Long triangles, cut by rows, and short ones of a frame of little squares.
        let mut b = MeshBuilder::new();
        let (y0, z) = (-3.0, 5.0);
        let p = |x: f32, y: f32| Vec3::new(x, y, z);
        b.quad(p(x - 3.0, y0), p(x + 3.0, y0), p(x + 3.0, 1.0), p(x - 3.0, 1.0), 0);
        for i in 0..30 {
            let from = x - 3.0 + 0.2 * i as f32;
            b.quad(p(from, 1.0), p(from + 0.2, 1.0), p(from + 0.2, 2.0), p(from, 2.0), 0);
        }
        let plate = instance(b.build("plate", 0.5), gray(Semantic::Fence, 0.5), DPose3::IDENTITY, 0);
        let scene = PosedScene::new(&[ground(), plate], DVec3::ZERO);
        let shadows = ShadowMaps::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, s, None, Vec::new());
        let middle = (x - s.x * z / s.z, -0.5 - s.y * z / s.z);
        let area = (1.0 - mean_sunlit(&shadows, s, middle, 4.0, 160)) * 64.0;
        assert!((area / 30.0 - 1.0).abs() < 0.015, "{x}: {area}");
    }
}

#[test]
fn crowns_cover_in_the_far_map_what_all_of_their_leaves_cover() {
    let s = Sky::new(&clear_sun_from(40.0)).sun_world;
    // Far apart, so that the area they cover is theirs: leaves a fifth of a meter long, turned to all sides.
    let leaves_at = |x: f32, pattern: Pattern| {
        let mut stream = Stream::from_seed("leaves", 4);
        let mut number = move || stream.range(-1.0, 1.0) as f32;
        let mut b = MeshBuilder::new();
        for k in 0..900 {
            let middle = Vec3::new(x + (k % 30) as f32 * 0.6 - 9.0, (k / 30) as f32 * 0.6 - 9.0, 8.0 + number() * 0.2);
            let mut corner = || middle + Vec3::new(number(), number(), number()) * 0.25;
            b.triangle(corner(), corner(), corner(), 0);
        }
        let material = Material::matt(Semantic::Vegetation, [0.1; 3], pattern, 0.3);
        let crown = instance(b.build("crown", 0.5), material, DPose3::IDENTITY, 0);
        let scene = PosedScene::new(&[ground(), crown], DVec3::ZERO);
        let shadows = ShadowMaps::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, s, None, Vec::new());
        let middle = (x - s.x * 8.0 / s.z, -s.y * 8.0 / s.z);
        1.0 - mean_sunlit(&shadows, s, middle, 11.0, 200)
    };
    let (some, all) = (leaves_at(75.0, Pattern::Leaves), leaves_at(75.0, Pattern::Wood));
    assert!(all > 0.02 && all < 0.2 && (some / all - 1.0).abs() < 0.1, "{some} {all}");
    assert!(some != all);
    // Near the camera every leaf casts its own shadow.
    assert_eq!(leaves_at(8.0, Pattern::Leaves), leaves_at(8.0, Pattern::Wood));
}

#[test]
fn what_lies_below_all_that_is_seen_is_not_drawn_and_the_rest_shades_as_before() {
    let plate =
        |x: f32, z: f32| cuboid(Vec3::new(x, -3.0, z), Vec3::new(x + 4.0, 3.0, z + 0.1), gray(Semantic::Fence, 0.5), 0);
    let s = Sky::new(&clear_sun_from(40.0)).sun_world;
    let eye = DVec3::new(0.0, 0.0, 8.0);
    // Near and far: a roof, a smaller one over it, and one far under it, over what nobody sees.
    for (x, low_z) in [(10.0, -3.0), (60.0, -9.0)] {
        let over = Vec3::new(x + 2.0, 0.0, 5.1) + s * (2.0 / s.z);
        let (low, high) = (over - Vec3::new(1.0, 1.0, 0.0), over + Vec3::new(1.0, 1.0, 0.1));
        let upper = cuboid(low, high, gray(Semantic::Fence, 0.5), 0);
        let scene = PosedScene::new(&[ground(), plate(x, 5.0), plate(x, low_z), upper], eye);
        let grid =
            |z: f32| (0..6400).map(move |i| Vec3::new(x + (i % 80) as f32 * 0.05, (i / 80) as f32 * 0.075 - 3.0, z));
        let (roof, unseen): (Vec<Vec3>, Vec<Vec3>) =
            (grid(5.1).collect(), grid(low_z).map(|p| p - s * (2.0 / s.z)).collect());
        let of = |seen: Option<&[Vec3]>| ShadowMaps::new(&scene, eye, DVec3::X, s, seen, Vec::new());
        let (all, some) = (of(None), of(Some(&roof)));
        let lit = |shadows: &ShadowMaps, points: &[Vec3]| -> Vec<f32> {
            points.iter().map(|p| sunlit(shadows, *p, Vec3::Z, s.z)).collect()
        };
        assert_eq!(lit(&all, &roof), lit(&some, &roof));
        assert!(lit(&some, &roof).iter().filter(|lit| **lit == 0.0).count() > 500);
        // Were it asked all the same, it would not know of the lower roof.
        let dark = |shadows: &ShadowMaps| lit(shadows, &unseen).iter().filter(|lit| **lit == 0.0).count();
        assert!(dark(&all) > 5000 && dark(&some) == 0, "{} {}", dark(&all), dark(&some));
    }
}

#[test]
fn maps_do_not_remember_an_earlier_frame() {
    let s = Sky::new(&clear_sun_from(40.0)).sun_world;
    let eye = DVec3::new(0.0, 0.0, EYE_HEIGHT_M);
    let seen: Vec<Vec3> = (0..60).map(|i| Vec3::new(i as f32, (i % 7) as f32 - 3.0, 0.0)).collect();
    let of =
        |scene: &PosedScene, seen: Option<&[Vec3]>, buffers| ShadowMaps::new(scene, eye, DVec3::X, s, seen, buffers);
    let first = PosedScene::new(&street(), eye);
    let second = PosedScene::new(&[ground()], eye);
    for seen in [None, Some(&seen[..])] {
        let used = of(&first, seen, Vec::new()).into_buffers();
        assert!(used == of(&second, None, Vec::new()).into_buffers());
        let again = of(&second, None, used);
        assert_eq!(mean_sunlit(&again, s, (20.0, 0.0), 40.0, 120), 1.0);
    }
}
