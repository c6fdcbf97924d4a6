//! Builds meshes face by face; normals come at the end, smooth below a crease angle.

use std::hash::BuildHasherDefault;

use super::bounds::Bounds;
use super::mesh::{IndexedFaces, Mesh};
use super::places::{ByPlace, place_key};
use crate::math::{Mat3, Vec3};

/// A mesh in the making: corners may be shared or repeated, [`MeshBuilder::build`] welds and splits them as needed.
#[derive(Debug, Clone, Default)]
pub struct MeshBuilder {
    positions: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    slots: Vec<u8>,
}

impl MeshBuilder {
    /// An empty mesh.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a corner and returns its index.
    #[inline]
    pub fn vertex(&mut self, position: Vec3) -> u32 {
        self.positions.push(position);
        (self.positions.len() - 1) as u32
    }

    /// Adds a triangle of existing corners, counter-clockwise from outside.
    #[inline]
    pub fn face(&mut self, corners: [u32; 3], slot: u8) {
        self.faces.push(corners);
        self.slots.push(slot);
    }

    /// Adds a triangle, counter-clockwise from outside.
    #[inline]
    pub fn triangle(&mut self, a: Vec3, b: Vec3, c: Vec3, slot: u8) {
        let corners = [self.vertex(a), self.vertex(b), self.vertex(c)];
        self.face(corners, slot);
    }

    /// Adds a planar quadrilateral, counter-clockwise from outside.
    #[inline]
    pub fn quad(&mut self, a: Vec3, b: Vec3, c: Vec3, d: Vec3, slot: u8) {
        let [a, b, c, d] = [a, b, c, d].map(|p| self.vertex(p));
        self.face([a, b, c], slot);
        self.face([a, c, d], slot);
    }

    /// Adds a box from its smallest to its largest corner.
    pub fn cuboid(&mut self, min: Vec3, max: Vec3, slot: u8) {
        let p = |i: usize| {
            Vec3::new(
                if i & 1 == 0 { min.x } else { max.x },
                if i & 2 == 0 { min.y } else { max.y },
                if i & 4 == 0 { min.z } else { max.z },
            )
        };
        for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            self.quad(p(a), p(b), p(c), p(d), slot);
        }
    }

    /// Joins closed rings of equal length into a tube; rings run counter-clockwise seen against the direction in
    /// which they follow each other. `caps` closes the first and the last ring with fans.
    ///
    /// # Panics
    /// If two rings differ in length, which is a bug in the asset.
    pub fn loft(&mut self, rings: &[Vec<Vec3>], slot: u8, caps: bool) {
        let indices: Vec<Vec<u32>> = rings.iter().map(|r| r.iter().map(|p| self.vertex(*p)).collect()).collect();
        for pair in indices.windows(2) {
            assert_eq!(pair[0].len(), pair[1].len(), "rings of a loft have equal length");
            let n = pair[0].len();
            for i in 0..n {
                let j = (i + 1) % n;
                self.face([pair[0][i], pair[0][j], pair[1][j]], slot);
                self.face([pair[0][i], pair[1][j], pair[1][i]], slot);
            }
        }
        if let (true, Some(first), Some(last)) = (caps, indices.first(), indices.last()) {
            for i in 1..first.len().saturating_sub(1) {
                self.face([first[0], first[i + 1], first[i]], slot);
                self.face([last[0], last[i], last[i + 1]], slot);
            }
        }
    }

    /// Appends another mesh in the making, moved by a linear map, which may mirror it, and an offset.
    pub fn append(&mut self, other: &Self, linear: Mat3, offset: Vec3) {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|p| linear * *p + offset));
        let is_mirrored = linear.determinant() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        self.faces.extend(other.faces.iter().map(|f| turned(f.map(|i| i + base))));
        self.slots.extend(&other.slots);
    }

    /// The corners so far, for last adjustments such as fitting the bounds.
    pub fn positions_mut(&mut self) -> &mut [Vec3] {
        &mut self.positions
    }

    /// The corners so far.
    #[must_use]
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Number of faces so far.
    #[must_use]
    pub fn num_faces(&self) -> usize {
        self.faces.len()
    }

    /// The bounds that the built mesh will have.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let corners = self.faces.iter().map(|f| f.map(|i| self.positions[i as usize]));
        Bounds::of(corners.filter(|c| has_area(area_normal(*c))).flatten())
    }

    /// Welds equal corners, drops faces without area, and gives each corner the area-weighted mean normal of those of
    /// its faces that lie within `crease_rad` of the face at hand.
    ///
    /// # Panics
    /// If no face with an area is left, which is a bug in the asset.
    #[must_use]
    pub fn build(&self, name: &str, crease_rad: f32) -> Mesh {
        Mesh::new(name, &self.indexed(crease_rad)).expect("an asset's mesh is valid")
    }

    /// Welds corners that lie at one place, and gives each vertex the normal of the faces about it, but those beyond
    /// creases.
    #[must_use]
    pub fn indexed(&self, crease_rad: f32) -> IndexedFaces {
        let cos_crease = crate::math::cosf(crease_rad);
        let mut welded = ByPlace::with_capacity_and_hasher(self.positions.len(), BuildHasherDefault::default());
        let mut points: Vec<Vec3> = Vec::with_capacity(self.positions.len());
        let remap: Vec<u32> = self
            .positions
            .iter()
            .map(|p| {
                *welded.entry(place_key(*p)).or_insert_with(|| {
                    points.push(*p);
                    (points.len() - 1) as u32
                })
            })
            .collect();
        let corner = |f: &[u32; 3]| f.map(|i| remap[i as usize]);
        let kept: Vec<([u32; 3], u8, Vec3)> = self
            .faces
            .iter()
            .zip(&self.slots)
            .map(|(f, s)| (corner(f), *s))
            .map(|(f, s)| (f, s, area_normal(f.map(|i| points[i as usize]))))
            .filter(|(_, _, n)| has_area(*n))
            .collect();
        let units: Vec<Vec3> = kept.iter().map(|k| k.2.normalize()).collect();
        let around = FacesAround::of(points.len(), kept.iter().map(|(f, _, _)| f));
        let (mut vertices, mut normals) = (Vec::with_capacity(points.len()), Vec::with_capacity(points.len()));
        // The copies of each point so far: the latest vertex of each point, and before each vertex the one before.
        let mut latest = vec![u32::MAX; points.len()];
        let mut before: Vec<u32> = Vec::with_capacity(points.len());
        let mut faces = Vec::with_capacity(kept.len());
        for ((f, _, _), own_unit) in kept.iter().zip(&units) {
            faces.push(f.map(|v| {
                let sum = around
                    .at(v)
                    .iter()
                    .filter(|i| units[**i as usize].dot(*own_unit) >= cos_crease)
                    .map(|i| kept[*i as usize].2)
                    .fold(Vec3::ZERO, |a, n| a + n);
                let normal = if sum.length_squared() > 0.0 { sum.normalize() } else { *own_unit };
                let mut copy = latest[v as usize];
                while copy != u32::MAX {
                    if place_key(normals[copy as usize]) == place_key(normal) {
                        return copy;
                    }
                    copy = before[copy as usize];
                }
                vertices.push(points[v as usize]);
                normals.push(normal);
                let number = (vertices.len() - 1) as u32;
                before.push(std::mem::replace(&mut latest[v as usize], number));
                number
            }));
        }
        IndexedFaces { vertices, normals, faces, slots: kept.iter().map(|k| k.1).collect() }
    }
}

