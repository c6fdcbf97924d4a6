//! Where in its row a house stands.

use strum::{AsRefStr, VariantArray};

/// Where in its row a house stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, AsRefStr, VariantArray)]
#[strum(prefix = "city-", serialize_all = "kebab-case")]
pub enum CityKind {
    /// Between two others.
    Row,
    /// At the corner where the street's front begins: at the left end seen from the house.
    FirstCorner,
    /// At the corner where it ends.
    LastCorner,
}
