//! Places to park: bays of the map, half on the sidewalk where bays are too narrow for a car, and stretches of curb
//! beside lanes wide enough.

use crate::ground::{Ground, GroundKind};
use crate::network::{AISLE_KMH, Lane, LaneKind, PaintColor, PaintedQuad, ParkingSpot, RoadNetwork, SpotKind};
use cadet_base::frames;
use cadet_base::math::{self, DPose3, DVec2, DVec3};
use cadet_base::plane::heading_rad;
use cadet_base::rng::{Stream, StreamKey};

/// Distance between the middles of spots: drawn per row.
const PITCH_M: (f64, f64) = (5.2, 6.0);
/// Bays narrower than this are tapering off, or for cars that stand half on the sidewalk.
const MIN_BAY_M: f64 = 1.8;
/// The narrowest bay for those, and where they stand: distance of their left flank from the middle of the lane.
const MIN_HALF_BAY_M: f64 = 0.7;
const HALF_BAY_FLANK_M: f64 = 1.65;
const HALF_BAY_SPOT_WIDTH_M: f64 = 1.65;
/// No curbside parking this near to the end of a lane.
const CLEAR_OF_JUNCTION_M: f64 = 10.0;
/// Distance of a curbside car's left flank from the middle of the lane beside it.
const CLEAR_OF_LANE_M: f64 = 1.65;
/// Room for a car in width; in a bay it lies toward the curb.
const SPOT_WIDTH_M: f64 = 1.9;
const TYRE_TO_CURB_M: f64 = 0.1;
/// A curbside car stands on the sidewalk with at most this much of its width, and people pass in what is left.
const MAX_ON_SIDEWALK_M: f64 = 1.3;
const LEFT_FOR_WALKERS_M: f64 = 0.9;
/// Bays at least this deep are for cars at an angle: 45, 60 or 90 degrees by these weights, noses to the curb.
const MIN_DEEP_BAY_M: f64 = 4.5;
const ANGLES_DEG: [(f64, f64); 3] = [(45.0, 0.35), (60.0, 0.25), (90.0, 0.4)];
/// Length and width of a place in a deep bay.
const ANGLED_SPOT_M: (f64, f64) = (4.75, 1.9);
const ANGLED_PITCH_M: f64 = 2.45;
/// Angles of cars by weights, a place, and the spacing of places at the aisles of car parks, with the lines between the
/// bays (EAR 05: bays of 2.5 m).
const AISLE_ANGLES_DEG: [(f64, f64); 3] = [(90.0, 0.75), (60.0, 0.15), (75.0, 0.1)];
const AISLE_SPOT_M: (f64, f64) = (5.0, 1.9);
const AISLE_PITCH_M: f64 = 2.5;
const LINE_WIDTH_M: f64 = 0.12;
const LINE_INSET_M: f64 = 0.2;
/// Their numbers are beyond those of the map's lines.
const LINES: u32 = 1 << 28;
const NOSE_TO_CURB_M: f64 = 0.25;
/// Curbside rows need curbs this straight over a car's length, bays this straight.
const MAX_TURN_RAD: f64 = 0.06;
const MAX_TURN_IN_BAY_RAD: f64 = 0.16;

/// Where cars may be parked: in the map's bays, and at the curb of wide lanes without bays.
#[must_use]
pub fn parking_spots(network: &RoadNetwork, ground: &Ground, key: &StreamKey) -> Vec<ParkingSpot> {
    let of_lane = |lane: &Lane| {
        let (pitch_m, mut stream) = pitch_and_stream(key, lane);
        match lane.kind {
            LaneKind::Parking if lane.width_m.iter().all(|w| *w < MIN_BAY_M) => {
                half_bays(lane, network, ground, pitch_m)
            }
            LaneKind::Parking if is_deep(lane) => angled_bays(lane, ground, &mut stream),
            LaneKind::Parking => bays(lane, ground, pitch_m),
            LaneKind::Driving if lane.junction.is_none() && !has_cycle_lane(network, lane) => {
                curbside(lane, ground, pitch_m)
            }
            _ => Vec::new(),
        }
    };
    network.lanes.iter().flat_map(of_lane).collect()
}

