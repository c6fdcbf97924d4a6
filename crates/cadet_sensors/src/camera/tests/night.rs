//! Nights against closed forms: what lamps make of plain surfaces, and how dark pictures are.

use super::{EYE_HEIGHT_M, INTRINSICS, SIZE, cuboid, gray, ground, view};
use crate::camera::light::Light;
use crate::camera::render::{Scratch, radiance};
use crate::camera::sensor::ROWS_BEFORE;
use crate::camera::{render, visibility_pass};
use crate::sense::PosedScene;
use crate::weather::Weather;
use cadet_base::instance::Instance;
use cadet_base::lamp::{Lamp, LampBeam, low_beam, luminaire};
use cadet_base::material::Semantic;
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

const CUT: (f32, f32) = (0.1, 0.32);

fn street_lamp(at: Vec3, intensity: f32) -> Lamp {
    let beam = LampBeam::Luminaire { cos_ends: CUT.0, cos_full: CUT.1 };
    Lamp { beam, at, ahead: -Vec3::Z, left: Vec3::Y, intensity: [intensity; 3], reach_m: 60.0 }
}

fn beam(at: Vec3) -> Lamp {
    Lamp { beam: LampBeam::LowBeam, at, ahead: Vec3::X, left: Vec3::Y, intensity: [160.0; 3], reach_m: 90.0 }
}

fn posed(instances: &[Instance], lamps: &[Lamp]) -> PosedScene {
    PosedScene::new(instances, DVec3::new(0.0, 0.0, EYE_HEIGHT_M)).with_lamps(lamps)
}

/// Green radiance of every pixel.
fn green(scene: &PosedScene, weather: &str) -> Vec<f32> {
    let weather = Weather::preset(weather).unwrap();
    let seen = visibility_pass(scene, &view()).unwrap();
    let mut scratch = Scratch::default();
    let _: Light = radiance(scene, &view(), &weather, &seen, &mut scratch);
    scratch.rgb[ROWS_BEFORE * SIZE.0 * 3..].chunks_exact(3).take(SIZE.0 * SIZE.1).map(|p| p[1]).collect()
}

/// The image point (the middle of a pixel's samples) and the pixel nearest to a place.
fn pixel_at(p: Vec3) -> (usize, [f32; 2]) {
    let [fx, fy, cx, cy] = INTRINSICS.map(|v| v as f32);
    let (u, v) = (cx - fx * p.y / p.x, cy - fy * (p.z - EYE_HEIGHT_M as f32) / p.x);
    let (column, row) = ((u - 0.25).round(), (v - 0.25).round());
    (row as usize * SIZE.0 + column as usize, [column + 0.25, row + 0.25])
}

/// Where the ray of an image point meets the ground.
fn on_ground([u, v]: [f32; 2]) -> Vec3 {
    let [fx, fy, cx, cy] = INTRINSICS.map(|v| v as f32);
    let x = EYE_HEIGHT_M as f32 * fy / (v - cy);
    Vec3::new(x, (cx - u) / fx * x, 0.0)
}

#[test]
fn ground_is_lit_by_the_inverse_square_and_the_cosine() {
    let lamp = street_lamp(Vec3::new(12.0, 1.0, 5.0), 3.0);
    let [dark, lit] = [vec![], vec![lamp]].map(|lamps| green(&posed(&[ground()], &lamps), "clear_night"));
    // Light that comes back from around the lamp is the same everywhere.
    let far = pixel_at(Vec3::new(60.0, 10.0, 0.0)).0;
    for place in [(12.0, 1.0), (9.0, 1.0), (14.0, -2.0), (8.0, 4.0), (16.0, 1.0)] {
        let (at, point) = pixel_at(Vec3::new(place.0, place.1, 0.0));
        let d = on_ground(point) - lamp.at;
        let (square, cos) = (d.length_squared(), 5.0 / d.length());
        let direct = 3.0 * luminaire(cos, CUT.0, CUT.1) * cos / square;
        let around = lit[far] - dark[far];
        let measured = (lit[at] - dark[at] - around) / 0.12;
        assert!((measured - direct).abs() < 0.02 * direct + 2e-4, "{place:?}: {measured} {direct} {around}");
    }
}

