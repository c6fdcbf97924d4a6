//! Small groups of neighboring faces, for rejecting many triangles with one question.

use std::ops::Deref;

use super::normal_cone::NormalCone;
use super::packed_normal::PackedNormal;
use crate::math::Vec3;

/// The most faces in a cluster.
pub const CLUSTER_FACES: usize = 64;
/// No cluster has more vertices: a `u8` counts them.
pub const CLUSTER_VERTICES: usize = 256;
/// How many points are worked on together.
pub const LANES: usize = 8;

/// The x, y and z of [`LANES`] points, one array a coordinate: what the compiler puts into vector registers.
pub type Lanes = [[f32; LANES]; 3];

/// A triangle of a cluster.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClusterFace {
    /// Its corners, as indices into [`Cluster::lanes`].
    pub corners: [u8; 3],
    /// Its material slot: an index into the instance's [`crate::material::Palette`].
    pub slot: u8,
    /// The shading normals of its corners, as indices for [`Cluster::normal`].
    pub normals: [u8; 3],
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

/// Bounds, material slots, and closed faces of a cluster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClusterSummary {
    /// Middle of the bounding sphere, local coordinates.
    pub center: Vec3,
    /// Radius of the bounding sphere, meters.
    pub radius_m: f32,
    /// Bit s is set where a face has material slot s; bit 63 stands for 63 and above.
    pub slots: u64,
    /// As `slots`, of the closed surfaces that the faces belong to, as wholes.
    pub closed_slots: u64,
    /// A bit for each face, the first the lowest: it belongs to a closed surface that turns its outside outwards.
    pub closed_faces: u64,
    /// As `closed_faces`, for each piece.
    pub closed_pieces: u64,
    /// About the faces' normals, if all of them belong to closed surfaces.
    pub normal_cone: NormalCone,
}

impl ClusterSummary {
    /// True if the faces bound a solid, nothing of which is transparent: seen from outside, near sides hide the far ones.
    #[inline(always)]
    #[must_use]
    pub fn is_of_solid(&self, transparent_slots: u64) -> bool {
        // Bit 63 may stand for several slots.
        self.closed_slots & transparent_slots == 0 && self.closed_slots >> 63 == 0
    }
}

/// Where a cluster begins in each array of [`Clusters`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Offsets {
    lanes: u32,
    faces: u32,
    pieces: u32,
    normals: u32,
}

/// Up to [`CLUSTER_FACES`] neighboring faces of a mesh, with their own short list of vertices.
#[derive(Debug, Clone, Copy)]
pub struct Cluster<'a> {
    summary: &'a ClusterSummary,
    /// The places of the faces' corners, local coordinates by eights; the last one fills what is left of the last eight.
    /// Vertices that differ in their normals alone share one.
    pub lanes: &'a [Lanes],
    /// Its triangles.
    pub faces: &'a [ClusterFace],
    /// The faces as they are drawn: two that form a flat convex quadrilateral are one piece.
    pub pieces: &'a [ClusterPiece],
    normals: &'a [PackedNormal],
}

impl Deref for Cluster<'_> {
    type Target = ClusterSummary;

    #[inline(always)]
    fn deref(&self) -> &ClusterSummary {
        self.summary
    }
}

impl<'a> Cluster<'a> {
    /// The places of its corners, local coordinates; the last one several times.
    pub fn places(&self) -> impl Iterator<Item = Vec3> + use<'a> {
        self.lanes.iter().flat_map(|[x, y, z]| (0..LANES).map(|k| Vec3::new(x[k], y[k], z[k])))
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
}

/// The clusters of a mesh: a summary of each, and one array of each kind for what they are made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Clusters {
    summaries: Vec<ClusterSummary>,
    /// Of each, and the arrays' ends.
    offsets: Vec<Offsets>,
    lanes: Vec<Lanes>,
    pub(super) faces: Vec<ClusterFace>,
    pub(super) pieces: Vec<ClusterPiece>,
    pub(super) normals: Vec<PackedNormal>,
}

impl Clusters {
    /// None yet.
    pub(super) fn new() -> Self {
        Self {
            summaries: Vec::new(),
            offsets: vec![Offsets::default()],
            lanes: Vec::new(),
            faces: Vec::new(),
            pieces: Vec::new(),
            normals: Vec::new(),
        }
    }

    /// A cluster.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, index: usize) -> Cluster<'_> {
        let [from, to] = [&self.offsets[index], &self.offsets[index + 1]];
        let range = |of: fn(&Offsets) -> u32| of(from) as usize..of(to) as usize;
        Cluster {
            summary: &self.summaries[index],
            lanes: &self.lanes[range(|at| at.lanes)],
            faces: &self.faces[range(|at| at.faces)],
            pieces: &self.pieces[range(|at| at.pieces)],
            normals: &self.normals[range(|at| at.normals)],
        }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = Cluster<'_>> {
        (0..self.len()).map(|index| self.get(index))
    }

    /// The summary of each.
    #[must_use]
    pub fn summaries(&self) -> &[ClusterSummary] {
        &self.summaries
    }

    /// How many they are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.summaries.len()
    }

    /// True if there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.summaries.is_empty()
    }

    /// Returns them longer, wider and higher by factors above 0.
    pub(super) fn stretched(&self, scale: Vec3) -> Self {
        let along = scale.to_array();
        let lanes = |lanes: &Lanes| -> Lanes { std::array::from_fn(|k| lanes[k].map(|v| v * along[k])) };
        let summary = |summary: &ClusterSummary| ClusterSummary {
            center: summary.center * scale,
            // A little more, for rounding.
            radius_m: summary.radius_m * scale.max_element() * 1.000_001,
            ..*summary
        };
        let mut stretched = Self {
            summaries: self.summaries.iter().map(summary).collect(),
            offsets: self.offsets.clone(),
            lanes: self.lanes.iter().map(lanes).collect(),
            faces: self.faces.clone(),
            pieces: self.pieces.clone(),
            normals: self.normals.iter().map(|n| PackedNormal::of(n.unpacked() / scale)).collect(),
        };
        for index in 0..stretched.len() {
            stretched.find_normal_cone(index);
        }
        stretched
    }

    /// Ends the cluster whose faces, pieces, and normals were added last, with the places of its corners and its summary;
    /// its normal cone is found.
    pub(super) fn end_cluster(&mut self, points: &[Vec3], summary: ClusterSummary) {
        self.lanes.extend(points.chunks(LANES).map(|eight| {
            let axes = [0, 1, 2];
            axes.map(|axis| std::array::from_fn(|i| eight[i.min(eight.len() - 1)][axis]))
        }));
        self.offsets.push(Offsets {
            lanes: self.lanes.len() as u32,
            faces: self.faces.len() as u32,
            pieces: self.pieces.len() as u32,
            normals: self.normals.len() as u32,
        });
        self.summaries.push(summary);
        self.find_normal_cone(self.len() - 1);
    }

    fn find_normal_cone(&mut self, index: usize) {
        let cluster = self.get(index);
        if cluster.closed_faces.count_ones() as usize == cluster.faces.len() {
            let triangles = cluster.faces.iter().map(|face| face.corners.map(|i| cluster.place(i)));
            self.summaries[index].normal_cone = NormalCone::of(triangles);
        }
    }

    /// Gives back the memory that was not needed.
    pub(super) fn shrink_to_fit(&mut self) {
        self.summaries.shrink_to_fit();
        self.offsets.shrink_to_fit();
        self.lanes.shrink_to_fit();
        self.faces.shrink_to_fit();
        self.pieces.shrink_to_fit();
        self.normals.shrink_to_fit();
    }
}