/// The spacing of parallel places along a lane, and the stream that all else of them is drawn from.
fn pitch_and_stream(key: &StreamKey, lane: &Lane) -> (f64, Stream) {
    let mut stream = key.indexed("town/parking", lane.id.0 as u64);
    (stream.within(PITCH_M), stream)
}

/// Whether a lane for bicycles lies beside a lane.
fn has_cycle_lane(network: &RoadNetwork, lane: &Lane) -> bool {
    let middle = lane.pose_at(lane.length_m() / 2.0);
    let is_beside = |o: &&Lane| {
        let (s_m, off_m) = o.project(middle.translation);
        off_m < (o.width_at(s_m) + lane.width_at(lane.length_m() / 2.0)) / 2.0 + 0.1
    };
    network.lanes.iter().filter(|o| o.kind == LaneKind::Biking && o.road == lane.road).any(|o| is_beside(&o))
}

/// Where along a lane spots have their middles: as many as find room where it is at least so wide.
fn row(lane: &Lane, min_width_m: f64, pitch_m: f64) -> Vec<f64> {
    let wide = |s: &f64| lane.width_at(*s) >= min_width_m;
    let reach: Vec<f64> = lane.s_m.iter().copied().filter(wide).collect();
    let (Some(from), Some(to)) = (reach.first(), reach.last()) else { return Vec::new() };
    let count = ((to - from) / pitch_m).floor() as usize;
    let margin = (to - from - count as f64 * pitch_m) / 2.0;
    let middles = (0..count).map(|k| from + margin + (k as f64 + 0.5) * pitch_m);
    middles.filter(|s| turn_at(lane, *s, pitch_m) <= MAX_TURN_IN_BAY_RAD).collect()
}

fn half_bays(lane: &Lane, network: &RoadNetwork, ground: &Ground, pitch_m: f64) -> Vec<ParkingSpot> {
    let side = lane.curb_side();
    let widest = lane.width_m.iter().copied().fold(MIN_HALF_BAY_M, f64::max);
    let half_bay = |s: f64| {
        let pose = lane.pose_at(s);
        let beside = network.driving().filter(|l| l.road == lane.road).map(|l| l.project(pose.translation).1);
        let out = HALF_BAY_FLANK_M + HALF_BAY_SPOT_WIDTH_M / 2.0 - beside.fold(f64::INFINITY, f64::min);
        let edge = pose.transform_point(DVec3::new(0.0, side * (out + HALF_BAY_SPOT_WIDTH_M / 2.0), 0.0));
        // Where there is no sidewalk to climb, nobody parks.
        let has_sidewalk = out.abs() <= 2.0 && ground.kind_at(edge.x, edge.y) == Some(GroundKind::Sidewalk);
        let laid = || spot(ground, SpotKind::Parallel, &pose, side * out, (pitch_m, HALF_BAY_SPOT_WIDTH_M));
        has_sidewalk.then(laid).flatten()
    };
    row(lane, widest - 0.02, pitch_m).into_iter().filter_map(half_bay).collect()
}

fn bays(lane: &Lane, ground: &Ground, pitch_m: f64) -> Vec<ParkingSpot> {
    let bay = |s: f64| {
        let width_m = SPOT_WIDTH_M.min(lane.width_at(s));
        let out = ((lane.width_at(s) - width_m) / 2.0 - TYRE_TO_CURB_M).max(0.0);
        spot(ground, SpotKind::Parallel, &lane.pose_at(s), lane.curb_side() * out, (pitch_m, width_m))
    };
    row(lane, MIN_BAY_M, pitch_m).into_iter().filter_map(bay).collect()
}

