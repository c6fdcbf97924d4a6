//! Triangle meshes and their bounds.

use super::bounds::Bounds;
use super::cluster::{CLUSTER_FACES, Cluster, ClusterFace, Clusters};
use super::clustering::clusters_of;
use super::columns::{LazyColumns, SurfaceColumn};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// A triangle mesh in its own local frame.
///
/// Faces are counter-clockwise seen from outside. A face's number is that of [`face_number`]: numbers rise along the
/// clusters, with gaps where clusters are not full.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Bounds of the faces.
    pub bounds: Bounds,
    /// The faces in small groups.
    pub clusters: Clusters,
    columns: LazyColumns,
}

/// Triangles by indices, as meshes are made of them.
#[derive(Debug, Clone, Default)]
pub struct IndexedFaces {
    /// Local coordinates, meters; repeated where the shading has a crease.
    pub vertices: Vec<Vec3>,
    /// Unit shading normals, one a vertex.
    pub normals: Vec<Vec3>,
    /// Three vertex indices a face.
    pub faces: Vec<[u32; 3]>,
    /// Material slot of each face: an index into the instance's [`crate::material::Palette`].
    pub slots: Vec<u8>,
}

impl IndexedFaces {
    /// Adds a triangle with vertices of its own.
    pub fn triangle(&mut self, corners: [Vec3; 3], normal: Vec3, slot: u8) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.normals.extend([normal; 3]);
        self.faces.push([base, base + 1, base + 2]);
        self.slots.push(slot);
    }

    /// Adds other faces.
    pub fn extend(&mut self, other: Self) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(other.vertices);
        self.normals.extend(other.normals);
        self.faces.extend(other.faces.iter().map(|f| f.map(|i| i + base)));
        self.slots.extend(other.slots);
    }
}

/// The number of a face in a mesh: of its cluster, and of its place among that one's faces.
#[inline(always)]
#[must_use]
pub fn face_number(cluster: u32, place: usize) -> u32 {
    cluster * CLUSTER_FACES as u32 + place as u32
}

impl Mesh {
    /// Checks the arrays and makes a mesh of them.
    ///
    /// # Errors
    /// [`Error::Mesh`]: arrays of unequal length, an index out of range, a coordinate that is not finite, no face, or more
    /// faces than there are numbers.
    pub fn new(name: &str, IndexedFaces { vertices, normals, faces, slots }: &IndexedFaces) -> Result<Self> {
        let fail = |reason: String| Err(Error::Mesh { name: name.to_owned(), reason });
        if faces.is_empty() {
            return fail("no faces".to_owned());
        }
        if normals.len() != vertices.len() || slots.len() != faces.len() {
            return fail("arrays of unequal length".to_owned());
        }
        if let Some(bad) = faces.iter().flatten().find(|i| **i as usize >= vertices.len()) {
            return fail(format!("face index {bad} with {} vertices", vertices.len()));
        }
        if vertices.iter().chain(normals).any(|v| !v.is_finite()) {
            return fail("a coordinate is not finite".to_owned());
        }
        let bounds = Bounds::of(faces.iter().flatten().map(|i| vertices[*i as usize]));
        let clusters = clusters_of(vertices, normals, faces, slots, &bounds);
        if u32::try_from(clusters.len() * CLUSTER_FACES).is_err() {
            return fail(format!("{} faces", faces.len()));
        }
        Ok(Self { bounds, clusters, columns: LazyColumns::default() })
    }

    /// Returns this mesh, longer, wider and higher by factors above 0: normals stay upright on what they stand on.
    #[must_use]
    pub fn stretched(&self, scale: Vec3) -> Self {
        let bounds = Bounds { min: self.bounds.min * scale, max: self.bounds.max * scale };
        Self { bounds, clusters: self.clusters.stretched(scale), columns: LazyColumns::default() }
    }

    /// Where a cluster has surfaces, seen from above; found at the first question.
    #[inline]
    #[must_use]
    pub fn columns_of(&self, cluster: usize) -> &[SurfaceColumn] {
        self.columns.of(&self.clusters, cluster)
    }

    /// How many faces it has.
    #[must_use]
    pub fn num_faces(&self) -> usize {
        self.clusters.faces.len()
    }

    /// The numbers of all faces, rising.
    pub fn face_numbers(&self) -> impl Iterator<Item = u32> {
        (0..)
            .zip(self.clusters.iter())
            .flat_map(|(number, c)| (0..c.faces.len()).map(move |place| face_number(number, place)))
    }

    /// A face.
    #[inline(always)]
    #[must_use]
    pub fn face(&self, number: u32) -> ClusterFace {
        self.cluster_and_face(number).1
    }

    /// The corners of a face, local coordinates.
    #[inline(always)]
    #[must_use]
    pub fn corners(&self, number: u32) -> [Vec3; 3] {
        let (cluster, face) = self.cluster_and_face(number);
        face.corners.map(|corner| cluster.place(corner))
    }

    /// The unit shading normals of a face's corners.
    #[inline(always)]
    #[must_use]
    pub fn corner_normals(&self, number: u32) -> [Vec3; 3] {
        let (cluster, face) = self.cluster_and_face(number);
        face.normals.map(|normal| cluster.normal(normal))
    }

    #[inline(always)]
    fn cluster_and_face(&self, number: u32) -> (Cluster<'_>, ClusterFace) {
        let cluster = self.clusters.get(number as usize / CLUSTER_FACES);
        (cluster, cluster.faces[number as usize % CLUSTER_FACES])
    }

    /// The corners of all faces, local coordinates, and their material slots.
    pub fn triangles(&self) -> impl Iterator<Item = ([Vec3; 3], u8)> {
        self.clusters.iter().flat_map(|c| c.faces.iter().map(move |face| (face.corners.map(|k| c.place(k)), face.slot)))
    }

    /// The material slots of all faces.
    pub fn slots(&self) -> impl Iterator<Item = u8> {
        self.clusters.faces.iter().map(|face| face.slot)
    }

    /// The unit shading normals of all faces' corners.
    pub fn normals(&self) -> impl Iterator<Item = Vec3> {
        self.clusters.iter().flat_map(|c| c.faces.iter().flat_map(move |face| face.normals.map(|n| c.normal(n))))
    }

    /// The places of all corners, local coordinates, each once a cluster.
    pub fn places(&self) -> impl Iterator<Item = Vec3> {
        self.clusters.iter().flat_map(|cluster| cluster.places())
    }
}
