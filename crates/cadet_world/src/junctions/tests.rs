//! Tests of who goes first at crossings: by the rules of the road, whatever the order in which requests stand.

use super::*;
use crate::lane_use::LaneUse;
use crate::params::LOOK_STEPS;
use crate::slot::Slot;
use crate::streets::LaneGraph;
use crate::tests::towns::crossing;
use cadet_base::math;
use cadet_base::plane::unit;
use cadet_town::RightOfWay;

const EAST: f64 = 0.0;
const NORTH: f64 = 0.5 * math::PI;
const WEST: f64 = math::PI;
const SOUTH: f64 = -0.5 * math::PI;

/// The crossing of four streets, and the way across it of who comes heading so and turns so.
struct Crossing(LaneGraph);

impl Crossing {
    fn new() -> Self {
        Self(LaneGraph::new(crossing()))
    }

    fn request(&self, slot: Slot, heading_rad: f64, turn: Turn, right_of_way: RightOfWay) -> Request {
        let heading = unit(heading_rad);
        let is_way = |l: &&cadet_town::Lane| {
            l.junction.is_some()
                && l.start_tangent().dot(heading) > 0.7
                && Turn::of(l.curb_side() * l.turn_rad()) == turn
        };
        let lane = self.0.lanes().iter().find(is_way).expect("a way across");
        let (heading, right_of_way) = (lane.start_tangent(), Some(right_of_way));
        Request { heading, turn, right_of_way, ..Request::of_car(slot, &[lane.id]) }
    }

    /// The vehicles that may go after one look at requests, whatever their order.
    fn first(&self, requests: &[Request]) -> Vec<Slot> {
        let mut order: Vec<Request> = requests.to_vec();
        let mut all = Vec::new();
        for _ in 0..order.len() {
            order.rotate_left(1);
            let mut junctions = Junctions::new(&self.0);
            junctions.resolve(&order, &LaneUse::default(), &self.0, 0);
            let mut holding: Vec<Slot> = requests.iter().map(|r| r.slot).filter(|s| junctions.holds_any(*s)).collect();
            holding.sort_unstable();
            all.push(holding);
        }
        assert!(all.windows(2).all(|w| w[0] == w[1]), "by order: {all:?}");
        all.swap_remove(0)
    }
}

#[test]
fn who_comes_from_the_right_goes_first_among_equals() {
    let (town, first) = (Crossing::new(), RightOfWay::RightFirst);
    let request = |slot, heading| town.request(slot, heading, Turn::Straight, first);
    // Northbound traffic comes from the right of who goes east.
    assert_eq!(town.first(&[request(1, EAST), request(2, NORTH)]), [2]);
    assert_eq!(town.first(&[request(1, EAST), request(2, SOUTH)]), [1]);
    // Of four that come from each other's right one goes, and with it who comes toward it.
    let four = [EAST, NORTH, WEST, SOUTH].map(|heading| request((heading * 10.0) as usize + 40, heading));
    assert!(!town.first(&four).is_empty());
    // A vehicle that is far off is not waited for.
    let far = Request { arrives_s: 9.0, ..request(2, NORTH) };
    assert_eq!(town.first(&[request(1, EAST), far]), [1]);
}

#[test]
fn who_has_to_give_way_waits_for_who_would_arrive_before_it_is_over() {
    let town = Crossing::new();
    let minor = |right_of_way| town.request(1, EAST, Turn::Straight, right_of_way);
    for sign in [RightOfWay::Yield, RightOfWay::Stop] {
        for heading in [NORTH, SOUTH] {
            for (arrives_s, goes) in [(0.0, false), (5.9, false), (6.1, true)] {
                let comes = town.request(2, heading, Turn::Straight, RightOfWay::Priority);
                let major = Request { arrives_s, stage: Stage::Comes, ..comes };
                let going = if goes { vec![1] } else { vec![] };
                assert_eq!(town.first(&[minor(sign), major]), going, "{sign:?} {heading} {arrives_s} s");
            }
        }
    }
    // After a while it goes when its turn comes.
    let mut junctions = Junctions::new(&town.0);
    let major = Request { stage: Stage::Comes, ..town.request(2, NORTH, Turn::Straight, RightOfWay::Priority) };
    let waited = (0..2000).step_by(LOOK_STEPS as usize).find(|step| {
        junctions.resolve(&[minor(RightOfWay::Yield), major.clone()], &LaneUse::default(), &town.0, *step);
        junctions.holds_any(1)
    });
    assert!(waited.is_some_and(|step| (1000..1200).contains(&step)), "{waited:?}");
}

#[test]
fn who_turns_across_lets_oncoming_traffic_go_first() {
    let town = Crossing::new();
    // From every side: what comes first by its lane's number alone would not do.
    for (heading, toward) in [(EAST, WEST), (NORTH, SOUTH), (WEST, EAST), (SOUTH, NORTH)] {
        for right_of_way in [RightOfWay::Signal, RightOfWay::Priority, RightOfWay::RightFirst] {
            let turns = town.request(1, heading, Turn::Across, right_of_way);
            for turn in [Turn::Straight, Turn::Near] {
                let first = town.first(&[turns.clone(), town.request(2, toward, turn, right_of_way)]);
                assert_eq!(first, [2], "{heading}, {turn:?}");
            }
            // Two who turn across each other's way pass in front of each other, or one after the other.
            assert!(!town.first(&[turns.clone(), town.request(2, toward, Turn::Across, right_of_way)]).is_empty());
        }
    }
}

#[test]
fn nobody_waits_for_who_may_not_go_itself() {
    let town = Crossing::new();
    let request = |slot, heading| town.request(slot, heading, Turn::Straight, RightOfWay::RightFirst);
    let waits = Request { stage: Stage::Waits, ..request(2, NORTH) };
    assert_eq!(town.first(&[request(1, EAST), waits.clone()]), [1]);
    // A light that changes takes the way across back.
    let mut junctions = Junctions::new(&town.0);
    junctions.resolve(&[request(2, NORTH)], &LaneUse::default(), &town.0, 0);
    assert!(junctions.holds_any(2));
    junctions.resolve(&[request(1, EAST), waits], &LaneUse::default(), &town.0, 3);
    assert!(junctions.holds_any(1) && !junctions.holds_any(2));
}
