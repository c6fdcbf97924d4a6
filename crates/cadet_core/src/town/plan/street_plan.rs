//! Lays out a suburb: streets, junctions, and parking bays along a grid.

use crate::math::{self, DVec2, PI, TAU, wrap_angle};
use crate::plane::unit;
use crate::rng::{Stream, StreamKey};
use crate::town::plan::junction::cycle_turns::{CycleTurn, cycle_turns};
use crate::town::plan::junction::roundabout::Roundabout;
use crate::town::plan::junction::turns::{End, StreetArm, Turn, turns};
use crate::town::plan::place_streets;
use crate::town::plan::place_streets::AISLE_BAY_M;
use crate::town::plan::plan_curve::{PlanCurve, PlanPose, heading_of};
use crate::town::plan::street_grid::{
    LineStyle, StreetKind, draw_grid, draw_styles, lay_tracks, thin, trace, widen_main_roads,
};
use crate::town::plan::suburb_config::SuburbConfig;
use crate::town::plan::{country_roads, cycle_lanes};

/// Curb radius at residential corners, and where a collector takes part.
const CORNER_RADIUS_M: (f64, f64) = (4.5, 7.0);
/// Width of a parallel parking bay, gutter included.
const BAY_WIDTH_M: f64 = 2.25;
/// How much wider bays are beside a cycle lane: doors open there.
const DOORS_M: f64 = 0.5;
/// Depth of bays in which cars stand at an angle or across, and share of the streets with bays at both curbs that have
/// them at both.
pub(in crate::town) const DEEP_BAY_M: f64 = 5.5;
const BOTH_DEEP_SHARE: f64 = 0.3;
/// Deep bays begin this much farther from a junction than others.
const DEEP_BAY_MARGIN_M: f64 = 4.0;
/// Beside narrower lanes cars stand half on the sidewalk: in a bay they would be grazed.
const MIN_LANE_BESIDE_BAYS_M: f64 = 2.55;
/// Share of the streets with wide lanes where cars stand half on the sidewalk all the same.
const HALF_BAYS_SHARE: f64 = 0.15;
/// How far such cars stand from the middle of the lane, and how much of a car of usual width is on the sidewalk.
const HALF_BAY_FLANK_M: f64 = 1.6;
const ON_SIDEWALK_M: (f64, f64) = (0.4, 1.0);
const CAR_WIDTH_M: f64 = 1.65;
/// Left of the sidewalk for walkers.
const LEFT_FOR_WALKERS_M: f64 = 0.95;
/// Radius at the bends of a street between two junctions.
const BEND_RADIUS_M: (f64, f64) = (14.0, 24.0);
/// A junction begins at least this far from its middle.
const MIN_CUT_M: f64 = 6.0;

/// A street between two junctions; its reference line is the middle of the carriageway.
#[derive(Debug, Clone)]
pub(in crate::town) struct Street {
    pub(in crate::town) curve: PlanCurve,
    pub(in crate::town) style: LineStyle,
    /// Stretch with bays at the right or the left curb or both.
    pub(in crate::town) bays: Option<(f64, f64)>,
    /// Widths of the bays at the right and at the left curb; 0 where there are none.
    pub(in crate::town) bay_widths_m: [f64; 2],
    /// The junctions at its start and its end.
    pub(in crate::town) junctions: [usize; 2],
}

/// Streets, junctions and the ways through them.
#[derive(Debug, Clone, Default)]
pub(in crate::town) struct StreetPlan {
    pub(in crate::town) streets: Vec<Street>,
    pub(in crate::town) turns: Vec<Turn>,
    /// The ways of bicycles through junctions with cycle lanes.
    pub(in crate::town) cycle_turns: Vec<CycleTurn>,
    pub(in crate::town) num_junctions: usize,
    /// By junction, the roundabout that it is.
    pub(in crate::town) roundabouts: Vec<Option<Roundabout>>,
    /// By junction, whether it has traffic lights.
    pub(in crate::town) has_signals: Vec<bool>,
}

