//! Puts prototypes on the ground: single ones, and runs of hedge and fence.

use std::sync::Arc;

use crate::placement::{Boundary, Site};
use cadet_assets::scenery::materials::plant_palette;
use cadet_assets::scenery::{PIECE_LENGTHS_M, SceneryModel, TreeKind, hedge, num_variants, tree};
use cadet_base::frames;
use cadet_base::instance::Instance;
use cadet_base::material::Palette;
use cadet_base::math::{DPose3, DVec2, DVec3, TAU};
use cadet_base::plane::{OrientedRect, heading_rad};
use cadet_base::rng::Stream;

/// What stands on the ground: for the tests, and for what is placed later.
#[derive(Debug, Clone)]
pub(crate) struct PropFootprint {
    /// What it covers at the ground: trunks of trees, crowns of shrubs, walls of houses.
    pub rect: OrientedRect,
    /// The prototype's name.
    #[cfg_attr(not(test), allow(dead_code))]
    pub name: String,
}

/// The ground that a model covers whose x axis is along `facing`.
pub(crate) fn footprint(model: &SceneryModel, at: DVec2, facing: DVec2) -> OrientedRect {
    let axis = facing.normalize_or(DVec2::X);
    let middle = (model.footprint_min + model.footprint_max) / 2.0;
    let center = at + axis * middle.x + axis.perp() * middle.y;
    OrientedRect { center, axis, half: model.footprint_size() / 2.0 }
}

/// A tree or shrub of a kind, of any variant.
pub(crate) fn draw_plant(kind: TreeKind, s: &mut Stream) -> SceneryModel {
    let [_, variants, ..] = num_variants();
    tree(kind, s.below(variants))
}

/// The instances so far.
#[derive(Debug)]
pub(crate) struct Placer<'a> {
    pub site: &'a Site<'a>,
    pub instances: Vec<Instance>,
    pub standing: Vec<PropFootprint>,
    /// Ways to doors and garages.
    pub ways: Vec<OrientedRect>,
    /// What houses of closed rows cover.
    pub row_walls: Vec<OrientedRect>,
    /// Places for vehicles on lots.
    pub bays: Vec<OrientedRect>,
    /// Trunks and shrubs so far: place and radius.
    plants: Vec<(DVec2, f64)>,
}

impl<'a> Placer<'a> {
    /// Nothing yet.
    pub fn new(site: &'a Site<'a>) -> Self {
        Self {
            site,
            instances: Vec::new(),
            standing: Vec::new(),
            ways: Vec::new(),
            row_walls: Vec::new(),
            bays: Vec::new(),
            plants: Vec::new(),
        }
    }

    /// Puts a model upright, its x axis along `facing`; houses go to the mean height of their corners, but never so
    /// high that their foot shows.
    pub fn put(&mut self, model: &SceneryModel, palette: Arc<Palette>, at: DVec2, facing: DVec2) {
        let rect = footprint(model, at, facing);
        let heights = rect.corners().map(|c| self.site.on_ground(c).z);
        let lowest = heights.into_iter().fold(f64::INFINITY, f64::min);
        let mean = heights.iter().sum::<f64>() / 4.0;
        let position = at.extend(mean.min(lowest + 1.0));
        self.set(model, palette, frames::upright(position, heading_rad(rect.axis)), rect);
    }

    /// Puts a model in its own colors, as [`Self::put`].
    pub fn put_plain(&mut self, model: &SceneryModel, at: DVec2, facing: DVec2) {
        self.put(model, Arc::clone(&model.palette), at, facing);
    }

    /// Puts a model at a pose, where it covers a rectangle.
    fn set(&mut self, model: &SceneryModel, palette: Arc<Palette>, pose: DPose3, rect: OrientedRect) {
        self.instances.push(model.with_palette(palette, pose));
        self.standing.push(PropFootprint { rect, name: model.name.clone() });
    }

    /// What was put last covers these rectangles instead of all of its footprint.
    pub fn cover(&mut self, parts: &[OrientedRect]) {
        let Some(last) = self.standing.pop() else { return };
        self.standing.extend(parts.iter().map(|rect| PropFootprint { rect: *rect, name: last.name.clone() }));
    }

