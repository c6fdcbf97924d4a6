//! Lit lamps shine whatever light falls on them, and nothing else changes with them.

use super::{clear_sun_from, gray, ground, picture, view};
use crate::camera::{render, visibility_pass};
use crate::sense::PosedScene;
use crate::weather::Weather;
use cadet_assets::scenery::{HeadKind, SignalPost, signal_head, signal_post};
use cadet_base::frames::upright;
use cadet_base::instance::Instance;
use cadet_base::material::Semantic;
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

const AT_M: f64 = 6.0;
/// Middles of the lenses of a head whose bottom is at this height: green, yellow, red.
const HEAD_M: f64 = 1.2;
const LENSES_M: [f64; 3] = [0.15, 0.45, 0.75];

/// A head for vehicles before a wall, which looks at the camera.
fn light(lit: [bool; 3]) -> Vec<Instance> {
    let (shape, palette) = signal_head(HeadKind::Vehicle, lit);
    let world_from_local = upright(DVec3::new(AT_M, 0.0, HEAD_M), std::f64::consts::PI);
    let wall = super::cuboid(Vec3::new(12.0, -9.0, 0.0), Vec3::new(13.0, 9.0, 5.0), gray(Semantic::Building, 0.4), 0);
    let post = signal_post(SignalPost::Post).at(upright(DVec3::new(AT_M + 0.1, 0.0, 0.0), std::f64::consts::PI));
    vec![ground(), wall, post, Instance::new(shape, palette, world_from_local, 0)]
}

/// Red, green, and blue at the middle of a lens.
fn lens(image: &[u8], which: usize) -> [u8; 3] {
    let [_, fy, cx, cy] = view().intrinsics_px;
    let depth = AT_M - 0.14;
    let row = cy + fy * (view().world_from_cam.translation.z - HEAD_M - LENSES_M[which]) / depth;
    let at = 3 * (row.round() as usize * view().width + cx.round() as usize);
    [image[at], image[at + 1], image[at + 2]]
}

#[test]
fn a_lit_lens_is_brighter_than_its_neighbors_and_of_its_color_in_sun_and_shade() {
    // The sun is behind the wall, or behind the camera.
    for azimuth_deg in [0.0, 180.0] {
        let weather = clear_sun_from(azimuth_deg);
        let red = picture(&light([true, false, false]), &weather, 1).image;
        let green = picture(&light([false, false, true]), &weather, 1).image;
        let yellow = picture(&light([false, true, false]), &weather, 1).image;
        let [r, g, _] = lens(&red, 2);
        assert!(r > 200 && r > 2 * g, "red is {:?}", lens(&red, 2));
        assert!(u16::from(r) > 2 * u16::from(lens(&green, 2)[0]), "red unlit is {:?}", lens(&green, 2));
        let [r, g, b] = lens(&green, 0);
        assert!(g > 180 && g >= b && u16::from(g) > 2 * u16::from(r), "green is {:?}", lens(&green, 0));
        let [r, g, b] = lens(&yellow, 1);
        assert!(r > 180 && g > 70 && u16::from(g) > 2 * u16::from(b), "yellow is {:?}", lens(&yellow, 1));
    }
}

#[test]
fn a_change_of_phase_changes_the_lenses_and_nothing_else() {
    let weather = Weather::preset("cloudy_noon").unwrap();
    let rendered = |lit: [bool; 3]| {
        let posed = PosedScene::new(&light(lit), DVec3::new(0.0, 0.0, super::EYE_HEIGHT_M));
        let seen = visibility_pass(&posed, &view()).unwrap();
        render(&posed, &view(), &weather, &seen, &mut Stream::from_seed("camera", 1))
    };
    let (red, green) = (rendered([true, false, false]), rendered([false, false, true]));
    let (width, [fx, fy, cx, cy]) = (view().width, view().intrinsics_px);
    let mut changed = 0;
    for (i, (a, b)) in red.chunks(3).zip(green.chunks(3)).enumerate() {
        let (row, column) = ((i / width) as f64, (i % width) as f64);
        let (y_m, z_m) = ((column - cx) / fx * AT_M, super::EYE_HEIGHT_M - (row - cy) / fy * AT_M - HEAD_M);
        let is_head = y_m.abs() < 0.35 && (-0.25..1.2).contains(&z_m);
        let difference = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        changed += usize::from(difference > 60);
        // Glare and exposure reach everywhere, a little.
        assert!(is_head || difference < 12, "{difference} at row {row}, column {column}");
    }
    assert!(changed > 20, "{changed} pixels");
}
