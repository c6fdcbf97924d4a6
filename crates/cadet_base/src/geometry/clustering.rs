//! Faces of a mesh in clusters.

use super::bounds::Bounds;
use super::closed::closed_surfaces;
use super::cluster::{CLUSTER_FACES, CLUSTER_VERTICES, ClusterFace, ClusterPiece, ClusterSummary, Clusters};
use super::normal_cone::NormalCone;
use super::packed_normal::PackedNormal;
use super::pieces::{MeshPiece, MeshSlices, pieces_of};
use super::places::lowest_at_place;
use crate::material::slot_bit;
use crate::math::Vec3;

/// A corner's normal is looked for among so many that were noted last: most are those of a neighbor.
const LATE_NORMALS: usize = 16;

/// Sorts faces along a space-filling curve and cuts them into clusters; those of one piece stay together. Indices must be
/// valid, coordinates finite.
#[must_use]
pub fn clusters_of(vertices: &[Vec3], normals: &[Vec3], faces: &[[u32; 3]], slots: &[u8], bounds: &Bounds) -> Clusters {
    let places = lowest_at_place(vertices);
    let closed = closed_surfaces(vertices, &places, faces, slots);
    let surface = MeshSlices { vertices, normals, faces, slots, closed: &closed };
    let scale = 1023.0 / bounds.size().max_element().max(1e-6);
    // Of a pair the first face goes for both.
    let key = |piece: &MeshPiece| {
        let [a, b, c] = faces[piece.first as usize].map(|i| vertices[i as usize]);
        let q = ((a + b + c) * (1.0 / 3.0) - bounds.min) * scale;
        spread(q.x) | spread(q.y) << 1 | spread(q.z) << 2
    };
    // The pieces come by rising faces: of those at one place the first stays the first.
    let pieces = pieces_of(&surface);
    let mut order: Vec<u64> = pieces.iter().zip(0..).map(|(piece, number)| key(piece) << 32 | number).collect();
    order.sort_unstable();
    let order: Vec<MeshPiece> = order.into_iter().map(|number| pieces[number as u32 as usize]).collect();
    let mut maker = ClusterMaker::new(surface, &places);
    let (mut from, mut num_faces) = (0, 0);
    for (i, piece) in order.iter().enumerate() {
        let more = piece.faces().count();
        if num_faces + more > CLUSTER_FACES {
            maker.make(&order[from..i]);
            (from, num_faces) = (i, 0);
        }
        num_faces += more;
    }
    if from < order.len() {
        maker.make(&order[from..]);
    }
    maker.made.shrink_to_fit();
    maker.made
}

/// The low ten bits of a number, two zeros after each.
fn spread(x: f32) -> u64 {
    let x = x.clamp(0.0, 1023.0) as u64;
    let x = (x | x << 16) & 0x0300_00FF;
    let x = (x | x << 8) & 0x0300_F00F;
    let x = (x | x << 4) & 0x030C_30C3;
    (x | x << 2) & 0x0924_9249
}

/// Makes the clusters of a mesh, one after the other.
struct ClusterMaker<'a> {
    surface: MeshSlices<'a>,
    /// Of each vertex, the lowest vertex at its place.
    places: &'a [u32],
    /// Of each vertex.
    normals: Vec<PackedNormal>,
    /// By place: which cluster had a corner there last, and the corner's number.
    last: Vec<(usize, u8)>,
    made: Clusters,
}

impl<'a> ClusterMaker<'a> {
    fn new(surface: MeshSlices<'a>, places: &'a [u32]) -> Self {
        let normals = surface.normals.iter().map(|normal| PackedNormal::of(*normal)).collect();
        Self { surface, places, normals, last: vec![(usize::MAX, 0); places.len()], made: Clusters::new() }
    }

    fn make(&mut self, of: &[MeshPiece]) {
        let MeshSlices { vertices, faces, slots, closed, .. } = self.surface;
        let chunk = || of.iter().flat_map(MeshPiece::faces).map(|face| face as usize);
        // Corners are numbered as they are met.
        let (number, mut points) = (self.made.len(), Vec::with_capacity(CLUSTER_VERTICES));
        let mut corner = |vertex: u32| {
            let place = self.places[vertex as usize] as usize;
            let last = &mut self.last[place];
            if last.0 != number {
                *last = (number, points.len() as u8);
                points.push(vertices[place]);
            }
            last.1
        };
        let mut first = 0;
        for piece in of {
            self.made.pieces.push(ClusterPiece { corners: piece.corners.map(&mut corner), first });
            first += piece.faces().count() as u8;
        }
        let normals = &mut self.made.normals;
        let first_normal = normals.len();
        let mut normal = |vertex: u32| {
            let normal = self.normals[vertex as usize];
            let lately = first_normal.max(normals.len().saturating_sub(LATE_NORMALS));
            let found = normals[lately..].iter().position(|n| *n == normal);
            let index = found.map_or(normals.len(), |i| lately + i);
            if found.is_none() {
                normals.push(normal);
            }
            (index - first_normal) as u8
        };
        self.made.faces.extend(chunk().map(|f| ClusterFace {
            corners: faces[f].map(&mut corner),
            slot: slots[f],
            normals: faces[f].map(&mut normal),
        }));
        let center = Bounds::of(points.iter().copied()).center();
        let radius = points.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
        let summary = ClusterSummary {
            center,
            radius_m: radius * 1.000_01 + 1e-6,
            slots: chunk().fold(0, |bits, f| bits | slot_bit(slots[f])),
            closed_slots: chunk().fold(0, |bits, f| bits | closed[f]),
            closed_faces: bits_of(chunk().map(|face| closed[face] != 0)),
            closed_pieces: bits_of(of.iter().map(|piece| closed[piece.first as usize] != 0)),
            normal_cone: NormalCone::NONE,
        };
        self.made.end_cluster(&points, summary);
    }
}

