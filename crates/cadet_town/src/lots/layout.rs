//! What a lot is laid out with, in its own plane: x along its front from the middle, y behind it.

use crate::ground::land::YardSurface;
use crate::network::SpotKind;
use crate::placement::Boundary;
use cadet_assets::props::{Drawn, Shipped};
use cadet_assets::scenery::{HALL_VARIANTS, HallKind, SceneryModel, TreeKind, hall, hall_palette};
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// A place for a vehicle.
#[derive(Debug, Clone)]
pub(in super::super) struct Bay {
    pub at: DVec2,
    /// Of who stands nose in.
    pub heading: DVec2,
    pub length_m: f64,
    pub width_m: f64,
    pub kind: SpotKind,
}

/// Something that stands.
#[derive(Debug, Clone)]
pub(in super::super) struct LotItem {
    pub drawn: Drawn,
    /// Of the model's origin.
    pub at: DVec2,
    pub facing: DVec2,
}

/// All of a lot.
#[derive(Debug, Clone, Default)]
pub(in super::super) struct LotLayout {
    /// [from, to] along the front and behind it.
    pub paved: Vec<(YardSurface, [f64; 4])>,
    pub bays: Vec<Bay>,
    pub lines: Vec<[DVec2; 2]>,
    pub items: Vec<LotItem>,
    pub trees: Vec<(TreeKind, DVec2)>,
    pub borders: Vec<(Boundary, DVec2, DVec2)>,
    /// Width, and the line's corners.
    pub walks: Vec<(f64, Vec<DVec2>)>,
}

impl LotLayout {
    /// A place for a vehicle of a length and a width.
    pub fn bay(&mut self, kind: SpotKind, at: DVec2, heading: DVec2, (length_m, width_m): (f64, f64)) {
        self.bays.push(Bay { at, heading, length_m, width_m, kind });
    }

    pub fn prop(&mut self, prop: Shipped, at: DVec2, facing: DVec2, s: &mut Stream) {
        self.items.push(LotItem { drawn: prop.draw(s), at, facing });
    }

    /// A building whose front lies `front_m` behind the lot's and looks at the street.
    pub fn building(&mut self, kind: HallKind, model: SceneryModel, at_m: f64, front_m: f64, s: &mut Stream) {
        let at = DVec2::new(at_m, front_m + model.footprint_max.x);
        let drawn = Drawn { model, palette: hall_palette(kind, s), seats: Vec::new() };
        self.items.push(LotItem { drawn, at, facing: -DVec2::Y });
    }

    /// Street trees in a line where they are free to stand, none nearer to its ends than a meter and a half.
    pub fn tree_line(
        &mut self,
        [from, to]: [DVec2; 2],
        spacing_m: f64,
        s: &mut Stream,
        is_free: impl Fn(DVec2) -> bool,
    ) {
        let length_m = (to - from).length();
        let mut at_m = s.range(1.5, spacing_m);
        while at_m < length_m - 1.5 {
            let at = from.lerp(to, at_m / length_m);
            if is_free(at) {
                self.trees.push((TreeKind::Street, at));
            }
            at_m += spacing_m * s.range(0.85, 1.2);
        }
    }

    /// A boundary along a line that leaves gaps, [from, to] along x.
    pub fn border_along(&mut self, boundary: Boundary, [a0, a1]: [f64; 2], y: f64, gaps: &[[f64; 2]]) {
        let mut gaps = gaps.to_vec();
        gaps.sort_by(|p, q| p[0].total_cmp(&q[0]));
        let mut from = a0;
        for gap in gaps.iter().chain([&[a1, a1]]) {
            if gap[0].min(a1) > from + 0.7 {
                self.borders.push((boundary, DVec2::new(from, y), DVec2::new(gap[0].min(a1), y)));
            }
            from = from.max(gap[1]);
        }
    }
}

/// The largest of some buildings that fits, of the first kind that has one.
pub(super) fn fitting(
    kinds: &[HallKind],
    width_m: f64,
    depth_m: f64,
    s: &mut Stream,
) -> Option<(HallKind, SceneryModel)> {
    let fits = |m: &SceneryModel| m.footprint_size().y <= width_m && m.footprint_size().x <= depth_m;
    let area_m2 = |m: &SceneryModel| m.footprint_size().x * m.footprint_size().y;
    kinds.iter().find_map(|kind| {
        let first = s.below(HALL_VARIANTS);
        let drawn = (0..3).map(|k| hall(*kind, first + 3 * k)).chain([hall(*kind, 0)]);
        let largest = drawn.filter(fits).max_by(|a, b| area_m2(a).total_cmp(&area_m2(b)));
        largest.map(|model| (*kind, model))
    })
}