#[test]
fn a_low_beam_ends_on_a_wall_where_it_is_aimed() {
    let wall = cuboid(Vec3::new(20.0, -12.0, 0.0), Vec3::new(21.0, 12.0, 6.0), gray(Semantic::Building, 0.5), 0);
    let lamp = beam(Vec3::new(2.0, 0.0, 0.65));
    let [dark, lit] = [vec![], vec![lamp]].map(|lamps| green(&posed(&[ground(), wall.clone()], &lamps), "clear_night"));
    let at = |y: f32, z: f32| {
        let at = pixel_at(Vec3::new(20.0, y, z)).0;
        (lit[at] - dark[at]) / 0.5
    };
    // 18 m ahead of the lamp: the edge is 18 cm lower than it at the left, 1 cm higher at the right.
    let (below, above) = (at(0.8, 0.25), at(0.8, 0.75));
    assert!(below > 15.0 * above && above > 0.0, "{below} {above}");
    assert!(at(-1.2, 0.55) > 10.0 * at(0.8, 0.75));
    let to = Vec3::new(18.0, -0.8, -0.4);
    let expected = 160.0 * low_beam(to.x, to.y, to.z) * (to.x / to.length()) / to.length_squared();
    assert!((at(-0.8, 0.25) / expected - 1.0).abs() < 0.1, "{} {expected}", at(-0.8, 0.25));
}

#[test]
fn signs_throw_the_beams_of_the_own_car_back() {
    let plate = |retro: bool| {
        let mut material = gray(Semantic::TrafficSign, 0.5);
        material.lidar.retro = retro;
        cuboid(Vec3::new(40.0, -1.5, 0.0), Vec3::new(40.1, 1.5, 2.0), material, 0)
    };
    let lamps = [beam(Vec3::new(0.5, 0.0, 0.65))];
    let [plain, retro] = [false, true].map(|retro| green(&posed(&[ground(), plate(retro)], &lamps), "clear_night"));
    let at = pixel_at(Vec3::new(40.0, 0.0, 1.2)).0;
    assert!(retro[at] > 20.0 * plain[at], "{} {}", retro[at], plain[at]);
    // Not the lamps of a car beside.
    let lamps = [beam(Vec3::new(0.5, -5.0, 0.65))];
    let [plain, retro] = [false, true].map(|retro| green(&posed(&[ground(), plate(retro)], &lamps), "clear_night"));
    assert!(retro[at] < 4.0 * plain[at], "{} {}", retro[at], plain[at]);
}

#[test]
fn a_wet_road_draws_lamps_out_to_streaks_toward_the_camera() {
    let lens = Lamp { beam: LampBeam::Lens, ahead: -Vec3::X, ..street_lamp(Vec3::new(30.0, 0.0, 0.8), 2.0) };
    let streak = |weather: &str| {
        let [dark, lit] = [vec![], vec![lens]].map(|lamps| green(&posed(&[ground()], &lamps), weather));
        let at = |x: f32, y: f32| {
            let at = pixel_at(Vec3::new(x, y, 0.0)).0;
            lit[at] - dark[at]
        };
        // Where it is mirrored, by like triangles, and as far aside as nearer.
        let mirror = 30.0 * 1.65 / (1.65 + 0.8);
        [at(mirror, 0.0), at(mirror - 6.0, 0.0), at(mirror, 6.0)]
    };
    let ([at, nearer, aside], [dry, ..]) = (streak("wet_night"), streak("clear_night"));
    assert!(at > 5.0 * dry && at > 30.0 * aside && nearer > 4.0 * aside, "{at} {nearer} {aside} {dry}");
}

#[test]
fn by_day_lamps_light_nothing_and_at_night_a_picture_is_the_same_each_time() {
    let lamp = street_lamp(Vec3::new(10.0, 0.0, 5.0), 300.0);
    let of = |lamps: &[Lamp], weather: &str| {
        let (scene, weather) = (posed(&[ground()], lamps), Weather::preset(weather).unwrap());
        let seen = visibility_pass(&scene, &view()).unwrap();
        render(&scene, &view(), &weather, &seen, &mut Stream::from_seed("camera", 1))
    };
    assert!(of(&[lamp], "clear_noon") == of(&[], "clear_noon"));
    assert!(of(&[lamp], "clear_night") != of(&[], "clear_night"));
    assert!(of(&[lamp], "clear_night") == of(&[lamp], "clear_night"));
}
