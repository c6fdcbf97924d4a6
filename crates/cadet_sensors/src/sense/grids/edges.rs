//! A triangle as three planes through the beams' origin.

use cadet_base::math::DVec3;

/// The set-up of the homogeneous edge test, in double precision.
///
/// A beam `d` from the origin `o` passes inside the edge a→b if `d · ((a - o) x (b - o))` has the right sign; no
/// clipping is needed, as points behind the origin carry their sign along. For `o = (0, 0, h)` that normal is
/// `a x b - o x (b - a)`: linear in h, so one set-up serves lasers at several heights.
///
/// Without fused operations `a x b` and `b x a` are exact opposites, bit for bit, and so is every sum made of them in
/// one order. Two triangles that share an edge therefore never both refuse a beam on it.
#[derive(Debug, Clone, Copy)]
pub struct EdgePlanes {
    /// a x b, b x c, c x a.
    pub cross: [DVec3; 3],
    /// b - a, c - b, a - c.
    pub delta: [DVec3; 3],
    /// (b - a) x (c - a).
    pub normal: DVec3,
    /// a · normal: six times the volume of the tetrahedron with the frame's origin.
    pub volume6_m3: f64,
}

impl EdgePlanes {
    /// The planes of a triangle given in the grid's frame.
    #[inline]
    #[must_use]
    pub fn new([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        Self {
            cross: [a.cross(b), b.cross(c), c.cross(a)],
            delta: [b - a, c - b, a - c],
            normal,
            volume6_m3: a.dot(normal),
        }
    }
}
