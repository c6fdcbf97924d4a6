//! Lays out a suburb: streets, junctions, and the ways through them, along a grid.

use crate::plan::junction::{CycleTurn, PlannedTurn, Roundabout, StreetArm, StreetEnd, cycle_turns, turns};
use crate::plan::{
    Chain, LineStyle, PlanCurve, PlanPose, StreetBays, StreetGrid, SuburbConfig, WhichEnd, country_roads, cycle_lanes,
    draw_grid, draw_styles, lay_tracks, place_streets, thin, trace, widen_main_roads,
};
use cadet_base::math::{self, DVec2, PI, TAU, wrap_angle};
use cadet_base::plane::{heading_rad, unit};
use cadet_base::rng::{Stream, StreamKey};

/// Curb radius at residential corners.
const CORNER_RADIUS_M: (f64, f64) = (4.5, 7.0);
/// Radius at the bends of a street between two junctions.
const BEND_RADIUS_M: (f64, f64) = (14.0, 24.0);
/// A junction begins at least this far from its middle.
const MIN_CUT_M: f64 = 6.0;

/// A street between two junctions; its reference line is the middle of the carriageway.
#[derive(Debug, Clone)]
pub(crate) struct Street {
    pub(crate) curve: PlanCurve,
    pub(crate) style: LineStyle,
    pub(crate) bays: StreetBays,
    /// The junctions at its start and its end.
    pub(crate) junctions: [usize; 2],
}

/// Streets, junctions and the ways through them.
#[derive(Debug, Clone, Default)]
pub(crate) struct StreetPlan {
    pub(crate) streets: Vec<Street>,
    pub(crate) turns: Vec<PlannedTurn>,
    /// The ways of bicycles through junctions with cycle lanes.
    pub(crate) cycle_turns: Vec<CycleTurn>,
    pub(crate) num_junctions: usize,
    /// By junction, the roundabout that it is.
    pub(crate) roundabouts: Vec<Option<Roundabout>>,
    /// By junction, whether it has traffic lights.
    pub(crate) has_signals: Vec<bool>,
}

/// Draws a plan.
pub(crate) fn draw(key: &StreamKey, config: &SuburbConfig) -> StreetPlan {
    let stream = &mut key.stream("suburb/plan");
    let (grid, styles) = draw_lines(key, config, stream);
    let (chains, headings) = trace(&grid, stream);
    let nodes: Vec<usize> = (0..grid.at.len()).filter(|node| grid.degree(*node) >= 3).collect();
    let lines = Lines { key, config, grid, styles, chains, headings, nodes };
    let mut arms = lines.arms_by_junction();
    let roundabouts = lines.shape_junctions(&mut arms, stream);
    let mut lights = key.stream("suburb/signals");
    let has_signals = arms
        .iter()
        .zip(&roundabouts)
        .map(|(arms, ring)| has_signals(arms, config.signal_share, &mut lights) && ring.is_none())
        .collect();
    let streets = lines.draw_streets(&arms, stream);
    let by_junction = || arms.iter().enumerate().zip(&roundabouts);
    let turns = by_junction().flat_map(|((junction, arms), ring)| turns(junction, arms, ring.as_ref())).collect();
    let cycle_turns = by_junction().flat_map(|((junction, arms), _)| cycle_turns(junction, arms)).collect();
    StreetPlan { streets, turns, cycle_turns, num_junctions: lines.nodes.len(), roundabouts, has_signals }
}

/// Draws the grid, and the style of each of its lines.
fn draw_lines(key: &StreamKey, config: &SuburbConfig, stream: &mut Stream) -> (StreetGrid, Vec<LineStyle>) {
    let mut grid = draw_grid(stream, config);
    thin(&mut grid, stream);
    let mut styles = draw_styles(stream, &grid, config.sidewalk_m, config.tram_share > 0.0);
    widen_main_roads(&mut key.stream("suburb/main roads"), config.main_share, &mut styles);
    country_roads::draw(&mut key.stream("suburb/country"), config.country_share, &mut styles);
    place_streets::draw(key, config, &mut styles);
    cycle_lanes::draw(&mut key.stream("suburb/cycle lanes"), config.cycle_lane_share, &mut styles);
    lay_tracks(&mut key.stream("suburb/tracks"), config.tram_share, &mut styles, &mut grid);
    (grid, styles)
}

