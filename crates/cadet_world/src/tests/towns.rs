//! Small towns for the tests: a hilly ring, a slope, a crossing.

use std::sync::Arc;

use cadet_base::math::{self, DVec2, DVec3, TAU, Vec3};
use cadet_base::plane::unit;
use cadet_base::rng::StreamKey;
use cadet_town::{Ground, Lane, LaneId, LaneKind, LaneSurface, PropConfig, RoadNetwork, SuburbConfig, Town, Walkway};

/// A grid of ground over [-half, half]² with height `z(x, y)`.
pub(crate) fn ground(half_m: f64, step_m: f64, z: &dyn Fn(f64, f64) -> f64) -> Ground {
    let n = (2.0 * half_m / step_m).round() as u32;
    let at = |i: u32| f64::from(i) * step_m - half_m;
    let mut vertices = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            vertices.push(Vec3::new(at(i) as f32, at(j) as f32, z(at(i), at(j)) as f32));
        }
    }
    let mut faces = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            faces.push([a, a + 1, a + n + 2]);
            faces.push([a, a + n + 2, a + n + 1]);
        }
    }
    Ground::flat(half_m).with_surface(vertices, faces)
}

/// Adds a driving lane along points of the plane.
pub(crate) fn lane(
    network: &mut RoadNetwork,
    points: &[DVec2],
    junction: Option<u32>,
    z: &dyn Fn(f64, f64) -> f64,
) -> LaneId {
    let center: Vec<DVec3> = points.iter().map(|p| DVec3::new(p.x, p.y, z(p.x, p.y))).collect();
    let mut s = 0.0;
    let mut s_m = vec![0.0];
    for pair in center.windows(2) {
        s += (pair[1] - pair[0]).length();
        s_m.push(s);
    }
    let id = LaneId(network.lanes.len());
    network.lanes.push(Lane {
        id,
        kind: LaneKind::Driving,
        surface: LaneSurface::Usual,
        width_m: vec![3.0; center.len()],
        center,
        s_m,
        successors: Vec::new(),
        predecessors: Vec::new(),
        junction,
        road: id.0 as u32,
        speed_limit_mps: 30.0 / 3.6,
        keeps_left: false,
    });
    id
}

pub(crate) fn join(network: &mut RoadNetwork, from: LaneId, to: LaneId) {
    network.lanes[from.0].successors.push(to);
    network.lanes[to.0].predecessors.push(from);
}

/// Points along an arc (counter-clockwise for a positive turn), at most 1.5 m apart.
pub(crate) fn arc(middle: DVec2, radius_m: f64, from_rad: f64, turn_rad: f64) -> Vec<DVec2> {
    let n = (radius_m * turn_rad.abs() / 1.5).ceil() as i32;
    (0..=n).map(|i| from_rad + turn_rad * f64::from(i) / f64::from(n)).map(|a| middle + unit(a) * radius_m).collect()
}

pub(crate) fn line(a: DVec2, b: DVec2) -> Vec<DVec2> {
    let n = ((b - a).length() / 1.5).ceil() as i32;
    (0..=n).map(|i| a.lerp(b, f64::from(i) / f64::from(n))).collect()
}

pub(crate) fn town(network: RoadNetwork, ground: Ground, walkways: Vec<Walkway>) -> Arc<Town> {
    Arc::new(Town {
        name: "test".to_owned(),
        network,
        ground,
        scenery: Vec::new(),
        parking: Vec::new(),
        walkways,
        obstacles: Vec::new(),
        seats: Vec::new(),
        signals: cadet_town::Signals::default(),
        map_warnings: Vec::new(),
    })
}

/// A plane of the given slope along x, with one straight lane.
pub(crate) fn slope(rise_per_m: f64) -> Arc<Town> {
    let z = move |x: f64, _: f64| rise_per_m * x;
    let mut network = RoadNetwork::default();
    lane(&mut network, &line(DVec2::new(-90.0, 0.0), DVec2::new(90.0, 0.0)), None, &z);
    town(network, ground(100.0, 5.0, &z), Vec::new())
}

/// Height of the hilly ring's ground: a long and a short wave, up to about 6 %.
pub(crate) fn hills(x: f64, y: f64) -> f64 {
    1.5 * math::sin(x / 25.0) + 0.8 * math::cos(y / 18.0)
}

