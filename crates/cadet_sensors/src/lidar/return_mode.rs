//! Which echoes are reported.

use strum::{AsRefStr, VariantArray};

use cadet_base::error::{Result, variant};

/// Which of several echoes of one pulse a sensor reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum ReturnMode {
    /// The one with the most power: how KITTI's sensor was set.
    #[default]
    Strongest,
    /// The farthest one that is detected.
    Last,
}

impl ReturnMode {
    /// The mode of that name: `strongest` or `last`.
    ///
    /// # Errors
    /// [`cadet_base::Error::Unknown`], listing the names.
    pub fn from_name(name: &str) -> Result<Self> {
        variant("return mode", name, |known| known == name)
    }
}
