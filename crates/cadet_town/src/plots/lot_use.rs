//! What lots are for.

/// What the lots along a street are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LotUse {
    /// Rows of bays, some with a market behind.
    CarPark,
    /// Works, offices, and their yards.
    Industry,
    /// Institutes behind lawns.
    Campus,
}

impl LotUse {
    /// Shortest and longest front.
    pub fn length_m(self) -> (f64, f64) {
        match self {
            Self::CarPark => (22.0, 66.0),
            Self::Industry => (36.0, 78.0),
            Self::Campus => (24.0, 62.0),
        }
    }

    /// Depths, the deepest first.
    pub fn depths_m(self) -> &'static [f64] {
        match self {
            Self::CarPark => &[56.0, 46.0, 35.0, 26.0, 18.4, 14.6],
            Self::Industry => &[58.0, 50.0, 42.0, 34.0, 27.0],
            Self::Campus => &[44.0, 36.0, 30.0, 24.0],
        }
    }
}
