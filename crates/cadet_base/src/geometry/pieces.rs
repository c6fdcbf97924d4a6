//! Pairs of faces that lie in one plane: who draws them takes them for one.

use super::edges::Edges;
use crate::math::{DVec3, Vec3};

/// What [`pieces_of`] needs of a mesh.
pub(super) struct MeshSlices<'a> {
    pub vertices: &'a [Vec3],
    /// Shading normals, one a vertex.
    pub normals: &'a [Vec3],
    pub faces: &'a [[u32; 3]],
    /// Material slots of the faces.
    pub slots: &'a [u8],
    /// See [`super::closed::closed_surfaces`].
    pub closed: &'a [u64],
}

/// One face of a mesh, or two that are drawn as one.
#[derive(Clone, Copy)]
pub(super) struct MeshPiece {
    pub first: u32,
    pub second: Option<u32>,
    /// Vertices, in the order of the first face's, which are the first three; a triangle's last one stands twice.
    pub corners: [u32; 4],
}

impl MeshPiece {
    pub fn faces(&self) -> impl Iterator<Item = u32> + Clone {
        std::iter::once(self.first).chain(self.second)
    }
}

/// A corner this far from the plane of the others lies in it, meters: far less than a sensor tells.
const FLAT_M: f64 = 2e-4;
/// A corner this far from the plane of the others lies in it, as a share of the shorter diagonal.
const FLAT: f64 = 5e-3;
/// How far the shading normal of the last corner may be from what the others' lead to.
const EVEN: f64 = 0.03;
/// The least weight of a corner of the first face on the second one, for normals that change: at the last corner of a
/// parallelogram it is -1.
pub const LEAST_WEIGHT: f32 = -2.0;
/// Sine of the least turn from one side to the next.
const LEAST_TURN: f64 = 1e-3;

/// Every face once, in order; two that share an edge, a plane and a material, and form a convex quadrilateral over which the
/// shading normal changes evenly, are one piece, which goes by its first face.
pub(super) fn pieces_of(surface: &MeshSlices<'_>) -> Vec<MeshPiece> {
    let edges = Edges::of(surface.vertices.len(), surface.faces.iter().copied());
    let mut pairs: Vec<MeshPiece> = Vec::with_capacity(surface.faces.len() / 2);
    for group in edges.by_corners() {
        if let [f, g] = group
            && let (f, g) = (f.face(), g.face())
            && let Some(corners) = quad(surface, [f, g])
        {
            pairs.push(MeshPiece { first: f, second: Some(g), corners });
        }
    }
    // Who made a quadrilateral wrote its halves one after the other.
    pairs.sort_by_key(|pair| (pair.second.map(|second| second - pair.first), pair.first));
    let mut is_paired = vec![false; surface.faces.len()];
    pairs.retain(|pair| {
        let is_free = pair.faces().all(|f| !is_paired[f as usize]);
        if is_free {
            pair.faces().for_each(|f| is_paired[f as usize] = true);
        }
        is_free
    });
    let alone = surface.faces.iter().zip(0..).filter(|(_, face)| !is_paired[*face as usize]);
    pairs.extend(alone.map(|([a, b, c], first)| MeshPiece { first, second: None, corners: [*a, *b, *c, *c] }));
    pairs.sort_unstable_by_key(|piece| piece.first);
    pairs
}

/// The corners of the quadrilateral that two faces form, in the order of the first, whose corners are the first three.
fn quad(surface: &MeshSlices<'_>, pair: [u32; 2]) -> Option<[u32; 4]> {
    let [f, g] = pair.map(|f| f as usize);
    if surface.slots[f] != surface.slots[g] || surface.closed[f] != surface.closed[g] {
        return None;
    }
    let (first, second) = (surface.faces[f], surface.faces[g]);
    // The shared edge is passed once each way.
    let turns = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]];
    let (corners, last) = turns(first).into_iter().find_map(|[a, b, c]| {
        turns(second).into_iter().find_map(|[p, q, r]| ((p, q) == (a, c)).then_some(([a, b, c], r)))
    })?;
    let [a, b, c] = corners;
    let quad = [a, b, c, last];
    let places = quad.map(|i| surface.vertices[i as usize].as_dvec3());
    let normals = quad.map(|i| surface.normals[i as usize].as_dvec3());
    (is_flat_and_convex(&places) && is_even(&places, &normals)).then_some(quad)
}

