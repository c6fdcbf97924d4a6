//! Changing lanes: whether it is worth it and safe (MOBIL: Kesting, Treiber, Helbing 2007, with the European rules of
//! passing), and the way across.

use super::idm::IdmParameters;
use super::junction_ahead::next_junction;
use super::lane_view::{LaneView, Neighbor};
use crate::footprint::Footprint;
use crate::params::lane_change::{
    ACROSS_S, BEFORE_END_M, BEFORE_JUNCTION_M, CRITICAL_MPS, LEAST_GAP_M, LEAST_GAP_S, LEAST_MPS, OUTER_BIAS_MPS2,
    POLITENESS_FACTOR, SAFE_MPS2, STAY_S, STAYS_BEHIND_MPS2, THRESHOLD_MPS2,
};
use crate::params::{CRAWLS_MPS, LONG_M, LOOK_STEPS};
use crate::physics::DT_S;
use crate::slot::Slot;
use crate::streets::{LaneGraph, Route};
use crate::traffic_state::TrafficState;
use cadet_base::math::DVec3;
use cadet_town::LaneId;

/// Distance to the line in the old lane up to which a vehicle needs no change to return.
const HARDLY_LEFT_M: f64 = 0.4;
/// Looks between two decisions.
const LOOKS: u64 = 3;

/// What a gap takes off a driver's acceleration; nothing where the lane is free.
fn interaction_accel(idm: &IdmParameters, speed_mps: f64, leader: Option<Neighbor>) -> f64 {
    leader.map_or(0.0, |l| idm.interaction_accel(speed_mps, l.gap_m, l.speed_mps))
}

/// The interaction on a lane whose inner neighbor has `inner` ahead: nobody passes it on the outside at speed.
fn on_the_outside(own_mps2: f64, inner_mps2: f64, speed_mps: f64, inner: Option<Neighbor>) -> f64 {
    let must_stay = inner.is_some_and(|l| speed_mps > l.speed_mps && l.speed_mps > CRITICAL_MPS);
    if must_stay { own_mps2.min(inner_mps2) } else { own_mps2 }
}

/// What a change is worth to who changes, in m/s², with what it costs others: MOBIL's incentive over its threshold.
/// `stays` and `changed` are the own interactions before and after it, `follower` those of who is let go or cut in on.
/// `bias_mps2` is against it.
fn mobil_incentive(stays_mps2: f64, changed_mps2: f64, follower_mps2: (f64, f64), bias_mps2: f64) -> f64 {
    changed_mps2 - stays_mps2 + POLITENESS_FACTOR * (follower_mps2.1 - follower_mps2.0) - THRESHOLD_MPS2 - bias_mps2
}

/// Whether a gap is safe for both: MOBIL's criterion of safety, and room to spare.
fn is_safe(idm: &IdmParameters, speed_mps: f64, leader: Option<Neighbor>, follower: Option<Neighbor>) -> bool {
    let has_room = |gap_m: f64, behind_mps: f64| gap_m > LEAST_GAP_M + LEAST_GAP_S * behind_mps;
    let ahead = leader.is_none_or(|l| {
        has_room(l.gap_m, 0.5 * speed_mps) && idm.interaction_accel(speed_mps, l.gap_m, l.speed_mps) > -SAFE_MPS2
    });
    let behind = follower.is_none_or(|f| {
        has_room(f.gap_m, 0.5 * f.speed_mps) && idm.interaction_accel(f.speed_mps, f.gap_m, speed_mps) > -SAFE_MPS2
    });
    ahead && behind
}

/// The share of the way across at a share of its time: a quintic, at rest sideways at both ends.
fn share_across(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (10.0 - 15.0 * t + 6.0 * t * t)
}

/// On the way into another lane, which the route follows already.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LaneChange {
    /// Whether it leads toward the middle of the road.
    pub is_inward: bool,
    from_m: f64,
    to_m: f64,
    /// The share of its time that is over.
    share: f64,
    /// Whether it leads back to the lane that was to be left.
    returns: bool,
}

