//! The ground of generated and imported towns: does it carry what stands on it?

#![allow(clippy::print_stderr, clippy::unwrap_used)]

use std::collections::BTreeMap;

use cadet_core::math::{DVec2, DVec3};
use cadet_core::rng::{Stream, StreamKey};
use cadet_core::town::{
    Ground, GroundKind, LaneKind, RoadNetwork, Roughness, SuburbConfig, generate_suburb, load_map, parking_spots,
    walkways,
};

const CURB_M: f64 = 0.12;

fn hilly() -> SuburbConfig {
    SuburbConfig { hilly_share: 1.0, ..SuburbConfig::default() }
}

/// A few suburbs, flat and hilly, and the shared towns where they exist.
fn towns() -> Vec<(String, RoadNetwork)> {
    let mut towns = Vec::new();
    for seed in 0..3 {
        for (name, config) in [("gentle", SuburbConfig::default()), ("hilly", hilly())] {
            towns.push((format!("{name} {seed}"), generate_suburb(&StreamKey::scene(seed), &config).unwrap().network));
        }
    }
    for name in ["Town01.xodr", "Town02.xodr"] {
        let path = format!("{}/../../../shared/maps/{name}", env!("CARGO_MANIFEST_DIR"));
        match std::fs::read_to_string(&path) {
            Ok(text) => towns.push((name.to_owned(), load_map(name, &text).unwrap())),
            Err(e) => eprintln!("skipped: {path}: {e}"),
        }
    }
    towns
}

/// The ground as towns have it.
fn rough(network: &RoadNetwork) -> Ground {
    Ground::rough(network, &Roughness::new(&mut Stream::from_seed("roughness", 0))).unwrap()
}

#[test]
fn lanes_lie_on_the_ground_and_sidewalks_a_curb_above() {
    for (name, network) in towns() {
        let ground = rough(&network);
        let height = |p: DVec3| ground.height_at(p.x, p.y).unwrap();
        for lane in network.driving() {
            for p in &lane.center {
                assert_eq!(ground.kind_at(p.x, p.y), Some(GroundKind::Road), "{name} {p}");
                assert!((height(*p) - p.z).abs() < 0.02 + 0.03, "{name}: {} below lane at {p}", p.z - height(*p));
                assert!(ground.normal_at(p.x, p.y).unwrap().z > 0.99, "{name} {p}");
            }
        }
        // Where a sidewalk lane is really sidewalk (junctions of some maps run lanes across each other).
        let walks = network.lanes.iter().filter(|l| l.kind == LaneKind::Sidewalk && l.junction.is_none());
        let (mut on, mut all) = (0, 0);
        for p in walks.flat_map(|l| &l.center) {
            all += 1;
            on += usize::from(ground.kind_at(p.x, p.y) == Some(GroundKind::Sidewalk));
        }
        // At the ends of deep bays the curb swings by 5.5 m over 2.5 m, and sidewalks round these corners.
        assert!(f64::from(on as u32) > 0.98 * f64::from(all as u32), "{name}: {on} of {all}");
    }
}

#[test]
fn hills_have_the_slopes_of_the_streets_that_were_asked_for() {
    let (mut slopes, mut steepest) = (Vec::new(), 0.0_f64);
    for seed in 0..20 {
        for (config, most) in [(SuburbConfig::default(), 0.07), (hilly(), 0.07)] {
            let network = generate_suburb(&StreamKey::scene(seed), &config).unwrap().network;
            for lane in network.driving() {
                let n = lane.center.len();
                for i in 0..n.saturating_sub(6) {
                    let (a, b, c) = (lane.center[i], lane.center[i + 3], lane.center[i + 6]);
                    let (l1, l2) = ((b - a).truncate().length(), (c - b).truncate().length());
                    let (s1, s2) = ((b.z - a.z) / l1, (c.z - b.z) / l2);
                    assert!(s1.abs() < most, "seed {seed}: slope {s1} at {a}");
                    steepest = steepest.max(s1.abs());
                    slopes.push(s1);
                    // The vertical bend on streets that do not turn; turning on a slope bends too.
                    let turn = (b - a).truncate().normalize().perp_dot((c - b).truncate().normalize()).abs();
                    if turn < 0.005 && l1 + l2 > 8.0 {
                        assert!((s2 - s1).abs() / ((l1 + l2) / 2.0) < 1.0 / 300.0, "seed {seed}: bend at {b}");
                    }
                }
            }
        }
    }
    let sd = (slopes.iter().map(|s| s * s).sum::<f64>() / slopes.len() as f64).sqrt();
    assert!((0.008..0.025).contains(&sd), "sd of slopes {sd}");
    assert!(steepest > 0.05, "no hill street: {steepest}");
}

