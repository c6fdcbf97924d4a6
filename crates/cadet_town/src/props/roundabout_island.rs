//! What stands on the islands of roundabouts and before them: a lawn with trees or shrubs, boards that point to the
//! right, and the signs of those who give way.

use crate::network::{Lane, LaneKind, RoadNetwork};
use crate::placement::Placer;
use cadet_assets::props::{ARROW_BOARD, ROUNDABOUT_SIGN, Shipped};
use cadet_assets::scenery::TreeKind;
use cadet_base::math::{DVec2, DVec3, TAU};
use cadet_base::plane::unit;
use cadet_base::rng::{Stream, StreamKey};

/// Boards stand so far inside of the curb, signs so far beside the lane and before its end.
const BOARD_INSET_M: f64 = 1.2;
const SIGN_BESIDE_M: f64 = 0.6;
const SIGN_BEFORE_M: f64 = 1.0;
/// Shrubs keep away from the curb, trees more.
const SHRUBS_INSET_M: f64 = 2.2;
const TREES_INSET_M: f64 = 4.0;
/// What grows: shrubs, trees, both, or the lawn alone.
const GROWTH: [f64; 4] = [0.3, 0.25, 0.25, 0.2];

/// An island as the map has it.
struct Island {
    center: DVec2,
    radius_m: f64,
}

/// Whether a median closes on itself, as around the middle of a roundabout.
pub(crate) fn is_island(lane: &Lane) -> bool {
    lane.kind == LaneKind::Median && lane.junction.is_none() && lane.is_closed()
}

impl Island {
    fn of(lane: &Lane) -> Self {
        let points = &lane.center[..lane.center.len() - 1];
        let center = points.iter().map(|p| p.truncate()).sum::<DVec2>() / points.len() as f64;
        let radius_m = (lane.center[0].truncate() - center).length() + lane.width_m[0] / 2.0;
        Self { center, radius_m }
    }

    /// A place anywhere on it, so far inside of its edge.
    fn place(&self, inset_m: f64, s: &mut Stream) -> DVec2 {
        let (around_rad, share) = (s.range(0.0, TAU), s.unit());
        self.center + unit(around_rad) * (self.radius_m - inset_m) * share.sqrt()
    }
}

/// Furnishes the roundabouts of a network; an imported map's as well.
pub(crate) fn furnish(key: &StreamKey, network: &RoadNetwork, greenery: f64, placer: &mut Placer) {
    let islands: Vec<Island> = network.lanes.iter().filter(|l| is_island(l)).map(Island::of).collect();
    for (i, island) in islands.iter().enumerate() {
        plant(island, greenery, &mut key.indexed("roundabout", i as u64), placer);
    }
    for lane in network.driving().filter(|l| network.ends_at_roundabout(l)) {
        announce(lane, &islands, placer);
    }
}

fn plant(island: &Island, greenery: f64, s: &mut Stream, placer: &mut Placer) {
    let growth = s.weighted(&GROWTH);
    let (shrubs, trees) = (s.poisson(9.0 * greenery), 1 + s.poisson(1.2 * greenery));
    let kind = if s.chance(0.3) { TreeKind::Conifer } else { TreeKind::Street };
    if greenery > 0.0 && matches!(growth, 1 | 2) {
        for _ in 0..trees {
            let at = island.place(TREES_INSET_M, s);
            placer.plant(kind, s, at);
        }
    }
    if matches!(growth, 0 | 2) {
        for _ in 0..shrubs {
            let at = island.place(SHRUBS_INSET_M, s);
            placer.plant(TreeKind::Shrub, s, at);
        }
    }
}

/// Before a lane's end a sign on its right, and a board on the island ahead of it.
fn announce(lane: &Lane, islands: &[Island], placer: &mut Placer) {
    let length_m = lane.length_m();
    let pose = lane.pose_at(length_m - SIGN_BEFORE_M);
    let (at, along) = (pose.translation.truncate(), (pose.rotation * DVec3::X).truncate().normalize_or(DVec2::X));
    let sign = at - along.perp() * (lane.width_at(length_m) / 2.0 + SIGN_BESIDE_M);
    let mut put = |kind: Shipped, place: DVec2| {
        let model = kind.model(0);
        placer.put_plain(&model, place, -along);
    };
    put(ROUNDABOUT_SIGN, sign);
    let distance = |i: &&Island| (i.center - at).length();
    if let Some(island) = islands.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))) {
        put(ARROW_BOARD, island.center - along * (island.radius_m - BOARD_INSET_M));
    }
}
