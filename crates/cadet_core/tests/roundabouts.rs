//! Suburbs with roundabouts: can one drive on them?

#![allow(clippy::unwrap_used)]

mod drivable;

use cadet_core::math::wrap_angle;
use cadet_core::rng::StreamKey;
use cadet_core::town::{Lane, SuburbConfig, generate_suburb, load_map};
use drivable::assert_drivable;

/// How much a lane turns from beginning to end, to the left.
fn turned_rad(lane: &Lane) -> f64 {
    let ways = lane.center.windows(2).map(|w| {
        let d = w[1] - w[0];
        cadet_core::math::atan2(d.y, d.x)
    });
    ways.clone().zip(ways.skip(1)).map(|(a, b)| wrap_angle(b - a)).sum()
}

#[test]
fn suburbs_with_roundabouts_can_be_driven_for_ever() {
    let config = SuburbConfig { roundabout_share: 1.0, signal_share: 1.0, ..SuburbConfig::default() };
    let mut num_roundabouts = 0;
    for seed in 0..20 {
        let suburb = generate_suburb(&StreamKey::scene(seed), &config).unwrap();
        let (name, network) = (format!("suburb {seed}"), &suburb.network);
        assert_drivable(&name, network);
        assert_eq!(network.driving().filter(|l| l.successors.is_empty()).count(), 0, "{name}");
        num_roundabouts += network.roundabouts.len();
        for light in &network.lights {
            assert!(light.lanes.iter().all(|l| !network.ends_at_roundabout(network.lane(*l))), "{name}: a light");
        }
        for lane in network.driving().filter(|l| network.is_in_roundabout(l)) {
            // In and out to the right; whoever stays on goes round to the left by as much as is missing.
            let right = lane.center.windows(3).map(|w| (w[1] - w[0]).truncate().perp_dot((w[2] - w[1]).truncate()));
            assert!(right.fold(0.0, f64::min) < 0.0, "{name}: {:?} never bends to the right", lane.id);
            let width_m = lane.width_at(lane.length_m() / 2.0);
            let is_round = turned_rad(lane) > -1.0;
            assert!(!is_round || (4.4..5.1).contains(&width_m), "{name}: {width_m} m wide");
        }
        // The map says so by OpenDRIVE's groups of junctions, and without them they are junctions as others are.
        let plain = suburb.xodr.replace("type=\"roundabout\"", "type=\"complexJunction\"");
        let plain = load_map("plain", &plain).unwrap();
        assert!(plain.roundabouts.is_empty() && plain.lanes.len() == network.lanes.len(), "{name}");
    }
    assert!(num_roundabouts > 200, "{num_roundabouts}");
}

#[test]
fn without_roundabouts_a_suburb_stays_what_it_was() {
    let key = StreamKey::scene(3);
    let text = |roundabout_share: f64| {
        generate_suburb(&key, &SuburbConfig { roundabout_share, ..SuburbConfig::default() }).unwrap().xodr
    };
    assert!(!text(0.0).contains("junctionGroup") && text(0.5).contains("junctionGroup"));
    // Roads outside of junctions are the same but for their ends.
    let streets = |text: &str| text.matches("junction=\"-1\" rule=\"RHT\">\n<link><predecessor").count();
    assert_eq!(streets(&text(0.0)), streets(&text(0.5)));
}
