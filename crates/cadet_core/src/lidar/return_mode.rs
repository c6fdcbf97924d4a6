//! Which echoes are reported.

use crate::error::{Error, Result};

/// Which of several echoes of one pulse a sensor reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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
    /// [`Error::Unknown`], listing the names.
    pub fn from_name(name: &str) -> Result<Self> {
        match name {
            "strongest" => Ok(Self::Strongest),
            "last" => Ok(Self::Last),
            _ => {
                Err(Error::Unknown { what: "return mode", name: name.to_owned(), known: "strongest, last".to_owned() })
            }
        }
    }
}
