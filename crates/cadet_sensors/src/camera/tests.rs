//! Pictures of small scenes against closed forms and invariances.

mod covers;
mod fog;
mod lamps;
mod lattice;
mod night;
mod oracle;
mod pairs;
mod reference;
mod rolling_shutter;
mod shadow_borders;
mod shadow_maps;
mod shadow_proxies;
mod sky_visibility;
mod snow;
mod spray;
mod surface_maps;
mod thin_things;
mod wet_ground;

use std::sync::Arc;

use super::{Foreground, Rendered, View, render_through, visibility_pass};
use crate::camera::light::{Sky, SkyProbes};
use crate::sense::{DrawnFace, PosedScene};
use crate::weather::Weather;
use cadet_base::frames::upright;
use cadet_base::geometry::{IndexedFaces, LodSet, Mesh, MeshBuilder};
use cadet_base::instance::Instance;
use cadet_base::material::{Material, Palette, Pattern, Semantic};
use cadet_base::math::{self, DMat3, DPose3, DQuat, DVec3, Vec3};
use cadet_base::rng::Stream;

const EYE_HEIGHT_M: f64 = 1.65;
const INTRINSICS: [f64; 4] = [200.0, 210.0, 155.3, 45.2];
const SIZE: (usize, usize) = (320, 100);

fn instance(mesh: Mesh, material: Material, world_from_local: DPose3, actor_id: i32) -> Instance {
    let palette = Arc::new(Palette::new(vec![material]));
    Instance::new(Arc::new(LodSet::single(mesh)), palette, world_from_local, actor_id)
}

fn gray(semantic: Semantic, albedo: f32) -> Material {
    Material::matt(semantic, [albedo; 3], Pattern::Plain, 0.2)
}

fn ground() -> Instance {
    let mut b = MeshBuilder::new();
    for i in 0..80 {
        for j in 0..80 {
            let p = |x: i32, y: i32| Vec3::new((x * 5 - 200) as f32, (y * 5 - 200) as f32, 0.0);
            b.quad(p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1), 0);
        }
    }
    instance(b.build("ground", 0.5), gray(Semantic::Road, 0.12), DPose3::IDENTITY, 0)
}

fn cuboid(min: Vec3, max: Vec3, material: Material, actor_id: i32) -> Instance {
    let mut b = MeshBuilder::new();
    let middle = (min + max) * 0.5;
    b.cuboid(min - middle, max - middle, 0);
    instance(b.build("cuboid", 0.5), material, upright(middle.as_dvec3(), 0.0), actor_id)
}

/// A camera at the eye's height that looks along x.
fn view() -> View {
    let axes = DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X);
    let world_from_cam = DPose3 { rotation: DQuat::from_mat3(&axes), translation: DVec3::new(0.0, 0.0, EYE_HEIGHT_M) };
    View { intrinsics_px: INTRINSICS, width: SIZE.0, height: SIZE.1, world_from_cam }
}

fn clear_sun_from(azimuth_deg: f64) -> Weather {
    let mut weather = Weather::preset("clear_noon").unwrap();
    weather.sun_azimuth_rad = azimuth_deg.to_radians();
    weather
}

fn picture(instances: &[Instance], weather: &Weather, seed: u64) -> Rendered {
    let posed = PosedScene::new(instances, DVec3::new(0.0, 0.0, EYE_HEIGHT_M));
    let seen = visibility_pass(&posed, &view()).unwrap();
    let stream = &mut Stream::from_seed("camera", seed);
    let rendered = render_through(&posed, &view(), weather, &seen, &Foreground::default(), stream);
    Rendered { maps: Some(seen.maps(&posed)), ..rendered }
}