impl LaneChange {
    /// The offset from the new lane's middle after one more step, and whether that was the last. Who slows down or stops
    /// on the way takes longer: nobody moves sideways without going ahead.
    pub fn step(&mut self, speed_mps: f64) -> (f64, bool) {
        self.share += (speed_mps / LEAST_MPS).clamp(0.0, 1.0) * DT_S / ACROSS_S;
        let t = self.share;
        (self.from_m + (self.to_m - self.from_m) * share_across(t), t >= 1.0)
    }

    /// How far to the left of the line at an offset the new lane's line is.
    pub fn left_m(&self, offset_m: f64) -> f64 {
        self.to_m - offset_m
    }

    /// What the changer claims: its place in the new lane, whatever it still covers of the old one.
    pub fn claim(&self, own: &Footprint, route: &Route, graph: &LaneGraph) -> Footprint {
        let place = route.ahead(0.0, graph);
        let center = place.at + place.tangent.perp() * self.left_m(route.offset_m);
        Footprint { center, ..place.moved(own) }
    }
}

/// What a driver thinks of lanes from one decision to the next.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LaneChoice {
    pub change: Option<LaneChange>,
    /// What staying behind who is ahead on the inner lane takes off the acceleration.
    pub stays_behind_mps2: f64,
    next_change_step: u64,
}

/// A driver who decides on changing lanes.
pub(crate) struct Decider<'a> {
    pub slot: Slot,
    pub own: &'a Footprint,
    pub idm: &'a IdmParameters,
    /// The offset from the middle that the driver keeps in any lane.
    pub offset_m: f64,
}

impl LaneChoice {
    /// Looks at both neighbors of a lane that allows changes now and then, and begins a change where it is worth it and safe: then the route
    /// leads along the new lane.
    pub fn decide(&mut self, by: &Decider<'_>, route: &mut Route, around: &TrafficState, graph: &LaneGraph, step: u64) {
        // From the two lanes beside one, nobody decides at the same look.
        let lane = route.lanes[0];
        let from_curb = std::iter::successors(Some(lane), |id| graph.outer_of(*id)).count() as u64 % 3;
        if !(step / LOOK_STEPS + 2 * from_curb).is_multiple_of(LOOKS) {
            return;
        }
        let (inner, outer) = (graph.inner_of(lane), graph.outer_of(lane));
        self.stays_behind_mps2 = 0.0;
        let Decider { slot, own, idm, .. } = *by;
        let speed_mps = own.velocity.dot(own.heading).max(0.0);
        // Of two side by side, one who would cut in and one who brakes for it, neither would move: who has come to stand in
        // the first half of a change stays in the old lane after all.
        if let Some(change) = self.change
            && speed_mps < CRAWLS_MPS
            && change.share < 0.5
            && !change.returns
            && let Some(back) = if change.is_inward { outer } else { inner }
        {
            let from_m = route.change_to(back, graph);
            let returning =
                LaneChange { is_inward: !change.is_inward, from_m, to_m: by.offset_m, share: 0.0, returns: true };
            self.change = Some(returning).filter(|c| (c.to_m - c.from_m).abs() > HARDLY_LEFT_M);
            return;
        }
        let view = |lane: LaneId| {
            let here = route.ahead(0.0, graph).at;
            let (s_m, _) = graph.lane(lane).project(DVec3::new(here.x, here.y, 0.0));
            LaneView::of(lane, s_m, own.half_length_m, Some(slot), around, graph)
        };
        let here = LaneView::of(lane, route.s_m, own.half_length_m, Some(slot), around, graph);
        let own_mps2 = interaction_accel(idm, speed_mps, here.leader);
        let inner_view = inner.map(view);
        let inner_leader = inner_view.and_then(|v| v.leader);
        let inner_mps2 = interaction_accel(idm, speed_mps, inner_leader);
        let stays_mps2 = on_the_outside(own_mps2, inner_mps2, speed_mps, inner_leader);
        // A vehicle that is alongside already is not waited for.
        if !inner_view.is_some_and(|v| v.is_taken) && stays_mps2 < own_mps2 {
            self.stays_behind_mps2 = inner_mps2.max(-STAYS_BEHIND_MPS2);
        }
        // Long vehicles keep out of the innermost of three lanes, and in towns, where they would stand across two, to theirs.
        let is_long = 2.0 * own.half_length_m > LONG_M;
        if self.change.is_some()
            || (is_long && !graph.is_fast(lane))
            || step < self.next_change_step
            || speed_mps < LEAST_MPS
            || !has_way(route, speed_mps, graph)
        {
            return;
        }
        let leads_inward = |id: &LaneId| !is_long || graph.outer_of(lane).is_none() || graph.inner_of(*id).is_some();
        let bias_mps2 = if graph.is_fast(lane) { OUTER_BIAS_MPS2 } else { 0.0 };
        let targets = [
            inner.filter(leads_inward).zip(inner_view).map(|(id, v)| (id, v, true)),
            outer.map(|id| (id, view(id), false)),
        ];
        let mut best: Option<(LaneId, bool, f64)> = None;
        for (id, v, is_inward) in targets.into_iter().flatten() {
            if v.is_taken || !route.may_use(id, graph) || !is_safe(idm, speed_mps, v.leader, v.follower) {
                continue;
            }
            let changed_mps2 = interaction_accel(idm, speed_mps, v.leader);
            // Only who follows on the inner lane counts: nobody owes the outer one anything.
            let gain = if is_inward {
                mobil_incentive(stays_mps2, changed_mps2, between(&v, own, speed_mps, idm), bias_mps2)
            } else {
                let changed_mps2 = on_the_outside(changed_mps2, own_mps2, speed_mps, here.leader);
                let (without, with) = between(&here, own, speed_mps, idm);
                mobil_incentive(own_mps2, changed_mps2, (with, without), -bias_mps2)
            };
            if gain > 0.0 && best.is_none_or(|(.., most)| gain > most) {
                best = Some((id, is_inward, gain));
            }
        }
        if let Some((id, is_inward, _)) = best {
            let from_m = route.change_to(id, graph);
            self.change = Some(LaneChange { is_inward, from_m, to_m: by.offset_m, share: 0.0, returns: false });
            self.next_change_step = step + ((ACROSS_S + STAY_S) / DT_S) as u64;
        }
    }
}

