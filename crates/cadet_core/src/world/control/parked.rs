//! Nobody is at the wheel.

use super::controller::Controller;

/// Leaves a vehicle where it stands.
pub(crate) struct Parked;

impl Controller for Parked {}
