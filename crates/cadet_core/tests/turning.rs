//! Scans of sensors that turn, or follow a path, while all moves: against closed forms.
#![allow(missing_docs)]

mod common;

use std::sync::Arc;

use cadet_core::lidar::{
    Aim, Firing, LidarSpec, Raster, Receiver, Rosette, Scan, SceneInMotion, Spin, SpinDirection, ideal_scan, scan,
    scan_in_motion,
};
use cadet_core::math::{self, DPose3, DVec3, PI, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{FaceTrees, LaserRing, MovingCaster, PosedScene, RigidMotion};
use cadet_core::spray::Spray;
use cadet_core::weather::Weather;
use common::{at, cuboid, place, posed, random_scene};

/// A sensor without noise, whose beams are lines and are reported where they go.
fn noiseless() -> LidarSpec {
    let mut spec = LidarSpec::hdl64e_uniform().with_divergence(0.0).expect("valid");
    let silent = Receiver { range_noise_m: 0.0, ..*spec.receiver() };
    spec = spec.with_receiver(silent).expect("valid");
    spec
}

fn clear() -> Weather {
    Weather::preset("clear_noon").expect("exists")
}

fn turn(
    scene: &Arc<PosedScene>,
    spec: &LidarSpec,
    sensor: RigidMotion,
    motion_of: impl Fn(i32) -> RigidMotion,
) -> Scan {
    let mut trees = FaceTrees::default();
    let scene = SceneInMotion::new(Arc::clone(scene), &mut trees, spec, DPose3::IDENTITY, sensor, motion_of);
    scan_in_motion(&scene, spec, (&clear(), &Spray::default()), &mut Stream::from_seed("scan", 0)).expect("valid")
}

fn moving(velocity_world: DVec3) -> RigidMotion {
    RigidMotion { velocity_world, ..RigidMotion::default() }
}

/// Points of an actor with the times of their firings.
fn points_of(scan: &Scan, spec: &LidarSpec, actor_id: i32) -> Vec<(f64, DVec3)> {
    (0..scan.ring.len())
        .filter(|i| scan.actor_id[*i] == actor_id)
        .map(|i| {
            let [x, y, z, _] = scan.points_velo[i].map(f64::from);
            (spec.spin.firing_time_s(spec.azimuths_rad()[scan.column[i] as usize]), DVec3::new(x, y, z))
        })
        .collect()
}

#[test]
fn where_all_stands_still_a_turn_is_the_scan_of_an_instant() {
    let mut stream = Stream::from_seed("turning", 3);
    for round in 0..4 {
        let scene = posed(&random_scene(&mut stream, DVec3::ZERO));
        let spec = if round % 2 == 0 { LidarSpec::hdl64e_kitti() } else { LidarSpec::cadet() };
        let spec = spec.with_divergence(if round < 2 { 0.0 } else { 3e-3 }).expect("valid");
        let still = scan(&scene, &DPose3::IDENTITY, &spec, &clear(), &mut Stream::from_seed("scan", 0)).expect("valid");
        let turned = turn(&scene, &spec, RigidMotion::default(), |_| RigidMotion::default());
        // Beam by beam: the kernel and parry part on a beam in ten thousand at the edges of triangles.
        let by_beam = |s: &Scan| {
            let mut out = std::collections::BTreeMap::new();
            for i in 0..s.ring.len() {
                assert!(out.insert((s.ring[i], s.column[i]), (s.points_velo[i], s.actor_id[i])).is_none());
            }
            out
        };
        let (still, turned) = (by_beam(&still), by_beam(&turned));
        let equal = still
            .iter()
            .filter(|(beam, (p, id))| {
                turned.get(beam).is_some_and(|(q, other)| {
                    id == other && (0..3).all(|i| (p[i] - q[i]).abs() < 2e-3) && (p[3] - q[3]).abs() < 0.011
                })
            })
            .count();
        let differing = still.len().max(turned.len()) - equal;
        assert!(
            still.len() > 10_000 && differing as f64 <= 3e-4 * still.len() as f64,
            "{differing} of {}",
            still.len()
        );
    }
}

#[test]
fn a_turn_through_a_moving_street_meets_what_single_rays_meet() {
    let mut stream = Stream::from_seed("moving street", 1);
    let speeds: Vec<[f64; 3]> = (0..200).map(|_| [-15.0, -15.0, -1.0].map(|v: f64| stream.range(v, -v))).collect();
    for (round, direction) in
        (0..4).zip([SpinDirection::Clockwise, SpinDirection::CounterClockwise].into_iter().cycle())
    {
        let scene = posed(&random_scene(&mut stream, DVec3::ZERO));
        let mut spec = noiseless();
        spec.spin = Spin { direction, start_rad: f64::from(round) * 1.3, ..Spin::default() };
        let sensor =
            RigidMotion { angular_velocity_world: DVec3::new(0.02, 0.05, 0.4), ..moving(DVec3::new(13.0, 0.5, 0.1)) };
        let motion_of = |id: i32| {
            let pivot_world = scene.instances.iter().find(|i| i.actor_id == id).map_or(DVec3::ZERO, |i| i.center_world);
            let [x, y, yaw] = speeds[id as usize % speeds.len()];
            RigidMotion { pivot_world, angular_velocity_world: DVec3::Z * yaw, ..moving(DVec3::new(x, y, 0.0)) }
        };
        let scan = turn(&scene, &spec, sensor, motion_of);
        let span_s = 0.1;
        let caster = MovingCaster::new(Arc::clone(&scene), &mut FaceTrees::default(), motion_of, span_s, |_| true);
        let rays = spec.rays();
        let mut by_beam = vec![None; spec.num_beams()];
        for (i, (ring, column)) in scan.ring.iter().zip(&scan.column).enumerate() {
            by_beam[*ring as usize * spec.num_columns() + *column as usize] = Some(scan.range_m[i]);
        }
        let (mut differing, mut hits) = (0, 0);
        for column in 0..spec.num_columns() {
            let time_s = spec.firing_time_s(column);
            let (moment, pose) = (caster.at(time_s), sensor.displacement(time_s));
            for ring in 0..spec.rings().len() {
                let at = ring * spec.num_columns() + column;
                let found =
                    moment.cast(pose.transform_point(rays.origins_velo[at]), pose.rotation * rays.directions_velo[at]);
                // Glass and what is too far or too dark to return are left out.
                let (Some(range_m), Some(opaque), None) = (by_beam[at], found.opaque, found.transparent) else {
                    continue;
                };
                hits += 1;
                differing += usize::from((range_m - opaque.range_m).abs() > 1e-4);
            }
        }
        assert!(hits > 10_000 && differing as f64 <= 1e-3 * f64::from(hits), "{differing} of {hits}");
    }
}

#[test]
fn a_wall_is_sheared_by_the_speed_of_the_car() {
    // Walls across the road, 20 m ahead and 20 m behind.
    let wall = || cuboid(Vec3::new(0.5, 15.0, 4.0));
    let scene = posed(&[place(wall(), at(20.5, 0.0, 0.0), 1), place(wall(), at(-20.5, 0.0, 0.0), 2)]);
    let speed_mps = 13.9;
    for (direction, ends_left) in [(SpinDirection::Clockwise, false), (SpinDirection::CounterClockwise, true)] {
        let mut spec = noiseless();
        spec.spin = Spin { direction, rate_hz: 5.0, ..Spin::default() };
        let scan = turn(&scene, &spec, moving(DVec3::new(speed_mps, 0.0, 0.0)), |_| RigidMotion::default());
        let ahead = points_of(&scan, &spec, 1);
        let behind = points_of(&scan, &spec, 2);
        assert!(ahead.len() > 5_000 && behind.len() > 5_000);
        for (walls_x, points) in [(20.0, &ahead), (-20.0, &behind)] {
            for (time_s, p) in points {
                assert!((p.x - (walls_x - speed_mps * time_s)).abs() < 1.1e-3, "{p} at {time_s}");
            }
        }
        // The seam behind the car: what the turn began with and what it ended with are a whole turn's way apart.
        let nearest = |left: bool| {
            let side = behind.iter().filter(|(_, p)| (p.y > 0.0) == left);
            side.min_by(|a, b| a.1.y.abs().total_cmp(&b.1.y.abs())).expect("points on both sides").1.x
        };
        let gap_m = nearest(!ends_left) - nearest(ends_left);
        assert!((gap_m - speed_mps / 5.0).abs() < 5e-3, "{gap_m}: later the wall is farther behind");
    }
}

#[test]
fn a_car_that_crosses_is_stretched_or_shortened() {
    // A face 4 m long 15 m ahead, centered on the axis; it is seen under an angle, and the beam sweeps to the right.
    let length_m = 4.0;
    let car = || place(cuboid(Vec3::new(0.9, 2.0, 0.75)), at(15.9, 0.0, -0.9), 7);
    let spec = noiseless();
    let width = |velocity: f64| {
        let scan = turn(&posed(&[car()]), &spec, RigidMotion::default(), |id| {
            assert_eq!(id, 7);
            RigidMotion { pivot_world: DVec3::new(15.9, 0.0, -1.6), ..moving(DVec3::new(0.0, velocity, 0.0)) }
        });
        let y: Vec<f64> = points_of(&scan, &spec, 7).iter().filter(|(_, p)| p.x < 15.01).map(|(_, p)| p.y).collect();
        assert!(y.len() > 200, "{}", y.len());
        y.iter().copied().fold(f64::NEG_INFINITY, f64::max) - y.iter().copied().fold(f64::INFINITY, f64::min)
    };
    // An end at y0 is seen at the time t with y0 + v t = -15 tan(2 pi t / T): y = y0 + v t.
    let expected = |velocity: f64| {
        let end = |y0: f64| {
            let then = |y: f64| y0 + velocity * spec.spin.firing_time_s(math::atan2(y, 15.0));
            let y = (0..60).fold(y0, |y, _| then(y));
            assert!((then(y) - y).abs() < 1e-9);
            y
        };
        end(length_m / 2.0) - end(-length_m / 2.0)
    };
    // Columns at 15 m are 4.7 cm apart.
    for velocity in [10.0, 0.0, -10.0] {
        let got = width(velocity);
        assert!((got - expected(velocity)).abs() < 0.1, "{velocity}: {got} {}", expected(velocity));
    }
    // About v T / (2 pi) times the angle it fills.
    let angle = 2.0 * math::atan2(2.0, 15.0);
    assert!((expected(10.0) - length_m + 10.0 * 0.1 / (2.0 * PI) * angle).abs() < 5e-3);
    assert!(width(10.0) < width(-10.0) - 0.05);
}

#[test]
fn a_turning_car_sees_walls_where_its_heading_was() {
    // A round wall looks the same from a turning sensor; a post does not: it is seen where the beam was when it met it.
    let scene = posed(&[place(cuboid(Vec3::new(0.05, 0.05, 3.0)), at(0.0, 10.0, 0.0), 1)]);
    let spec = noiseless();
    let yaw_rate = 0.8;
    let sensor = RigidMotion { angular_velocity_world: DVec3::new(0.0, 0.0, yaw_rate), ..RigidMotion::default() };
    let points = points_of(&turn(&scene, &spec, sensor, |_| RigidMotion::default()), &spec, 1);
    assert!(points.len() > 50);
    // In the sensor's frame the post stands at the azimuth 90 deg - yaw, seen when the beam points there.
    let mut azimuth = PI / 2.0;
    for _ in 0..40 {
        azimuth = PI / 2.0 - yaw_rate * spec.spin.firing_time_s(azimuth);
    }
    for (_, p) in &points {
        assert!((math::atan2(p.y, p.x) - azimuth).abs() < 0.008, "{p}");
        assert!((p.truncate().length() - 9.95).abs() < 0.03, "{p}");
    }
}

#[test]
fn a_box_lies_where_the_points_of_a_turn_are() {
    // Cars around a car in a bend, by place and velocity: they come, cross, and overtake. None is cut by the seam behind it.
    let size_m = Vec3::new(2.0, 0.8, 0.75);
    let cars = [
        ([20.0, 3.5], [-14.0, 0.0]),
        ([2.0, 12.0], [12.0, 0.0]),
        ([-3.0, -9.0], [0.0, 9.0]),
        ([-15.0, 6.0], [20.0, 0.0]),
    ];
    let pose = |k: usize| at(cars[k].0[0], cars[k].0[1], -1.0);
    let motion = |id: i32| {
        let (k, [x, y]) = (id as usize - 1, cars[id as usize - 1].1);
        RigidMotion { pivot_world: pose(k).translation, ..moving(DVec3::new(x, y, 0.0)) }
    };
    let scene = posed(&(0..4).map(|k| place(cuboid(size_m), pose(k), k as i32 + 1)).collect::<Vec<_>>());
    let spec = noiseless();
    let sensor =
        RigidMotion { angular_velocity_world: DVec3::new(0.0, 0.0, 0.3), ..moving(DVec3::new(14.0, 0.0, 0.0)) };
    let scan = turn(&scene, &spec, sensor, motion);
    for (k, (_, velocity)) in cars.iter().enumerate() {
        let points = points_of(&scan, &spec, k as i32 + 1);
        assert!(points.len() > 100);
        let mean_off_m = |box_pose: DPose3| {
            let off_m =
                |p: &DVec3| (box_pose.inverse().transform_point(*p).abs() - size_m.as_dvec3()).max_element().abs();
            points.iter().map(|(_, p)| off_m(p)).sum::<f64>() / points.len() as f64
        };
        let seen = spec.seen_pose((&pose(k), &motion(k as i32 + 1)), (&DPose3::IDENTITY, &sensor));
        let (at_instant_m, off_m) = (mean_off_m(pose(k)), mean_off_m(seen));
        // Its ends are met a little before and after its middle.
        assert!(off_m < 0.03 && at_instant_m > 3.0 * off_m, "{velocity:?}: {off_m}, {at_instant_m}");
    }
}

/// Every pattern that does not spin, without noise.
fn paths() -> [LidarSpec; 3] {
    let raster = Raster { lines: 20, columns: 60, azimuth_rad: [0.4, -0.4], elevation_rad: [0.1, -0.1], period_s: 0.1 };
    let rosette =
        Rosette { firings: 2000, deflections_rad: [0.2, 0.15], prism_rates_hz: [121.6, -77.7], period_s: 0.2 };
    let aim = |k: i32| Aim {
        time_s: 0.04 * f64::from(k),
        azimuth_rad: 0.1 * f64::from(k % 3),
        elevation_rad: -0.02 * f64::from(k),
    };
    let table = Firing::Table((-3..=3).map(aim).collect());
    [Firing::Raster(raster), Firing::Rosette(rosette), table].map(|firing| {
        let lasers = [(0.02, 0.3), (-0.03, -0.2)].map(|(elevation, height_m)| LaserRing::on_axis(elevation, height_m));
        let spec = LidarSpec::with_firing("path", lasers.to_vec(), firing).expect("valid");
        let silent = Receiver { range_noise_m: 0.0, ..*spec.receiver() };
        spec.with_receiver(silent).expect("valid").staggered(vec![0.05, -0.1]).expect("valid")
    })
}

#[test]
fn a_path_meets_a_wall_at_the_moment_of_each_firing() {
    let scene = posed(&[place(cuboid(Vec3::new(0.5, 30.0, 30.0)), at(20.5, 0.0, 0.0), 1)]);
    let speed_mps = 13.9;
    for spec in paths() {
        let rays = spec.rays();
        // Sums of a laser's and the scanner's angles.
        let elevation_rad = |i: usize| math::asin(rays.directions_velo[i].z);
        assert!((elevation_rad(0) - elevation_rad(spec.num_columns()) - 0.05).abs() < 1e-12);
        let azimuth_rad = |i: usize| math::atan2(rays.directions_velo[i].y, rays.directions_velo[i].x);
        assert!((azimuth_rad(0) - azimuth_rad(spec.num_columns()) - 0.15).abs() < 1e-12);
        for (forward_mps, world_mps) in [(0.0, 0.0), (speed_mps, 0.0), (0.0, -speed_mps)] {
            let scan = turn(&scene, &spec, moving(DVec3::new(forward_mps, 0.0, 0.0)), |_| {
                moving(DVec3::new(world_mps, 0.0, 0.0))
            });
            assert_eq!(scan.ring.len(), spec.num_beams(), "the wall is everywhere");
            for i in 0..scan.ring.len() {
                let (ring, column) = (scan.ring[i] as usize, scan.column[i] as usize);
                let beam = ring * spec.num_columns() + column;
                let time_s = spec.firing_time_s(column);
                let range_m = (20.0 - (forward_mps - world_mps) * time_s) / rays.directions_velo[beam].x;
                let expected = rays.origins_velo[beam] + rays.directions_velo[beam] * range_m;
                let [x, y, z, _] = scan.points_velo[i].map(f64::from);
                assert!((DVec3::new(x, y, z) - expected).abs().max_element() < 1.1e-3, "{expected} at {time_s}");
            }
        }
        let ideal = ideal_scan(&scene, &DPose3::IDENTITY, &spec);
        let off_m =
            (0..spec.num_beams()).map(|i| (f64::from(ideal.range_m[i]) - 20.0 / rays.directions_velo[i].x).abs());
        assert!(off_m.fold(0.0, f64::max) < 1e-4);
        assert!(spec.with_divergence(1e-3).expect_err("no neighbors").to_string().contains("divergence is 0.001"));
    }
    let [spec, ..] = paths();
    let still = scan(&scene, &DPose3::IDENTITY, &spec, &clear(), &mut Stream::from_seed("scan", 0));
    assert!(still.expect_err("no grid").to_string().contains("expected a sensor that spins"));
}

#[test]
fn boxes_of_a_raster_stand_where_its_lines_met_them() {
    let size_m = Vec3::new(2.0, 0.8, 0.8);
    // Met by the last lines, below the horizon.
    let pose = at(18.0, 1.0, -1.6);
    let motion = RigidMotion { pivot_world: pose.translation, ..moving(DVec3::new(0.0, 9.0, 0.0)) };
    let scene = posed(&[place(cuboid(size_m), pose, 1)]);
    let [spec, ..] = paths();
    let scan = turn(&scene, &spec, RigidMotion::default(), |_| motion);
    let points: Vec<DVec3> =
        scan.points_velo.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect();
    assert!(points.len() > 30);
    let seen = spec.seen_pose((&pose, &motion), (&DPose3::IDENTITY, &RigidMotion::default()));
    let late_m = seen.translation.y - pose.translation.y;
    let most_off_m = |box_pose: DPose3| {
        let off = |p: &DVec3| (box_pose.inverse().transform_point(*p).abs() - size_m.as_dvec3()).max_element();
        points.iter().map(off).fold(f64::MIN, f64::max)
    };
    assert!((0.1..0.45).contains(&late_m), "{late_m}");
    assert!(most_off_m(seen) < 0.6 * most_off_m(pose), "{} {}", most_off_m(seen), most_off_m(pose));
}

#[test]
fn trees_are_kept_while_their_meshes_are() {
    let instances = random_scene(&mut Stream::from_seed("trees", 0), DVec3::ZERO);
    let mut trees = FaceTrees::default();
    let spec = LidarSpec::cadet();
    let make = |scene: &Arc<PosedScene>, trees: &mut FaceTrees| {
        let rest = RigidMotion::default();
        let _ = SceneInMotion::new(Arc::clone(scene), trees, &spec, DPose3::IDENTITY, rest, |_| rest);
        trees.forget_unused();
        trees.len()
    };
    let scene = posed(&instances);
    let n = make(&scene, &mut trees);
    assert!(n > 20 && make(&scene, &mut trees) == n);
    drop((scene, instances));
    trees.forget_unused();
    assert!(trees.is_empty());
}
