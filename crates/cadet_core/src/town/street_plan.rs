//! Lays out a suburb: an irregular grid of streets, thinned to T-junctions, with bends at its corners.

use super::plan_curve::{PlanCurve, PlanPose, heading_of, unit};
use super::suburb_config::SuburbConfig;
use crate::math::{self, DVec2, PI, TAU, wrap_angle};
use crate::rng::{Stream, StreamKey};

/// Crossroads are thinned to this share of all nodes; the other nodes are T-junctions and bends.
const CROSSROADS_SHARE: f64 = 0.3;
/// Kerb radius at residential corners, and where a collector takes part.
const CORNER_RADIUS_M: (f64, f64) = (4.5, 7.0);
/// Width of a parallel parking bay, gutter included.
const BAY_WIDTH_M: f64 = 2.25;
/// Depth of bays in which cars stand at an angle or across, and share of the streets with bays at both kerbs that have
/// them at both.
pub(super) const DEEP_BAY_M: f64 = 5.5;
const BOTH_DEEP_SHARE: f64 = 0.3;
/// Deep bays begin this much farther from a junction than others.
const DEEP_BAY_MARGIN_M: f64 = 4.0;
/// Beside narrower lanes cars stand half on the pavement: in a bay they would be grazed.
const MIN_LANE_BESIDE_BAYS_M: f64 = 2.55;
/// Share of the streets with wide lanes where cars stand half on the pavement all the same.
const HALF_BAYS_SHARE: f64 = 0.15;
/// How far such cars stand from the middle of the lane, and how much of a car of usual width is on the pavement.
const HALF_BAY_FLANK_M: f64 = 1.6;
const ON_PAVEMENT_M: (f64, f64) = (0.4, 1.0);
const CAR_WIDTH_M: f64 = 1.65;
/// Left of the pavement for walkers.
const LEFT_FOR_WALKERS_M: f64 = 0.95;
/// Share of the streets with a wide carriageway.
const WIDE_SHARE: f64 = 0.18;
/// A junction begins at least this far from its middle.
const MIN_CUT_M: f64 = 6.0;

/// Which end of a street.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    Start,
    Finish,
}

/// A street between two junctions; its reference line is the middle of the carriageway.
#[derive(Debug, Clone)]
pub(super) struct Street {
    pub(super) curve: PlanCurve,
    pub(super) lane_width_m: f64,
    pub(super) sidewalk_width_m: f64,
    pub(super) speed_kmh: u32,
    /// Stretch with bays at the right or the left kerb or both.
    pub(super) bays: Option<(f64, f64)>,
    /// Widths of the bays at the right and at the left kerb; 0 where there are none.
    pub(super) bay_widths_m: [f64; 2],
    /// The junctions at its start and its end.
    pub(super) junctions: [usize; 2],
}

/// A way through a junction: one lane from one street's end to another's.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    pub(super) junction: usize,
    pub(super) from: (usize, End),
    pub(super) to: (usize, End),
    /// From the middle of the one carriageway to the middle of the other.
    pub(super) curve: PlanCurve,
    /// True where the turn follows the kerb, and so carries the pavement round the corner.
    pub(super) along_kerb: bool,
}

/// Streets, junctions and the ways through them.
#[derive(Debug, Clone, Default)]
pub(super) struct StreetPlan {
    pub(super) streets: Vec<Street>,
    pub(super) turns: Vec<Turn>,
    pub(super) num_junctions: usize,
}

#[derive(Debug, Clone, Copy)]
struct LineStyle {
    lane_width_m: f64,
    sidewalk_width_m: f64,
    speed_kmh: u32,
}

/// A street's arm at a junction.
struct Arm {
    street: usize,
    end: End,
    heading_rad: f64,
    half_width_m: f64,
    collector: bool,
    cut_m: f64,
}

struct Grid {
    columns: usize,
    rows: usize,
    at: Vec<DVec2>,
    /// East, north, west, south neighbor of each node.
    links: Vec<[Option<usize>; 4]>,
}

impl Grid {
    fn degree(&self, node: usize) -> usize {
        self.links[node].iter().flatten().count()
    }

    fn unlink(&mut self, node: usize, direction: usize) {
        if let Some(other) = self.links[node][direction].take() {
            self.links[other][(direction + 2) % 4] = None;
        }
    }

