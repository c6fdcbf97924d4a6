//! Small groups of neighboring faces, for rejecting many triangles with one question.

use super::bounds::Bounds;
use super::closed::closed_surfaces;
use super::lanes::{LANES, Lanes, lanes_of};
use super::normal_cone::NormalCone;
use super::packed_normal::PackedNormal;
use super::pieces::{MeshPiece, MeshSlices, pieces_of};
use super::places::lowest_at_place;
use crate::material::slot_bit;
use crate::math::Vec3;

/// The most faces in a cluster.
pub const CLUSTER_FACES: usize = 64;
/// No cluster has more vertices: a `u8` counts them.
pub const CLUSTER_VERTICES: usize = 256;
/// A corner's normal is looked for among so many that were noted last: most are those of a neighbor.
const LATE_NORMALS: usize = 16;

/// A triangle of a cluster.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClusterFace {
    /// Its corners, as indices into [`Cluster::lanes`].
    pub corners: [u8; 3],
    /// Its material slot: an index into the instance's [`crate::material::Palette`].
    pub slot: u8,
    /// The shading normals of its corners, as indices into [`Cluster::normals`].
    pub normals: [u8; 3],
}

/// Up to [`CLUSTER_FACES`] neighboring faces of a mesh, with their own short list of vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Cluster {
    /// Middle of the bounding sphere, local coordinates.
    pub center: Vec3,
    /// Radius of the bounding sphere, meters.
    pub radius_m: f32,
    /// Bit s is set where a face has material slot s; bit 63 stands for 63 and above.
    pub slots: u64,
    /// As `slots`, of the closed surfaces that the faces belong to, as wholes.
    pub closed_slots: u64,
    /// The places of the faces' corners, local coordinates by eights. Vertices that differ in their normals alone share
    /// one.
    pub lanes: Vec<Lanes>,
    /// Its triangles.
    pub faces: Vec<ClusterFace>,
    /// Unit shading normals, which the faces share.
    normals: Vec<PackedNormal>,
    /// A bit for each face, the first the lowest: it belongs to a closed surface that turns its outside outwards.
    pub closed_faces: u64,
    /// The faces as they are drawn: two that form a flat convex quadrilateral are one piece.
    pub pieces: Vec<ClusterPiece>,
    /// About the faces' normals, if all of them belong to closed surfaces.
    pub normal_cone: NormalCone,
    /// As `closed_faces`, for each piece.
    pub closed_pieces: u64,
}

impl Cluster {
    /// Returns this cluster, longer, wider and higher by factors above 0.
    pub(super) fn stretched(&self, scale: Vec3) -> Self {
        let along = scale.to_array();
        let stretched = |lanes: &Lanes| -> Lanes { std::array::from_fn(|k| lanes[k].map(|v| v * along[k])) };
        let mut cluster = Self {
            center: self.center * scale,
            // A little more, for rounding.
            radius_m: self.radius_m * scale.max_element() * 1.000_001,
            slots: self.slots,
            closed_slots: self.closed_slots,
            lanes: self.lanes.iter().map(stretched).collect(),
            faces: self.faces.clone(),
            normals: self.normals.iter().map(|n| PackedNormal::of(n.unpacked() / scale)).collect(),
            closed_faces: self.closed_faces,
            pieces: self.pieces.clone(),
            closed_pieces: self.closed_pieces,
            normal_cone: NormalCone::NONE,
        };
        cluster.find_normal_cone();
        cluster
    }

    fn find_normal_cone(&mut self) {
        if self.closed_faces.count_ones() as usize == self.faces.len() {
            self.normal_cone = NormalCone::of(self.faces.iter().map(|face| face.corners.map(|i| self.place(i))));
        }
    }

    /// A corner's place, local coordinates.
    #[inline(always)]
    #[must_use]
    pub fn place(&self, corner: u8) -> Vec3 {
        let (eight, k) = (&self.lanes[usize::from(corner) / LANES], usize::from(corner) % LANES);
        Vec3::new(eight[0][k], eight[1][k], eight[2][k])
    }

    /// A unit shading normal, local coordinates; `index` is one of [`ClusterFace::normals`].
    #[inline(always)]
    #[must_use]
    pub fn normal(&self, index: u8) -> Vec3 {
        self.normals[usize::from(index)].unpacked()
    }

    /// The places of its corners, local coordinates; the last one several times.
    pub fn places(&self) -> impl Iterator<Item = Vec3> {
        self.lanes.iter().flat_map(|[x, y, z]| (0..LANES).map(|k| Vec3::new(x[k], y[k], z[k])))
    }

    /// True if the faces bound a solid, nothing of which is transparent: seen from outside, near sides hide the far ones.
    #[inline(always)]
    #[must_use]
    pub fn is_of_solid(&self, transparent_slots: u64) -> bool {
        // Bit 63 may stand for several slots.
        self.closed_slots & transparent_slots == 0 && self.closed_slots >> 63 == 0
    }
}

