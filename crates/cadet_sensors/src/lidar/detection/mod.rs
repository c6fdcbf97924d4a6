//! What a receiver makes of the power that reaches it: whether it is detected, and the intensity that is reported.

mod intensity;
mod laser_receiver;
mod receiver;
mod return_mode;
mod ring_receiver;

pub(super) use intensity::{intensity, reading_noise, saturated};
pub use laser_receiver::LaserReceiver;
pub(super) use laser_receiver::focused;
pub use receiver::{MAX_DIVERGENCE_RAD, Receiver};
pub use return_mode::ReturnMode;
pub(super) use ring_receiver::RingReceiver;
