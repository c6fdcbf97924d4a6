//! A plot beside a street, and its house.

use crate::plots::right_of;
use cadet_assets::scenery::House;
use cadet_base::math::DVec2;
use cadet_base::plane::OrientedRect;

/// A plot: a rectangle whose front lies along the sidewalk.
#[derive(Debug, Clone)]
pub(crate) struct Plot {
    /// Middle of the front.
    pub front: DVec2,
    /// Along the front, with the traffic beside it.
    pub along: DVec2,
    /// Extent along the front.
    pub length_m: f64,
    /// Extent away from the street.
    pub depth_m: f64,
    /// Its house, if it has one.
    pub house: Option<PlacedHouse>,
}

impl Plot {
    /// Away from the street.
    pub fn out(&self) -> DVec2 {
        right_of(self.along)
    }

    /// The place so far along the front from its middle, and so far behind it.
    pub fn at(&self, along_m: f64, behind_m: f64) -> DVec2 {
        self.front + self.along * along_m + self.out() * behind_m
    }

    /// A rectangle of the plot: from where to where along the front, and behind it.
    pub fn rect(&self, along_m: [f64; 2], behind_m: [f64; 2]) -> OrientedRect {
        let ([a0, a1], [d0, d1]) = (along_m, behind_m);
        let center = self.at((a0 + a1) / 2.0, (d0 + d1) / 2.0);
        OrientedRect { center, axis: self.along, half: DVec2::new((a1 - a0) / 2.0, (d1 - d0) / 2.0) }
    }

    /// Places along its front, half a meter apart.
    pub(super) fn front_line(&self) -> impl Iterator<Item = DVec2> + '_ {
        let steps = (self.length_m / 0.5).ceil();
        (0..=steps as usize).map(move |k| self.at(self.length_m * (k as f64 / steps - 0.5), 0.0))
    }

    /// The whole of it.
    pub fn whole(&self) -> OrientedRect {
        self.rect([-self.length_m / 2.0, self.length_m / 2.0], [0.0, self.depth_m])
    }

    /// What its house covers: one rectangle, or two where a corner is cut.
    pub fn house_parts(&self) -> Vec<OrientedRect> {
        let (Some(house), Some(whole)) = (&self.house, self.house_rect()) else { return Vec::new() };
        let Some(corner) = house.house.corner() else { return vec![whole] };
        let (w, d) = (house.size_m().y / 2.0, [house.setback_m, house.setback_m + whole.half.y * 2.0]);
        // The house looks toward the street, so its own y axis runs against the plot's.
        let strip = |a0: f64, a1: f64, d: [f64; 2]| {
            let (a0, a1) = if corner.side > 0.0 { (-a1, -a0) } else { (a0, a1) };
            self.rect([house.along_m + a0, house.along_m + a1], d)
        };
        // A hair's breadth apart: they are not to count as overlapping.
        let cut_at = w - corner.cut_m;
        vec![strip(-w, cut_at, d), strip(cut_at + 0.005, w, [d[0] + corner.cut_m, d[1]])]
    }

    /// The ground before the doors of its house, as wide as they are and at least `least_m`, from where to where behind the
    /// plot's front.
    pub fn before_doors(&self, least_m: f64, behind_m: [f64; 2]) -> Vec<OrientedRect> {
        let Some(house) = &self.house else { return Vec::new() };
        let before = |[y0, y1]: [f64; 2]| {
            // The house looks toward the street, so its own y axis runs against the plot's.
            let (middle_m, half_m) = (house.along_m - (y0 + y1) / 2.0, ((y1 - y0) / 2.0).max(least_m / 2.0));
            self.rect([middle_m - half_m, middle_m + half_m], behind_m)
        };
        house.house.doorways_m().into_iter().map(before).collect()
    }

    /// The walls of its house.
    pub fn house_rect(&self) -> Option<OrientedRect> {
        self.house.as_ref().map(|h| {
            let size = h.size_m();
            self.rect([h.along_m - size.y / 2.0, h.along_m + size.y / 2.0], [h.setback_m, h.setback_m + size.x])
        })
    }
}

/// A house on its plot.
#[derive(Debug, Clone)]
pub(crate) struct PlacedHouse {
    pub house: House,
    /// Middle of the house along the front, from the plot's middle.
    pub along_m: f64,
    /// Distance of its front wall from the plot's front.
    pub setback_m: f64,
    /// Bays of the garage beside it, 0 for none; it stands at the end of the plot where `along` grows.
    pub garage_bays: usize,
}

impl PlacedHouse {
    /// Depth and width of what it covers.
    pub fn size_m(&self) -> DVec2 {
        self.house.model.footprint_size()
    }
}
