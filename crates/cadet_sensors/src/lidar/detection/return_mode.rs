//! Which echoes are reported.

use strum::{AsRefStr, VariantArray};

use cadet_base::error::{Result, variant};

/// Which of the echoes of one pulse a sensor reports, of those that it detects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum ReturnMode {
    /// The one with the highest peak: how KITTI's sensor was set.
    #[default]
    Strongest,
    /// The farthest one.
    Last,
    /// The nearest one.
    First,
    /// The strongest and the last: one where they are the same.
    Dual,
    /// The three strongest.
    Triple,
}

impl ReturnMode {
    /// The mode of that name, such as `strongest`.
    ///
    /// # Errors
    /// [`cadet_base::Error::Unknown`], listing the names.
    pub fn from_name(name: &str) -> Result<Self> {
        variant("return mode", name, |known| known == name)
    }

    /// The names that [`ReturnMode::from_name`] knows.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        Self::VARIANTS.iter().map(AsRef::as_ref).collect()
    }

    /// Whether it reports echo `k` of those that are detected, given by their powers in the order of their ranges.
    pub(crate) fn reports(self, powers: &[f64], k: usize) -> bool {
        let rank = powers.iter().filter(|power| **power > powers[k]).count();
        let is_last = k + 1 == powers.len();
        match self {
            Self::Strongest => rank == 0,
            Self::Last => is_last,
            Self::First => k == 0,
            Self::Dual => rank == 0 || is_last,
            Self::Triple => rank < 3,
        }
    }
}