/// The lines that streets follow, and what their streets are like.
struct Lines<'a> {
    key: &'a StreamKey,
    config: &'a SuburbConfig,
    grid: StreetGrid,
    styles: Vec<LineStyle>,
    chains: Vec<Chain>,
    /// Of the arms at each node.
    headings: Vec<[f64; 4]>,
    /// The nodes at which streets meet, ascending.
    nodes: Vec<usize>,
}

impl Lines<'_> {
    /// The number of the junction at an end of a chain.
    fn junction_at(&self, chain: &Chain, end: WhichEnd) -> usize {
        self.nodes.partition_point(|n| *n < chain.node(end))
    }

    /// The arms of each junction, round counter-clockwise; not yet cut back.
    fn arms_by_junction(&self) -> Vec<Vec<StreetArm>> {
        let mut arms: Vec<Vec<StreetArm>> = self.nodes.iter().map(|_| Vec::new()).collect();
        for (street, chain) in self.chains.iter().enumerate() {
            for (end, direction) in [(WhichEnd::Start, chain.leaves), (WhichEnd::Finish, chain.arrives)] {
                let node = chain.node(end);
                arms[self.junction_at(chain, end)].push(StreetArm {
                    from: StreetEnd { street, end },
                    center: self.grid.at[node],
                    heading_rad: self.headings[node][direction],
                    style: self.styles[chain.line],
                    cut_m: 0.0,
                });
            }
        }
        for arms in &mut arms {
            arms.sort_by(|a, b| wrap_angle(a.heading_rad).total_cmp(&wrap_angle(b.heading_rad)));
        }
        arms
    }

    /// Cuts the arms of all junctions back to where their streets end, and draws which junctions are roundabouts.
    fn shape_junctions(&self, arms: &mut [Vec<StreetArm>], stream: &mut Stream) -> Vec<Option<Roundabout>> {
        let mut rings = self.key.stream("suburb/roundabouts");
        let shape = |arms: &mut Vec<StreetArm>| {
            cut_back(arms, stream.within(CORNER_RADIUS_M));
            let roundabout = Roundabout::draw(arms, self.config.roundabout_share, &mut rings);
            if let Some(ring) = &roundabout {
                arms.iter_mut().for_each(|arm| arm.cut_m = arm.cut_m.max(ring.approach_m()));
            }
            roundabout
        };
        arms.iter_mut().map(shape).collect()
    }

    /// Draws the streets between junctions whose arms are cut back.
    fn draw_streets(&self, arms: &[Vec<StreetArm>], stream: &mut Stream) -> Vec<Street> {
        let mut ends = vec![[PlanPose::new(DVec2::ZERO, 0.0); 2]; self.chains.len()];
        for arm in arms.iter().flatten() {
            ends[arm.from.street][arm.from.end as usize] = arm.pose();
        }
        let mut winding = self.key.stream("suburb/winding");
        let draw = |(chain, [start, finish]): (&Chain, &[PlanPose; 2])| {
            let middle: Vec<DVec2> = chain.nodes[1..chain.nodes.len() - 1].iter().map(|n| self.grid.at[*n]).collect();
            let style = self.styles[chain.line];
            let bends_m = if style.country.is_some() { country_roads::BEND_RADIUS_M } else { BEND_RADIUS_M };
            let mut curve = street_curve(*start, &middle, finish.reversed(), bends_m, stream);
            if style.country.is_some() {
                curve = country_roads::wind(&curve, &mut winding);
            }
            let bays = StreetBays::draw(&style, curve.length_m(), self.config, stream);
            let junctions = [WhichEnd::Start, WhichEnd::Finish].map(|end| self.junction_at(chain, end));
            Street { curve, style, bays, junctions }
        };
        self.chains.iter().zip(&ends).map(draw).collect()
    }
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
        let (before, after) = (heading_rad(*bend - at.at), heading_rad(next - *bend));
        let turn = wrap_angle(after - before);
        let shorter = (*bend - at.at).length().min((next - *bend).length());
        let drawn = stream.within(bend_radius_m);
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
