//! Points by eights, one array a coordinate: what the compiler puts into vector registers.

use crate::math::Vec3;

/// How many points are worked on together.
pub const LANES: usize = 8;

/// The x, y and z of [`LANES`] points.
pub type Lanes = [[f32; LANES]; 3];

/// Points by [`LANES`]; the last one fills what is left of the last eight.
#[must_use]
pub fn lanes_of(points: &[Vec3]) -> Vec<Lanes> {
    let eight = |chunk: &[Vec3]| {
        let point = |i: usize| chunk[i.min(chunk.len() - 1)];
        [std::array::from_fn(|i| point(i).x), std::array::from_fn(|i| point(i).y), std::array::from_fn(|i| point(i).z)]
    };
    points.chunks(LANES).map(eight).collect()
}
