//! The kinds of belongings.

use strum::{AsRefStr, VariantArray};

/// A kind of thing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Thing {
    /// Open, over the head.
    Umbrella,
    /// Pushed with both hands, a child in it.
    Pram,
    /// On a lead.
    Dog,
    /// On wheels, pulled behind.
    Case,
    /// A frame on wheels that old people push.
    Rollator,
    /// A walking stick.
    Stick,
    /// A forearm crutch.
    Crutch,
    /// A forearm crutch for each arm.
    Crutches,
}

impl Thing {
    /// Whether it is carried; what is not stands or runs on the ground by itself.
    pub(super) fn is_carried(self) -> bool {
        matches!(self, Self::Umbrella | Self::Stick | Self::Crutch | Self::Crutches)
    }
}