fn street() -> Vec<Instance> {
    let mut paint = gray(Semantic::Car, 0.3);
    (paint.specular, paint.roughness) = (0.05, 0.05);
    let mut glass = gray(Semantic::Car, 0.9);
    (glass.specular, glass.roughness, glass.transmission) = (0.04, 0.02, 0.8);
    vec![
        ground(),
        cuboid(Vec3::new(20.0, 6.0, 0.0), Vec3::new(40.0, 16.0, 9.0), gray(Semantic::Building, 0.5), 0),
        cuboid(Vec3::new(9.0, -3.0, 0.25), Vec3::new(13.0, -1.4, 1.4), paint, 3),
        cuboid(Vec3::new(8.0, -0.5, 0.2), Vec3::new(8.01, 1.5, 2.0), glass, 4),
        cuboid(Vec3::new(14.0, 0.5, 0.0), Vec3::new(14.4, 1.0, 1.8), gray(Semantic::Person, 0.2), 5),
    ]
}

#[test]
fn depth_at_pixel_centres_is_the_planes_and_the_sky_has_none() {
    let r = picture(&[ground()], &clear_sun_from(60.0), 0).maps.unwrap();
    let [_, fy, _, cy] = INTRINSICS;
    for row in 0..SIZE.1 {
        let down = (row as f64 - cy) / fy;
        for column in [0, 100, 319] {
            let at = row * SIZE.0 + column;
            let z = EYE_HEIGHT_M / down;
            if (0.0..100.0).contains(&z) {
                assert!((f64::from(r.depth_m[at]) - z).abs() < 1e-4 * z, "row {row}: {} {z}", r.depth_m[at]);
                assert_eq!((r.instance[at], r.semantic[at]), (0, Semantic::Road as u8));
            } else if down < 0.0 {
                assert!(r.depth_m[at].is_infinite());
                assert_eq!((r.instance[at], r.semantic[at]), (-1, Semantic::Sky as u8));
            }
        }
    }
}

#[test]
fn identity_agrees_between_the_two_samplings_and_windows_carry_their_cars_id() {
    let (w, h) = SIZE;
    let Rendered { image, maps, .. } = picture(&street(), &clear_sun_from(60.0), 0);
    let r = maps.unwrap();
    assert_eq!((r.instance.len(), image.len()), (w * h, 3 * w * h));
    let posed = PosedScene::new(&street(), DVec3::new(0.0, 0.0, EYE_HEIGHT_M));
    let seen = visibility_pass(&posed, &view()).unwrap();
    for id in [3, 4, 5] {
        let centers = r.instance.iter().filter(|i| **i == id).count() as f64;
        let samples = seen.samples_of_actor(id, 0..2 * h, 0..w) as f64;
        // The man stands behind the glass: only his head shows.
        assert!(samples > 0.0 || id == 5, "{id}");
        assert!((samples / 2.0 - centers).abs() <= 0.05 * centers + 12.0, "{id}: {samples} {centers}");
    }
    // In windows that cut blocks, those with panes too: as sample by sample.
    for (rows, columns) in [(0..2 * h, 0..w), (3..2 * h - 5, 9..w - 7), (h..h + 90, 101..171)] {
        let count = |id: i32| {
            let actor_of = |(face, _): (&DrawnFace, f32)| posed.instances[face.instance as usize].actor_id;
            let samples = rows.clone().flat_map(|row| columns.clone().map(move |column| (row, column)));
            samples.filter(|(row, column)| seen.samples.0.front(*row, *column).map(actor_of) == Some(id)).count()
        };
        for id in [0, 3, 4, 5] {
            assert_eq!(
                seen.samples_of_actor(id, rows.clone(), columns.clone()),
                count(id),
                "{id} {rows:?} {columns:?}"
            );
        }
    }
    // A point on the glass: u = cx - fx y / x, v = cy + fy (1.65 - z) / x.
    let [fx, fy, cx, cy] = INTRINSICS;
    let at = (cy + fy * 0.5 / 8.0).round() as usize * w + (cx - fx * 0.5 / 8.0).round() as usize;
    assert_eq!((r.instance[at], r.semantic[at]), (4, Semantic::Car as u8));
    assert!((r.depth_m[at] - 8.0).abs() < 1e-3);
    assert!((0..h * w).all(|at| seen.depth_m_at(at / w, at % w) == r.depth_m[at]));
}