/// A triangle or a quadrilateral, of one plane, one material and one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClusterPiece {
    /// Its corners in the order of its first face's, as indices into [`Cluster::lanes`]; a triangle's last one stands
    /// twice.
    pub corners: [u8; 4],
    /// Which of the cluster's faces is its first; that one has the first three corners.
    pub first: u8,
}

impl ClusterPiece {
    /// True for two faces.
    #[inline]
    #[must_use]
    pub fn is_quad(&self) -> bool {
        self.corners[2] != self.corners[3]
    }
}

/// Sorts faces along a space-filling curve and cuts them into clusters; those of one piece stay together. Indices must be
/// valid, coordinates finite.
#[must_use]
pub fn clusters_of(
    vertices: &[Vec3],
    normals: &[Vec3],
    faces: &[[u32; 3]],
    slots: &[u8],
    bounds: &Bounds,
) -> Vec<Cluster> {
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
    let mut clusters = Vec::with_capacity(faces.len().div_ceil(CLUSTER_FACES));
    let (mut from, mut num_faces) = (0, 0);
    for (i, piece) in order.iter().enumerate() {
        let more = piece.faces().count();
        if num_faces + more > CLUSTER_FACES {
            clusters.push(maker.make(&order[from..i]));
            (from, num_faces) = (i, 0);
        }
        num_faces += more;
    }
    if from < order.len() {
        clusters.push(maker.make(&order[from..]));
    }
    clusters.shrink_to_fit();
    clusters
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
    last: Vec<(u32, u8)>,
    num_made: u32,
}

impl<'a> ClusterMaker<'a> {
    fn new(surface: MeshSlices<'a>, places: &'a [u32]) -> Self {
        let normals = surface.normals.iter().map(|normal| PackedNormal::of(*normal)).collect();
        Self { surface, places, normals, last: vec![(u32::MAX, 0); places.len()], num_made: 0 }
    }

    fn make(&mut self, of: &[MeshPiece]) -> Cluster {
        let MeshSlices { vertices, faces, slots, closed, .. } = self.surface;
        let mut chunk = Vec::with_capacity(of.iter().map(|piece| piece.faces().count()).sum());
        chunk.extend(of.iter().flat_map(MeshPiece::faces).map(|face| face as usize));
        // Corners are numbered as they are met.
        let mut points: Vec<Vec3> = Vec::with_capacity(CLUSTER_VERTICES);
        let mut corner = |vertex: u32| {
            let place = self.places[vertex as usize] as usize;
            let last = &mut self.last[place];
            if last.0 != self.num_made {
                *last = (self.num_made, points.len() as u8);
                points.push(vertices[place]);
            }
            last.1
        };
        let (mut pieces, mut first) = (Vec::with_capacity(of.len()), 0);
        for piece in of {
            pieces.push(ClusterPiece { corners: piece.corners.map(&mut corner), first });
            first += piece.faces().count() as u8;
        }
        let mut normals: Vec<PackedNormal> = Vec::with_capacity(3 * CLUSTER_FACES);
        let mut normal = |vertex: u32| {
            let (normal, lately) = (self.normals[vertex as usize], normals.len().saturating_sub(LATE_NORMALS));
            let found = normals[lately..].iter().position(|n| *n == normal);
            let index = found.map_or(normals.len(), |i| lately + i);
            if found.is_none() {
                normals.push(normal);
            }
            index as u8
        };
        let mut of_cluster = Vec::with_capacity(chunk.len());
        of_cluster.extend(chunk.iter().map(|f| ClusterFace {
            corners: faces[*f].map(&mut corner),
            slot: slots[*f],
            normals: faces[*f].map(&mut normal),
        }));
        normals.shrink_to_fit();
        let center = Bounds::of(points.iter().copied()).center();
        let radius = points.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
        let mut cluster = Cluster {
            center,
            radius_m: radius * 1.000_01 + 1e-6,
            slots: chunk.iter().fold(0, |bits, f| bits | slot_bit(slots[*f])),
            closed_slots: chunk.iter().fold(0, |bits, f| bits | closed[*f]),
            pieces,
            closed_faces: bits_of(chunk.iter().map(|face| closed[*face] != 0)),
            closed_pieces: bits_of(of.iter().map(|piece| closed[piece.first as usize] != 0)),
            lanes: lanes_of(&points),
            faces: of_cluster,
            normals,
            normal_cone: NormalCone::NONE,
        };
        cluster.find_normal_cone();
        self.num_made += 1;
        cluster
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
    use crate::geometry::MeshBuilder;

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
        for c in &mesh.clusters {
            assert!(c.faces.len() <= CLUSTER_FACES);
            for face in &c.faces {
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
        for c in &mesh.clusters {
            let mut next = 0;
            for piece in &c.pieces {
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
        let pieces = mesh.clusters.iter().flat_map(|c| &c.pieces);
        assert_eq!(pieces.filter(|p| p.is_quad()).count(), 60 * 6);
    }
}
