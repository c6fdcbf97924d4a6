//! Scans against parry's own triangle meshes, ray by ray, and what KITTI's files promise about points.
#![allow(missing_docs, clippy::print_stderr)]

mod common;

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use common::{angle_to_edges, at, cuboid, place, posed, random_scene, sphere};
use parry3d::query::{Ray, RayCast};
use parry3d::shape::TriMesh;

use cadet_core::lidar::{Firing, LidarSpec, PRESETS, ideal_scan, scan};
use cadet_core::material::{Material, Palette, Pattern, Semantic};
use cadet_core::math::{self, DPose3, DQuat, DVec3, TAU, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{LaserRing, NO_HIT, PosedScene, RayCaster};
use cadet_core::weather::Weather;

fn tilted(s: &mut Stream, center: DVec3) -> DPose3 {
    let rotation = DQuat::from_rotation_z(s.range(0.0, TAU)) * DQuat::from_rotation_y(s.normal() * 0.02);
    DPose3 { rotation, translation: center }
}

/// Lasers that fire one after the other, as Velodyne's smaller sensors do: every ring has azimuths of its own.
fn one_after_the_other() -> LidarSpec {
    let ring = |k: usize| LaserRing::on_axis((10.0 - 2.5 * k as f64).to_radians(), 0.002 * k as f64);
    let offsets_rad = (0..16).map(|k| f64::from(k * 7 % 16) / 16.0 * TAU / 1800.0).collect();
    LidarSpec::with_firing("staggered", (0..16).map(ring).collect(), Firing::Uniform { columns: 1800 })
        .and_then(|spec| spec.staggered(offsets_rad))
        .expect("valid")
}

/// The oracle shares nothing with the product but the triangles: one parry mesh, tested by parry in single precision.
#[test]
fn ideal_scans_agree_with_parrys_own_mesh() {
    let presets = PRESETS.into_iter().map(|name| LidarSpec::preset(name).expect("listed"));
    for (seed, spec) in presets.chain([one_after_the_other()]).enumerate() {
        let mut s = Stream::from_seed("parry", seed as u64);
        // Near the origin, where single precision can follow.
        let scene = posed(&random_scene(&mut s, DVec3::ZERO));
        let pose = tilted(&mut s, DVec3::new(0.1, -0.2, 0.05));
        let all = scene.indexed_triangles();
        let owner = all.owners;
        let mesh = TriMesh::new(all.vertices, all.faces).expect("a valid mesh");
        let ideal = ideal_scan(&scene, &pose, &spec);
        let caster = RayCaster::new(Arc::clone(&scene));
        let rays = spec.rays();
        assert_eq!(ideal.range_m.len(), rays.ring.len());
        let (mut by_parry, mut by_caster, mut hits) = (0, 0, 0);
        for i in 0..rays.ring.len() {
            let origin = pose.translation + pose.rotation * rays.origins_velo[i];
            let direction = pose.rotation * rays.directions_velo[i];
            let kernel_m = f64::from(ideal.range_m[i]);
            hits += usize::from(kernel_m.is_finite());
            let agree = |other: f64| kernel_m == other || (kernel_m - other).abs() < 1e-3;
            let check = |other_m: f64, other: (u32, u32), limit: f64| {
                let (instance, face) = if kernel_m < other_m { (ideal.instance[i], ideal.face[i]) } else { other };
                let corners = scene.corners(instance, face);
                let angle = angle_to_edges(corners, origin, direction);
                // Seen edge-on, a triangle is all edge.
                let [a, b, c] = corners.map(|p| p.as_dvec3());
                let grazing = (b - a).cross(c - a).normalize_or_zero().dot(direction).abs();
                assert!(angle < limit || grazing < 0.003, "ray {i}: {kernel_m} {other_m} {angle} {grazing}");
            };
            let single = caster.cast(origin, direction).expect("finite");
            let single_m = single.map_or(f64::INFINITY, |h| h.range_m);
            if !agree(single_m) {
                by_caster += 1;
                check(single_m, single.map_or((NO_HIT, NO_HIT), |h| (h.instance, h.face)), 1e-8);
            }
            let ray = Ray::new(origin.as_vec3(), direction.as_vec3());
            let found = mesh.cast_local_ray_and_get_normal(&ray, 1e6, false);
            let parry_m = found.map_or(f64::INFINITY, |h| f64::from(h.time_of_impact));
            if !agree(parry_m) {
                by_parry += 1;
                let face = found.and_then(|h| match h.feature {
                    parry3d::shape::FeatureId::Face(f) => Some(owner[f as usize % owner.len()]),
                    _ => None,
                });
                check(parry_m, face.unwrap_or((NO_HIT, NO_HIT)), 1e-4);
            }
        }
        let n = rays.ring.len();
        eprintln!("{}: {n} rays, {hits} hits, parry differs in {by_parry}, single rays in {by_caster}", spec.name());
        assert!(hits > n / 4);
        assert!((by_parry as f64) <= 1e-4 * n as f64, "{by_parry} of {n}");
        assert!((by_caster as f64) <= 1e-5 * n as f64, "{by_caster} of {n}");
    }
}

fn street() -> Arc<PosedScene> {
    let mut instances = vec![place(cuboid(Vec3::new(120.0, 120.0, 0.5)), at(0.0, 0.0, -2.23), 0)];
    for (id, x, y) in [(1, 12.0, 3.0), (2, 20.0, -3.5), (3, -15.0, 3.0), (4, 42.0, 2.0)] {
        instances.push(place(cuboid(Vec3::new(2.0, 0.8, 0.75)), at(x, y, -0.95), id));
    }
    instances.push(place(sphere(4.0, 24), at(-20.0, -14.0, 2.0), 0));
    posed(&instances)
}

#[test]
fn points_keep_kittis_promises() {
    let scene = street();
    let spec = LidarSpec::hdl64e_kitti();
    let weather = Weather::preset("clear_noon").expect("exists");
    let scan = scan(&scene, &DPose3::IDENTITY, &spec, &weather, &mut Stream::from_seed("scan", 0)).expect("valid");
    let ideal = ideal_scan(&scene, &DPose3::IDENTITY, &spec);
    assert!(scan.ring.len() > 60_000, "{}", scan.ring.len());
    let mut last = (0, -1.0);
    let mut beams = HashSet::new();
    let mut noise = Vec::new();
    for (i, [x, y, z, intensity]) in scan.points_velo.iter().copied().enumerate() {
        let (ring, column) = (scan.ring[i], scan.column[i]);
        let azimuth = math::atan2(f64::from(y), f64::from(x)).rem_euclid(TAU);
        assert!((ring, azimuth) >= last, "ring-major, azimuth rising");
        last = (ring, azimuth);
        assert!(beams.insert((ring, column)), "one return a beam");
        let whole = |v: f32, unit: f64| (f64::from(v) * unit - (f64::from(v) * unit).round()).abs() < 5e-3;
        assert!(whole(x, 1e3) && whole(y, 1e3) && whole(z, 1e3) && whole(intensity, 1e2));
        assert!((0.0..=0.99).contains(&intensity));
        // On the laser's line: z = h + tan(e) * rho, up to rounding.
        let laser = spec.rings()[ring as usize];
        let rho = math::hypot(f64::from(x), f64::from(y));
        let off_line = f64::from(z) - laser.height_m - math::tan(laser.elevation_rad) * rho;
        assert!(off_line.abs() < 1.1e-3, "{off_line}");
        // At a tick of the encoder, the nearest to where the beam went, as the laser beside the axis sees it.
        let reported = (azimuth - math::atan2(laser.left_m, rho)) / (TAU / 4000.0);
        let fired = spec.azimuths_rad()[column as usize] / (TAU / 4000.0);
        let late = (reported - fired + 2000.0).rem_euclid(4000.0) - 2000.0;
        assert!(late.abs() < 0.5 + 1.0 / rho, "{reported} {fired}");
        assert!((reported - reported.round()).abs() < 1.0 / rho, "{reported}");
        let at = ring as usize * spec.azimuths_rad().len() + column as usize;
        assert_eq!(scan.actor_id[i], ideal.actor_id[at]);
        let offset_m = spec.laser_receivers[ring as usize].range_offset_m;
        noise.push(scan.range_m[i] - offset_m - f64::from(ideal.range_m[at]));
    }
    let n = noise.len() as f64;
    let mean = noise.iter().sum::<f64>() / n;
    let sd = (noise.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / n).sqrt();
    // 7.8 mm, and up to half as much again where the echo is weak.
    assert!(mean.abs() < 5e-4 && (0.0075..0.012).contains(&sd), "{mean} {sd}");
}

#[test]
fn the_same_stream_gives_the_same_bytes_and_clear_weather_changes_none() {
    let scene = street();
    let spec = LidarSpec::hdl64e_uniform();
    let run = |weather: &Weather, seed| {
        scan(&scene, &DPose3::IDENTITY, &spec, weather, &mut Stream::from_seed("scan", seed)).expect("valid")
    };
    let clear = Weather::preset("clear_noon").expect("exists");
    let cloudy = Weather::preset("cloudy_sunset").expect("exists");
    assert_eq!(run(&clear, 5), run(&clear, 5));
    assert_eq!(run(&clear, 5), run(&cloudy, 5));
    assert_ne!(run(&clear, 5), run(&clear, 6));
    let far = |name: &str| {
        let got = run(&Weather::preset(name).expect("exists"), 5);
        // What stands: fallen snow brightens the ground, and flakes return themselves.
        let stands = |s: &Semantic| *s != Semantic::Sky && !s.is_ground();
        got.range_m.iter().zip(&got.semantic).filter(|(r, s)| **r > 15.0 && stands(s)).count()
    };
    assert!(far("dense_fog") < far("light_fog") && far("light_fog") < far("clear_noon"));
    assert!(far("hard_rain_noon") < far("soft_rain_noon") && far("soft_rain_noon") < far("clear_noon"));
    assert!(far("snow") < far("clear_noon"));
}

#[test]
fn transparent_surfaces_show_what_is_behind_them() {
    let mut glass = common::matt().materials().to_vec();
    glass[0].transmission = 0.9;
    glass[0].lidar.transmission = 0.95;
    let mut window = place(cuboid(Vec3::new(0.01, 30.0, 30.0)), at(5.0, 0.0, 0.0), 1);
    window.palette = Arc::new(Palette::new(glass));
    let wall = place(cuboid(Vec3::new(0.5, 30.0, 30.0)), at(9.5, 0.0, 0.0), 2);
    let scene = posed(&[window, wall]);
    let weather = Weather::preset("clear_noon").expect("exists");
    let spec = LidarSpec::cadet();
    let ideal = ideal_scan(&scene, &DPose3::IDENTITY, &spec);
    assert!(ideal.actor_id.iter().all(|id| *id == 1 || *id == -1), "to an ideal scan glass is opaque");
    let got = scan(&scene, &DPose3::IDENTITY, &spec, &weather, &mut Stream::from_seed("scan", 0)).expect("valid");
    let behind = got.actor_id.iter().filter(|id| **id == 2).count() as f64 / got.actor_id.len() as f64;
    // The rest is dust on the pane.
    assert!((behind - 0.55).abs() < 0.05, "{behind}");
    for (i, [x, ..]) in got.points_velo.iter().enumerate() {
        let expected = if got.actor_id[i] == 1 { 4.99 } else { 9.0 };
        assert!((f64::from(*x) - expected).abs() < 0.1, "{x} {}", got.actor_id[i]);
    }
}

#[test]
fn impossible_rays_are_refused() {
    let caster = RayCaster::new(street());
    let text = |d: DVec3| caster.cast(DVec3::ZERO, d).expect_err("bad").to_string();
    assert!(text(DVec3::ZERO).contains("ray direction"));
    assert!(text(DVec3::new(f64::NAN, 0.0, 1.0)).contains("NaN"));
    assert!(caster.cast(DVec3::INFINITY, DVec3::X).is_err());
    for scale in [1e-200, 1.0, 1e200] {
        let hit = caster.cast(DVec3::ZERO, DVec3::new(0.0, 0.0, -scale)).expect("valid").expect("the ground");
        assert!((hit.range_m - 1.73).abs() < 1e-6 && (hit.normal_world - DVec3::Z).length() < 1e-9, "{hit:?}");
    }
    assert!(caster.cast(DVec3::ZERO, DVec3::Z).expect("valid").is_none());
}

/// Intensities of two scans of a level square of this material, less the mean of their rings, whose noise differs.
fn two_scans_of(material: Material) -> (Vec<f64>, Vec<f64>) {
    let mut slab = place(cuboid(Vec3::new(40.0, 40.0, 0.5)), at(3.7, -2.1, -2.23), 0);
    slab.palette = Arc::new(Palette::new(vec![material]));
    let scene = posed(&[slab]);
    let weather = Weather::preset("clear_noon").expect("exists");
    let spec = LidarSpec::hdl64e_uniform();
    let by_beam = |seed| -> BTreeMap<(i32, i32), f64> {
        let got =
            scan(&scene, &DPose3::IDENTITY, &spec, &weather, &mut Stream::from_seed("scan", seed)).expect("valid");
        (0..got.ring.len())
            .filter(|i| got.range_m[*i] < 15.0)
            .map(|i| ((got.ring[i], got.column[i]), f64::from(got.points_velo[i][3])))
            .collect()
    };
    let (first, second) = (by_beam(0), by_beam(1));
    let mut rings: BTreeMap<i32, Vec<(f64, f64)>> = BTreeMap::new();
    for (beam, a) in &first {
        if let Some(b) = second.get(beam) {
            rings.entry(beam.0).or_default().push((*a, *b));
        }
    }
    let less_mean = |ring: Vec<(f64, f64)>| {
        let n = ring.len() as f64;
        let (a, b) = (ring.iter().map(|p| p.0).sum::<f64>() / n, ring.iter().map(|p| p.1).sum::<f64>() / n);
        ring.into_iter().map(move |p| (p.0 - a, p.1 - b))
    };
    rings.into_values().flat_map(less_mean).unzip()
}

#[test]
fn asphalts_texture_belongs_to_the_place_and_not_to_chance() {
    let correlation = |(a, b): (Vec<f64>, Vec<f64>)| {
        assert!(a.len() > 20_000, "{}", a.len());
        let product = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(x, y)| x * y).sum::<f64>();
        product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
    };
    let of = |pattern| correlation(two_scans_of(Material::matt(Semantic::Road, [0.1; 3], pattern, 0.23)));
    let (asphalt, plain) = (of(Pattern::Asphalt), of(Pattern::Plain));
    assert!((0.2..0.5).contains(&asphalt) && plain.abs() < 0.05, "{asphalt} {plain}");
}