    /// Direction of the arm that leaves `node`: along the line through it where the line goes on behind.
    fn arm_heading(&self, node: usize, direction: usize, stream: &mut Stream) -> f64 {
        let wobble = stream.range(-0.1, 0.1);
        let Some(ahead) = self.links[node][direction] else { return 0.0 };
        match self.links[node][(direction + 2) % 4] {
            Some(behind) => heading_of(self.at[ahead] - self.at[behind]),
            None => heading_of(self.at[ahead] - self.at[node]) + wobble,
        }
    }
}

/// Draws a plan.
pub(super) fn draw(key: &StreamKey, config: &SuburbConfig) -> StreetPlan {
    let mut stream = key.stream("suburb/plan");
    let mut grid = draw_grid(&mut stream, config);
    thin(&mut grid, &mut stream);
    let styles = draw_styles(&mut stream, &grid);
    let (chains, headings) = trace(&grid, &mut stream);
    let mut junction_of = vec![usize::MAX; grid.at.len()];
    let mut num_junctions = 0;
    for node in 0..grid.at.len() {
        if grid.degree(node) >= 3 {
            junction_of[node] = num_junctions;
            num_junctions += 1;
        }
    }
    let mut arms: Vec<Vec<Arm>> = (0..num_junctions).map(|_| Vec::new()).collect();
    for (street, chain) in chains.iter().enumerate() {
        let style = styles[chain.line];
        for (end, node, direction) in [
            (End::Start, chain.nodes[0], chain.leaves),
            (End::Finish, chain.nodes[chain.nodes.len() - 1], chain.arrives),
        ] {
            arms[junction_of[node]].push(Arm {
                street,
                end,
                heading_rad: headings[node][direction],
                half_width_m: style.lane_width_m,
                collector: style.speed_kmh > 30,
                cut_m: 0.0,
            });
        }
    }
    let mut cuts = vec![[PlanPose::new(DVec2::ZERO, 0.0); 2]; chains.len()];
    for node in (0..grid.at.len()).filter(|n| junction_of[*n] != usize::MAX) {
        let arms = &mut arms[junction_of[node]];
        arms.sort_by(|a, b| wrap_angle(a.heading_rad).total_cmp(&wrap_angle(b.heading_rad)));
        cut_back(arms, stream.range(CORNER_RADIUS_M.0, CORNER_RADIUS_M.1));
        for arm in arms.iter() {
            let at = grid.at[node] + unit(arm.heading_rad) * arm.cut_m;
            cuts[arm.street][usize::from(arm.end == End::Finish)] = PlanPose::new(at, arm.heading_rad);
        }
    }
    let streets: Vec<Street> = chains
        .iter()
        .zip(&cuts)
        .map(|(chain, [start, finish])| {
            let middle: Vec<DVec2> = chain.nodes[1..chain.nodes.len() - 1].iter().map(|n| grid.at[*n]).collect();
            let curve = street_curve(*start, &middle, finish.reversed(), &mut stream);
            let style = styles[chain.line];
            let mut margin = (stream.range(5.0, 9.0), stream.range(5.0, 9.0));
            let (mut right, mut left) = (stream.chance(config.parking_share), stream.chance(config.parking_share));
            let mut bay_width_m = BAY_WIDTH_M;
            let on_pavement_m = stream.range(ON_PAVEMENT_M.0, ON_PAVEMENT_M.1);
            let (half_all_the_same, is_right) = (stream.chance(HALF_BAYS_SHARE), stream.chance(0.5));
            if style.lane_width_m < MIN_LANE_BESIDE_BAYS_M || half_all_the_same {
                // On one side alone: the other pavement stays free.
                let on_pavement_m = on_pavement_m.min(style.sidewalk_width_m - LEFT_FOR_WALKERS_M);
                bay_width_m = HALF_BAY_FLANK_M + CAR_WIDTH_M - on_pavement_m - style.lane_width_m / 2.0;
                let any = right || left;
                (right, left) = (any && is_right, any && !is_right);
            }
            let mut bay_widths_m = [right, left].map(|has_bays| if has_bays { bay_width_m } else { 0.0 });
            let (is_deep, both_deep) = (stream.chance(config.angled_share), stream.chance(BOTH_DEEP_SHARE));
            if is_deep && (right || left) {
                for (width_m, is_on_this_side) in bay_widths_m.iter_mut().zip([is_right, !is_right]) {
                    if is_on_this_side || (both_deep && *width_m > 0.0) {
                        *width_m = DEEP_BAY_M;
                    }
                }
                margin = (margin.0 + DEEP_BAY_MARGIN_M, margin.1 + DEEP_BAY_MARGIN_M);
            }
            let length = curve.length_m();
            let fits = length - margin.0 - margin.1 > 20.0;
            Street {
                curve,
                lane_width_m: style.lane_width_m,
                sidewalk_width_m: style.sidewalk_width_m,
                speed_kmh: style.speed_kmh,
                bays: (fits && (right || left)).then_some((margin.0, length - margin.1)),
                bay_widths_m,
                junctions: [junction_of[chain.nodes[0]], junction_of[chain.nodes[chain.nodes.len() - 1]]],
            }
        })
        .collect();
    let mut turns = Vec::new();
    for (junction, arms) in arms.iter().enumerate() {
        for (i, from) in arms.iter().enumerate() {
            for (j, to) in arms.iter().enumerate().filter(|(j, _)| *j != i) {
                let pose = |arm: &Arm| cuts[arm.street][usize::from(arm.end == End::Finish)];
                let mut curve = PlanCurve::default();
                curve.extend_to(pose(from).reversed(), pose(to));
                let along_kerb = j == (i + 1) % arms.len();
                turns.push(Turn {
                    junction,
                    from: (from.street, from.end),
                    to: (to.street, to.end),
                    curve,
                    along_kerb,
                });
            }
        }
    }
    StreetPlan { streets, turns, num_junctions }
}

