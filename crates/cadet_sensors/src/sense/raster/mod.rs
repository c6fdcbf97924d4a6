//! The visibility buffer: which faces the samples of an image see.

mod block_rasterization;
mod depth_test;
mod outline;
mod rasterization;
mod visibility_buffer;

pub use depth_test::{ROW_BITS, bits_by_column};
pub use rasterization::{rasterize, rasterize_instances};
pub use visibility_buffer::{BLOCK, Block, DrawnFace, VisibilityBuffer};
