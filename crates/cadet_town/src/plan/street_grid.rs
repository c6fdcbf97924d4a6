//! The irregular grid that a suburb's streets follow, thinned to T-junctions, with bends at its corners.

use crate::network::LaneSurface;
use crate::plan::SuburbConfig;
use cadet_base::math::{self, DVec2, TAU};
use cadet_base::plane::{heading_rad, unit};
use cadet_base::rng::Stream;

/// Crossroads are thinned to this share of all nodes; the other nodes are T-junctions and bends.
const CROSSROADS_SHARE: f64 = 0.3;
/// Share of the streets with a wide carriageway.
const WIDE_SHARE: f64 = 0.18;

/// Shares of the main roads with two lanes a direction, and of those the share with a median; with one lane all have one.
const TWO_LANES_SHARE: f64 = 0.6;
const MEDIAN_SHARE: f64 = 0.7;
/// Width of the bed of two tracks, and what it is covered with.
const TRACK_BED_M: (f64, f64) = (6.4, 7.0);
const TRACK_BEDS: [(LaneSurface, f64); 3] =
    [(LaneSurface::Ballast, 0.4), (LaneSurface::Grass, 0.4), (LaneSurface::Slabs, 0.2)];

/// What the streets of one line of the grid have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LineStyle {
    pub lane_width_m: f64,
    pub lanes_per_side: usize,
    /// 0 where nothing parts the directions.
    pub median_width_m: f64,
    /// The bed of the two tracks in the place of the median, if there are any.
    pub tracks: Option<LaneSurface>,
    /// Of the verge on country roads.
    pub sidewalk_width_m: f64,
    pub speed_kmh: u32,
    pub kind: StreetKind,
    /// What it has in open country.
    pub country: Option<CountryRoad>,
    /// The lane for bicycles to the right of the others, on both sides, if there is one.
    pub cycle_lane: Option<CycleLane>,
}

/// What kind of street it is in town.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StreetKind {
    Usual,
    /// Between rows of bays on both sides.
    Aisle,
    /// Paved from wall to wall, without curbs.
    Campus,
}

/// What a road in open country has in place of curb and sidewalk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CountryRoad {
    /// Whether a line is painted along both edges.
    pub has_edge_lines: bool,
}

/// A lane for bicycles on the carriageway.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CycleLane {
    pub width_m: f64,
    /// Whether cars may use it (a Schutzstreifen): its line is narrow and broken; it is wide and solid otherwise.
    pub is_advisory: bool,
    /// Whether it is red where it leads over a junction.
    pub is_red: bool,
}

impl LineStyle {
    /// A street with one lane a direction, and nothing else than sidewalks beside them.
    pub fn new(lane_width_m: f64, sidewalk_width_m: f64, speed_kmh: u32) -> Self {
        Self {
            lane_width_m,
            lanes_per_side: 1,
            median_width_m: 0.0,
            tracks: None,
            sidewalk_width_m,
            speed_kmh,
            kind: StreetKind::Usual,
            country: None,
            cycle_lane: None,
        }
    }

    /// From the middle to the curb, parking bays left out.
    pub fn half_width_m(&self) -> f64 {
        self.driven_half_width_m() + self.cycle_lane.map_or(0.0, |c| c.width_m)
    }

    /// From the middle to the right edge of the outermost lane for cars.
    pub fn driven_half_width_m(&self) -> f64 {
        self.median_width_m / 2.0 + self.lanes_per_side as f64 * self.lane_width_m
    }

    /// A street with a median or with several lanes a direction.
    pub fn is_main_road(&self) -> bool {
        self.lanes_per_side > 1 || self.median_width_m > 0.0
    }
}

/// Nodes on a bent grid, and the streets between them.
pub(crate) struct StreetGrid {
    pub columns: usize,
    pub rows: usize,
    pub at: Vec<DVec2>,
    /// East, north, west, south neighbor of each node.
    pub links: Vec<[Option<usize>; 4]>,
}

impl StreetGrid {
    pub fn degree(&self, node: usize) -> usize {
        self.links[node].iter().flatten().count()
    }

    fn is_border(&self, node: usize) -> bool {
        let (i, j) = (node % self.columns, node / self.columns);
        i == 0 || j == 0 || i + 1 == self.columns || j + 1 == self.rows
    }

    fn unlink(&mut self, node: usize, direction: usize) {
        if let Some(other) = self.links[node][direction].take() {
            self.links[other][(direction + 2) % 4] = None;
        }
    }

    /// The nodes of a line: a row, or number of rows plus column.
    fn line(&self, line: usize) -> Vec<usize> {
        if line < self.rows {
            (0..self.columns).map(|i| line * self.columns + i).collect()
        } else {
            (0..self.rows).map(|j| j * self.columns + line - self.rows).collect()
        }
    }

    /// Links the nodes of a line to their neighbors on it.
    fn relink(&mut self, line: usize) {
        let ahead = usize::from(line >= self.rows);
        for pair in self.line(line).windows(2) {
            self.links[pair[0]][ahead] = Some(pair[1]);
            self.links[pair[1]][ahead + 2] = Some(pair[0]);
        }
    }