/// Draws a plan.
pub(in crate::town) fn draw(key: &StreamKey, config: &SuburbConfig) -> StreetPlan {
    let mut stream = key.stream("suburb/plan");
    let mut grid = draw_grid(&mut stream, config);
    thin(&mut grid, &mut stream);
    let mut styles = draw_styles(&mut stream, &grid, config.sidewalk_m, config.tram_share > 0.0);
    widen_main_roads(&mut key.stream("suburb/main roads"), config.main_share, &mut styles);
    country_roads::draw(&mut key.stream("suburb/country"), config.country_share, &mut styles);
    place_streets::draw(key, config, &mut styles);
    cycle_lanes::draw(&mut key.stream("suburb/cycle lanes"), config.cycle_lane_share, &mut styles);
    lay_tracks(&mut key.stream("suburb/tracks"), config.tram_share, &mut styles, &mut grid);
    let (chains, headings) = trace(&grid, &mut stream);
    let mut junction_of = vec![usize::MAX; grid.at.len()];
    let mut num_junctions = 0;
    for node in 0..grid.at.len() {
        if grid.degree(node) >= 3 {
            junction_of[node] = num_junctions;
            num_junctions += 1;
        }
    }
    let mut arms: Vec<Vec<StreetArm>> = (0..num_junctions).map(|_| Vec::new()).collect();
    for (street, chain) in chains.iter().enumerate() {
        let style = styles[chain.line];
        for (end, node, direction) in [
            (End::Start, chain.nodes[0], chain.leaves),
            (End::Finish, chain.nodes[chain.nodes.len() - 1], chain.arrives),
        ] {
            arms[junction_of[node]].push(StreetArm {
                street,
                end,
                heading_rad: headings[node][direction],
                style,
                cut_m: 0.0,
            });
        }
    }
    let mut rings = key.stream("suburb/roundabouts");
    let mut roundabouts = vec![None; num_junctions];
    let mut cuts = vec![[PlanPose::new(DVec2::ZERO, 0.0); 2]; chains.len()];
    for node in (0..grid.at.len()).filter(|n| junction_of[*n] != usize::MAX) {
        let arms = &mut arms[junction_of[node]];
        arms.sort_by(|a, b| wrap_angle(a.heading_rad).total_cmp(&wrap_angle(b.heading_rad)));
        cut_back(arms, stream.range(CORNER_RADIUS_M.0, CORNER_RADIUS_M.1));
        let of_arms: Vec<_> = arms.iter().map(|arm| (arm.heading_rad, arm.style)).collect();
        let roundabout = Roundabout::draw(grid.at[node], &of_arms, config.roundabout_share, &mut rings);
        if let Some(ring) = &roundabout {
            arms.iter_mut().for_each(|arm| arm.cut_m = arm.cut_m.max(ring.approach_m()));
        }
        roundabouts[junction_of[node]] = roundabout;
        for arm in arms.iter() {
            let at = grid.at[node] + unit(arm.heading_rad) * arm.cut_m;
            cuts[arm.street][usize::from(arm.end == End::Finish)] = PlanPose::new(at, arm.heading_rad);
        }
    }
    let mut lights = key.stream("suburb/signals");
    let has_signals = arms
        .iter()
        .zip(&roundabouts)
        .map(|(arms, ring)| has_signals(arms, config.signal_share, &mut lights) && ring.is_none())
        .collect();
    let mut winding = key.stream("suburb/winding");
    let streets: Vec<Street> = chains
        .iter()
        .zip(&cuts)
        .map(|(chain, [start, finish])| {
            let middle: Vec<DVec2> = chain.nodes[1..chain.nodes.len() - 1].iter().map(|n| grid.at[*n]).collect();
            let style = styles[chain.line];
            let bends_m = if style.country.is_some() { country_roads::BEND_RADIUS_M } else { BEND_RADIUS_M };
            let mut curve = street_curve(*start, &middle, finish.reversed(), bends_m, &mut stream);
            if style.country.is_some() {
                curve = country_roads::wind(&curve, &mut winding);
            }
            let mut margin = (stream.range(5.0, 9.0), stream.range(5.0, 9.0));
            let (mut right, mut left) = (stream.chance(config.parking_share), stream.chance(config.parking_share));
            let mut bay_width_m = BAY_WIDTH_M;
            let on_sidewalk_m = stream.range(ON_SIDEWALK_M.0, ON_SIDEWALK_M.1);
            let (half_all_the_same, is_right) = (stream.chance(HALF_BAYS_SHARE), stream.chance(0.5));
            if style.lane_width_m < MIN_LANE_BESIDE_BAYS_M
                || (half_all_the_same && !style.is_main_road() && style.cycle_lane.is_none())
            {
                // On one side alone: the other sidewalk stays free.
                let on_sidewalk_m = on_sidewalk_m.min(style.sidewalk_width_m - LEFT_FOR_WALKERS_M);
                bay_width_m = HALF_BAY_FLANK_M + CAR_WIDTH_M - on_sidewalk_m - style.lane_width_m / 2.0;
                let any = right || left;
                (right, left) = (any && is_right, any && !is_right);
            }
            let mut bay_widths_m = [right, left].map(|has_bays| if has_bays { bay_width_m } else { 0.0 });
            let (is_deep, both_deep) = (stream.chance(config.angled_share), stream.chance(BOTH_DEEP_SHARE));
            if style.cycle_lane.is_some() {
                // Nobody backs out over a cycle lane.
                bay_widths_m = bay_widths_m.map(|m| if m > 0.0 { m + DOORS_M } else { 0.0 });
            } else if is_deep && (right || left) {
                for (width_m, is_on_this_side) in bay_widths_m.iter_mut().zip([is_right, !is_right]) {
                    if is_on_this_side || (both_deep && *width_m > 0.0) {
                        *width_m = DEEP_BAY_M;
                    }
                }
                margin = (margin.0 + DEEP_BAY_MARGIN_M, margin.1 + DEEP_BAY_MARGIN_M);
            }
            if style.kind == StreetKind::Aisle && (right || left || !is_deep) {
                (right, left) = (true, true);
                bay_widths_m = [AISLE_BAY_M; 2];
                margin = (margin.0.max(2.0 * DEEP_BAY_MARGIN_M), margin.1.max(2.0 * DEEP_BAY_MARGIN_M));
            }
            let length = curve.length_m();
            let fits =
                length - margin.0 - margin.1 > 20.0 && style.country.is_none() && style.kind != StreetKind::Campus;
            Street {
                curve,
                style,
                bays: (fits && (right || left)).then_some((margin.0, length - margin.1)),
                bay_widths_m,
                junctions: [junction_of[chain.nodes[0]], junction_of[chain.nodes[chain.nodes.len() - 1]]],
            }
        })
        .collect();
    let pose = |arm: &StreetArm| cuts[arm.street][usize::from(arm.end == End::Finish)];
    let turns = arms
        .iter()
        .zip(&roundabouts)
        .enumerate()
        .flat_map(|(junction, (arms, ring))| turns(junction, arms, ring.as_ref(), &pose))
        .collect();
    let cycle_turns = arms.iter().enumerate().flat_map(|(junction, arms)| cycle_turns(junction, arms, &pose)).collect();
    StreetPlan { streets, turns, cycle_turns, num_junctions, roundabouts, has_signals }
}