/// Square to a triangle, twice as long as its area.
fn area_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

fn has_area(area_normal: Vec3) -> bool {
    area_normal.length_squared() > 1e-16
}

/// The faces at each point, by rising number.
struct FacesAround {
    first: Vec<u32>,
    faces: Vec<u32>,
}

impl FacesAround {
    fn of<'a>(num_points: usize, faces: impl Iterator<Item = &'a [u32; 3]> + Clone) -> Self {
        let mut first = vec![0; num_points + 1];
        for v in faces.clone().flatten() {
            first[*v as usize + 1] += 1;
        }
        for i in 0..num_points {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut all = vec![0; first[num_points] as usize];
        for (number, face) in (0..).zip(faces) {
            for v in face {
                let place = &mut next[*v as usize];
                all[*place as usize] = number;
                *place += 1;
            }
        }
        Self { first, faces: all }
    }

    fn at(&self, point: u32) -> &[u32] {
        let point = point as usize;
        &self.faces[self.first[point] as usize..self.first[point + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(mesh: &Mesh) -> f32 {
        mesh.triangles().map(|([a, b, c], _)| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn a_cuboid_is_closed_outward_and_creased() {
        let mut b = MeshBuilder::new();
        b.cuboid(Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 4.0, 6.0), 0);
        let mesh = b.build("box", 0.5);
        assert_eq!((mesh.num_faces(), b.indexed(0.5).vertices.len()), (12, 24));
        assert_eq!(mesh.bounds, b.bounds());
        assert!((volume(&mesh) - 6.0).abs() < 1e-5);
    }

    #[test]
    fn a_loft_with_caps_is_outward_and_smooth() {
        let ring = |z: f32| -> Vec<Vec3> {
            (0..32)
                .map(|i| i as f32 * std::f32::consts::TAU / 32.0)
                .map(|a| Vec3::new(crate::math::cosf(a), crate::math::sinf(a), z))
                .collect()
        };
        let mut b = MeshBuilder::new();
        b.loft(&[ring(0.0), ring(1.0)], 3, true);
        let mesh = b.build("tube", 0.6);
        assert!((volume(&mesh) - std::f32::consts::PI).abs() < 0.03, "{}", volume(&mesh));
        assert!(mesh.slots().all(|s| s == 3));
        for (p, n) in mesh.triangles().flat_map(|(corners, _)| corners).zip(mesh.normals()) {
            let side = Vec3::new(p.x, p.y, 0.0).dot(n);
            assert!(side > 0.99 || n.z.abs() > 0.99, "{p} {n}");
        }
    }
}