/// What who follows in a lane has to brake without somebody between, and with.
fn between(view: &LaneView, own: &Footprint, speed_mps: f64, idm: &IdmParameters) -> (f64, f64) {
    let Some(f) = view.follower else { return (0.0, 0.0) };
    let over_m = f.gap_m + 2.0 * own.half_length_m;
    let without = view.leader.map_or(0.0, |l| idm.interaction_accel(f.speed_mps, over_m + l.gap_m, l.speed_mps));
    (without, idm.interaction_accel(f.speed_mps, f.gap_m, speed_mps))
}

/// Whether there is way enough before the next junction, or where the lanes end.
fn has_way(route: &Route, speed_mps: f64, graph: &LaneGraph) -> bool {
    let free_m = next_junction(route, graph, &|_| true).map_or(route.remaining_m(graph), |(_, m)| m);
    let rest_m = if graph.is_fast(route.lanes[0]) { BEFORE_END_M } else { BEFORE_JUNCTION_M };
    graph.lane(route.lanes[0]).junction.is_none() && free_m > (ACROSS_S + 1.0) * speed_mps + rest_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streets::LanePosition;
    use crate::tests::towns::long_main_roads;
    use cadet_base::rng::Stream;
    use cadet_town::Lane;

    const IDM: IdmParameters = IdmParameters {
        desired_speed_factor: 1.0,
        time_gap_s: 1.2,
        minimum_gap_m: 2.0,
        accel_mps2: 1.2,
        comfortable_mps2: 2.0,
        hardest_mps2: 7.0,
        top_speed_mps: f64::INFINITY,
    };

    fn neighbor(gap_m: f64, speed_mps: f64) -> Option<Neighbor> {
        Some(Neighbor { gap_m, speed_mps })
    }

    /// -a (s*/s)², s* = s0 + vT + v dv / (2 sqrt(ab)), with a = 1.2 and b = 2.0.
    fn idm_by_hand(speed_mps: f64, gap_m: f64, leader_mps: f64) -> f64 {
        let wanted_m = 2.0 + 1.2 * speed_mps + speed_mps * (speed_mps - leader_mps) / (2.0 * 2.4_f64.sqrt());
        -1.2 * wanted_m * wanted_m / (gap_m * gap_m)
    }

    #[test]
    fn incentives_are_those_of_mobil() {
        let truck = neighbor(90.0, 23.0);
        let own = interaction_accel(&IDM, 33.0, truck);
        assert!((own - idm_by_hand(33.0, 90.0, 23.0)).abs() < 1e-12 && interaction_accel(&IDM, 33.0, None) == 0.0);
        // To the left: a' - a + p (n' - n) > threshold + bias. To the right the bias helps.
        let follower = (-0.2, -0.9);
        let expected = -own + 0.25 * (-0.9 + 0.2) - 0.1;
        assert!((mobil_incentive(own, 0.0, follower, 0.3) - (expected - 0.3)).abs() < 1e-12);
        assert!((mobil_incentive(own, 0.0, follower, -0.3) - (expected + 0.3)).abs() < 1e-12);
        // On a free road one keeps right, and does not leave the right lane.
        let bias_mps2 = OUTER_BIAS_MPS2;
        let on_free_road = |bias_mps2: f64| mobil_incentive(0.0, 0.0, (0.0, 0.0), bias_mps2);
        assert!(on_free_road(-bias_mps2) > 0.0 && on_free_road(bias_mps2) < 0.0);
    }

    #[test]
    fn gaps_are_safe_where_idm_brakes_no_harder_than_allowed() {
        for speed_mps in [15.0, 25.0, 35.0] {
            for other_mps in [15.0, 25.0, 35.0, 42.0] {
                for gap_m in [5.0, 15.0, 30.0, 60.0, 120.0, 240.0] {
                    let ahead = is_safe(&IDM, speed_mps, neighbor(gap_m, other_mps), None);
                    let behind = is_safe(&IDM, speed_mps, None, neighbor(gap_m, other_mps));
                    // A faster vehicle ahead asks for no more than the usual gap.
                    let by_hand = |v: f64, leader_mps: f64| idm_by_hand(v, gap_m, leader_mps) > -2.0;
                    let room = |v: f64| gap_m > 3.0 + 0.55 * 0.5 * v;
                    let name = format!("{speed_mps} {other_mps} {gap_m}");
                    if other_mps <= speed_mps {
                        assert_eq!(ahead, by_hand(speed_mps, other_mps) && room(speed_mps), "{name}");
                    }
                    if other_mps >= speed_mps {
                        assert_eq!(behind, by_hand(other_mps, speed_mps) && room(other_mps), "{name}");
                    }
                }
            }
        }
        assert!(is_safe(&IDM, 30.0, None, None));
    }

    #[test]
    fn nobody_gains_by_passing_on_the_right_at_speed() {
        let left = neighbor(40.0, 25.0);
        assert_eq!(on_the_outside(0.0, -1.4, 33.0, left), -1.4);
        // Slower traffic than 60 km/h may be passed, and who is slower than the left lane does not care.
        assert_eq!(on_the_outside(0.0, -1.4, 33.0, neighbor(40.0, 15.0)), 0.0);
        assert_eq!(on_the_outside(0.0, -1.4, 24.0, left), 0.0);
    }

    #[test]
    fn the_way_across_begins_and_ends_at_rest_with_bounded_jerk() {
        let mut change = LaneChange { is_inward: true, from_m: -3.75, to_m: 0.1, share: 0.0, returns: false };
        let mut offsets = vec![-3.75];
        loop {
            let (offset_m, is_over) = change.step(9.0);
            offsets.push(offset_m);
            if is_over {
                break;
            }
        }
        let differences = |v: &[f64]| v.windows(2).map(|w| (w[1] - w[0]) / DT_S).collect::<Vec<f64>>();
        let speeds = differences(&offsets);
        let accelerations = differences(&speeds);
        let jerks = differences(&accelerations);
        let most = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // Of the quintic over T: 15/8 d/T, 5.774 d/T², 60 d/T³.
        let (d, t) = (3.85, ACROSS_S);
        assert!((most(&speeds) - 1.875 * d / t).abs() < 0.01, "{}", most(&speeds));
        assert!((most(&accelerations) - 5.7735 * d / (t * t)).abs() < 0.02, "{}", most(&accelerations));
        assert!(most(&jerks) < 60.5 * d / (t * t * t), "{}", most(&jerks));
        assert!(
            (3.0..5.0).contains(&(offsets.len() as f64 * DT_S)) && (offsets[offsets.len() - 1] - 0.1).abs() < 1e-12
        );
        assert!(speeds[0].abs() < 0.01 && speeds[speeds.len() - 1].abs() < 0.01);
    }

    #[test]
    fn who_stops_on_the_way_across_goes_no_farther_sideways() {
        let mut change = LaneChange { is_inward: false, from_m: 3.1, to_m: 0.0, share: 0.0, returns: false };
        let mut go = |speed_mps: f64, steps: u32| (0..steps).map(|_| change.step(speed_mps).0).last().unwrap();
        let begun_m = go(5.0, 60);
        assert!(begun_m > 2.5 && begun_m < 3.1, "{begun_m}");
        assert_eq!(go(0.0, 600), begun_m, "stands");
        assert_eq!(go(-0.1, 60), begun_m, "rocks on its springs");
        let (slow_m, steps) = (go(1.0, 60), 60.0);
        // No more than a third of the way that is gone ahead.
        assert!((begun_m - slow_m) < 1.0 * steps * DT_S / 3.0, "{begun_m} {slow_m}");
        assert_eq!(go(5.0, 600), 0.0);
    }

    #[test]
    fn who_has_come_to_stand_early_in_a_change_stays_in_the_old_lane() {
        let graph = LaneGraph::new(long_main_roads(1));
        let is_right = |l: &&Lane| l.junction.is_none() && graph.inner_of(l.id).is_some() && l.length_m() > 60.0;
        let old = graph.lanes().iter().find(is_right).expect("a lane beside another");
        let stands_after = |share: f64, speed_mps: f64| {
            let at = LanePosition { lane: old.id, s_m: 20.0, left_m: 0.0 };
            let mut route = Route::new(at, 1.0, Stream::from_seed("change", 1), &graph);
            let begun = route.ahead(0.0, &graph);
            let from_m = route.change_to(graph.inner_of(old.id).unwrap(), &graph);
            route.offset_m = from_m * (1.0 - share_across(share));
            let own = begun.covered_by(DVec3::new(4.4, 1.8, 1.5), speed_mps);
            let change = Some(LaneChange { is_inward: true, from_m, to_m: 0.0, share, returns: false });
            let mut choice = LaneChoice { change, ..LaneChoice::default() };
            let decider = Decider { slot: 0, own: &own, idm: &IDM, offset_m: 0.0 };
            for step in 0..LOOKS * LOOK_STEPS {
                choice.decide(&decider, &mut route, &TrafficState::new(&graph), &graph, step);
            }
            let is_back = route.lanes[0] == old.id;
            assert!(choice.change.is_none_or(|change| change.is_inward != is_back && change.returns == is_back));
            // The line does not jump.
            let line = route.ahead(0.0, &graph).at;
            assert!((line - begun.at).length() < (from_m * share_across(share)).abs() + 0.05, "{line}");
            is_back
        };
        assert!(stands_after(0.2, 0.0) && stands_after(0.45, 0.0));
        assert!(!stands_after(0.2, 3.0), "goes on");
        assert!(!stands_after(0.7, 0.0), "is nearly there");
    }
}