/// Whether a junction has traffic lights: of fast streets that meet more often than of those that side streets join.
fn has_signals(arms: &[StreetArm], share: f64, stream: &mut Stream) -> bool {
    let drawn = stream.unit();
    let fast = arms.iter().filter(|a| a.style.speed_kmh > 30).count();
    let is_main = arms.iter().any(|a| a.style.is_main_road());
    let share = if fast > 2 || is_main { share } else { share * share };
    fast > 0 && drawn < share
}

/// Moves each arm's end out until the curbs' corner arc fits between it and its neighbors.
fn cut_back(arms: &mut [StreetArm], corner_radius_m: f64) {
    let n = arms.len();
    for i in 0..n {
        let j = (i + 1) % n;
        let between = (arms[j].heading_rad - arms[i].heading_rad).rem_euclid(TAU);
        if between > 0.85 * PI {
            continue;
        }
        let radius =
            corner_radius_m + if arms[i].style.speed_kmh.max(arms[j].style.speed_kmh) > 30 { 1.0 } else { 0.0 };
        let radius = radius + if arms[i].style.country.is_some() { country_roads::CORNER_MORE_M } else { 0.0 };
        let (sin, cos) = (math::sin(between), math::cos(between));
        let round = radius / math::tan(between / 2.0);
        let (wi, wj) = (arms[i].style.half_width_m(), arms[j].style.half_width_m());
        let (di, dj) = ((wj + wi * cos) / sin + round, (wi + wj * cos) / sin + round);
        arms[i].cut_m = arms[i].cut_m.max(di);
        arms[j].cut_m = arms[j].cut_m.max(dj);
    }
    for arm in arms {
        arm.cut_m = arm.cut_m.max(MIN_CUT_M);
    }
}

/// From junction to junction by way of the bends between them.
fn street_curve(
    start: PlanPose,
    middle: &[DVec2],
    end: PlanPose,
    bend_radius_m: (f64, f64),
    stream: &mut Stream,
) -> PlanCurve {
    let mut curve = PlanCurve::default();
    let mut at = start;
    for (i, bend) in middle.iter().enumerate() {
        let next = middle.get(i + 1).copied().unwrap_or(end.at);
        let (before, after) = (heading_of(*bend - at.at), heading_of(next - *bend));
        let turn = wrap_angle(after - before);
        let shorter = (*bend - at.at).length().min((next - *bend).length());
        let drawn = stream.range(bend_radius_m.0, bend_radius_m.1);
        if turn.abs() < 0.4 {
            let pose = PlanPose::new(*bend, before + turn / 2.0);
            curve.extend_to(at, pose);
            at = pose;
        } else {
            // Bends leave room for the straights between them, however short the block.
            let tangent = (drawn * math::tan(turn.abs() / 2.0)).min(0.4 * shorter);
            let into = PlanPose::new(*bend - unit(before) * tangent, before);
            let out = PlanPose::new(*bend + unit(after) * tangent, after);
            curve.extend_to(at, into);
            curve.extend_to(into, out);
            at = out;
        }
    }
    curve.extend_to(at, end);
    curve
}
