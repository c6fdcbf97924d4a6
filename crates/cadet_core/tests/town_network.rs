//! Road networks, imported and generated: can one drive on them?

#![allow(clippy::print_stderr, clippy::unwrap_used)]

mod drivable;

use cadet_core::math::DVec3;
use cadet_core::rng::{Stream, StreamKey};
use cadet_core::town::{Ground, Lane, LaneKind, RoadNetwork, SuburbConfig, generate_suburb, load_map};
use drivable::assert_drivable;

/// The text of a map that is not part of the repository; `None`, with a reason printed, where it is missing.
fn shared_map(name: &str) -> Option<String> {
    let path = format!("{}/../../../shared/maps/{name}", env!("CARGO_MANIFEST_DIR"));
    match std::fs::read_to_string(&path) {
        Ok(text) => Some(text),
        Err(e) => {
            eprintln!("skipped: {path}: {e}");
            None
        }
    }
}

#[test]
fn shared_towns_can_be_driven() {
    for name in ["Town01.xodr", "Town02.xodr"] {
        let Some(text) = shared_map(name) else { return };
        let network = load_map(name, &text).unwrap();
        assert_drivable(name, &network);
        assert!(network.lanes.iter().any(|l| l.kind == LaneKind::Sidewalk));
    }
}

#[test]
fn what_is_no_map_is_refused_by_name() {
    let header = "<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/></OpenDRIVE>";
    let walk = "<OpenDRIVE><header/><road id=\"1\" length=\"9\" junction=\"-1\"><planView><geometry s=\"0\" x=\"0\" y=\"0\" \
                hdg=\"0\" length=\"9\"><line/></geometry></planView><lanes><laneSection s=\"0\"><right><lane id=\"-1\" \
                type=\"sidewalk\"><width sOffset=\"0\" a=\"2\" b=\"0\" c=\"0\" d=\"0\"/></lane></right></laneSection>\
                </lanes></road></OpenDRIVE>";
    let (unreadable, refused) = ("broken.xodr:1: not readable as XML: ", "broken.xodr: ");
    for (text, start) in
        [("", unreadable), ("hello", unreadable), ("<svg/>", refused), (header, refused), (walk, refused)]
    {
        let error = load_map("broken.xodr", text).unwrap_err().to_string();
        assert!(error.starts_with(start), "{error}");
    }
    assert!(load_map("walk.xodr", walk).unwrap_err().to_string().contains("driving"));
}

#[test]
fn suburbs_can_be_driven_for_ever() {
    for seed in 0..20 {
        let suburb = generate_suburb(&StreamKey::scene(seed), &SuburbConfig::default()).unwrap();
        assert_drivable(&format!("suburb {seed}"), &suburb.network);
        let dead_ends = suburb.network.driving().filter(|l| l.successors.is_empty()).count();
        assert_eq!(dead_ends, 0, "suburb {seed}");
    }
}

#[test]
fn main_roads_can_be_driven_for_ever_on_every_lane() {
    let (mut with_median, mut with_two) = (0, 0);
    for seed in 0..20 {
        let config = SuburbConfig { main_share: 1.0, ..SuburbConfig::default() };
        let network = generate_suburb(&StreamKey::scene(seed), &config).unwrap().network;
        assert_drivable(&format!("suburb {seed}"), &network);
        assert_eq!(network.driving().filter(|l| l.successors.is_empty()).count(), 0, "suburb {seed}");
        with_median += usize::from(network.lanes.iter().any(|l| l.kind == LaneKind::Median));
        let lanes_of = |road: u32| network.driving().filter(|l| l.road == road && l.junction.is_none()).count();
        let widest = network.lanes.iter().map(|l| lanes_of(l.road)).max().unwrap();
        with_two += usize::from(widest >= 4);
        // Every suburb has a street that is faster than 30 km/h.
        assert!(widest >= 4 || network.lanes.iter().any(|l| l.kind == LaneKind::Median), "suburb {seed}");
    }
    assert!(with_median >= 8 && with_two >= 8, "{with_median} with a median, {with_two} with two lanes a direction");
}