fn is_flat_and_convex(corners: &[DVec3; 4]) -> bool {
    let [a, b, c, d] = *corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let side = |i: usize| corners[(i + 1) % 4] - corners[i % 4];
    let turns = |i: usize| {
        let (from, to) = (side(i), side(i + 1));
        from.cross(to).dot(normal) > LEAST_TURN * from.length() * to.length()
    };
    let flat_m = FLAT_M.min(FLAT * a.distance(c).min(b.distance(d)));
    normal.dot(d - a).abs() <= flat_m && (0..4).all(turns)
}

/// True if the last corner's normal is about what follows from the others', linearly.
fn is_even([a, b, c, d]: &[DVec3; 4], [na, nb, nc, nd]: &[DVec3; 4]) -> bool {
    let (ab, ac, ad) = (b - a, c - a, d - a);
    let (d11, d12, d22) = (ab.dot(ab), ab.dot(ac), ac.dot(ac));
    let (along_b, along_c) = (ad.dot(ab), ad.dot(ac));
    let area2 = d11 * d22 - d12 * d12;
    let (wb, wc) = ((along_b * d22 - along_c * d12) / area2, (along_c * d11 - along_b * d12) / area2);
    let is_near = wb.min(wc).min(1.0 - wb - wc) >= f64::from(LEAST_WEIGHT);
    let expected = na + (nb - na) * wb + (nc - na) * wc;
    (is_near || (na == nb && na == nc)) && (expected.normalize_or_zero() - nd).length() <= EVEN
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No partner.
    const ALONE: u32 = u32::MAX;

    fn partners_of(vertices: &[Vec3], normals: &[Vec3], faces: &[[u32; 3]]) -> Vec<u32> {
        let (slots, closed) = (vec![0; faces.len()], vec![0; faces.len()]);
        let mut partners = vec![ALONE; faces.len()];
        for piece in pieces_of(&MeshSlices { vertices, normals, faces, slots: &slots, closed: &closed }) {
            if let Some(second) = piece.second {
                (partners[piece.first as usize], partners[second as usize]) = (second, piece.first);
            }
        }
        partners
    }

    #[test]
    fn the_halves_of_a_rectangle_are_partners_unless_bent_or_dented_or_unevenly_shaded() {
        let at = |d: Vec3| [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), d];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let flat = [Vec3::Z; 4];
        assert_eq!(partners_of(&at(Vec3::Y), &flat, &faces), [1, 0]);
        assert_eq!(partners_of(&at(Vec3::Y + Vec3::Z * 1e-4), &flat, &faces), [1, 0]);
        assert_eq!(partners_of(&at(Vec3::Y + Vec3::Z * 1e-3), &flat, &faces), [ALONE; 2]);
        assert_eq!(partners_of(&at(Vec3::new(-0.5, -0.2, 0.0)), &flat, &faces), [ALONE; 2]);
        assert_eq!(partners_of(&at(Vec3::Y), &flat, &[[0, 1, 2], [2, 3, 0]]), [1, 0]);
        // Turned over, its other half would face the other way.
        assert_eq!(partners_of(&at(Vec3::Y), &flat, &[[0, 1, 2], [0, 3, 2]]), [ALONE; 2]);
        // As on a rounded column, and with one corner pulled aside.
        let turned = |by: f32| Vec3::new(by, 0.0, 1.0).normalize();
        let mut smooth = [0.0, 0.2, 0.2, 0.0].map(turned);
        assert_eq!(partners_of(&at(Vec3::Y), &smooth, &faces), [1, 0]);
        smooth[3] = turned(0.1);
        assert_eq!(partners_of(&at(Vec3::Y), &smooth, &faces), [ALONE; 2]);
        // Much smaller than its partner, the first does not tell how the normal goes on.
        let long = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.3, 0.0), Vec3::Y];
        assert_eq!(partners_of(&long, &[0.0, 0.02, 0.02, 0.0].map(turned), &faces), [ALONE; 2]);
        assert_eq!(partners_of(&long, &flat, &faces), [1, 0]);
    }
}