    /// Puts a tree or a shrub, turned anyhow, if it keeps its distance from other plants.
    pub fn plant(&mut self, kind: TreeKind, s: &mut Stream, at: DVec2) -> bool {
        let model = draw_plant(kind, s);
        self.plant_model(kind, &model, s, at)
    }

    /// Puts this very tree, if it keeps its distance from other plants.
    pub fn plant_model(&mut self, kind: TreeKind, model: &SceneryModel, s: &mut Stream, at: DVec2) -> bool {
        let radius = model.footprint_max.x;
        let apart = |(place, r): &(DVec2, f64)| (*place - at).length() >= 0.62 * (r + radius);
        // Only the latest ones can be near: plots are filled one after the other.
        if !self.plants.iter().rev().take(60).all(apart) {
            return false;
        }
        self.plants.push((at, radius));
        let palette = plant_palette(s, kind.is_evergreen());
        let yaw_rad = s.range(0.0, TAU);
        let position = self.site.on_ground(at) - DVec3::Z * 0.03;
        // The square inside a round crown.
        let half = if matches!(kind, TreeKind::Shrub | TreeKind::Conifer) { radius * 0.7 } else { 0.3 };
        let rect = OrientedRect { center: at, axis: DVec2::X, half: DVec2::splat(half) };
        self.set(model, palette, frames::upright(position, yaw_rad), rect);
        true
    }

    /// True where a vehicle may stand on a lot within `margin_m` of a place.
    pub fn is_bay(&self, at: DVec2, margin_m: f64) -> bool {
        self.bays.iter().any(|bay| bay.contains(at, margin_m))
    }

    /// True where a house stands within `margin_m` of a place.
    pub fn is_built(&self, at: DVec2, margin_m: f64) -> bool {
        // Latest first: the plots beside a frontage were filled just before.
        self.standing.iter().rev().take(1500).any(|s| s.rect.half.x > 2.5 && s.rect.contains(at, margin_m))
    }

    /// The pose of what lies along +x on the ground from one place to another.
    pub fn lying(&self, from: DVec2, to: DVec2) -> DPose3 {
        let (a, b) = (self.site.on_ground(from), self.site.on_ground(to));
        frames::facing(a, b - a, DVec3::Z)
    }

    /// Puts a piece that lies along +x on the ground between two places.
    pub fn lay(&mut self, model: &SceneryModel, palette: Arc<Palette>, from: DVec2, to: DVec2) {
        let (axis, half) = ((to - from).normalize_or(DVec2::X), model.footprint_size() / 2.0);
        let rect = OrientedRect { center: from + axis * half.x, axis, half };
        self.set(model, palette, self.lying(from, to), rect);
    }

    /// Lays a piece in its own colors, as [`Self::lay`].
    pub fn lay_plain(&mut self, model: &SceneryModel, from: DVec2, to: DVec2) {
        self.lay(model, Arc::clone(&model.palette), from, to);
    }

    /// Runs a boundary from one place to another, in one color.
    pub fn run(&mut self, boundary: Boundary, palette: &Arc<Palette>, from: DVec2, to: DVec2) {
        let length = (to - from).length();
        let along = (to - from).normalize_or_zero();
        let mut done = 0.0;
        while length - done > 0.25 {
            let left = length - done;
            let last = PIECE_LENGTHS_M.len() - 1;
            let piece = PIECE_LENGTHS_M.iter().position(|l| *l <= left + 0.02).unwrap_or(last);
            let step = PIECE_LENGTHS_M[piece];
            // The last piece moves back over the one before rather than beyond the end.
            let start = if left < step { (length - step).max(0.0) } else { done };
            let model = match boundary {
                Boundary::Hedge(variant) => hedge(variant, piece),
                Boundary::Fence(kind, variant) => kind.piece(variant, piece),
                Boundary::Open => return,
            };
            let pose = self.lying(from + along * start, from + along * (start + step));
            let center = from + along * (start + step / 2.0);
            let half = DVec2::new(step / 2.0, model.footprint_max.y);
            self.set(&model, Arc::clone(palette), pose, OrientedRect { center, axis: along, half });
            done = start + step;
        }
    }
}