fn draw_grid(stream: &mut Stream, config: &SuburbConfig) -> Grid {
    let (columns, rows) = (config.blocks.0 + 1, config.blocks.1 + 1);
    let mut spread = |n: usize| {
        let mut at = vec![0.0];
        for i in 1..n {
            at.push(at[i - 1] + stream.range(config.block_m.0, config.block_m.1));
        }
        let middle = at[n - 1] / 2.0;
        at.into_iter().map(|v| v - middle).collect::<Vec<f64>>()
    };
    let (xs, ys) = (spread(columns), spread(rows));
    // A slow wave through the whole grid bends its lines together; its slope stays below 0.24, so corners stay open.
    let wave = |stream: &mut Stream| {
        let length = stream.range(230.0, 400.0);
        (length, stream.range(0.08, 0.24) * length / TAU, stream.range(0.0, TAU))
    };
    let (wave_x, wave_y) = (wave(stream), wave(stream));
    let turn = unit(stream.range(0.0, TAU));
    let mut at = Vec::with_capacity(columns * rows);
    for y in &ys {
        for x in &xs {
            let jitter = DVec2::new(stream.clipped_normal(0.0, 3.5), stream.clipped_normal(0.0, 3.5));
            let bent = DVec2::new(
                x + wave_x.1 * math::sin(TAU * y / wave_x.0 + wave_x.2),
                y + wave_y.1 * math::sin(TAU * x / wave_y.0 + wave_y.2),
            );
            at.push(turn.rotate(bent + jitter));
        }
    }
    let links = (0..columns * rows)
        .map(|n| {
            let (i, j) = (n % columns, n / columns);
            [
                (i + 1 < columns).then_some(n + 1),
                (j + 1 < rows).then_some(n + columns),
                (i > 0).then(|| n - 1),
                (j > 0).then(|| n - columns),
            ]
        })
        .collect();
    Grid { columns, rows, at, links }
}

/// Takes streets away until T-junctions prevail; no node is left with fewer than two streets.
fn thin(grid: &mut Grid, stream: &mut Stream) {
    let (columns, rows) = (grid.columns, grid.rows);
    if columns > 3 && rows > 3 && stream.chance(0.6) {
        let corner = [0, columns - 1, columns * (rows - 1), columns * rows - 1][stream.below(4)];
        for direction in 0..4 {
            grid.unlink(corner, direction);
        }
    }
    let mut inner: Vec<(usize, usize)> = (0..columns * rows)
        .flat_map(|n| [(n, 0), (n, 1)])
        .filter(|(n, d)| {
            let (i, j) = (n % columns, n / columns);
            if *d == 0 { i + 1 < columns && j > 0 && j + 1 < rows } else { j + 1 < rows && i > 0 && i + 1 < columns }
        })
        .collect();
    stream.shuffle(&mut inner);
    let wanted = CROSSROADS_SHARE * (columns * rows) as f64;
    for (node, direction) in inner {
        let crossroads = (0..columns * rows).filter(|n| grid.degree(*n) == 4).count();
        if (crossroads as f64) <= wanted {
            break;
        }
        let both_cross = |other| grid.degree(node) == 4 && grid.degree(other) == 4;
        if grid.links[node][direction].is_some_and(both_cross) {
            grid.unlink(node, direction);
        }
    }
}