#[test]
fn lit_and_shaded_ground_differ_as_sun_and_sky_do() {
    // A small plate high up: its shadow is dark of sun alone, the sky over it stays open.
    let weather = clear_sun_from(90.0);
    let sky = Sky::new(&weather);
    let up = 20.0_f32;
    let back = sky.sun_world * (up / sky.sun_world.z);
    let (x, y) = (10.0 + back.x, back.y);
    let plate =
        cuboid(Vec3::new(x - 2.0, y - 2.0, up), Vec3::new(x + 2.0, y + 2.0, up + 0.1), gray(Semantic::Fence, 0.1), 0);
    let r = picture(&[ground(), plate], &weather, 1);
    let [fx, fy, cx, cy] = INTRINSICS;
    let mean_around = |x: f64, y: f64| {
        let (u, v) = ((cx - fx * y / x).round() as usize, (cy + fy * EYE_HEIGHT_M / x).round() as usize);
        let values = (v - 2..=v + 2).flat_map(|v| (u - 4..=u + 4).map(move |u| (v * SIZE.0 + u) * 3 + 1));
        values.map(|i| f64::from(r.image[i])).sum::<f64>() / 45.0
    };
    let (shaded, lit) = (mean_around(10.0, 0.0), mean_around(10.0, -5.5));
    // The veil lies over both: take it from the mean of the image, as a camera's maker would.
    let veil = 0.025 * r.image.iter().skip(1).step_by(3).map(|v| f64::from(*v)).sum::<f64>() / (SIZE.0 * SIZE.1) as f64;
    let direct = f64::from(sky.sun.y * sky.sun_world.z);
    let expected = (direct + f64::from(sky.sky_on_level.y)) / f64::from(sky.sky_on_level.y);
    let measured = (lit - veil) / (shaded - veil);
    assert!(lit < 250.0, "{lit}");
    assert!((measured / expected - 1.0).abs() < 0.12, "{measured} {expected}");
}

#[test]
fn every_weather_is_exposed_alike() {
    for name in Weather::NAMES.into_iter().filter(|name| !name.ends_with("_night")) {
        let r = picture(&street(), &Weather::preset(name).unwrap(), 5);
        let luma: f64 = r
            .image
            .chunks(3)
            .map(|p| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]))
            .sum::<f64>()
            / (SIZE.0 * SIZE.1) as f64;
        assert!((82.0..106.0).contains(&luma), "{name}: {luma}");
    }
}

#[test]
fn a_low_sun_is_noisier_than_noon() {
    let [noon, dusk] = ["clear_noon", "dusk"].map(|name| {
        // A wall that hides the sky.
        let (near, far) = (Vec3::new(12.0, -60.0, 0.0), Vec3::new(13.0, 60.0, 40.0));
        let scene = [ground(), cuboid(near, far, gray(Semantic::Building, 0.2), 0)];
        let of = |seed| picture(&scene, &Weather::preset(name).unwrap(), seed).image;
        let pairs: Vec<[f64; 2]> = of(1).into_iter().zip(of(2)).map(|(a, b)| [a, b].map(f64::from)).collect();
        let gray = pairs.iter().filter(|[a, b]| (80.0..120.0).contains(&(0.5 * (a + b))));
        let (count, sum) = gray.fold((0.0, 0.0), |(count, sum), [a, b]| (count + 1.0, sum + 0.5 * (a - b) * (a - b)));
        assert!(count > 300.0, "{count}");
        sum / count
    });
    assert!((2.0..8.0).contains(&noon) && dusk > 2.0 * noon, "{noon} {dusk}");
}

#[test]
fn the_same_stream_gives_the_same_bytes_and_labels_do_not_show() {
    let weather = clear_sun_from(200.0);
    let scene = street();
    let first = picture(&scene, &weather, 9);
    assert_eq!(first, picture(&scene, &weather, 9));
    assert_ne!(first.image, picture(&scene, &weather, 10).image);
    let mut renamed = scene;
    for i in renamed.iter_mut().filter(|i| i.actor_id > 0) {
        i.actor_id = 20 - i.actor_id;
    }
    let other = picture(&renamed, &weather, 9);
    assert_eq!(first.image, other.image);
    assert_ne!(first.maps.unwrap().instance, other.maps.unwrap().instance);
}