/// Whether a lane's bays are for cars at an angle.
fn is_deep(lane: &Lane) -> bool {
    lane.kind == LaneKind::Parking && lane.width_m.iter().any(|w| *w >= MIN_DEEP_BAY_M)
}

/// Whether a lane's bays are those of a car park's aisle.
fn is_at_aisle(lane: &Lane) -> bool {
    is_deep(lane) && lane.speed_limit_mps * 3.6 < f64::from(AISLE_KMH) + 1.0
}

/// The angle of cars to the curb, and the distance from one to the next along it.
fn angle_and_pitch(lane: &Lane, stream: &mut Stream) -> (f64, f64) {
    let is_at_aisle = is_at_aisle(lane);
    let angles = if is_at_aisle { AISLE_ANGLES_DEG } else { ANGLES_DEG };
    let angle_rad = stream.pick(&angles).to_radians();
    let pitch_m = if is_at_aisle { AISLE_PITCH_M } else { ANGLED_PITCH_M };
    (angle_rad, pitch_m / math::sin(angle_rad))
}

/// The lines between the bays of aisles; their heights do not count.
pub(crate) fn bay_lines(network: &RoadNetwork, key: &StreamKey) -> Vec<PaintedQuad> {
    let mut lines = Vec::new();
    for lane in network.lanes.iter().filter(|l| is_at_aisle(l)) {
        let (_, mut stream) = pitch_and_stream(key, lane);
        let (angle_rad, pitch_m) = angle_and_pitch(lane, &mut stream);
        let middles = row(lane, MIN_DEEP_BAY_M, pitch_m);
        let starts = middles.iter().map(|s| s - pitch_m / 2.0);
        let is_last = |s: &f64| middles.iter().all(|o| (o - s - pitch_m).abs() > 0.1);
        let ends = middles.iter().filter(|s| is_last(s)).map(|s| s + pitch_m / 2.0);
        for s in starts.chain(ends) {
            let pose = lane.pose_at(s);
            let forward = (pose.rotation * DVec3::X).truncate().normalize_or_zero();
            let width_m = lane.width_at(s) - LINE_INSET_M;
            let heading = forward * math::cos(angle_rad) + forward.perp() * (lane.curb_side() * math::sin(angle_rad));
            let (middle, half) = (pose.translation.truncate(), heading * (width_m / 2.0 / math::sin(angle_rad)));
            let aside = heading.perp() * (LINE_WIDTH_M / 2.0);
            let corners = [middle - half - aside, middle + half - aside, middle + half + aside, middle - half + aside];
            let line = LINES + lane.id.0 as u32;
            lines.push(PaintedQuad { corners: corners.map(|p| p.extend(0.0)), color: PaintColor::White, line });
        }
    }
    lines
}

/// Cars side by side, turned toward the curb by one angle a row.
fn angled_bays(lane: &Lane, ground: &Ground, stream: &mut Stream) -> Vec<ParkingSpot> {
    let (angle_rad, pitch_m) = angle_and_pitch(lane, stream);
    let (sin, cos) = (math::sin(angle_rad), math::cos(angle_rad));
    let (kind, (length_m, width_m)) =
        if is_at_aisle(lane) { (SpotKind::Lot, AISLE_SPOT_M) } else { (SpotKind::Angled, ANGLED_SPOT_M) };
    let bay = |s: f64| {
        let pose = lane.pose_at(s);
        let forward = (pose.rotation * DVec3::X).truncate().normalize_or_zero();
        let out = forward.perp() * lane.curb_side();
        // Longer cars than most reach over the bay's inner edge rather than over the curb.
        let usual_length_m = length_m - 0.3;
        let to_curb_m = (usual_length_m * sin + width_m * cos) / 2.0 + NOSE_TO_CURB_M;
        let aside_m = (lane.width_at(s) / 2.0 - to_curb_m).max(0.0);
        let place = pose.translation + (out * aside_m).extend(0.0);
        let turned = frames::upright(place, heading_rad(forward * cos + out * sin));
        spot(ground, kind, &turned, 0.0, (length_m, width_m))
    };
    row(lane, MIN_DEEP_BAY_M, pitch_m).into_iter().filter_map(bay).collect()
}