/// One style a row, then one a column: a street keeps its width across junctions.
fn draw_styles(stream: &mut Stream, grid: &Grid) -> Vec<LineStyle> {
    let lines = grid.rows + grid.columns;
    let collectors = [stream.below(grid.rows), grid.rows + stream.below(grid.columns)];
    let second = stream.chance(0.5);
    (0..lines)
        .map(|line| {
            let collector = line == collectors[0] || (second && line == collectors[1]);
            let (is_wide, wide_m) = (stream.chance(WIDE_SHARE), stream.range(6.8, 9.5));
            let usual_m = if collector { stream.range(5.8, 6.5) } else { stream.range(4.75, 5.6) };
            let carriageway = if is_wide { wide_m } else { usual_m };
            LineStyle {
                lane_width_m: (carriageway * 10.0).round() / 20.0,
                sidewalk_width_m: (stream.range(1.5, 2.5) * 10.0).round() / 10.0,
                speed_kmh: if collector { 50 } else { 30 },
            }
        })
        .collect()
}

/// A walk along the grid from one junction to the next.
struct Chain {
    nodes: Vec<usize>,
    /// The direction of the walk's first arm at its first node, and of its last arm at its last node.
    leaves: usize,
    arrives: usize,
    /// Row, or number of rows plus column.
    line: usize,
}

/// The streets of the grid, each once, and the heading of every arm.
fn trace(grid: &Grid, stream: &mut Stream) -> (Vec<Chain>, Vec<[f64; 4]>) {
    let headings: Vec<[f64; 4]> =
        (0..grid.at.len()).map(|n| [0, 1, 2, 3].map(|d| grid.arm_heading(n, d, stream))).collect();
    let mut seen = vec![[false; 4]; grid.at.len()];
    let mut chains = Vec::new();
    for node in (0..grid.at.len()).filter(|n| grid.degree(*n) >= 3) {
        for leaves in 0..4 {
            if seen[node][leaves] || grid.links[node][leaves].is_none() {
                continue;
            }
            seen[node][leaves] = true;
            let (mut nodes, mut at, mut direction) = (vec![node], node, leaves);
            while let Some(next) = grid.links[at][direction] {
                nodes.push(next);
                at = next;
                let back = (direction + 2) % 4;
                if grid.degree(at) != 2 {
                    direction = back;
                    break;
                }
                direction = (0..4).find(|d| *d != back && grid.links[at][*d].is_some()).unwrap_or(back);
            }
            seen[at][direction] = true;
            let line = if leaves % 2 == 0 { node / grid.columns } else { grid.rows + node % grid.columns };
            chains.push(Chain { nodes, leaves, arrives: direction, line });
        }
    }
    (chains, headings)
}

/// Moves each arm's end out until the kerbs' corner arc fits between it and its neighbors.
fn cut_back(arms: &mut [Arm], corner_radius_m: f64) {
    let n = arms.len();
    for i in 0..n {
        let j = (i + 1) % n;
        let between = (arms[j].heading_rad - arms[i].heading_rad).rem_euclid(TAU);
        if between > 0.85 * PI {
            continue;
        }
        let radius = corner_radius_m + if arms[i].collector || arms[j].collector { 1.0 } else { 0.0 };
        let (sin, cos) = (math::sin(between), math::cos(between));
        let round = radius / math::tan(between / 2.0);
        let (wi, wj) = (arms[i].half_width_m, arms[j].half_width_m);
        let (di, dj) = ((wj + wi * cos) / sin + round, (wi + wj * cos) / sin + round);
        arms[i].cut_m = arms[i].cut_m.max(di);
        arms[j].cut_m = arms[j].cut_m.max(dj);
    }
    for arm in arms {
        arm.cut_m = arm.cut_m.max(MIN_CUT_M);
    }
}

/// From junction to junction by way of the bends between them.
fn street_curve(start: PlanPose, middle: &[DVec2], end: PlanPose, stream: &mut Stream) -> PlanCurve {
    let mut curve = PlanCurve::default();
    let mut at = start;
    for (i, bend) in middle.iter().enumerate() {
        let next = middle.get(i + 1).copied().unwrap_or(end.at);
        let (before, after) = (heading_of(*bend - at.at), heading_of(next - *bend));
        let turn = wrap_angle(after - before);
        let shorter = (*bend - at.at).length().min((next - *bend).length());
        let drawn = stream.range(14.0, 24.0);
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
