//! Where in its row a house stands.

/// Where in its row a house stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CityKind {
    /// Between two others.
    Row,
    /// At the corner where the street's front begins: at the left end seen from the house.
    FirstCorner,
    /// At the corner where it ends.
    LastCorner,
}

impl CityKind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Row, Self::FirstCorner, Self::LastCorner];

    /// A short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Row => "city-row",
            Self::FirstCorner => "city-first-corner",
            Self::LastCorner => "city-last-corner",
        }
    }
}