/// Two lanes round a ring of about 300 m, in both directions, over hills; each in two halves.
pub(crate) fn hilly_ring() -> Arc<Town> {
    let mut network = RoadNetwork::default();
    for (radius, turn) in [(49.5, TAU / 2.0), (46.5, -TAU / 2.0)] {
        let a = lane(&mut network, &arc(DVec2::ZERO, radius, 0.0, turn), None, &hills);
        let b = lane(&mut network, &arc(DVec2::ZERO, radius, math::PI, turn), None, &hills);
        join(&mut network, a, b);
        join(&mut network, b, a);
    }
    let walkways = [54.0, 42.0]
        .map(|r| {
            let center = arc(DVec2::ZERO, r, 0.0, TAU).iter().map(|p| p.extend(hills(p.x, p.y))).collect();
            Walkway { center, width_m: 2.0 }
        })
        .to_vec();
    town(network, ground(80.0, 1.0, &hills), walkways)
}

/// Four arms of 70 m that meet in one junction, each with a turning loop at its far end.
pub(crate) fn crossing() -> Arc<Town> {
    let flat = |_: f64, _: f64| 0.0;
    let mut network = RoadNetwork::default();
    let (near, far, half) = (10.0, 80.0, 1.5);
    let turned = |p: DVec2, quarter: i32| {
        let a = f64::from(quarter) * math::PI / 2.0;
        unit(a).rotate(p)
    };
    let arm = |points: Vec<DVec2>, quarter| points.into_iter().map(|p| turned(p, quarter)).collect::<Vec<_>>();
    let (mut inward, mut outward) = (Vec::new(), Vec::new());
    let mut walkways = Vec::new();
    for q in 0..4 {
        let out = arm(line(DVec2::new(near, -half), DVec2::new(far, -half)), q);
        let back = arm(line(DVec2::new(far, half), DVec2::new(near, half)), q);
        let mut bulb = line(DVec2::new(far, -half), DVec2::new(far + 10.0, -half - 4.5));
        bulb.pop();
        bulb.extend(arc(DVec2::new(far + 10.0, 0.0), 6.0, -math::PI / 2.0, math::PI));
        bulb.pop();
        bulb.extend(line(DVec2::new(far + 10.0, half + 4.5), DVec2::new(far, half)));
        let out = lane(&mut network, &out, None, &flat);
        let turn = lane(&mut network, &arm(bulb, q), None, &flat);
        let back = lane(&mut network, &back, None, &flat);
        join(&mut network, out, turn);
        join(&mut network, turn, back);
        inward.push(back);
        outward.push(out);
        for y in [-4.8, 4.8] {
            let center = arm(line(DVec2::new(near, y), DVec2::new(far, y)), q).iter().map(|p| p.extend(0.0)).collect();
            walkways.push(Walkway { center, width_m: 2.0 });
        }
    }
    for q in 0..4_usize {
        // Coming in along arm 0 toward -x at y = +half: straight on to arm 2, right to arm 1, left to arm 3.
        let straight = line(DVec2::new(near, half), DVec2::new(-near, half));
        let right = arc(DVec2::new(near, near), near - half, -math::PI / 2.0, -math::PI / 2.0);
        let left = arc(DVec2::new(near, -near), near + half, math::PI / 2.0, math::PI / 2.0);
        for (points, to) in [(straight, 2), (right, 1), (left, 3)] {
            let id = lane(&mut network, &arm(points, q as i32), Some(1), &flat);
            join(&mut network, inward[q], id);
            join(&mut network, id, outward[(q + to) % 4]);
        }
    }
    town(network, ground(110.0, 5.0, &flat), walkways)
}

/// A generated suburb with ground, parking places and sidewalks, without props.
pub(crate) fn suburb(seed: u64) -> Arc<Town> {
    unfurnished(seed, &SuburbConfig::default())
}

/// A generated suburb all of whose faster streets are main roads.
pub(crate) fn main_roads(seed: u64) -> Arc<Town> {
    unfurnished(seed, &SuburbConfig { blocks: (2, 2), main_share: 1.0, ..Default::default() })
}