#[test]
fn country_roads_can_be_driven_for_ever_between_their_verges() {
    let mut with_edge_lines = 0;
    for seed in 0..20 {
        let config = SuburbConfig {
            country_share: 1.0,
            blocks: (2, 2),
            block_m: (200.0, 320.0),
            main_share: 1.0,
            tram_share: 1.0,
            ..SuburbConfig::default()
        };
        let network = generate_suburb(&StreamKey::scene(seed), &config).unwrap().network;
        let name = format!("country {seed}");
        assert_drivable(&name, &network);
        assert_eq!(network.driving().filter(|l| l.successors.is_empty()).count(), 0, "{name}");
        assert!(network.is_rural(), "{name}");
        for lane in network.driving().filter(|l| l.junction.is_none()) {
            let of_road =
                |kind: LaneKind| network.lanes.iter().filter(|l| l.road == lane.road && l.kind == kind).count();
            assert_eq!((of_road(LaneKind::Driving), of_road(LaneKind::Verge)), (2, 2), "{name}");
            let (width_m, kmh) = (lane.width_at(5.0), lane.speed_limit_mps * 3.6);
            assert!((2.7..=3.6).contains(&width_m) && (49.0..=81.0).contains(&kmh), "{name}: {width_m} m, {kmh} km/h");
            // An edge line lies a quarter of a meter inside of the asphalt's edge.
            let inside_m = |mark: &cadet_core::town::PaintedQuad| {
                let middle = mark.corners.iter().sum::<DVec3>() / 4.0;
                let (s_m, off_m) = lane.project(middle);
                let is_beside = s_m > 1.0 && s_m < lane.length_m() - 1.0;
                (is_beside && off_m < width_m / 2.0).then_some(width_m / 2.0 - off_m)
            };
            let edge: Vec<f64> = network.lane_marks.iter().filter_map(inside_m).collect();
            let elsewhere = edge.iter().find(|m| **m >= 0.02 && (**m - 0.25).abs() >= 0.02);
            assert!(elsewhere.is_none(), "{name}: a line {elsewhere:?} m inside of the edge");
            with_edge_lines += usize::from(edge.iter().any(|m| *m > 0.2));
        }
        for lane in network.lanes.iter().filter(|l| l.kind == LaneKind::Verge && l.junction.is_none()) {
            assert!((1.0..=1.7).contains(&lane.width_at(5.0)), "{name}: a verge of {} m", lane.width_at(5.0));
        }
    }
    assert!(with_edge_lines > 100, "{with_edge_lines}");
}

#[test]
fn motorways_can_be_driven_for_ever_on_every_lane() {
    let (mut with_three, mut bypasses) = (0, 0);
    for seed in 0..20 {
        let config = SuburbConfig { motorway_share: 1.0, main_share: 1.0, ..SuburbConfig::default() };
        let network = generate_suburb(&StreamKey::scene(seed), &config).unwrap().network;
        let name = format!("motorway {seed}");
        assert_drivable(&name, &network);
        assert!(network.is_motorway() && network.lanes.iter().all(|l| l.junction.is_none()), "{name}");
        for lane in network.driving() {
            // A lane leads to one other, of the same width, and round to itself.
            assert_eq!((lane.successors.len(), lane.predecessors.len()), (1, 1), "{name}");
            let (mut at, mut roads) = (network.lane(lane.successors[0]), 1);
            while at.id != lane.id {
                (at, roads) = (network.lane(at.successors[0]), roads + 1);
                assert!(roads < 100 && (at.width_at(1.0) - lane.width_at(1.0)).abs() < 1e-3, "{name}");
            }
            let (width_m, kmh) = (lane.width_at(5.0), lane.speed_limit_mps * 3.6);
            assert!((3.49..3.76).contains(&width_m) && (99.0..131.0).contains(&kmh), "{name}: {width_m} m, {kmh} km/h");
            let steepest = lane.center.windows(2).map(|w| ((w[1].z - w[0].z) / (w[1] - w[0]).length()).abs());
            assert!(steepest.fold(0.0, f64::max) < 0.045, "{name}");
        }
        let of_road = |kind: LaneKind| network.lanes.iter().filter(|l| l.road == 0 && l.kind == kind).count();
        assert_eq!((of_road(LaneKind::Median), of_road(LaneKind::Verge)), (2, 2), "{name}");
        with_three += usize::from(of_road(LaneKind::Driving) == 6);
        let shoulder = network.lanes.iter().filter(|l| l.kind == LaneKind::Shoulder).map(|l| l.width_at(5.0));
        bypasses += usize::from(shoulder.fold(0.0, f64::max) < 1.0);
    }
    assert!(with_three >= 3 && bypasses >= 3, "{with_three} {bypasses}");
}

