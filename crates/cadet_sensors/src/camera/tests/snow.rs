//! Snow lies on what stands, panes included, where they don't stand upright.

use super::{EYE_HEIGHT_M, INTRINSICS, SIZE, cuboid, gray, ground, picture};
use crate::weather::Weather;
use cadet_base::instance::Instance;
use cadet_base::material::Semantic;
use cadet_base::math::Vec3;

const PANE_X_M: f32 = 7.0;
const PANE_Z_M: f32 = 0.9;

/// Mean green of the picture about the middle of a pane over a black box, in snow.
fn green_of_pane(half: Vec3, sheds_snow: bool) -> f64 {
    let middle = Vec3::new(PANE_X_M, 0.0, PANE_Z_M);
    let mut glass = gray(Semantic::Car, 0.9);
    (glass.specular, glass.roughness, glass.transmission) = (0.04, 0.02, 0.8);
    let pane = Instance { sheds_snow, ..cuboid(middle - half, middle + half, glass, 1) };
    // Behind and below the pane.
    let box_min = Vec3::new(PANE_X_M - 1.2, -1.5, 0.05);
    let below = cuboid(box_min, Vec3::new(PANE_X_M + 1.5, 1.5, PANE_Z_M - half.z - 0.02), gray(Semantic::Car, 0.02), 1);
    let behind = Vec3::new(PANE_X_M + 1.5, -1.5, 0.05);
    let behind = cuboid(behind, behind + Vec3::new(0.1, 3.0, 2.0), gray(Semantic::Car, 0.02), 1);
    let hidden_from_snow = |instance: Instance| Instance { sheds_snow: true, ..instance };
    let instances = [ground(), pane, hidden_from_snow(below), hidden_from_snow(behind)];
    let image = picture(&instances, &Weather::preset("snow").unwrap(), 5).image;
    let row = INTRINSICS[3] + INTRINSICS[1] * (EYE_HEIGHT_M - f64::from(PANE_Z_M)) / f64::from(PANE_X_M);
    let (row, column) = (row as usize, INTRINSICS[2] as usize);
    let near = (row - 1..=row + 1).flat_map(|r| (column - 8..column + 8).map(move |c| (r * SIZE.0 + c) * 3 + 1));
    near.map(|i| f64::from(image[i])).sum::<f64>() / 48.0
}

#[test]
fn a_pane_that_lies_is_white_on_what_stands_and_clear_on_what_drives() {
    let lying = Vec3::new(1.0, 1.0, 0.01);
    let [standing, driving] = [false, true].map(|sheds_snow| green_of_pane(lying, sheds_snow));
    assert!(standing > 2.0 * driving, "{standing} {driving}");
}

#[test]
fn no_snow_lies_on_an_upright_pane() {
    let upright = Vec3::new(0.01, 1.0, 0.3);
    let [standing, driving] = [false, true].map(|sheds_snow| green_of_pane(upright, sheds_snow));
    assert!((standing / driving - 1.0).abs() < 0.02, "{standing} {driving}");
}