fn curbside(lane: &Lane, ground: &Ground, pitch_m: f64) -> Vec<ParkingSpot> {
    let margin_m = CLEAR_OF_JUNCTION_M + pitch_m / 2.0;
    let places = std::iter::successors(Some(margin_m), |s| Some(s + pitch_m));
    let place = |s: f64| {
        let left_m = lane.curb_side() * curbside_offset(lane, ground, s, pitch_m)?;
        spot(ground, SpotKind::Parallel, &lane.pose_at(s), left_m, (pitch_m, SPOT_WIDTH_M))
    };
    let end = lane.length_m() - CLEAR_OF_JUNCTION_M - pitch_m / 2.0;
    places.take_while(|s| *s <= end).filter_map(place).collect()
}

/// By how much a lane turns over the length of a spot.
fn turn_at(lane: &Lane, s_m: f64, pitch_m: f64) -> f64 {
    lane.pose_at(s_m - pitch_m / 2.0).rotation.angle_between(lane.pose_at(s_m + pitch_m / 2.0).rotation)
}

/// How far off the lane's middle toward the curb a car may stand, if it may: the curb must be where half a car fits.
fn curbside_offset(lane: &Lane, ground: &Ground, s_m: f64, pitch_m: f64) -> Option<f64> {
    let (before, after) = (lane.pose_at(s_m - pitch_m / 2.0), lane.pose_at(s_m + pitch_m / 2.0));
    if turn_at(lane, s_m, pitch_m) > MAX_TURN_RAD {
        return None;
    }
    let flank = CLEAR_OF_LANE_M + SPOT_WIDTH_M;
    for pose in [before, lane.pose_at(s_m), after] {
        let kind = |out_m: f64| {
            let p = pose.transform_point(DVec3::new(0.0, lane.curb_side() * out_m, 0.0));
            ground.kind_at(p.x, p.y)
        };
        let curb_is_far = kind(flank - MAX_ON_SIDEWALK_M) == Some(GroundKind::Road);
        let room_to_walk = kind(flank + LEFT_FOR_WALKERS_M) == Some(GroundKind::Sidewalk);
        if !(curb_is_far && room_to_walk) {
            return None;
        }
    }
    Some(CLEAR_OF_LANE_M + SPOT_WIDTH_M / 2.0)
}

/// A place `left_m` left of `lane_pose`, in which a car has its wheels on the ground (half on a curb, if need be).
fn spot(
    ground: &Ground,
    kind: SpotKind,
    lane_pose: &DPose3,
    left_m: f64,
    (length_m, width_m): (f64, f64),
) -> Option<ParkingSpot> {
    let forward = (lane_pose.rotation * DVec3::X).truncate().normalize_or_zero();
    let left = forward.perp();
    let middle = lane_pose.translation.truncate() + left * left_m;
    let wheel = |along: f64, across: f64| -> Option<DVec3> {
        let p: DVec2 = middle + forward * (along * length_m * 0.25) + left * (across * width_m * 0.38);
        Some(p.extend(ground.height_at(p.x, p.y)?))
    };
    let (front_left, front_right) = (wheel(1.0, 1.0)?, wheel(1.0, -1.0)?);
    let (rear_left, rear_right) = (wheel(-1.0, 1.0)?, wheel(-1.0, -1.0)?);
    let along = front_left + front_right - rear_left - rear_right;
    let across = front_left + rear_left - front_right - rear_right;
    let z = (front_left.z + front_right.z + rear_left.z + rear_right.z) / 4.0;
    let world_from_spot = frames::facing(middle.extend(z), along, along.cross(across));
    Some(ParkingSpot { kind, world_from_spot, length_m, width_m })
}
