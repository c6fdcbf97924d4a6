//! Sky visibility beside a long wall, under a roof, and beyond what is known.

use super::{EYE_HEIGHT_M, cuboid, gray, ground};
use crate::camera::light::{SkyProbes, SkyVisibility};
use crate::sense::PosedScene;
use cadet_base::instance::Instance;
use cadet_base::material::Semantic;
use cadet_base::math::{DVec3, Vec3};

fn open(more: Option<Instance>, point: Vec3, normal: Vec3) -> SkyVisibility {
    let instances: Vec<Instance> = std::iter::once(ground()).chain(more).collect();
    let scene = PosedScene::new(&instances, DVec3::ZERO);
    let probes = SkyProbes::new(&scene, DVec3::new(0.0, 0.0, EYE_HEIGHT_M), DVec3::X, &[point]);
    probes.sky_visibility(point, normal)
}

fn block(min: Vec3, max: Vec3) -> Option<Instance> {
    Some(cuboid(min, max, gray(Semantic::Building, 0.5), 0))
}

#[test]
fn open_ground_sees_all_of_the_sky_and_nothing_is_known_beyond_the_map() {
    for side in open(None, Vec3::new(30.3, -7.8, 0.0), Vec3::Z) {
        assert!((side - 1.0).abs() < 1e-5, "{side}");
    }
    assert_eq!(open(None, Vec3::new(500.0, 0.0, 0.0), Vec3::Z), [0.85; 6]);
}

#[test]
fn a_long_wall_hides_what_is_below_its_horizon() {
    let (height, wall_x) = (8.0_f32, 40.0);
    for (x, z) in [(24.5, 0.3), (30.5, 0.3), (34.5, 1.6), (34.5, 4.0), (36.5, 0.3)] {
        let wall = || block(Vec3::new(wall_x, -65.0, 0.0), Vec3::new(wall_x + 6.0, 65.0, height));
        let [east, west, north, south, up, down] = open(wall(), Vec3::new(x, 0.5, z), Vec3::Z);
        // Towards an azimuth the horizon's tangent is height / distance times its cosine: the mean of 1 / (1 + tangent^2) over
        // the half circle that looks at the wall is 1 / sqrt(1 + (height / distance)^2).
        let tangent = (height - z) / (wall_x - x);
        let mean = 0.5 + 0.5 / (1.0 + tangent * tangent).sqrt();
        assert!((up - mean).abs() < 0.06, "{x} {z}: {up} {mean}");
        assert!((down - (0.4 + 0.6 * up)).abs() < 1e-5, "{x} {z}: {down} {up}");
        assert!((west - 1.0).abs() < 1e-5 && (north - south).abs() < 1e-5, "{x} {z}: {west} {north} {south}");
        assert!(
            1.0 / (1.0 + tangent * tangent) < east + 0.06 && east < north && north < west,
            "{x} {z}: {east} {north}"
        );
    }
    // Over its top.
    let wall = block(Vec3::new(wall_x, -65.0, 0.0), Vec3::new(wall_x + 6.0, 65.0, height));
    assert!(open(wall, Vec3::new(34.5, 0.5, 9.0), Vec3::Z).iter().all(|side| (side - 1.0).abs() < 1e-5));
}

#[test]
fn a_wall_is_not_hidden_by_its_own_house_and_a_wide_roof_hides_nearly_all() {
    let house = || block(Vec3::new(40.0, -65.0, 0.0), Vec3::new(46.0, 65.0, 8.0));
    // On the wall itself: as far off as surfaces are looked at from, and not from within.
    let on_wall = open(house(), Vec3::new(40.0, 0.5, 4.0), -Vec3::X);
    assert!(on_wall[1] > 0.99 && on_wall[0] < 0.6, "{on_wall:?}");
    let roof = block(Vec3::new(20.0, -20.0, 5.0), Vec3::new(60.0, 20.0, 5.2));
    let under = open(roof, Vec3::new(40.5, 0.5, 0.0), Vec3::Z);
    assert!(under[..5].iter().all(|side| *side < 0.06), "{under:?}");
}

#[test]
fn what_is_known_fades_into_what_is_not_at_the_maps_border() {
    let far: Vec<f32> = (0..800).map(|k| open(None, Vec3::new(90.0 + 0.05 * k as f32, 0.5, 0.0), Vec3::Z)[4]).collect();
    assert!((far[0] - 1.0).abs() < 1e-5 && far[799] == 0.85, "{} {}", far[0], far[799]);
    assert!(far.windows(2).all(|pair| (-1e-3..=1e-6).contains(&(pair[1] - pair[0]))));
}
