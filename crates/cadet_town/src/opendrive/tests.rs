//! Maps whose lights stand far from their junction, and whose junctions have ids that are alike.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::*;
use crate::network::RightOfWay;
use crate::signals::{Aspect, Signals};
use cadet_base::rng::StreamKey;

/// A road of one driving lane along x, which joins the roads `before` and `behind` it or, at its end, a junction.
struct Road<'a> {
    id: usize,
    at_m: DVec2,
    junction: &'a str,
    before: Option<usize>,
    behind: &'a str,
    inside: &'a str,
}

const ROAD_M: f64 = 20.0;

impl Road<'_> {
    fn write(&self, out: &mut String) {
        let Self { id, at_m: DVec2 { x, y }, junction, before, behind, inside } = self;
        let before = before.map_or(String::new(), |road| {
            format!("<predecessor elementType='road' elementId='{road}' contactPoint='end'/>")
        });
        write!(
            out,
            "<road id='{id}' length='{ROAD_M}' junction='{junction}'><link>{before}{behind}</link>\
             <planView><geometry s='0' x='{x}' y='{y}' hdg='0' length='{ROAD_M}'><line/></geometry></planView>\
             <lanes><laneSection s='0'><center><lane id='0' type='none'/></center><right><lane id='-1' type='driving'>\
             <link><predecessor id='-1'/><successor id='-1'/></link><width sOffset='0' a='3' b='0' c='0' d='0'/></lane>\
             </right></laneSection></lanes>{inside}</road>"
        )
        .expect("a string");
    }
}

/// A street of so many roads to a junction with one way through it, `y_m` to the left of the x axis; roads are
/// numbered from `first` on. Inside of the first road and of the one through the junction there is something.
fn street(out: &mut String, (first, num_roads): (usize, usize), y_m: f64, junction: &str, inside: [&str; 2]) {
    let at = |k: usize| DVec2::new(ROAD_M * k as f64, y_m);
    for k in 0..num_roads {
        let behind = if k + 1 < num_roads {
            format!("<successor elementType='road' elementId='{}' contactPoint='start'/>", first + k + 1)
        } else {
            format!("<successor elementType='junction' elementId='{junction}'/>")
        };
        let before = (k > 0).then(|| first + k - 1);
        let inside = if k == 0 { inside[0] } else { "" };
        Road { id: first + k, at_m: at(k), junction: "-1", before, behind: &behind, inside }.write(out);
    }
    let (through, exit) = (first + num_roads, first + num_roads + 1);
    let behind = format!("<successor elementType='road' elementId='{exit}' contactPoint='start'/>");
    let before = Some(through - 1);
    Road { id: through, at_m: at(num_roads), junction, before, behind: &behind, inside: inside[1] }.write(out);
    Road { id: exit, at_m: at(num_roads + 1), junction: "-1", before: None, behind: "", inside: "" }.write(out);
    write!(
        out,
        "<junction id='{junction}'><connection id='0' incomingRoad='{}' connectingRoad='{through}' contactPoint='start'>\
         <laneLink from='-1' to='-1'/></connection></junction>",
        through - 1
    )
    .expect("a string");
}

fn map(write: impl FnOnce(&mut String)) -> String {
    let mut out = "<OpenDRIVE><header revMajor='1' revMinor='7'/>".to_owned();
    write(&mut out);
    out + "</OpenDRIVE>"
}

fn signal(orientation: char, number: &str) -> String {
    format!(
        "<signals><signal s='3' t='-4' id='17' name='mast A' dynamic='yes' orientation='{orientation}' type='{number}' \
         country='OpenDRIVE' subtype='-1' value='-1'/></signals>"
    )
}

fn light(orientation: char) -> String {
    signal(orientation, "1000001")
}

