//! A flat convex polygon as planes through the camera: triangles, and quadrilaterals that are drawn as one.

use crate::math::DVec3;

/// The edges of a polygon with three or four corners, and its plane; see [`super::edges::EdgePlanes`], of which every
/// number of a triangle is the same, bit for bit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    /// a x b, b x c, and so on; a triangle's last one stands twice.
    pub edges: [DVec3; 4],
    pub is_quad: bool,
    /// (b - a) x (c - a).
    pub normal: DVec3,
    /// a · normal.
    pub volume: f64,
}

impl Outline {
    /// Of a triangle in the camera's frame.
    #[inline(always)]
    pub fn triangle([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let last = c.cross(a);
        Self { edges: [a.cross(b), b.cross(c), last, last], is_quad: false, normal, volume: a.dot(normal) }
    }

    /// Of a quadrilateral that was flat and convex before its corners were rounded to single precision; `None` where it is
    /// not any more, as the camera sees it: so nearly from the side that its halves must be drawn by themselves.
    #[inline(always)]
    pub fn quad([a, b, c, d]: [DVec3; 4]) -> Option<Self> {
        let normal = (b - a).cross(c - a);
        let edges = [a.cross(b), b.cross(c), c.cross(d), d.cross(a)];
        // Six times the volumes of the tetrahedra of three corners in a row and the camera: all of one sign, or it is seen dented.
        let volumes = [edges[0].dot(c), edges[1].dot(d), edges[2].dot(a), edges[3].dot(b)];
        let least = volumes.into_iter().fold(f64::INFINITY, |a, b| if b < a { b } else { a });
        let most = volumes.into_iter().fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a });
        let out = Self { edges, is_quad: true, normal, volume: a.dot(normal) };
        ((least > 0.0) & (out.volume > 0.0) | (most < 0.0) & (out.volume < 0.0)).then_some(out)
    }
}
