//! Water and snow on surfaces of many materials: in what order of brightness, with what contours, and as LIDARs find them.

use super::{INTRINSICS, SIZE, cuboid, ground, instance, picture};
use crate::camera::surfaces::value_noise;
use crate::weather::Weather;
use cadet_base::geometry::MeshBuilder;
use cadet_base::material::{Material, Pattern, Semantic};
use cadet_base::math::{self, DPose3, Vec3};

/// Mean green of rows of the picture left and right of its middle, with a plate of each material over the road.
fn halves(materials: [Material; 2], weather: &Weather) -> [f64; 2] {
    let plate = |y: f32, material| cuboid(Vec3::new(4.0, y - 2.0, 0.0), Vec3::new(9.0, y + 2.0, 0.02), material, 0);
    let image = picture(&[ground(), plate(2.0, materials[0]), plate(-2.0, materials[1])], weather, 4).image;
    let (row, middle) = (INTRINSICS[3] as usize + 45, INTRINSICS[2] as usize);
    [middle - 60..middle - 8, middle + 8..middle + 60].map(|columns| {
        let places = (row..row + 8).flat_map(|r| columns.clone().map(move |c| (r * SIZE.0 + c) * 3 + 1));
        let values: Vec<f64> = places.map(|at| f64::from(image[at])).collect();
        values.iter().sum::<f64>() / values.len() as f64
    })
}

fn matt(semantic: Semantic, albedo: f32) -> Material {
    Material::matt(semantic, [albedo; 3], Pattern::Plain, 0.2)
}

#[test]
fn rain_darkens_paving_and_not_paint_on_metal() {
    let mut dry = Weather::preset("cloudy_noon").unwrap();
    dry.cloudiness = 1.0;
    let wet = Weather { wetness: 0.5, ..dry.clone() };
    let materials = [matt(Semantic::Fence, 0.2), matt(Semantic::Car, 0.2)];
    let [dry, wet] = [&dry, &wet].map(|weather| {
        let [stone, metal] = halves(materials, weather);
        stone / metal
    });
    assert!((dry - 1.0).abs() < 0.03, "{dry}");
    // Angstrom's share of 0.2: 0.98^2 0.567 / (1 - 0.2 0.433); half of it is wet.
    let expected = 0.5 * (1.0 + 0.98 * 0.98 * 0.567 / (1.0 - 0.2 * 0.433));
    assert!((wet / dry / expected - 1.0).abs() < 0.04, "{wet} {dry} {expected}");
}

#[test]
fn snow_lies_alike_on_road_and_marking_and_covers_what_the_weather_says() {
    let weather = Weather::preset("snow").unwrap();
    let kinds = [Semantic::Road, Semantic::RoadMarking, Semantic::Sidewalk, Semantic::Car];
    for kind in &kinds[1..] {
        let [road, other] = halves([matt(Semantic::Road, 0.1), matt(*kind, 0.1)], &weather);
        // Other drifts lie left and right: the same kind on both sides differs by them alone.
        let [left, right] = halves([matt(Semantic::Road, 0.1); 2], &weather);
        assert!((other / road / (right / left) - 1.0).abs() < 0.02, "{kind:?}: {other} {road}");
    }
    let cover = weather.snow_cover();
    let drift = |k: i32| f64::from(value_noise(k as f32 * 0.377, (k % 331) as f32 * 1.713, 0x5E0));
    let mean = (0..40_000).map(|k| (cover * (0.5 + drift(k))).min(1.0)).sum::<f64>() / 40_000.0;
    assert!((mean / cover - 1.0).abs() < 0.02, "{mean} {cover}");
}

#[test]
fn a_wet_vault_has_no_contour() {
    let mut b = MeshBuilder::new();
    let at = |k: i32, y: f32| {
        let angle = f64::from(k) * std::f64::consts::PI / 64.0;
        Vec3::new(9.0 - 3.0 * math::cos(angle) as f32, y, 3.0 * math::sin(angle) as f32)
    };
    for k in 0..64 {
        b.quad(at(k, -6.0), at(k, 6.0), at(k + 1, 6.0), at(k + 1, -6.0), 0);
    }
    let vault = instance(b.build("vault", 3.0), matt(Semantic::Building, 0.4), DPose3::IDENTITY, 0);
    let mut dry = Weather::preset("cloudy_noon").unwrap();
    dry.cloudiness = 1.0;
    let wet = Weather { wetness: 1.0, ..dry.clone() };
    let [dry, wet] = [&dry, &wet].map(|weather| picture(&[ground(), vault.clone()], weather, 6).image);
    let column = INTRINSICS[2] as usize;
    let mean = |image: &[u8], row: usize| {
        (column - 20..column + 20).map(|c| f64::from(image[(row * SIZE.0 + c) * 3 + 1])).sum::<f64>() / 40.0
    };
    let ratios: Vec<f64> = (0..SIZE.1).map(|row| mean(&wet, row) / mean(&dry, row)).collect();
    // Of the rows that show the vault.
    let (top, bottom) = (16, 96);
    let steps = ratios[top..bottom].windows(2).map(|pair| (pair[1] / pair[0] - 1.0).abs());
    let (most_step, most) = (steps.clone().fold(0.0, f64::max), ratios[top] / ratios[bottom - 1]);
    assert!(most_step < 0.03, "{most_step} {ratios:.2?}");
    assert!(most < 0.8, "{most} {ratios:.2?}");
}
