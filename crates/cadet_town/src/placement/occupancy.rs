//! Ground that is taken: rectangles in the plane, and the streets.

use std::collections::BTreeMap;

use crate::ground::{Ground, GroundKind};
use crate::placement::{ClearanceGrid, MAX_MARGIN_M};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::{OrientedRect, bounds};

const CELL_M: f64 = 16.0;

fn cells(min: DVec2, max: DVec2) -> impl Iterator<Item = (i32, i32)> {
    let index = |v: f64| (v / CELL_M).floor() as i32;
    let (x, y) = (index(min.x)..=index(max.x), index(min.y)..=index(max.y));
    x.flat_map(move |i| y.clone().map(move |j| (i, j)))
}

/// Rectangles that must stay apart.
#[derive(Debug, Clone, Default)]
pub(crate) struct Occupancy {
    rects: Vec<OrientedRect>,
    grid: BTreeMap<(i32, i32), Vec<usize>>,
}

impl Occupancy {
    /// Ground of which some rectangles are taken.
    pub fn of(rects: impl IntoIterator<Item = OrientedRect>) -> Self {
        let mut taken = Self::default();
        rects.into_iter().for_each(|rect| taken.take(rect));
        taken
    }

    /// True where no rectangle is met.
    pub fn is_free(&self, rect: &OrientedRect) -> bool {
        let (lo, hi) = bounds(rect.corners());
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
        let (lo, hi) = bounds(rect.corners());
        for c in cells(lo, hi) {
            self.grid.entry(c).or_default().push(self.rects.len());
        }
        self.rects.push(rect);
    }
}

/// Where the streets are, sidewalks included, and how high the ground lies.
#[derive(Debug)]
pub(crate) struct Site<'a> {
    pub ground: &'a Ground,
    /// Smallest corner of all streets.
    pub min: DVec2,
    /// Largest corner of all streets.
    pub max: DVec2,
    clearance: ClearanceGrid,
}

impl<'a> Site<'a> {
    /// Surveys the streets of a town.
    pub fn new(ground: &'a Ground) -> Self {
        let outline = ground.sidewalk_outline();
        let (min, max) = bounds(outline.iter().flatten().copied());
        Self { ground, min, max, clearance: ClearanceGrid::new(outline) }
    }

    /// Distance from a place to the sidewalks' outline, negative on streets and under bridges, at most
    /// [`MAX_MARGIN_M`].
    pub fn clearance_m(&self, p: DVec2) -> f64 {
        if self.ground.is_near_bridge(p) {
            return -MAX_MARGIN_M;
        }
        self.clearance.at(p)
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

    /// True where no street comes within `margin_m` (at most that of [`Self::clearance_m`]) of the place.
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