#[test]
fn the_ground_under_a_car_is_nearly_black_and_overcast_casts_no_shadow() {
    let car = cuboid(Vec3::new(9.0, -0.9, 0.3), Vec3::new(13.0, 0.9, 1.5), gray(Semantic::Car, 0.3), 1);
    let [_, fy, cx, cy] = INTRINSICS;
    let ground_at = |r: &Rendered, x: f64| {
        let v = (cy + fy * EYE_HEIGHT_M / x).round() as usize;
        // A mean, as pixels are noisy.
        let values = (0..13).map(|i| f64::from(r.image[(v * SIZE.0 + cx as usize - 6 + i) * 3 + 1]));
        values.sum::<f64>() / 13.0
    };
    // A bright gray sky scatters more veil into the dark.
    for (name, share) in [("clear_noon", 0.35), ("soft_rain_noon", 0.5)] {
        let mut weather = Weather::preset(name).unwrap();
        weather.wetness = 0.0;
        let r = picture(&[ground(), car.clone()], &weather, 2);
        assert!(ground_at(&r, 9.8) < share * ground_at(&r, 6.7), "{name}");
    }
    // Sun from behind the car: its shadow lies before the camera, but not in the rain.
    let mut weather = clear_sun_from(0.0);
    weather.sun_elevation_rad = math::atan(1.0);
    let in_shadow = |w: &Weather| {
        let r = picture(&[ground(), car.clone()], w, 2);
        ground_at(&r, 8.2) / ground_at(&r, 6.7)
    };
    assert!(in_shadow(&weather) < 0.6, "{}", in_shadow(&weather));
    weather.rain_mm_per_h = 5.0;
    assert!(in_shadow(&weather) > 0.75, "{}", in_shadow(&weather));
}

#[test]
fn vehicles_darken_a_point_alike_whoever_is_asked_with_it() {
    let car =
        |y: f32, id| cuboid(Vec3::new(9.0, y - 0.9, 0.3), Vec3::new(13.0, y + 0.9, 1.5), gray(Semantic::Car, 0.3), id);
    let scene = PosedScene::new(&[ground(), car(0.0, 1), car(3.0, 2)], DVec3::ZERO);
    let eye = Vec3::new(0.0, 0.0, EYE_HEIGHT_M as f32);
    let view = SkyProbes::new(&scene, eye.as_dvec3(), DVec3::X, &[]);
    let at = |i: usize| Vec3::new(11.0, i as f32 * 0.09 - 5.0, 0.0);
    let points = [0, 1, 2].map(|axis| std::array::from_fn::<f32, 144, _>(|i| (at(i) - eye)[axis]));
    let mut together = [f32::NAN; 144];
    view.contacts.shade(eye, &points, &std::array::from_fn(|i| i % 5 != 2), 144, &mut together);
    for (i, near) in together.into_iter().enumerate() {
        let mut alone = [f32::NAN; 16];
        view.contacts.shade(eye, &points.map(|axis| [axis[i]; 16]), &[i % 5 != 2; 16], 1, &mut alone);
        assert_eq!(near, alone[0], "{}", at(i));
        // The nearer side of the nearer car: beyond one and a half of its heights nothing is left of it.
        let beside = (at(i).y.abs() - 0.9).min((at(i).y - 3.0).abs() - 0.9);
        match beside {
            _ if i % 5 == 2 => assert_eq!(near, 1.0),
            b if b < -0.2 => assert!(near < 0.3, "{}: {near}", at(i)),
            b if b > 0.1 && b < 0.6 => assert!((0.3..0.95).contains(&near), "{}: {near}", at(i)),
            b if b > 1.9 => assert_eq!(near, 1.0),
            _ => {}
        }
    }
}

/// Makes a mesh of these faces with no vertex in common: none is drawn with another.
fn taken_apart(mesh: &Mesh) -> Mesh {
    let faces = IndexedFaces {
        vertices: mesh.triangles().flat_map(|(corners, _)| corners).collect(),
        normals: mesh.normals().collect(),
        faces: (0..mesh.num_faces() as u32).map(|f| [0, 1, 2].map(|k| 3 * f + k)).collect(),
        slots: mesh.slots().collect(),
    };
    Mesh::new("apart", &faces).unwrap()
}

