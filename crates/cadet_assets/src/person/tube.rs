//! Tubes of elliptical rings with smooth normals: limbs, trunk, head.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use cadet_base::geometry::{Bounds, IndexedFaces, LazyMesh, LodSet, Mesh};
use cadet_base::math::{Vec3, cosf, sinf};

/// One ring of a tube.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ring {
    pub center: Vec3,
    /// Along the tube, toward the next ring.
    pub along: Vec3,
    /// The direction of the first half axis; made square to `along`.
    pub forward: Vec3,
    /// Half axes along `forward` and square to it.
    pub half: [f32; 2],
    /// Material between this ring and the next.
    pub slot: u8,
    /// The coarsest level of detail that keeps the ring.
    pub level: usize,
}

impl Ring {
    /// A ring whose axes are the directions of `along` and `forward`.
    pub fn new(center: Vec3, [along, forward]: [Vec3; 2], half: [f32; 2], slot: u8, level: usize) -> Self {
        Self { center, along, forward, half, slot, level }
    }
}

/// Points of the unit circle at `k / sides` of a turn: cosine and sine.
fn circle(sides: usize) -> Cow<'static, [[f32; 2]]> {
    const MOST: usize = 24;
    static CIRCLES: [OnceLock<Vec<[f32; 2]>>; MOST + 1] = [const { OnceLock::new() }; MOST + 1];
    let angle = |k: usize| k as f32 / sides as f32 * std::f32::consts::TAU;
    let points = || (0..sides).map(|k| [cosf(angle(k)), sinf(angle(k))]).collect();
    match CIRCLES.get(sides) {
        Some(cell) => Cow::Borrowed(cell.get_or_init(points)),
        None => Cow::Owned(points()),
    }
}

/// Tubes in the making, with corners shared inside each.
#[derive(Debug, Default)]
pub(crate) struct Tubes {
    pub vertices: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    slots: Vec<u8>,
}

impl Tubes {
    /// Adds a tube with `sides` corners a ring, closed at both ends by domes. Each ring is cut off below `flat_fraction`
    /// of its first half axis (soles), -1 for whole ellipses.
    pub fn tube(&mut self, rings: &[Ring], sides: usize, level: usize, flat_fraction: f32) {
        let rings: Vec<&Ring> = rings.iter().filter(|r| r.level >= level).collect();
        let (Some(first), Some(last)) = (rings.first(), rings.last()) else { return };
        let start = self.vertices.len() as u32;
        let circle: Vec<[f32; 2]> = circle(sides).iter().map(|[u, v]| [u.max(flat_fraction), *v]).collect();
        self.vertices.reserve(rings.len() * sides + 2);
        for r in &rings {
            let across = r.along.cross(r.forward).normalize();
            let forward = across.cross(r.along).normalize();
            for [u, v] in &circle {
                self.vertices.push(r.center + forward * (u * r.half[0]) + across * (v * r.half[1]));
            }
        }
        let n = sides as u32;
        for (i, pair) in rings.windows(2).enumerate() {
            let (base, next) = (start + i as u32 * n, start + (i as u32 + 1) * n);
            for k in 0..n {
                let l = (k + 1) % n;
                self.face([base + k, base + l, next + l], pair[0].slot);
                self.face([base + k, next + l, next + k], pair[0].slot);
            }
        }
        let ends = [(first, start, -1.0_f32), (last, start + (rings.len() as u32 - 1) * n, 1.0)];
        for (ring, base, sign) in ends {
            let tip = self.vertices.len() as u32;
            let dome = 0.45 * ring.half[0].min(ring.half[1]);
            let sink = if flat_fraction > -1.0 {
                ring.forward * (0.5 * (1.0 + flat_fraction) * ring.half[0] * 0.5)
            } else {
                Vec3::ZERO
            };
            self.vertices.push(ring.center + ring.along * (sign * dome) + sink);
            for k in 0..n {
                let l = (k + 1) % n;
                self.face(if sign < 0.0 { [tip, base + l, base + k] } else { [tip, base + k, base + l] }, ring.slot);
            }
        }
    }

    fn face(&mut self, corners: [u32; 3], slot: u8) {
        self.faces.push(corners);
        self.slots.push(slot);
    }

    /// The shape of tubes, moved by an offset, whose levels of detail end at these distances and are made when they are
    /// needed.
    pub fn lods(
        name: &str,
        limits_m: [f32; 3],
        offset: Vec3,
        make: impl Fn(usize) -> Self + Send + Sync + 'static,
    ) -> LodSet {
        let bounds = Bounds::of(make(0).vertices.iter().map(|v| *v + offset));
        let make = Arc::new(make);
        let levels = limits_m.into_iter().enumerate().map(|(level, limit_m)| {
            let (make, name) = (Arc::clone(&make), name.to_owned());
            (limit_m, LazyMesh::new(move || make(level).into_mesh(&name, offset)))
        });
        LodSet { bounds, levels: levels.collect(), coarse_shadow_proxies: 2 }
    }

    /// The mesh with area-weighted smooth normals, moved by an offset.
    fn into_mesh(mut self, name: &str, offset: Vec3) -> Mesh {
        for v in &mut self.vertices {
            *v += offset;
        }
        let mut normals = vec![Vec3::ZERO; self.vertices.len()];
        for f in &self.faces {
            let [a, b, c] = f.map(|i| self.vertices[i as usize]);
            let area = (b - a).cross(c - a);
            for i in f {
                normals[*i as usize] += area;
            }
        }
        for n in &mut normals {
            *n = if n.length_squared() > 0.0 { n.normalize() } else { Vec3::Z };
        }
        Mesh::new(name, &IndexedFaces { vertices: self.vertices, normals, faces: self.faces, slots: self.slots })
            .expect("a person's mesh is valid")
    }
}