/// Edges used once, by whether they lie on the rim of the ground.
fn open_edges(ground: &Ground) -> (usize, usize) {
    let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for f in ground.faces.iter() {
        for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    let bounds = ground.vertices.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), v| {
        (lo.min(v.as_dvec3().truncate()), hi.max(v.as_dvec3().truncate()))
    });
    let on_rim = |i: u32| {
        let p = ground.vertices[i as usize].as_dvec3().truncate();
        (p - bounds.0).min_element() < 0.01 || (bounds.1 - p).min_element() < 0.01
    };
    let open = edges.iter().filter(|(_, n)| **n != 0).map(|(e, _)| on_rim(e.0) && on_rim(e.1));
    open.fold((0, 0), |(rim, inner), r| if r { (rim + 1, inner) } else { (rim, inner + 1) })
}

#[test]
fn the_surface_has_no_holes_and_curbs_close_its_steps() {
    for (name, network) in towns() {
        let ground = rough(&network);
        assert!(ground.faces.len() < 80_000, "{name}: {} faces", ground.faces.len());
        let (rim, inner) = open_edges(&ground);
        assert!(rim > 10 && inner == 0, "{name}: {inner} open edges inside, {rim} on the rim");
        let mut stream = Stream::from_seed("holes", 0);
        let lanes: Vec<DVec3> = network.driving().flat_map(|l| l.center.iter().copied()).collect();
        for _ in 0..20_000 {
            let p = lanes[stream.below(lanes.len())];
            let q = p.truncate() + DVec2::new(stream.range(-40.0, 40.0), stream.range(-40.0, 40.0));
            assert!(ground.height_at(q.x, q.y).is_some(), "{name}: nothing at {q}");
        }
    }
}

#[test]
fn a_curb_is_a_step_of_its_height_along_the_whole_carriageway() {
    let network = generate_suburb(&StreamKey::scene(1), &hilly()).unwrap().network;
    let ground = rough(&network);
    let mut steps = 0;
    for ring in ground.carriageway_outline() {
        for (i, a) in ring.iter().enumerate() {
            let b = ring[(i + 1) % ring.len()];
            let middle = (*a + b) / 2.0;
            let left = (b - *a).normalize().perp();
            let (inner, outer) = (middle + left * 0.02, middle - left * 0.02);
            let (low, high) =
                (ground.height_at(inner.x, inner.y).unwrap(), ground.height_at(outer.x, outer.y).unwrap());
            assert!((high - low - CURB_M).abs() < 0.01, "step of {} at {middle}", high - low);
            assert_eq!(ground.kind_at(inner.x, inner.y), Some(GroundKind::Road));
            assert_eq!(ground.kind_at(outer.x, outer.y), Some(GroundKind::Sidewalk));
            steps += 1;
        }
    }
    assert!(steps > 500, "{steps}");
}

