//! A flat convex polygon as planes through the camera: triangles, and quadrilaterals that are drawn as one.

use crate::sense::grids::EdgePlanes;
use cadet_base::math::{DVec3, greater, lesser};

/// The edges of a polygon with three or four corners, and its plane; see [`EdgePlanes`].
#[derive(Debug, Clone, Copy)]
pub(super) struct FacePlanes {
    /// a x b, b x c, and so on; a triangle's last one stands twice.
    pub edges: [DVec3; 4],
    pub is_quad: bool,
    /// (b - a) x (c - a).
    pub normal: DVec3,
    /// a · normal.
    pub volume6_m3: f64,
}

impl FacePlanes {
    /// Of a triangle in the camera's frame.
    #[inline(always)]
    pub fn triangle(corners: [DVec3; 3]) -> Self {
        let EdgePlanes { cross: [first, second, last], normal, volume6_m3: volume, .. } = EdgePlanes::new(corners);
        Self { edges: [first, second, last, last], is_quad: false, normal, volume6_m3: volume }
    }

    /// Of a quadrilateral that was flat and convex before its corners were rounded to single precision; `None` where it is
    /// not any more, as the camera sees it: so nearly from the side that its halves must be drawn by themselves.
    #[inline(always)]
    pub fn quad([a, b, c, d]: [DVec3; 4]) -> Option<Self> {
        let Self { edges: [first, second, ..], normal, volume6_m3: volume, .. } = Self::triangle([a, b, c]);
        let edges = [first, second, c.cross(d), d.cross(a)];
        // Six times the volumes of the tetrahedra of three corners in a row and the camera: all of one sign, or it is
        // seen dented.
        let volumes = [edges[0].dot(c), edges[1].dot(d), edges[2].dot(a), edges[3].dot(b)];
        let least = volumes.into_iter().fold(f64::INFINITY, |least, volume| lesser(volume, least));
        let most = volumes.into_iter().fold(f64::NEG_INFINITY, |most, volume| greater(volume, most));
        let out = Self { edges, is_quad: true, normal, volume6_m3: volume };
        ((least > 0.0) & (out.volume6_m3 > 0.0) | (most < 0.0) & (out.volume6_m3 < 0.0)).then_some(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math::{cos, sin};

    /// A square of a meter about a middle, turned about z and then about x.
    fn square(middle: DVec3, turn: f64, tilt: f64) -> [DVec3; 4] {
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| {
            let (x, y) = (x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn));
            middle + DVec3::new(x, y * cos(tilt), y * sin(tilt))
        })
    }

    #[test]
    fn a_beam_is_inside_of_a_quadrilateral_where_it_is_inside_of_a_half() {
        for k in 0..400 {
            let k = f64::from(k);
            let middle = DVec3::new(sin(k * 0.7) * 3.0, cos(k * 0.3) * 2.0, 4.0 + 3.0 * sin(k * 0.11));
            let [a, b, c, d] = square(middle, k, k * 0.37);
            let quad = FacePlanes::quad([a, b, c, d]).expect("seen from a side");
            let halves = [[a, b, c], [a, c, d]].map(FacePlanes::triangle);
            assert!(halves.iter().all(|half| half.volume6_m3.signum() == quad.volume6_m3.signum()));
            let is_in =
                |o: &FacePlanes, beam: DVec3| o.edges.iter().all(|e| e.dot(beam) * o.volume6_m3.signum() >= 0.0);
            for i in 0..400 {
                let beam = middle + DVec3::new(f64::from(i % 20) * 0.1 - 1.0, f64::from(i / 20) * 0.1 - 1.0, 0.0);
                assert_eq!(is_in(&quad, beam), halves.iter().any(|half| is_in(half, beam)), "{k} {i}");
            }
        }
    }

    #[test]
    fn what_is_seen_dented_or_from_the_rim_is_no_quadrilateral() {
        let flat = square(DVec3::new(0.0, 0.0, 5.0), 0.3, 0.0);
        assert!(FacePlanes::quad(flat).is_some());
        let mut bent = flat;
        bent[3] = (flat[0] + flat[2]) * 0.5 + (flat[1] - flat[3]) * 0.1;
        assert!(FacePlanes::quad(bent).is_none());
        // In a plane with the camera.
        let on_edge = flat.map(|p| DVec3::new(p.x, 0.0, 5.0 + p.y));
        assert!(FacePlanes::quad(on_edge).is_none());
    }
}
