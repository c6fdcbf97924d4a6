//! Which faces of a mesh bound solids, whose inner sides are never seen from outside.

use super::edges::Edges;
use crate::material::slot_bit;
use crate::math::{DVec3, Vec3};

/// For each face that belongs to a closed surface, which turns its outside outwards, the bits of the surface's material
/// slots; 0 for others.
///
/// Every edge of such a surface is passed as often one way as the other, and it encloses a positive volume. Vertices at
/// one place count as one: `places` has, for each, the lowest at its place. From outside of the mesh's bounds, faces that
/// are turned away lie behind such as are turned to the viewer.
#[must_use]
pub(super) fn closed_surfaces(vertices: &[Vec3], places: &[u32], faces: &[[u32; 3]], slots: &[u8]) -> Vec<u64> {
    let edges = Edges::of(vertices.len(), faces.iter().map(|corners| corners.map(|i| places[i as usize])));
    let mut surfaces = DisjointSets((0..faces.len() as u32).collect());
    let mut is_open = vec![false; faces.len()];
    for group in edges.by_corners() {
        let forth = group.iter().filter(|e| e.is_forth()).count();
        if 2 * forth != group.len() {
            is_open[group[0].face() as usize] = true;
        }
        for pair in group.windows(2) {
            surfaces.join(pair[0].face(), pair[1].face());
        }
    }
    // By the number of a surface's first face.
    let mut volumes = vec![0.0; faces.len()];
    let mut slots_of = vec![0_u64; faces.len()];
    let mut surface_is_open = vec![false; faces.len()];
    for (corners, face) in faces.iter().zip(0..) {
        let surface = surfaces.of(face) as usize;
        // From a corner of the surface: far from the origin, little would be left of the sum.
        let origin = vertices[faces[surface][0] as usize].as_dvec3();
        let [a, b, c]: [DVec3; 3] = corners.map(|i| vertices[i as usize].as_dvec3() - origin);
        volumes[surface] += a.dot(b.cross(c));
        slots_of[surface] |= slot_bit(slots[face as usize]);
        surface_is_open[surface] |= is_open[face as usize];
    }
    (0..faces.len() as u32)
        .map(|face| surfaces.of(face) as usize)
        .map(|surface| {
            let is_closed = !surface_is_open[surface] && volumes[surface] > 1e-9;
            if is_closed { slots_of[surface] } else { 0 }
        })
        .collect()
}

/// Disjoint sets of faces.
struct DisjointSets(Vec<u32>);

impl DisjointSets {
    fn of(&mut self, face: u32) -> u32 {
        let mut at = face;
        while self.0[at as usize] != at {
            let above = self.0[self.0[at as usize] as usize];
            self.0[at as usize] = above;
            at = above;
        }
        at
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::places::lowest_at_place;
    use crate::geometry::{IndexedFaces, MeshBuilder};

    /// For each face, whether it belongs to a closed surface.
    fn closed(vertices: &[Vec3], faces: &[[u32; 3]]) -> Vec<bool> {
        closed_surfaces(vertices, &lowest_at_place(vertices), faces, &vec![0; faces.len()])
            .iter()
            .map(|slots| *slots != 0)
            .collect()
    }

    fn cuboid(at: Vec3, slot: u8) -> IndexedFaces {
        let mut b = MeshBuilder::new();
        b.cuboid(at, at + Vec3::new(1.0, 2.0, 3.0), slot);
        b.indexed(0.5)
    }

    #[test]
    fn a_box_is_closed_until_a_face_is_taken_away_or_turned_or_all_are() {
        // Far from the origin, as houses of a street's mesh are.
        for at in [Vec3::ZERO, Vec3::new(300.0, -200.0, 5.0)] {
            let mesh = cuboid(at, 0);
            // Its corners stand there once for each side's normal.
            assert!(mesh.vertices.len() > 8);
            assert_eq!(closed(&mesh.vertices, &mesh.faces), [true; 12]);
            assert_eq!(closed(&mesh.vertices, &mesh.faces[1..]), [false; 11]);
            let mut faces = mesh.faces.clone();
            faces[4].swap(1, 2);
            assert_eq!(closed(&mesh.vertices, &faces), [false; 12]);
            faces = mesh.faces.clone();
            faces.iter_mut().for_each(|f| f.swap(1, 2));
            assert_eq!(closed(&mesh.vertices, &faces), [false; 12]);
        }
    }

    #[test]
    fn surfaces_are_told_apart_with_their_slots() {
        let mut all = IndexedFaces::default();
        for (at, slot) in [(Vec3::ZERO, 3), (Vec3::new(1.0, 2.0, 3.0), 5), (Vec3::splat(9.0), 7)] {
            all.extend(cuboid(at, slot));
        }
        let IndexedFaces { vertices, faces, slots, .. } = all;
        // The first two boxes touch in a corner; of the last one the last face is missing.
        let found = closed_surfaces(&vertices, &lowest_at_place(&vertices), &faces[..35], &slots[..35]);
        let expected = [[1_u64 << 3; 12], [1 << 5; 12]].concat();
        assert_eq!(found[..24], expected);
        assert_eq!(found[24..], [0; 11]);
    }
}
