//! A wet road mirrors the sky as rough ground does, not as a pond.

use super::{INTRINSICS, SIZE, cuboid, gray, ground, picture};
use crate::weather::Weather;
use cadet_base::instance::Instance;
use cadet_base::material::Semantic;
use cadet_base::math::Vec3;

/// A street of rows of houses.
fn canyon() -> Vec<Instance> {
    let house =
        |y: f32| cuboid(Vec3::new(-10.0, y, 0.0), Vec3::new(90.0, y + 8.0, 8.0), gray(Semantic::Building, 0.4), 0);
    vec![ground(), house(7.0), house(-15.0)]
}

#[test]
fn no_part_of_a_wet_road_is_a_bright_blob() {
    let horizon = INTRINSICS[3] as usize;
    for name in ["soft_rain_noon", "mid_rain_noon", "hard_rain_noon"] {
        let image = picture(&canyon(), &Weather::preset(name).unwrap(), 3).image;
        // Means of squares of the road before the camera, from 4 m to 12 m.
        let side = 8;
        let mean = |row: usize, column: usize| {
            let values = (row..row + side).flat_map(|r| (column..column + side).map(move |c| (r * SIZE.0 + c) * 3 + 1));
            values.map(|i| f64::from(image[i])).sum::<f64>() / (side * side) as f64
        };
        let rows = (horizon + 30..SIZE.1 - side).step_by(4);
        let mut means: Vec<f64> =
            rows.flat_map(|row| (40..280).step_by(side).map(move |c| (row, c))).map(|(r, c)| mean(r, c)).collect();
        means.sort_unstable_by(f64::total_cmp);
        let [median, most] = [means[means.len() / 2], means[means.len() - 1]];
        assert!(most < 1.6 * median, "{name}: {most} where half of the road is below {median}");
    }
}
