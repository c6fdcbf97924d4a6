//! Ground that is taken: rectangles in the plane, and the streets.

use std::collections::BTreeMap;

use crate::math::{DVec2, DVec3};
use crate::plane::OrientedRect;
use crate::plane::bounds;
use crate::town::ground::land::fields::Crop;
use crate::town::ground::region::Ring;
use crate::town::{Ground, GroundKind};

const CELL_M: f64 = 16.0;

fn cells(min: DVec2, max: DVec2) -> impl Iterator<Item = (i32, i32)> {
    let index = |v: f64| (v / CELL_M).floor() as i32;
    let (x, y) = (index(min.x)..=index(max.x), index(min.y)..=index(max.y));
    x.flat_map(move |i| y.clone().map(move |j| (i, j)))
}

/// Rectangles that must stay apart.
#[derive(Debug, Clone, Default)]
pub(in crate::town) struct Occupancy {
    rects: Vec<OrientedRect>,
    grid: BTreeMap<(i32, i32), Vec<usize>>,
}

impl Occupancy {
    fn reach(rect: &OrientedRect) -> (DVec2, DVec2) {
        let corners = rect.corners();
        corners.iter().fold((corners[0], corners[0]), |(lo, hi), c| (lo.min(*c), hi.max(*c)))
    }

    /// True where no rectangle is met.
    pub fn is_free(&self, rect: &OrientedRect) -> bool {
        let (lo, hi) = Self::reach(rect);
        cells(lo, hi)
            .all(|c| self.grid.get(&c).is_none_or(|inside| inside.iter().all(|i| !self.rects[*i].overlaps(rect))))
    }

    /// True where no rectangle comes within `margin_m` of the point.
    pub fn is_free_at(&self, point: DVec2, margin_m: f64) -> bool {
        let square = OrientedRect { center: point, axis: DVec2::X, half: DVec2::splat(margin_m.max(0.01)) };
        self.is_free(&square)
    }

    /// Takes a rectangle.
    pub fn take(&mut self, rect: OrientedRect) {
        let (lo, hi) = Self::reach(&rect);
        for c in cells(lo, hi) {
            self.grid.entry(c).or_default().push(self.rects.len());
        }
        self.rects.push(rect);
    }
}

/// Where the streets are, sidewalks included, and how high the ground lies.
#[derive(Debug)]
pub(in crate::town) struct Site<'a> {
    ground: &'a Ground,
    /// Smallest corner of all streets.
    pub min: DVec2,
    /// Largest corner of all streets.
    pub max: DVec2,
    origin: DVec2,
    step_m: f64,
    columns: usize,
    rows: usize,
    /// Distance to the sidewalks' outline at each grid point, negative inside, at most [`MAX_MARGIN_M`].
    clearance_m: Vec<f32>,
}

/// The largest margin that [`Site::clearance_m`] can tell.
pub(in crate::town) const MAX_MARGIN_M: f64 = 6.0;
/// Finest step of the grid of clearances, and how many points it has at most.
const STEP_M: f64 = 0.75;
const MAX_POINTS: f64 = 4.0e6;