#[test]
fn roads_with_tracks_can_be_driven_for_ever_and_tracks_go_on_to_the_last_junction() {
    let mut with_tracks = 0;
    for seed in 0..30 {
        let config = SuburbConfig { main_share: 1.0, tram_share: 1.0, ..SuburbConfig::default() };
        let network = generate_suburb(&StreamKey::scene(seed), &config).unwrap().network;
        assert_drivable(&format!("suburb {seed}"), &network);
        assert_eq!(network.driving().filter(|l| l.successors.is_empty()).count(), 0, "suburb {seed}");
        if network.tracks().next().is_none() {
            continue;
        }
        with_tracks += 1;
        let is_track = |l: &&Lane| l.kind == LaneKind::Tram;
        let streets = network.lanes.iter().filter(is_track).filter(|l| l.junction.is_none());
        let ends = streets.clone().filter(|l| l.successors.is_empty()).count();
        let begins = streets.clone().filter(|l| l.predecessors.is_empty()).count();
        // A line is two tracks, and there are at most two lines.
        assert!(ends == begins && (ends == 2 || ends == 4), "suburb {seed}: {ends} ends, {begins} beginnings");
        for lane in network.lanes.iter().filter(is_track) {
            for next in lane.successors.iter().map(|n| network.lane(*n)) {
                let gap_m = (lane.center[lane.center.len() - 1] - next.center[0]).length();
                assert!(gap_m < 0.01 && next.kind == LaneKind::Tram, "suburb {seed}: {gap_m} m between two tracks");
            }
            // Room for two trams beside each other.
            assert!(lane.width_m.iter().all(|w| (3.15..3.6).contains(w)), "suburb {seed}: {:?}", lane.width_m);
            if lane.junction.is_none() {
                assert!(lane.surface.name().is_some(), "suburb {seed}: {:?}", lane.surface);
                assert!(lane.length_m() > 5.0, "suburb {seed}: {} m from {}", lane.length_m(), lane.center[0]);
            }
        }
    }
    assert!(with_tracks >= 12, "{with_tracks} of 30");
}

#[test]
fn the_tracks_of_a_map_are_read_whatever_they_are_called() {
    let config = SuburbConfig { main_share: 1.0, tram_share: 1.0, ..SuburbConfig::default() };
    let suburbs = (0..20).map(|seed| generate_suburb(&StreamKey::scene(seed), &config).unwrap());
    let suburb = suburbs.into_iter().find(|s| s.network.tracks().next().is_some()).expect("a suburb with tracks");
    let renamed = load_map("rail", &suburb.xodr.replace("type=\"tram\"", "type=\"rail\"")).unwrap();
    let kinds = |n: &RoadNetwork| n.lanes.iter().map(|l| (l.kind, l.surface, l.successors.len())).collect::<Vec<_>>();
    assert_eq!(kinds(&renamed), kinds(&suburb.network));
}

