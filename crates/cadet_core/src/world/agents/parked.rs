//! Nobody is at the wheel, or somebody sits.

use super::controller::Controller;

/// Leaves a vehicle or a person where they are.
pub(crate) struct Parked;

impl Controller for Parked {}