#[test]
fn a_light_holds_the_lane_before_its_junction_however_many_pieces_lie_between() {
    for num_roads in [1, 2, 7, 30] {
        let text = map(|out| street(out, (1, num_roads), 0.0, "5", [&light('+'), ""]));
        let (network, warnings) = load_with_warnings("far.xodr", &text).expect("a map");
        assert!(warnings.is_empty(), "{warnings:?}");
        let held: Vec<LaneId> = network.lights.iter().flat_map(|l| l.lanes.clone()).collect();
        assert_eq!(held.len(), 1, "{num_roads} roads");
        let lane = network.lane(held[0]);
        let next = network.lane(lane.successors[0]);
        assert!(lane.junction.is_none() && next.junction.is_some(), "{num_roads} roads: {lane:?}");
    }
}

#[test]
fn lights_and_signs_hold_the_lane_before_the_junction_wherever_they_are_applied() {
    let read = |along: &str, in_junction: &str, controllers: &str| {
        let text = map(|out| {
            street(out, (1, 1), 0.0, "7", [along, in_junction]);
            out.push_str(controllers);
        });
        load("hand.xodr", &text).expect("a map")
    };
    let held = |network: &RoadNetwork| -> Vec<LaneId> { network.lights.iter().flat_map(|l| l.lanes.clone()).collect() };
    let controllers = "<controller id='1' name=''><control signalId='17' type=''/></controller>";
    let network = read(&light('+'), "", controllers);
    let before = network.driving().find(|l| l.junction.is_none() && !l.successors.is_empty());
    let before = before.expect("a lane that leads into the junction").id;
    assert_eq!(held(&network), [before]);
    assert!(network.lights[0].controller.is_some());
    // It is red at times, and green at others.
    let signals = Signals::of(&network, &StreamKey::scene(1));
    let shown: Vec<Option<Aspect>> = (0..200).map(|t| signals.aspect(before, f64::from(t))).collect();
    assert!(shown.contains(&Some(Aspect::Red)) && shown.contains(&Some(Aspect::Green)), "{shown:?}");
    // The same light applied from the way across.
    let applied = "<signals><signalReference s='0' t='0' id='17' orientation='+'/></signals>";
    let network = read(&light('-'), applied, "");
    assert!(held(&network).contains(&before), "{:?}", network.lights);
    // A stop sign is no light, and says who goes first.
    for (number, says) in [("205", RightOfWay::Yield), ("206", RightOfWay::Stop), ("306", RightOfWay::Priority)] {
        let network = read(&signal('+', number), "", "");
        assert!(network.lights.is_empty());
        let of = |lane| RightOfWay::of(network.lane(lane), &network, &Signals::default());
        assert_eq!(of(before), Some(says), "{number}");
    }
}

#[test]
fn a_light_that_holds_no_lane_is_named() {
    let text = map(|out| street(out, (1, 2), 0.0, "5", [&light('-'), ""]));
    let (network, warnings) = load_with_warnings("lost.xodr", &text).expect("a map");
    assert!(network.lights.is_empty());
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("lost.xodr: traffic light \"mast A\" at (3.0, -4.0) left out: "), "{warnings:?}");
}

#[test]
fn junctions_stay_apart_however_alike_their_ids_are() {
    // Of the last two pairs the 32-bit FNV-1a hashes are equal.
    for [a, b] in [["7", "07"], ["1", "+1"], ["costarring", "liquid"], ["declinate", "macallums"]] {
        let group = |id: &str| {
            format!(
                "<junctionGroup id='1' type='roundabout' name=''><junctionReference junction='{id}'/></junctionGroup>"
            )
        };
        let text = map(|out| {
            street(out, (1, 1), 0.0, a, [""; 2]);
            street(out, (11, 1), 60.0, b, [""; 2]);
            out.push_str(&group(b));
        });
        let network = load("alike.xodr", &text).expect("a map");
        let numbers: BTreeSet<u32> = network.lanes.iter().filter_map(|l| l.junction).collect();
        assert_eq!(numbers.len(), 2, "{a} and {b}");
        let round: Vec<f64> =
            network.lanes.iter().filter(|l| network.is_in_roundabout(l)).map(|l| l.center[0].y).collect();
        assert!(round.len() == 1 && round[0] > 50.0, "{a} and {b}: {round:?}");
    }
}