#[test]
fn aisles_commercial_streets_and_campuses_can_be_driven_for_ever() {
    let base = SuburbConfig { blocks: (3, 3), block_m: (90.0, 140.0), ..SuburbConfig::default() };
    let places = [
        SuburbConfig { aisle_share: 0.8, ..base.clone() },
        SuburbConfig { industrial_share: 1.0, ..base.clone() },
        SuburbConfig { campus_share: 1.0, ..base },
    ];
    let mut deep_bays = 0;
    for (place, seed) in (0..3).flat_map(|place| (0..14).map(move |seed| (place, seed))) {
        let network = generate_suburb(&StreamKey::scene(seed), &places[place]).unwrap().network;
        let name = format!("place {place}, seed {seed}");
        assert_drivable(&name, &network);
        assert_eq!(network.driving().filter(|l| l.successors.is_empty()).count(), 0, "{name}");
        for lane in network.driving().filter(|l| l.junction.is_none()) {
            let (width_m, kmh) = (2.0 * lane.width_at(lane.length_m() / 2.0), lane.speed_limit_mps * 3.6);
            match place {
                0 if kmh < 25.0 => assert!((width_m - 6.0).abs() < 0.01, "{name}: an aisle of {width_m} m"),
                0 => {}
                1 => assert!((6.5..=7.5).contains(&width_m) && kmh > 49.0, "{name}: {width_m} m, {kmh} km/h"),
                _ => assert!((4.5..=5.0).contains(&width_m) && kmh < 21.0, "{name}: {width_m} m, {kmh} km/h"),
            }
        }
        assert_eq!(network.is_curbless(), place == 2, "{name}");
        let is_deep = |l: &&Lane| l.kind == LaneKind::Parking && l.width_m.iter().any(|w| (w - 5.0).abs() < 0.01);
        deep_bays += if place == 0 { network.lanes.iter().filter(is_deep).count() } else { 0 };
        // Without curbs the ground is as high beside a lane as on it.
        if place == 2 {
            let ground = Ground::new(&network).unwrap();
            let lane = network.driving().find(|l| l.junction.is_none() && l.length_m() > 20.0).unwrap();
            let at = |right_m: f64| {
                let p = lane.pose_at(10.0).transform_point(DVec3::new(0.0, -right_m, 0.0));
                ground.height_at(p.x, p.y).unwrap()
            };
            let half_m = lane.width_at(10.0) / 2.0;
            assert!((at(half_m - 0.2) - at(half_m + 0.4)).abs() < 0.04, "{name}: a curb");
        }
    }
    assert!(deep_bays > 60, "{deep_bays}");
}

#[test]
fn without_main_roads_a_suburb_has_none() {
    let network = generate_suburb(&StreamKey::scene(1), &SuburbConfig::default()).unwrap().network;
    assert!(network.lanes.iter().all(|l| l.kind != LaneKind::Median));
}

#[test]
fn suburbs_differ_by_key_and_by_nothing_else() {
    let make = |seed| generate_suburb(&StreamKey::scene(seed), &SuburbConfig::default()).unwrap().xodr;
    assert_eq!(make(3), make(3));
    assert_ne!(make(3), make(4));
}

#[test]
fn every_allowed_suburb_can_be_driven_and_has_a_ground() {
    let extremes = [
        SuburbConfig { blocks: (2, 2), block_m: (60.0, 60.0), ..SuburbConfig::default() },
        SuburbConfig {
            blocks: (2, 6),
            block_m: (60.0, 75.0),
            max_slope: 0.1,
            hilly_share: 1.0,
            ..SuburbConfig::default()
        },
        SuburbConfig { blocks: (3, 3), block_m: (150.0, 250.0), parking_share: 1.0, ..SuburbConfig::default() },
        SuburbConfig { blocks: (6, 5), parking_share: 0.0, max_slope: 0.0, ..SuburbConfig::default() },
        SuburbConfig { country_share: 1.0, blocks: (2, 3), block_m: (60.0, 60.0), ..SuburbConfig::default() },
        SuburbConfig {
            country_share: 1.0,
            blocks: (2, 2),
            block_m: (350.0, 350.0),
            hilly_share: 1.0,
            ..SuburbConfig::default()
        },
    ];
    for (number, config) in extremes.iter().enumerate() {
        for seed in 0..5 {
            let suburb = generate_suburb(&StreamKey::scene(seed), config).unwrap();
            assert_drivable(&format!("extreme {number}, seed {seed}"), &suburb.network);
            let ground = Ground::new(&suburb.network).unwrap();
            for p in suburb.network.driving().flat_map(|l| l.center.iter().step_by(5)) {
                let z = ground.height_at(p.x, p.y).unwrap();
                assert!((z - p.z).abs() < 0.025, "extreme {number}, seed {seed}: {z} at {p}");
            }
        }
    }
}