/// The first as the lowest bit.
fn bits_of(flags: impl Iterator<Item = bool>) -> u64 {
    flags.zip(0..).fold(0, |bits, (flag, i)| bits | u64::from(flag) << i)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::geometry::{IndexedFaces, Mesh, MeshBuilder};
    use crate::rng::Stream;

    #[test]
    fn bits_are_spread_by_threes() {
        for x in 0..1024_u16 {
            let expected = (0..10).fold(0, |out, bit| out | u64::from(x >> bit & 1) << (3 * bit));
            assert_eq!(spread(f32::from(x)), expected, "{x}");
        }
        assert_eq!((spread(-3.0), spread(2000.0)), (0, spread(1023.0)));
    }

    #[test]
    fn clusters_hold_every_face_once_and_within_their_spheres() {
        let mut b = MeshBuilder::new();
        for i in 0..40 {
            let at = Vec3::new((i * 7 % 11) as f32, (i * 5 % 13) as f32, (i % 3) as f32);
            b.cuboid(at, at + Vec3::splat(0.9), (i % 5) as u8);
        }
        let mesh = b.build("boxes", 0.5);
        let key = |corners: [Vec3; 3], slot: u8| (corners.map(|p| p.to_array().map(f32::to_bits)), slot);
        let mut seen = BTreeMap::new();
        for c in mesh.clusters.iter() {
            assert!(c.faces.len() <= CLUSTER_FACES);
            for face in c.faces {
                let corners = face.corners.map(|k| c.place(k));
                *seen.entry(key(corners, face.slot)).or_insert(0) += 1;
                assert!(corners.iter().all(|p| p.distance(c.center) <= c.radius_m));
                assert!(c.slots & slot_bit(face.slot) != 0);
                let [p, q, r] = corners;
                let normals = face.normals.map(|n| c.normal(n));
                assert!(normals.into_iter().all(|n| (q - p).cross(r - p).normalize().distance(n) < 2e-4));
            }
        }
        let given = b.indexed(0.5);
        for (face, slot) in given.faces.iter().zip(&given.slots) {
            assert_eq!(seen.remove(&key(face.map(|i| given.vertices[i as usize]), *slot)), Some(1));
        }
        assert!(seen.is_empty());
    }

    #[test]
    fn corners_keep_their_normals_whether_or_not_the_one_before_has_the_same() {
        let mut given = IndexedFaces::default();
        let mut s = Stream::from_seed("normals", 0);
        let mut any = || Vec3::from_array([0; 3].map(|_| s.range(-1.0, 1.0) as f32));
        for _ in 0..300 {
            given.triangle([any(), any(), any()], Vec3::Z, 0);
        }
        // Some recur among the last few of a cluster, some later, and some in the next cluster alone.
        let few: Vec<Vec3> = (0..40).map(|_| any().normalize()).collect();
        given.normals = (0..given.vertices.len()).map(|i| few[i * i % 37 + i % 4]).collect();
        let mesh = Mesh::new("any", &given).unwrap();
        let key = |corners: [Vec3; 3]| corners.map(|p| p.to_array().map(f32::to_bits));
        let normals: BTreeMap<_, _> = given
            .faces
            .iter()
            .map(|face| (key(face.map(|i| given.vertices[i as usize])), face.map(|i| given.normals[i as usize])))
            .collect();
        assert_eq!((mesh.num_faces(), normals.len()), (300, 300));
        for number in mesh.face_numbers() {
            let expected = normals[&key(mesh.corners(number))];
            for (found, expected) in mesh.corner_normals(number).into_iter().zip(expected) {
                assert!(found.distance(expected) < 2e-4, "{number}: {found} {expected}");
            }
        }
    }

    #[test]
    fn pieces_are_the_faces_each_once() {
        let mut b = MeshBuilder::new();
        for i in 0..60 {
            let at = Vec3::new((i * 7 % 11) as f32, (i * 5 % 13) as f32, (i % 3) as f32);
            b.cuboid(at, at + Vec3::splat(0.9), (i % 5) as u8);
            // Beside the boxes, so that no corner is shared.
            let at = at + Vec3::new(0.03, 0.07, 40.0);
            b.triangle(at, at + Vec3::X, at + Vec3::new(0.3, 0.2, 0.9), 0);
        }
        let mesh = b.build("boxes and triangles", 0.5);
        for c in mesh.clusters.iter() {
            let mut next = 0;
            for piece in c.pieces {
                let ([p, q, r, s], first) = (piece.corners, usize::from(piece.first));
                assert_eq!(first, next);
                let same =
                    |face: [u8; 3], piece: [u8; 3]| (0..3).any(|k| [0, 1, 2].map(|i| face[(i + k) % 3]) == piece);
                assert!(same(c.faces[first].corners, [p, q, r]));
                if piece.is_quad() {
                    assert!(same(c.faces[first + 1].corners, [p, r, s]));
                    let slots = [first, first + 1].map(|i| c.faces[i].slot);
                    assert_eq!(slots[0], slots[1]);
                }
                next += if piece.is_quad() { 2 } else { 1 };
            }
            assert_eq!(next, c.faces.len());
        }
        let pieces = mesh.clusters.iter().flat_map(|c| c.pieces);
        assert_eq!(pieces.filter(|p| p.is_quad()).count(), 60 * 6);
    }
}
