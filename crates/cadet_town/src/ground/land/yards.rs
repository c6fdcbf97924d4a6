//! Paved ground beside streets: what covers it, where it lies in plan, and what is painted on it.

use strum::VariantArray;

use crate::network::PaintedQuad;
use crate::paint::Paint;
use cadet_base::math::{DVec2, DVec3};

/// What covers a yard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, VariantArray)]
pub(crate) enum YardSurface {
    /// As on carriageways.
    Asphalt,
    /// Blocks of concrete.
    Pavers,
    /// Large slabs.
    Slabs,
}

/// The yards of a town.
#[derive(Debug, Clone, Default)]
pub(crate) struct Yards {
    /// Outlines, which may overlap each other and streets.
    pub outlines: Vec<(YardSurface, [DVec2; 4])>,
    /// Lines on yards and on parking places; their heights do not count.
    pub lines: Vec<PaintedQuad>,
}

impl Yards {
    /// Lays the lines on a ground.
    pub fn paint(&self, surface_near: &dyn Fn(DVec3) -> Option<(f64, bool)>, quads: &mut Vec<PaintedQuad>) {
        let mut paint = Paint::new(surface_near, false);
        self.lines.iter().for_each(|line| paint.along(line));
        quads.append(&mut paint.quads);
    }
}