impl<'a> Site<'a> {
    /// Surveys the streets of a town.
    pub fn new(ground: &'a Ground) -> Self {
        let points = ground.sidewalk_outline().iter().flatten();
        let (min, max) = bounds(points.copied());
        let origin = min - DVec2::splat(MAX_MARGIN_M + 1.0);
        let size = max + DVec2::splat(MAX_MARGIN_M + 1.0) - origin;
        let step_m = STEP_M.max((size.x * size.y / MAX_POINTS).sqrt());
        let (columns, rows) = ((size.x / step_m).ceil() as usize + 1, (size.y / step_m).ceil() as usize + 1);
        let clearance_m = Vec::new();
        let mut squared_m2 = vec![MAX_MARGIN_M * MAX_MARGIN_M; columns * rows];
        let mut site = Self { ground, min, max, origin, step_m, columns, rows, clearance_m };
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); rows];
        for ring in ground.sidewalk_outline() {
            for (i, a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % ring.len()];
                site.lower_about(*a, b, &mut squared_m2);
                let (low, high) = if a.y < b.y { (*a, b) } else { (b, *a) };
                let row_of = |y: f64| ((y - origin.y) / step_m).ceil() as usize;
                for (row, list) in crossings.iter_mut().enumerate().take(row_of(high.y)).skip(row_of(low.y)) {
                    let y = origin.y + row as f64 * step_m;
                    list.push(low.x + (high.x - low.x) * (y - low.y) / (high.y - low.y));
                }
            }
        }
        site.clearance_m = squared_m2.iter().map(|v| v.sqrt() as f32).collect();
        for (row, mut list) in crossings.into_iter().enumerate() {
            list.sort_by(f64::total_cmp);
            for pair in list.chunks_exact(2) {
                let column_of = |x: f64| ((x - origin.x) / step_m).ceil() as usize;
                for column in column_of(pair[0])..column_of(pair[1]) {
                    let value = &mut site.clearance_m[row * columns + column];
                    *value = -*value;
                }
            }
        }
        site
    }

    /// Lowers the squares of the clearances about an edge of the outline.
    fn lower_about(&self, a: DVec2, b: DVec2, squared_m2: &mut [f64]) {
        let reach = DVec2::splat(MAX_MARGIN_M);
        let lo = ((a.min(b) - reach - self.origin) / self.step_m).ceil().max(DVec2::ZERO);
        let hi = ((a.max(b) + reach - self.origin) / self.step_m).floor();
        let (d, length_2) = (b - a, (b - a).length_squared().max(1e-12));
        for row in lo.y as usize..=(hi.y as usize).min(self.rows - 1) {
            for column in lo.x as usize..=(hi.x as usize).min(self.columns - 1) {
                let p = self.origin + DVec2::new(column as f64, row as f64) * self.step_m - a;
                let t = (p.dot(d) / length_2).clamp(0.0, 1.0);
                let known = &mut squared_m2[row * self.columns + column];
                *known = known.min((p - d * t).length_squared());
            }
        }
    }

    /// Distance from a place to the sidewalks' outline, negative on streets and under bridges, at most [`MAX_MARGIN_M`].
    pub fn clearance_m(&self, p: DVec2) -> f64 {
        if self.ground.is_near_bridge(p) {
            return -MAX_MARGIN_M;
        }
        let at = (p - self.origin) / self.step_m;
        if at.x < 0.0 || at.y < 0.0 || at.x >= (self.columns - 1) as f64 || at.y >= (self.rows - 1) as f64 {
            return MAX_MARGIN_M;
        }
        let (i, j) = (at.x as usize, at.y as usize);
        let (u, v) = (at.x - i as f64, at.y - j as f64);
        let value = |i: usize, j: usize| f64::from(self.clearance_m[j * self.columns + i]);
        let low = value(i, j) * (1.0 - u) + value(i + 1, j) * u;
        low * (1.0 - v) + (value(i, j + 1) * (1.0 - u) + value(i + 1, j + 1) * u) * v
    }

    /// What grows where in open country.
    pub fn fields(&self) -> &'a [(Crop, Vec<Ring>)] {
        self.ground.fields()
    }

    /// Whether cars drive or park at a place, or a bridge leads over it.
    pub fn is_road(&self, p: DVec2) -> bool {
        self.ground.kind_at(p.x, p.y) == Some(GroundKind::Road) || self.ground.is_near_bridge(p)
    }

    /// Whether a place is carriageway or sidewalk, or a bridge leads over it.
    pub fn is_street(&self, p: DVec2) -> bool {
        self.ground.kind_at(p.x, p.y).is_some_and(|kind| kind != GroundKind::Terrain) || self.ground.is_near_bridge(p)
    }

    /// The ground at a place.
    pub fn on_ground(&self, p: DVec2) -> DVec3 {
        p.extend(self.ground.height_at(p.x, p.y).unwrap_or(0.0))
    }

    /// True where no street comes within `margin_m` (at most [`MAX_MARGIN_M`]) of the place.
    pub fn is_clear(&self, p: DVec2, margin_m: f64) -> bool {
        self.clearance_m(p) >= margin_m
    }

    /// True where a whole rectangle keeps `margin_m` from every street.
    pub fn is_rect_clear(&self, rect: &OrientedRect, margin_m: f64) -> bool {
        rect.corners().into_iter().chain(rect.samples(1.5)).all(|p| self.is_clear(p, margin_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taken_ground_is_not_free_across_cells() {
        let mut taken = Occupancy::default();
        let rect = |x: f64, y: f64| OrientedRect { center: DVec2::new(x, y), axis: DVec2::X, half: DVec2::splat(5.0) };
        taken.take(rect(16.0, -16.0));
        assert!(!taken.is_free(&rect(24.0, -8.0)));
        assert!(taken.is_free(&rect(26.1, -16.0)));
        assert!(!taken.is_free_at(DVec2::new(22.0, -16.0), 1.5) && taken.is_free_at(DVec2::new(22.0, -16.0), 0.5));
    }
}