#[test]
fn faces_that_are_drawn_as_one_look_as_they_do_alone() {
    let mut b = MeshBuilder::new();
    let at = |angle: i32, z: f32| {
        let angle = f64::from(angle) * math::TAU / 40.0;
        let (sin, cos) = (math::sin(angle), math::cos(angle));
        // A little thinner at its top.
        Vec3::new(cos as f32, sin as f32, 0.0) * (1.6 - 0.1 * z) + Vec3::Z * z
    };
    for (k, z) in (0..40).flat_map(|k| (0..6).map(move |z| (k, z as f32 * 0.5))) {
        b.quad(at(k, z), at(k + 1, z), at(k + 1, z + 0.5), at(k, z + 0.5), 0);
    }
    b.cuboid(Vec3::new(-1.0, 3.0, 0.0), Vec3::new(1.0, 5.0, 2.0), 0);
    let whole = b.build("a tower and a box", 0.6);
    let apart = taken_apart(&whole);
    let count = |mesh: &Mesh| mesh.clusters.iter().map(|c| c.pieces.len()).sum::<usize>();
    assert_eq!((count(&whole), count(&apart)), (246, 492));
    let mut coat = gray(Semantic::Building, 0.5);
    (coat.specular, coat.roughness) = (0.05, 0.1);
    for material in [gray(Semantic::Building, 0.5), coat] {
        let of = |mesh: &Mesh| {
            let tower = instance(mesh.clone(), material, upright(DVec3::new(9.0, -2.0, 0.0), 0.3), 0);
            picture(&[ground(), tower], &clear_sun_from(160.0), 5)
        };
        let (one, other) = (of(&whole), of(&apart));
        assert_eq!(one.maps.as_ref().unwrap().semantic, other.maps.as_ref().unwrap().semantic);
        let differences = one.image.iter().zip(&other.image).map(|(a, b)| a.abs_diff(*b));
        let (many, most) = (differences.clone().filter(|d| *d > 3).count(), differences.max().unwrap());
        assert!(many < one.image.len() / 1000 && most < 30, "{many} {most}");
    }
}

#[test]
fn however_a_wall_is_cut_into_triangles_it_looks_the_same() {
    let wall = |is_cut_the_other_way: bool| {
        let mut b = MeshBuilder::new();
        let p = |j: i32, k: i32| Vec3::new(12.0 + 0.02 * j as f32, 0.35 * j as f32 - 5.0, 0.31 * k as f32 + 0.1);
        for (j, k) in (0..28).flat_map(|j| (0..12).map(move |k| (j, k))) {
            let [a, b_, c, d] = [p(j, k), p(j, k + 1), p(j + 1, k + 1), p(j + 1, k)];
            let corners = if is_cut_the_other_way { [b_, c, d, a] } else { [a, b_, c, d] };
            b.quad(corners[0], corners[1], corners[2], corners[3], 0);
        }
        let bricks = Material::matt(Semantic::Building, [0.4, 0.3, 0.25], Pattern::Bricks, 0.3);
        let rotated = upright(DVec3::new(0.0, 0.0, 0.0), 0.1);
        picture(&[ground(), instance(b.build("wall", 0.5), bricks, rotated, 0)], &clear_sun_from(150.0), 3)
    };
    let (one, other) = (wall(false), wall(true));
    let (maps, other_maps) = (one.maps.as_ref().unwrap(), other.maps.as_ref().unwrap());
    assert!(maps.semantic.iter().filter(|s| **s == Semantic::Building as u8).count() > 8000);
    assert_eq!(maps.semantic, other_maps.semantic);
    let differences = one.image.iter().zip(&other.image).map(|(a, b)| a.abs_diff(*b));
    let (many, most) = (differences.clone().filter(|d| *d > 2).count(), differences.max().unwrap());
    assert!(many < one.image.len() / 1000 && most < 24, "{many} {most}");
}
