//! Two pixels side by side are shaded at once: which ones these are may not show.

use super::{EYE_HEIGHT_M, SIZE, View, clear_sun_from, cuboid, gray, street, view, visibility_pass};
use crate::camera::render::{Scratch, radiance};
use crate::camera::sensor::ROWS_BEFORE;
use crate::sense::PosedScene;
use crate::weather::Weather;
use cadet_base::instance::Instance;
use cadet_base::material::{Material, Pattern, Semantic};
use cadet_base::math::{DVec3, Vec3};

/// Linear radiance, RGB, pixel by pixel.
fn radiance_of(instances: &[Instance], view: &View, weather: &Weather) -> Vec<[f32; 3]> {
    let posed = PosedScene::new(instances, DVec3::new(0.0, 0.0, EYE_HEIGHT_M));
    let seen = visibility_pass(&posed, view).unwrap();
    let mut scratch = Scratch::default();
    let _ = radiance(&posed, view, weather, &seen, &mut scratch);
    scratch.rgb.as_chunks::<3>().0[ROWS_BEFORE * view.width..][..view.width * view.height].to_vec()
}

/// The street before a brick wall, with cars, transparent surfaces and shadows.
fn scene() -> Vec<Instance> {
    let bricks = Material::matt(Semantic::Building, [0.4, 0.3, 0.25], Pattern::Bricks, 0.3);
    let mut scene = street();
    scene.push(cuboid(Vec3::new(15.0, -14.0, 0.0), Vec3::new(15.5, -2.0, 5.0), bricks, 0));
    scene.push(cuboid(Vec3::new(10.0, -9.0, 0.0), Vec3::new(10.06, -8.94, 4.0), gray(Semantic::Pole, 0.3), 0));
    scene
}

/// The view, moved by whole pixels, of another size.
fn moved(right: usize, down: usize, (width, height): (usize, usize)) -> View {
    let mut view = view();
    view.intrinsics_px[2] += right as f64;
    view.intrinsics_px[3] += down as f64;
    View { width, height, ..view }
}

/// How two radiances differ, relative to the brighter one or to a tenth of white.
fn difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).abs() / a[k].max(b[k]).max(0.1)).fold(0.0, f32::max)
}

#[test]
fn an_image_that_is_moved_by_whole_pixels_is_the_same() {
    for weather in [clear_sun_from(60.0), clear_sun_from(200.0), Weather::preset("hard_rain_noon").unwrap()] {
        let still = radiance_of(&scene(), &moved(0, 0, SIZE), &weather);
        for (right, down) in [(1, 0), (2, 0), (5, 3), (0, 1)] {
            let other = radiance_of(&scene(), &moved(right, down, SIZE), &weather);
            let mut differences = Vec::new();
            for row in 0..SIZE.1 - down {
                for column in 0..SIZE.0 - right {
                    let at = (row + down) * SIZE.0 + column + right;
                    differences.push(difference(still[row * SIZE.0 + column], other[at]));
                }
            }
            differences.sort_unstable_by(f32::total_cmp);
            let at = |share: f64| differences[(share * differences.len() as f64) as usize];
            // The light at the edges of shadows is found at other points.
            assert!(
                at(0.5) < 0.0015 && at(0.9) < 0.01 && at(0.98) < 0.06,
                "{right} {down}: {} {} {}",
                at(0.5),
                at(0.9),
                at(0.98)
            );
        }
    }
}

#[test]
fn an_image_of_any_size_is_a_part_of_a_larger_one() {
    let weather = clear_sun_from(60.0);
    let whole = radiance_of(&scene(), &view(), &weather);
    for (width, height) in [(1, 1), (2, 1), (7, 3), (37, 13), (64, 99), (161, 50), (320, 5)] {
        // Such that its middle is the whole one's.
        let (left, top) = ((SIZE.0 - width) / 16 * 8, (SIZE.1 - height) / 8 * 4);
        let mut view = view();
        view.intrinsics_px[2] -= left as f64;
        view.intrinsics_px[3] -= top as f64;
        let part = radiance_of(&scene(), &View { width, height, ..view }, &weather);
        assert_eq!(part.len(), width * height);
        let is_alike = |i: &usize| {
            let of_whole = whole[(top + i / width) * SIZE.0 + left + i % width];
            difference(part[*i], of_whole) < 0.02
        };
        let alike = (0..part.len()).filter(is_alike).count();
        assert!(part.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "{width} x {height}");
        assert!(alike as f64 >= 0.98 * part.len() as f64, "{width} x {height}: {alike}");
    }
}

#[test]
fn a_texture_is_as_fine_as_the_pixels() {
    // Joints of bricks are as thin as pixels: neighbors that are shaded at once differ as much as those that are not.
    let bricks = Material::matt(Semantic::Building, [0.4, 0.3, 0.25], Pattern::Bricks, 0.3);
    let wall = [cuboid(Vec3::new(7.0, -9.0, -3.0), Vec3::new(7.5, 9.0, 9.0), bricks, 0)];
    let image = radiance_of(&wall, &view(), &clear_sun_from(180.0));
    let at = |row: usize, column: usize| image[row * SIZE.0 + column][0];
    let (mut within, mut between) = (0.0, 0.0);
    for row in 10..90 {
        for column in (20..300).step_by(2) {
            within += (at(row, column) - at(row, column + 1)).abs();
            between += (at(row, column + 1) - at(row, column + 2)).abs();
        }
    }
    assert!(within > 0.0 && (within / between - 1.0).abs() < 0.05, "{within} {between}");
}