    /// Direction of the arm that leaves `node`: along the line through it where the line goes on behind.
    fn arm_heading(&self, node: usize, direction: usize, stream: &mut Stream) -> f64 {
        let wobble = stream.range(-0.1, 0.1);
        let Some(ahead) = self.links[node][direction] else { return 0.0 };
        match self.links[node][(direction + 2) % 4] {
            Some(behind) => heading_rad(self.at[ahead] - self.at[behind]),
            None => heading_rad(self.at[ahead] - self.at[node]) + wobble,
        }
    }
}

/// Draws the nodes of a grid, all linked to their neighbors.
pub(crate) fn draw_grid(stream: &mut Stream, config: &SuburbConfig) -> StreetGrid {
    let (columns, rows) = (config.blocks.0 + 1, config.blocks.1 + 1);
    let mut spread = |n: usize| {
        let mut at = vec![0.0];
        for i in 1..n {
            at.push(at[i - 1] + stream.within(config.block_m));
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
    StreetGrid { columns, rows, at, links }
}

/// Takes streets away until T-junctions prevail; no node is left with fewer than two streets.
pub(crate) fn thin(grid: &mut StreetGrid, stream: &mut Stream) {
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

/// One style a row, then one a column: a street keeps its width across junctions. The faster ones, of which main roads are
/// made, may run along the border unless `are_inner`, as trams need it.
pub(crate) fn draw_styles(
    stream: &mut Stream,
    grid: &StreetGrid,
    sidewalk_m: (f64, f64),
    are_inner: bool,
) -> Vec<LineStyle> {
    let lines = grid.rows + grid.columns;
    let mut collector = |count: usize| {
        if are_inner && count > 2 { 1 + stream.below(count - 2) } else { stream.below(count) }
    };
    let collectors = [collector(grid.rows), grid.rows + collector(grid.columns)];
    let second = stream.chance(0.5);
    (0..lines)
        .map(|line| {
            let collector = line == collectors[0] || (second && line == collectors[1]);
            let (is_wide, wide_m) = (stream.chance(WIDE_SHARE), stream.range(6.8, 9.5));
            let usual_m = if collector { stream.range(5.8, 6.5) } else { stream.range(4.75, 5.6) };
            let carriageway = if is_wide { wide_m } else { usual_m };
            let sidewalk_m = (stream.within(sidewalk_m) * 10.0).round() / 10.0;
            LineStyle::new((carriageway * 10.0).round() / 20.0, sidewalk_m, if collector { 50 } else { 30 })
        })
        .collect()
}

/// Makes main roads of some of the streets that are faster than others.
pub(crate) fn widen_main_roads(stream: &mut Stream, share: f64, styles: &mut [LineStyle]) {
    for style in styles.iter_mut().filter(|s| s.speed_kmh > 30) {
        let (is_main, has_two, has_median) =
            (stream.chance(share), stream.chance(TWO_LANES_SHARE), stream.chance(MEDIAN_SHARE));
        let (lane_m, median_m) = (stream.range(3.0, 3.3), stream.range(1.6, 6.0));
        let sidewalk_m = stream.range(2.0, 3.0);
        if is_main {
            style.lanes_per_side = if has_two { 2 } else { 1 };
            style.median_width_m = if has_median || !has_two { (median_m * 10.0).round() / 10.0 } else { 0.0 };
            style.lane_width_m = (lane_m * 20.0).round() / 20.0;
            style.sidewalk_width_m = (sidewalk_m * 10.0).round() / 10.0;
        }
    }
}

/// Lays the two tracks of a tram in some of the main roads that cross the suburb from one side to the other.
pub(crate) fn lay_tracks(stream: &mut Stream, share: f64, styles: &mut [LineStyle], grid: &mut StreetGrid) {
    for (line, style) in styles.iter_mut().enumerate() {
        let (has_tracks, bed_m) = (stream.chance(share), stream.within(TRACK_BED_M));
        let bed = stream.pick(&TRACK_BEDS);
        let is_border = [0, grid.rows - 1, grid.rows, grid.rows + grid.columns - 1].contains(&line);
        // Trams don't take the bends at the corners of a suburb.
        let ends_at_junctions = grid.line(line).iter().all(|n| grid.degree(*n) >= 3 || !grid.is_border(*n));
        if has_tracks && style.is_main_road() && !is_border && ends_at_junctions {
            grid.relink(line);
            style.tracks = Some(bed);
            style.median_width_m = (bed_m * 5.0).round() / 5.0;
        }
    }
}

/// Which end of a street; an index of what it has at both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WhichEnd {
    Start,
    Finish,
}

/// A walk along the grid from one junction to the next.
pub(crate) struct Chain {
    pub nodes: Vec<usize>,
    /// The direction of the walk's first arm at its first node, and of its last arm at its last node.
    pub leaves: usize,
    pub arrives: usize,
    /// Row, or number of rows plus column.
    pub line: usize,
}

impl Chain {
    /// The node at an end.
    pub fn node(&self, end: WhichEnd) -> usize {
        match end {
            WhichEnd::Start => self.nodes[0],
            WhichEnd::Finish => self.nodes[self.nodes.len() - 1],
        }
    }
}

/// The streets of the grid, each once, and the heading of every arm.
pub(crate) fn trace(grid: &StreetGrid, stream: &mut Stream) -> (Vec<Chain>, Vec<[f64; 4]>) {
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