#[test]
fn suburbs_outside_their_limits_are_refused_by_name() {
    let fine = SuburbConfig::default;
    for (config, what) in [
        (SuburbConfig { blocks: (1, 4), ..fine() }, "blocks"),
        (SuburbConfig { blocks: (4, 13), ..fine() }, "blocks"),
        (SuburbConfig { block_m: (59.0, 80.0), ..fine() }, "block_m"),
        (SuburbConfig { block_m: (90.0, 80.0), ..fine() }, "block_m"),
        (SuburbConfig { block_m: (f64::NAN, 80.0), ..fine() }, "block_m"),
        (SuburbConfig { parking_share: 1.1, ..fine() }, "parking_share"),
        (SuburbConfig { hilly_share: f64::NAN, ..fine() }, "hilly_share"),
        (SuburbConfig { max_slope: 0.2, ..fine() }, "max_slope"),
    ] {
        let error = generate_suburb(&StreamKey::scene(0), &config).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
}

#[test]
fn traffic_keeps_to_the_right() {
    let mut networks = vec![generate_suburb(&StreamKey::scene(0), &SuburbConfig::default()).unwrap().network];
    networks.extend(shared_map("Town01.xodr").map(|text| load_map("Town01.xodr", &text).unwrap()));
    for network in networks {
        let streets: Vec<&Lane> = network.driving().filter(|l| l.junction.is_none() && l.length_m() > 10.0).collect();
        for lane in &streets {
            let pose = lane.pose_at(lane.length_m() / 2.0);
            let left = pose.transform_point(DVec3::new(0.0, lane.width_at(lane.length_m() / 2.0), 0.0));
            let nearest = |o: &&&Lane| o.project(left).1;
            let beside = streets.iter().filter(|o| o.id != lane.id).min_by(|a, b| nearest(a).total_cmp(&nearest(b)));
            let oncoming = beside.unwrap().pose_at(beside.unwrap().project(left).0);
            assert!((oncoming.translation - left).truncate().length() < 0.5);
            assert!((oncoming.rotation * DVec3::X).dot(pose.rotation * DVec3::X) < -0.95, "{left}");
        }
    }
}

#[test]
fn damaged_maps_are_refused_or_read_but_never_panic() {
    let small = SuburbConfig { blocks: (2, 2), ..SuburbConfig::default() };
    let text = generate_suburb(&StreamKey::scene(0), &small).unwrap().xodr;
    let mut stream = Stream::from_seed("damage", 0);
    let mut refused = 0;
    for round in 0..80 {
        let mut bytes = text.clone().into_bytes();
        match round % 4 {
            0 => bytes.truncate(stream.below(bytes.len())),
            1 => {
                for _ in 0..20 {
                    let at = stream.below(bytes.len());
                    bytes[at] = b"0123456789-.e<>/\"x"[stream.below(18)];
                }
            }
            _ => {
                let values = ["NaN", "1e300", "-7", "", "1e-300", "999999"];
                let quotes: Vec<usize> =
                    (0..bytes.len() - 1).filter(|i| bytes[*i] == b'=' && bytes[i + 1] == b'"').collect();
                for _ in 0..3 {
                    let at = quotes[stream.below(quotes.len())] + 2;
                    let end = (at..bytes.len()).find(|i| bytes[*i] == b'"').unwrap_or(at);
                    let value = values[stream.below(values.len())].as_bytes();
                    // Same length, so that the other places stay where they are.
                    for i in at..end {
                        bytes[i] = value.get(i - at).copied().unwrap_or(b' ');
                    }
                }
            }
        }
        let damaged = String::from_utf8_lossy(&bytes);
        match load_map("damaged.xodr", &damaged) {
            Ok(network) => {
                assert!(network.driving().next().is_some());
                // Lanes torn apart still have a ground, or a reason why not.
                if let Err(error) = Ground::new(&network) {
                    assert!(error.to_string().contains("network"), "{error}");
                }
            }
            Err(error) => {
                refused += 1;
                let message = error.to_string();
                let place = message.split(": ").next().unwrap_or("");
                let line = place.strip_prefix("damaged.xodr").expect("the file");
                let is_line = line.strip_prefix(':').is_some_and(|n| n.parse::<usize>().is_ok());
                assert!(line.is_empty() || is_line, "{message}");
            }
        }
    }
    assert!(refused > 20, "{refused}");
}
