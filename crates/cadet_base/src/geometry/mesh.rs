//! Triangle meshes and their bounds.

use super::bounds::Bounds;
use super::cluster::{Cluster, clusters_of};
use super::columns::{LazyColumns, SurfaceColumn};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// A triangle mesh in its own local frame.
///
/// Faces are counter-clockwise seen from outside. Vertices are repeated where the shading has a crease.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Local coordinates, meters.
    pub vertices: Vec<Vec3>,
    /// Unit shading normals, one a vertex.
    pub normals: Vec<Vec3>,
    /// Three vertex indices a face.
    pub faces: Vec<[u32; 3]>,
    /// Material slot of each face: an index into the instance's [`crate::material::Palette`].
    pub slots: Vec<u8>,
    /// Bounds of the vertices.
    pub bounds: Bounds,
    /// The faces in small groups.
    pub clusters: Vec<Cluster>,
    columns: LazyColumns,
}

impl Mesh {
    /// Checks the arrays and makes a mesh of them.
    ///
    /// # Errors
    /// [`Error::Mesh`]: arrays of unequal length, an index out of range, a coordinate that is not finite, no face.
    pub fn new(
        name: &str,
        vertices: Vec<Vec3>,
        normals: Vec<Vec3>,
        faces: Vec<[u32; 3]>,
        slots: Vec<u8>,
    ) -> Result<Self> {
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
        if vertices.iter().chain(&normals).any(|v| !v.is_finite()) {
            return fail("a coordinate is not finite".to_owned());
        }
        let bounds = Bounds::of(vertices.iter().copied());
        let clusters = clusters_of(&vertices, &normals, &faces, &slots, &bounds);
        Ok(Self { vertices, normals, faces, slots, bounds, clusters, columns: LazyColumns::default() })
    }

    /// Returns this mesh, longer, wider and higher by factors above 0: normals stay upright on what they stand on.
    #[must_use]
    pub fn stretched(&self, scale: Vec3) -> Self {
        let vertices: Vec<Vec3> = self.vertices.iter().map(|v| *v * scale).collect();
        let normals = self.normals.iter().map(|n| (*n / scale).normalize()).collect();
        let bounds = Bounds { min: self.bounds.min * scale, max: self.bounds.max * scale };
        let clusters = self.clusters.iter().map(|c| c.stretched(scale)).collect();
        let (faces, slots) = (self.faces.clone(), self.slots.clone());
        Self { vertices, normals, faces, slots, bounds, clusters, columns: LazyColumns::default() }
    }

    /// Where a cluster has surfaces, seen from above; found at the first question.
    #[inline]
    #[must_use]
    pub fn columns_of(&self, cluster: usize) -> &[SurfaceColumn] {
        self.columns.of(&self.clusters, cluster)
    }

    /// Renumbers faces and vertices along the clusters, so that a walk over a cluster reads memory in order.
    #[must_use]
    pub fn in_cluster_order(self) -> Self {
        let order = self.clusters.iter().flat_map(|c| &c.faces);
        let (mut faces, mut slots) = (Vec::with_capacity(self.faces.len()), Vec::with_capacity(self.slots.len()));
        let (mut vertices, mut normals) = (Vec::new(), Vec::new());
        let mut renumbered = vec![u32::MAX; self.vertices.len()];
        for face in order.map(|f| *f as usize) {
            slots.push(self.slots[face]);
            faces.push(self.faces[face].map(|v| {
                let number = &mut renumbered[v as usize];
                if *number == u32::MAX {
                    *number = vertices.len() as u32;
                    vertices.push(self.vertices[v as usize]);
                    normals.push(self.normals[v as usize]);
                }
                *number
            }));
        }
        // Meshes of assets live as long as the process.
        vertices.shrink_to_fit();
        normals.shrink_to_fit();
        let bounds = Bounds::of(vertices.iter().copied());
        if bounds != self.bounds {
            // Vertices that no face has are gone, and with them the grid that faces were sorted by.
            let clusters = clusters_of(&vertices, &normals, &faces, &slots, &bounds);
            return Self { vertices, normals, faces, slots, bounds, clusters, columns: LazyColumns::default() };
        }
        let mut clusters = self.clusters;
        for (number, face) in (0..).zip(clusters.iter_mut().flat_map(|c| &mut c.faces)) {
            *face = number;
        }
        Self { vertices, normals, faces, slots, bounds, clusters, columns: LazyColumns::default() }
    }
}
