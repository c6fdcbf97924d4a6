//! What the air adds before a surface is there whatever the surface is.

use super::{EYE_HEIGHT_M, INTRINSICS, SIZE, cuboid, gray, ground, picture};
use crate::camera::light::{Light, Sky, SkyProbes};
use crate::sense::PosedScene;
use crate::weather::Weather;
use cadet_base::instance::Instance;
use cadet_base::material::{Material, Semantic};
use cadet_base::math::{DVec3, Vec3};

const AT_M: f32 = 60.0;

/// A black wall, its right half behind glass.
fn wall(transmission: f32) -> Vec<Instance> {
    let black = gray(Semantic::Building, 0.0);
    let glass = Material { specular: 0.04, roughness: 0.02, transmission, ..gray(Semantic::Building, 0.9) };
    vec![
        ground(),
        cuboid(Vec3::new(AT_M, -20.0, 0.0), Vec3::new(AT_M + 1.0, 20.0, 20.0), black, 0),
        cuboid(Vec3::new(AT_M - 0.2, -20.0, 0.0), Vec3::new(AT_M - 0.1, 0.0, 20.0), glass, 0),
    ]
}

/// Mean levels of a square of the wall left and right of its middle.
fn halves(image: &[u8]) -> [f64; 2] {
    let middle = INTRINSICS[2] as usize;
    [middle - 40..middle - 10, middle + 10..middle + 40].map(|columns| {
        let places = (15..35).flat_map(|row| columns.clone().map(move |column| 3 * (row * SIZE.0 + column)));
        let levels: Vec<f64> = places.flat_map(|at| image[at..at + 3].iter().map(|l| f64::from(*l))).collect();
        levels.iter().sum::<f64>() / levels.len() as f64
    })
}

#[test]
fn far_glass_in_dense_fog_is_as_bright_as_a_black_wall_beside_it() {
    let weather = Weather::preset("dense_fog").unwrap();
    for transmission in [0.05, 0.4, 0.95] {
        let [bare, behind_glass] = halves(&picture(&wall(transmission), &weather, 3).image);
        assert!(bare > 40.0, "{bare}");
        assert!((behind_glass / bare - 1.0).abs() < 0.04, "{transmission}: {behind_glass} beside {bare}");
    }
}

#[test]
fn in_clear_air_glass_reflects_the_sky_before_a_black_wall() {
    let [bare, behind_glass] = halves(&picture(&wall(0.4), &Weather::preset("cloudy_noon").unwrap(), 3).image);
    assert!(behind_glass > 1.15 * bare, "{behind_glass} beside {bare}");
}

/// Mean R, G, B of some rows of the picture's middle.
fn colors(image: &[u8], rows: std::ops::Range<usize>) -> [f64; 3] {
    let columns = INTRINSICS[2] as usize - 30..INTRINSICS[2] as usize + 30;
    let places: Vec<usize> = rows.flat_map(|row| columns.clone().map(move |c| 3 * (row * SIZE.0 + c))).collect();
    [0, 1, 2].map(|k| places.iter().map(|at| f64::from(image[at + k])).sum::<f64>() / places.len() as f64)
}

#[test]
fn fog_is_white_and_as_bright_at_the_horizon_as_above_it() {
    let image = picture(&[ground()], &Weather::preset("dense_fog").unwrap(), 2).image;
    let horizon = INTRINSICS[3] as usize;
    let [above, at, low] = [5..10, horizon - 2..horizon + 2, horizon + 3..horizon + 6].map(|rows| colors(&image, rows));
    for color in [above, at] {
        assert!((color[0] / color[1] - 1.0).abs() < 0.02 && (color[2] / color[1] - 1.0).abs() < 0.03, "{color:?}");
    }
    assert!((at[1] / above[1] - 1.0).abs() < 0.05, "{at:?} {above:?}");
    // The road far away is fog, and darker the nearer it is.
    let road: Vec<f64> = (horizon + 6..SIZE.1 - 4).step_by(8).map(|row| colors(&image, row..row + 4)[1]).collect();
    assert!(road.windows(2).all(|pair| pair[1] < pair[0]) && low[1] > 0.85 * at[1], "{road:?} {low:?}");
}

#[test]
fn black_things_far_away_have_what_sun_sky_and_ground_give_a_white_droplet() {
    let weather = Weather { fog_alpha_per_m: 0.06, ..Weather::preset("dense_fog").unwrap() };
    let sky = Sky::new(&weather);
    let scene = PosedScene::new(&[ground()], DVec3::new(0.0, 0.0, EYE_HEIGHT_M));
    let probes = SkyProbes::new(&scene, DVec3::Z, DVec3::X, &[]);
    let light = Light::new(&weather, (sky.clone(), None), None, probes);
    let seen = light.through_air(Vec3::ZERO, Vec3::X, 1000.0);
    // Overcast: no sun; half of the light comes from above and half from the ground.
    let expected = 0.5 * (sky.sky_on_level.y + sky.ground.y);
    assert!((seen.y / expected - 1.0).abs() < 0.03, "{seen} {expected}");
}
