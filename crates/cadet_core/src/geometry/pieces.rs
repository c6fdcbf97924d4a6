//! Pairs of faces that lie in one plane: who draws them takes them for one.

use crate::math::{DVec3, Vec3};

/// What [`partners`] asks of a mesh.
pub(super) struct Surface<'a> {
    pub vertices: &'a [Vec3],
    /// Shading normals, one a vertex.
    pub normals: &'a [Vec3],
    pub faces: &'a [[u32; 3]],
    /// Material slots of the faces.
    pub slots: &'a [u8],
    /// See [`super::closed::closed_surfaces`].
    pub closed: &'a [u64],
}

/// No partner.
pub(super) const ALONE: u32 = u32::MAX;
/// A corner this far from the plane of the others lies in it: share of the largest coordinate, which rounding moves by a
/// quarter of that.
const FLAT: f64 = 2.5e-7;
/// Sine of the least turn from one side to the next.
const LEAST_TURN: f64 = 1e-3;

/// For each face another one, whose partner it is, or [`ALONE`]. Both share an edge, a plane, a material and one shading
/// normal, and form a convex quadrilateral.
pub(super) fn partners(surface: &Surface<'_>) -> Vec<u32> {
    // Lower and higher vertex, and the face.
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * surface.faces.len());
    for ([a, b, c], face) in surface.faces.iter().zip(0..) {
        edges.extend([(a, b), (b, c), (c, a)].map(|(p, q)| (*p.min(q), *p.max(q), face)));
    }
    edges.sort_unstable();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [(.., f), (.., g)] = group
            && quad(surface, [*f, *g]).is_some()
        {
            pairs.push([*f, *g]);
        }
    }
    // Who made a quadrilateral wrote its halves one after the other.
    pairs.sort_unstable_by_key(|[f, g]| (f.abs_diff(*g), *f));
    let mut partners = vec![ALONE; surface.faces.len()];
    for [f, g] in pairs.into_iter().map(|pair| pair.map(|f| f as usize)) {
        if partners[f] == ALONE && partners[g] == ALONE {
            (partners[f], partners[g]) = (g as u32, f as u32);
        }
    }
    partners
}

/// The corners of the quadrilateral that two faces form, in the order of the first, whose corners are the first three.
pub(super) fn quad(surface: &Surface<'_>, pair: [u32; 2]) -> Option<[u32; 4]> {
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
    let normals = quad.map(|i| surface.normals[i as usize]);
    if normals.iter().any(|n| *n != normals[0]) {
        return None;
    }
    is_flat_and_convex(quad.map(|i| surface.vertices[i as usize].as_dvec3())).then_some(quad)
}

fn is_flat_and_convex(corners: [DVec3; 4]) -> bool {
    let [a, b, c, d] = corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let largest = corners.iter().fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    let side = |i: usize| corners[(i + 1) % 4] - corners[i % 4];
    let turns = |i: usize| {
        let (from, to) = (side(i), side(i + 1));
        from.cross(to).dot(normal) > LEAST_TURN * from.length() * to.length()
    };
    normal.dot(d - a).abs() <= 4.0 * FLAT * largest && (0..4).all(turns)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn partners_of(vertices: &[Vec3], normals: &[Vec3], faces: &[[u32; 3]]) -> Vec<u32> {
        let (slots, closed) = (vec![0; faces.len()], vec![0; faces.len()]);
        partners(&Surface { vertices, normals, faces, slots: &slots, closed: &closed })
    }

    #[test]
    fn the_halves_of_a_rectangle_are_partners_unless_bent_or_smooth_or_dented() {
        let at = |d: Vec3| [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), d];
        let faces = [[0, 1, 2], [0, 2, 3]];
        let flat = [Vec3::Z; 4];
        assert_eq!(partners_of(&at(Vec3::Y), &flat, &faces), [1, 0]);
        assert_eq!(partners_of(&at(Vec3::Y + Vec3::Z * 1e-3), &flat, &faces), [ALONE; 2]);
        assert_eq!(partners_of(&at(Vec3::new(0.6, 0.7, 0.0)), &flat, &faces), [ALONE; 2]);
        assert_eq!(partners_of(&at(Vec3::Y), &flat, &[[0, 1, 2], [2, 0, 3]]), [1, 0]);
        // Turned over, its other half would face the other way.
        assert_eq!(partners_of(&at(Vec3::Y), &flat, &[[0, 1, 2], [0, 3, 2]]), [ALONE; 2]);
        let mut smooth = flat;
        smooth[3] = Vec3::X;
        assert_eq!(partners_of(&at(Vec3::Y), &smooth, &faces), [ALONE; 2]);
    }
}