#[test]
fn queries_agree_with_a_ray_from_above() {
    let network = generate_suburb(&StreamKey::scene(5), &hilly()).unwrap().network;
    let ground = rough(&network);
    let mut stream = Stream::from_seed("queries", 0);
    for _ in 0..300 {
        let (x, y) = (stream.range(-230.0, 230.0), stream.range(-230.0, 230.0));
        // Every triangle, in double precision, without the index.
        let hits = ground.faces.iter().filter_map(|f| {
            let [a, b, c] = f.map(|i| ground.vertices[i as usize].as_dvec3());
            let normal = (b - a).cross(c - a);
            let p = DVec3::new(x, y, a.z - (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z);
            let inside = |u: DVec3, v: DVec3| (v - u).truncate().perp_dot((p - u).truncate()) >= 0.0;
            (normal.z > 1e-9 && inside(a, b) && inside(b, c) && inside(c, a)).then_some(p.z)
        });
        let highest = hits.fold(f64::NEG_INFINITY, f64::max);
        let z = ground.height_at(x, y).unwrap();
        assert!((z - highest).abs() < 1e-6, "{z} {highest} at {x} {y}");
    }
    assert_eq!(ground.height_at(1e6, 0.0), None);
    assert_eq!(ground.height_at(f64::NAN, 0.0), None);
}

#[test]
fn visible_tiles_are_the_surface_and_paint_lies_just_above() {
    let network = generate_suburb(&StreamKey::scene(2), &SuburbConfig::default()).unwrap().network;
    let ground = rough(&network);
    let (mut surface, mut paint) = (0, 0);
    for tile in &ground.tiles {
        let mesh = &tile.shape.levels[0].1;
        for (corners, slot) in mesh.triangles() {
            assert!((slot as usize) < tile.palette.materials().len());
            let corners = corners.map(|p| p.as_dvec3() + tile.world_from_local.translation);
            if tile.palette.materials()[slot as usize].semantic == cadet_core::material::Semantic::RoadMarking {
                paint += 1;
                let p = (corners[0] + corners[1] + corners[2]) / 3.0;
                let above = p.z - ground.height_at(p.x, p.y).unwrap();
                assert!((0.0005..0.008).contains(&above), "paint {above} above the road at {p}");
                assert_eq!(ground.kind_at(p.x, p.y), Some(GroundKind::Road));
            } else {
                surface += 1;
            }
        }
    }
    assert_eq!(surface, ground.faces.len());
    assert!(paint > 100, "{paint}");
}

#[test]
fn people_walk_on_sidewalks_and_parked_cars_leave_the_lanes_free() {
    for (name, network) in towns() {
        let key = StreamKey::scene(0);
        let ground = rough(&network);
        let walks = walkways(&ground);
        let (mut on, mut all) = (0, 0);
        for walk in &walks {
            for pair in walk.center.windows(2) {
                assert!((pair[1] - pair[0]).truncate().length() <= 2.0, "{name}");
            }
            assert_eq!(walk.center.first(), walk.center.last(), "{name}: a loop");
            for p in &walk.center {
                all += 1;
                on += usize::from(ground.kind_at(p.x, p.y) == Some(GroundKind::Sidewalk));
                assert!((ground.height_at(p.x, p.y).unwrap() - p.z).abs() < 1e-9);
            }
        }
        assert!(walks.len() >= 4 && on == all, "{name}: {on} of {all} points of {} walks", walks.len());
        let spots = parking_spots(&network, &ground, &key);
        assert!(spots.len() > 100, "{name}: {} spots", spots.len());
        let driving: Vec<_> = network.driving().collect();
        for spot in spots.iter().step_by(7) {
            let pose = spot.world_from_spot;
            // The flank of a car 1.7 m wide in the middle of the spot, front and rear.
            for (x, y) in [(-2.0, 0.85), (0.0, 0.85), (2.0, 0.85)] {
                let p = pose.transform_point(DVec3::new(x, y, 0.0));
                let nearest = driving.iter().map(|l| l.project(p).1).fold(f64::INFINITY, f64::min);
                assert!(nearest > 1.58, "{name}: {nearest} m between lane and car at {p}");
            }
            assert!((pose.rotation * DVec3::Z).z > 0.98, "{name}");
        }
    }
}

#[test]
fn the_same_network_gives_the_same_ground() {
    let network = generate_suburb(&StreamKey::scene(9), &SuburbConfig::default()).unwrap().network;
    let (a, b) = (Ground::new(&network).unwrap(), Ground::new(&network).unwrap());
    assert_eq!((&a.vertices, &a.faces), (&b.vertices, &b.faces));
    assert!(a.tiles.iter().zip(&b.tiles).all(|(x, y)| x.shape.levels[0].1 == y.shape.levels[0].1));
}

#[test]
fn a_flat_ground_is_level_asphalt_with_a_road_across_it() {
    let ground = Ground::flat(100.0);
    let network = RoadNetwork::straight(150.0, 3.0);
    for lane in &network.lanes {
        assert!((lane.length_m() - 150.0).abs() < 1e-9);
        for p in &lane.center {
            assert_eq!(ground.height_at(p.x, p.y), Some(0.0));
            assert_eq!(ground.kind_at(p.x, p.y), Some(GroundKind::Road));
        }
        // Right-hand traffic: the road's middle is on the left.
        let pose = lane.pose_at(75.0);
        assert!((pose.transform_point(DVec3::new(0.0, 1.5, 0.0)).y).abs() < 1e-9);
    }
    assert_eq!(ground.normal_at(3.0, 4.0), Some(DVec3::Z));
    assert_eq!(ground.height_at(101.0, 0.0), None);
}

#[test]
fn the_smooth_surface_holds_the_lanes_within_2_cm_and_bumps_are_on_top_of_it() {
    for (name, network) in towns() {
        let (smooth, rough) = (Ground::new(&network).unwrap(), rough(&network));
        let (mut square, mut n) = (0.0, 0.0);
        for p in network.driving().flat_map(|l| &l.center) {
            let z = smooth.height_at(p.x, p.y).unwrap();
            assert!((z - p.z).abs() < 0.02, "{name} {p}");
            let bump = rough.height_at(p.x, p.y).unwrap() - z;
            assert!(bump.abs() < 0.046, "{name} {p} {bump}");
            (square, n) = (square + bump * bump, n + 1.0);
        }
        let rms_m = f64::sqrt(square / n);
        assert!((0.010..0.024).contains(&rms_m), "{name}: {rms_m}");
    }
}

#[test]
fn streets_fall_to_one_side_by_2_to_2_5_percent_and_crossings_lie_level() {
    let level = SuburbConfig { max_slope: 0.0, ..SuburbConfig::default() };
    let (mut left, mut right) = (0, 0);
    for seed in 0..4 {
        let network = generate_suburb(&StreamKey::scene(seed), &level).unwrap().network;
        let ground = Ground::new(&network).unwrap();
        let slope_at = |lane: &cadet_core::town::Lane, s_m: f64| {
            let pose = lane.pose_at(s_m);
            let half_m = lane.width_at(s_m) / 2.0;
            let height = |y: f64| {
                let p = pose.transform_point(DVec3::new(0.0, y, 0.0));
                ground.height_at(p.x, p.y).unwrap()
            };
            (height(0.6 * half_m) - height(-0.6 * half_m)) / (1.2 * half_m)
        };
        for lane in network.driving() {
            if lane.junction.is_some() {
                let slope = slope_at(lane, lane.length_m() / 2.0);
                assert!(slope.abs() < 0.008, "seed {seed}: crossing of slope {slope}");
            } else if lane.length_m() > 50.0 {
                let slope = slope_at(lane, lane.length_m() / 2.0);
                let (length_m, width_m) = (lane.length_m(), lane.width_at(lane.length_m() / 2.0));
                // Beside curbs the surface between two lanes' samples is a little flatter on wide streets.
                assert!((0.014..0.029).contains(&slope.abs()), "seed {seed}: {slope}, {length_m} m by {width_m} m");
                (left, right) = (left + i32::from(slope > 0.0), right + i32::from(slope < 0.0));
            }
        }
    }
    // Two lanes of a street fall one to its left and one to its right.
    assert!(left > 40 && right > 40, "{left} {right}");
}

#[test]
fn a_plane_fits_28_m_of_rough_road() {
    for seed in 0..6 {
        let config = if seed % 2 == 0 { SuburbConfig::default() } else { hilly() };
        let network = generate_suburb(&StreamKey::scene(seed), &config).unwrap().network;
        let ground = rough(&network);
        let (mut num_views, mut within_5_cm) = (0, 0);
        for lane in network.driving().filter(|l| l.junction.is_none() && l.length_m() > 45.0) {
            let pose = lane.pose_at(8.0);
            let ahead = (1..=14).flat_map(|x| [-1.0, 0.0, 1.0].map(|y| DVec3::new(2.0 * f64::from(x), y, 0.0)));
            let road = |p: &DVec3| ground.kind_at(p.x, p.y) == Some(GroundKind::Road);
            let places: Vec<DVec3> = ahead.map(|p| pose.transform_point(p)).filter(road).collect();
            if places.len() < 42 {
                continue;
            }
            num_views += 1;
            let rows: Vec<[f64; 4]> = places
                .iter()
                .map(|p| [p.x - places[0].x, p.y - places[0].y, 1.0, ground.height_at(p.x, p.y).unwrap()])
                .collect();
            let matrix = nalgebra::DMatrix::from_fn(rows.len(), 3, |i, j| rows[i][j]);
            let heights = nalgebra::DVector::from_fn(rows.len(), |i, _| rows[i][3]);
            let plane = matrix.clone().svd(true, true).solve(&heights, 1e-9).unwrap();
            let off = matrix * plane - heights;
            let rms_m = off.norm() / f64::sqrt(rows.len() as f64);
            // A crest of 1000 m radius is up to 5 cm off, and bumps come on top.
            assert!(rms_m < 0.035 && off.amax() < 0.08, "seed {seed}: {rms_m} {} at {}", off.amax(), places[0]);
            within_5_cm += usize::from(off.amax() < 0.05);
        }
        assert!(num_views > 10, "seed {seed}: {num_views}");
        assert!(within_5_cm * 10 >= num_views * 9, "seed {seed}: {within_5_cm} of {num_views}");
    }
}