/// Main roads whose junctions are far apart.
pub(crate) fn long_main_roads(seed: u64) -> Arc<Town> {
    let block_m = (130.0, 160.0);
    unfurnished(seed, &SuburbConfig { blocks: (2, 2), main_share: 1.0, block_m, ..Default::default() })
}

/// A commercial area, all of whose streets, or most by odd seeds, have cycle lanes, with main roads and lights at some
/// junctions.
pub(crate) fn cycle_lanes(seed: u64) -> Arc<Town> {
    let config = SuburbConfig {
        blocks: (2, 2),
        main_share: 0.5,
        signal_share: 0.5,
        industrial_share: 1.0,
        cycle_lane_share: if seed.is_multiple_of(2) { 1.0 } else { 0.6 },
        ..Default::default()
    };
    bare(seed, &config, PropConfig::default())
}

/// Roads in open country, with its ditches and fields.
pub(crate) fn country_roads(seed: u64) -> Arc<Town> {
    let config = SuburbConfig { country_share: 1.0, blocks: (2, 2), block_m: (180.0, 260.0), ..Default::default() };
    with_props(seed, &config, &PropConfig { greenery: 0.0, ..Default::default() })
}

/// Car parks (0), a commercial area (1), or a campus (2), with all that stands there but plants.
pub(crate) fn place(kind: usize, seed: u64) -> Arc<Town> {
    let (suburb, props) =
        (SuburbConfig { blocks: (2, 2), block_m: (100.0, 140.0), ..Default::default() }, PropConfig::default());
    let (suburb, props) = match kind {
        0 => (SuburbConfig { aisle_share: 0.75, ..suburb }, PropConfig { car_park_share: 0.9, ..props }),
        1 => (SuburbConfig { industrial_share: 1.0, ..suburb }, PropConfig { industrial_share: 0.95, ..props }),
        _ => (SuburbConfig { campus_share: 1.0, ..suburb }, PropConfig { campus_share: 0.95, ..props }),
    };
    bare(seed, &suburb, props)
}

/// A motorway or a bypass, without what grows beside it.
pub(crate) fn motorway(seed: u64) -> Arc<Town> {
    let config = SuburbConfig { motorway_share: 1.0, ..Default::default() };
    with_props(seed, &config, &PropConfig { greenery: 0.0, ..Default::default() })
}

/// Main roads with the tracks of a tram wherever they may be.
pub(crate) fn tram_roads(seed: u64) -> Arc<Town> {
    let tracked = SuburbConfig { main_share: 1.0, tram_share: 1.0, ..Default::default() };
    unfurnished(seed, &SuburbConfig { blocks: (4, 2), block_m: (85.0, 130.0), ..tracked })
}

/// Main roads with tracks between their carriageways.
pub(crate) fn tram_main_roads(seed: u64) -> Arc<Town> {
    unfurnished(seed, &SuburbConfig { main_share: 1.0, tram_share: 1.0, blocks: (3, 2), ..Default::default() })
}

/// A suburb without plants and what surrounds it.
pub(crate) fn bare(seed: u64, suburb: &SuburbConfig, props: PropConfig) -> Arc<Town> {
    with_props(seed, suburb, &PropConfig { greenery: 0.0, belt_m: 0.0, ..props })
}

fn with_props(seed: u64, suburb: &SuburbConfig, props: &PropConfig) -> Arc<Town> {
    Arc::new(Town::suburb(&StreamKey::scene(seed), suburb, props).expect("a town"))
}

fn unfurnished(seed: u64, suburb: &SuburbConfig) -> Arc<Town> {
    let key = StreamKey::scene(seed);
    without_props(&key, cadet_town::generate_suburb(&key, suburb).expect("a suburb").network)
}

/// One of the shared maps, where they are at hand.
pub(crate) fn map(name: &str) -> Option<Arc<Town>> {
    let path = format!("{}/../../../shared/maps/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).ok()?;
    Some(without_props(&StreamKey::scene(0), cadet_town::load_map(name, &text).expect("a map")))
}

fn without_props(key: &StreamKey, network: RoadNetwork) -> Arc<Town> {
    let ground = Ground::new(&network).expect("a ground");
    let parking = cadet_town::parking_spots(&network, &ground, key);
    let walkways = cadet_town::walkways(&ground);
    let mut town = Arc::unwrap_or_clone(town(network, ground, walkways));
    town.parking = parking;
    Arc::new(town)
}
