//! What the air adds before a surface is there whatever the surface is.

use super::{INTRINSICS, SIZE, cuboid, gray, ground, picture};
use crate::weather::Weather;
use cadet_base::instance::Instance;
use cadet_base::material::{Material, Semantic};
use cadet_base::math::Vec3;

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
