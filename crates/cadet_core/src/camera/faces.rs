//! Which faces were seen lately, and what of the sky they see: neighbouring pixels mostly show the same one.

use super::face::{Face, Kind, Raw, Stand};
use super::look::{Rays, View};
use super::pattern::hash2;
use super::shade::Light;
use crate::geometry::Mesh;
use crate::material::{Material, Pattern};
use crate::math::Vec3;
use crate::sense::{DrawnFace, PosedScene};

/// What collecting needs of a face that was made ready.
#[derive(Debug, Clone, Copy)]
struct Brief {
    kind: u32,
    instance: u32,
    /// Material and normal, in so many steps that the eye sees none.
    look: u32,
    /// The instance whose leaf it is, or [`NO_PLANT`].
    leaf_of: u32,
    /// Number of the block for which the sky's visibility was last found, and where it is kept.
    block: u32,
    open: u32,
}

/// A part of the image whose hits on a face share the sky's visibility.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Number of the block of 8 x 4 pixels.
    pub block: u32,
    /// Number of the square of 8 x 8 pixels, for leaves of one plant.
    pub square: u32,
}

/// What is known of a drawn face.
#[derive(Debug, Clone, Copy)]
struct Made {
    /// Index in [`Faces::faces`], or [`NOT_MADE`].
    index: u32,
    /// The plant of which it is a part, or [`NO_PLANT`].
    plant: u32,
}

const NOT_MADE: u32 = u32::MAX;
/// No block.
const NOWHERE: u32 = u32::MAX;

/// What shading needs of an instance, in single precision.
struct Placed<'a> {
    mesh: &'a Mesh,
    materials: &'a [Material],
    stand: Stand,
    /// Number of the square for which the sky's visibility of its leaves was last found, and where it is kept.
    square: u32,
    open: u32,
}

/// Faces and visibilities of the sky that were seen lately. Faces go by their numbers in the visibility buffer.
pub struct Faces<'a> {
    light: &'a Light,
    rays: &'a Rays,
    intrinsics: [f64; 4],
    drawn: &'a [DrawnFace],
    placed: Vec<Placed<'a>>,
    made: Vec<Made>,
    /// Drawn faces that are to be made, and how many they are.
    asked: Vec<u32>,
    asked_count: usize,
    raw: Vec<Raw>,
    /// All since the last `forget`.
    pub faces: Vec<Face>,
    /// As `faces`.
    brief: Vec<Brief>,
    /// As `faces`; see [`DrawnFace::nearness_on_image`].
    planes: Vec<[f64; 3]>,
    /// The sky's visibility, padded, so that it is one load: towards the six half axes; for flat faces the light from all
    /// around, then the visibility towards the four level half axes.
    pub open: Vec<[f32; 8]>,
    /// Of faces of one instance that lie alike within a block, and where it is kept.
    alike: Vec<(Alike, u32)>,
}

/// Block, instance, kind and coarse normal of a face.
type Alike = (u32, u32, u32, u32);
const ALIKE: usize = 256;
const ALIKE_FROM_M: f32 = 15.0;
const NOT_ALIKE: (Alike, u32) = ((NOWHERE, 0, 0, 0), 0);

/// No leaf.
const NO_PLANT: u32 = u32::MAX;
/// Faces and visibilities are forgotten when there are so many.
const MAX_FACES: usize = 2500;
const MAX_OPEN: usize = 6_000;
/// More than the samples of 64 x 8 pixels, solid and of panes.
const MAX_ASKED: usize = 4096;

impl<'a> Faces<'a> {
    pub fn new(scene: &'a PosedScene, view: &View, rays: &'a Rays, light: &'a Light, drawn: &'a [DrawnFace]) -> Self {
        let eye = view.world_from_cam.translation;
        let placed = scene.instances.iter().map(|i| Placed {
            mesh: &i.mesh,
            materials: i.palette.materials(),
            stand: Stand {
                world_from_local: i.placement.rotation.as_mat3(),
                origin: (i.placement.translation - eye).as_vec3(),
                place_hash: hash2((i.center_world.x * 8.0) as i32, (i.center_world.y * 8.0) as i32, 0x97AC),
            },
            square: NOWHERE,
            open: 0,
        });
        let plants: Vec<u32> =
            (0..).zip(&scene.instances).map(|(i, of)| if of.palette.is_plant() { i } else { NO_PLANT }).collect();
        let made = |face: &DrawnFace| Made { index: NOT_MADE, plant: plants[face.instance as usize] };
        Self {
            made: drawn.iter().map(made).collect(),
            asked: vec![0; MAX_ASKED],
            asked_count: 0,
            raw: Vec::new(),
            drawn,
            placed: placed.collect(),
            light,
            rays,
            faces: Vec::with_capacity(2 * MAX_FACES),
            brief: Vec::with_capacity(2 * MAX_FACES),
            planes: Vec::with_capacity(2 * MAX_FACES),
            intrinsics: view.intrinsics,
            open: Vec::with_capacity(2 * MAX_OPEN),
            alike: vec![NOT_ALIKE; ALIKE],
        }
    }

    /// True if so much has been made that it leaves the cache.
    pub fn are_many(&self) -> bool {
        self.faces.len() > MAX_FACES || self.open.len() > MAX_OPEN
    }

    /// Drops what has been made.
    pub fn forget(&mut self) {
        self.faces.clear();
        self.brief.clear();
        self.planes.clear();
        self.open.clear();
        self.alike.fill(NOT_ALIKE);
        for made in &mut self.made {
            made.index = NOT_MADE;
        }
        for placed in &mut self.placed {
            placed.square = NOWHERE;
        }
    }

    /// Notes a drawn face for [`Faces::make_asked`], unless it is made.
    ///
    /// Without branches: else the processor would wait for the memory of one face after the other.
    #[inline]
    pub fn ask(&mut self, number: u32) {
        let made = &mut self.made[number as usize];
        let is_new = made.index == NOT_MADE;
        let next = (self.faces.len() + self.asked_count) as u32;
        made.index = if is_new { next } else { made.index };
        self.asked[self.asked_count % MAX_ASKED] = number;
        self.asked_count += usize::from(is_new);
    }

    /// True if two drawn faces are of one plant.
    #[inline]
    pub fn are_of_one_plant(&self, first: u32, second: u32) -> bool {
        let [a, b] = [first, second].map(|number| self.made[number as usize].plant);
        a == b && a != NO_PLANT
    }

    /// Makes the faces that were asked for. They are read step by step, so that the processor waits for the memory of
    /// many at once.
    pub fn make_asked(&mut self) {
        let (mut raw, asked) = (std::mem::take(&mut self.raw), &self.asked[..self.asked_count]);
        raw.clear();
        let (none, unread) = ([Vec3::ZERO; 3], [0; 3]);
        raw.extend(asked.iter().map(|number| {
            let DrawnFace { instance, face, is_quad, .. } = self.drawn[*number as usize];
            Raw { instance, face, is_quad, slot: 0, corners: unread, vertices: none, normals: none }
        }));
        for r in &mut raw {
            let mesh = self.placed[r.instance as usize].mesh;
            (r.slot, r.corners) = (mesh.slots[r.face as usize], mesh.faces[r.face as usize]);
        }
        for r in &mut raw {
            let mesh = self.placed[r.instance as usize].mesh;
            r.vertices = r.corners.map(|i| mesh.vertices[i as usize]);
            r.normals = r.corners.map(|i| mesh.normals[i as usize]);
        }
        self.planes.extend(asked.iter().map(|n| self.drawn[*n as usize].nearness_on_image(self.intrinsics)));
        for raw in &raw {
            let placed = &self.placed[raw.instance as usize];
            let material = &placed.materials[usize::from(raw.slot)];
            let (face, kind) = Face::make(raw, &placed.stand, material, self.rays, self.light.wetness > 0.0);
            let leaf_of = if kind.pattern == Pattern::Leaves { raw.instance } else { NO_PLANT };
            let [x, y, z] = face.face_normal.to_array().map(|n| (n * 14.0 + 15.5) as u32);
            let look = x | y << 5 | z << 10 | u32::from(raw.slot) << 16;
            self.brief.push(Brief {
                kind: kind.index() as u32,
                instance: raw.instance,
                look,
                leaf_of,
                block: NOWHERE,
                open: 0,
            });
            self.faces.push(face);
        }
        self.raw = raw;
        self.asked_count = 0;
    }

    /// True if two made faces of one instance show the same where they meet: the halves of a wall, neighbours on a rounded
    /// body.
    #[inline]
    pub fn are_alike(&self, first: u32, second: u32) -> bool {
        let [a, b] = [first, second].map(|number| &self.brief[self.made[number as usize].index as usize]);
        (a.instance, a.look) == (b.instance, b.look)
    }

    /// Index in `faces` of a drawn face that was asked for and made, and the number of its kind.
    #[inline]
    pub fn made(&self, number: u32) -> (u32, u32) {
        let index = self.made[number as usize].index;
        (index, self.brief[index as usize].kind)
    }

    /// 1 / z of a made face's plane at an image point, 1/m, and its change by column and by row.
    #[inline]
    pub fn nearness_at(&self, index: u32, u: f32, v: f32) -> [f32; 3] {
        let [first, by_column, by_row] = self.planes[index as usize];
        let here = first + by_column * f64::from(u) + by_row * f64::from(v);
        [here, by_column, by_row].map(|n| n as f32)
    }

    /// Index of the sky's visibility at a hit of a face.
    #[inline]
    pub fn open_index(&mut self, index: u32, place: Place, u: f32, v: f32, nearness: f32) -> u32 {
        let brief = &self.brief[index as usize];
        if brief.leaf_of == NO_PLANT {
            if brief.block == place.block {
                return brief.open;
            }
        } else {
            let plant = &self.placed[brief.leaf_of as usize];
            if plant.square == place.square {
                return plant.open;
            }
        }
        self.find_open(index, place, u, v, 1.0 / nearness)
    }

    #[inline(never)]
    fn find_open(&mut self, index: u32, place: Place, u: f32, v: f32, depth: f32) -> u32 {
        let brief = &mut self.brief[index as usize];
        let found = self.open.len() as u32;
        let point_world = self.rays.eye + self.rays.direction(u, v) * depth;
        let sky_view = &self.light.sky_view;
        let normal = self.faces[index as usize].face_normal;
        if brief.leaf_of != NO_PLANT {
            // Leaves turn to all sides.
            let [a, b, c, d, e, f] = sky_view.openness(point_world, Vec3::ZERO);
            self.open.push([a, b, c, d, e, f, 0.0, 0.0]);
            let plant = &mut self.placed[brief.leaf_of as usize];
            (plant.square, plant.open) = (place.square, found);
            return found;
        }
        let is_flat = Kind::of(brief.kind as usize).is_flat();
        // Near by, where faces are large in the image and coats mirror clearly, each face looks for itself.
        if depth > ALIKE_FROM_M {
            let coarse = normal.to_array().map(|n| (n * 7.0 + 8.0) as u32);
            let coarse = coarse[0] | coarse[1] << 4 | coarse[2] << 8;
            let key = (place.block, brief.instance, brief.kind, coarse);
            let slot = (coarse ^ coarse >> 3 ^ brief.instance.wrapping_mul(37) ^ brief.kind) as usize % ALIKE;
            let (known, index) = self.alike[slot];
            if known == key {
                (brief.block, brief.open) = (place.block, index);
                return index;
            }
            self.alike[slot] = (key, found);
        }
        let open = sky_view.openness(point_world, normal);
        let [a, b, c, d, e, f] = open;
        self.open.push(if is_flat {
            let around = self.light.sky.all_around(normal, &open);
            [around.x, around.y, around.z, a, b, c, d, 0.0]
        } else {
            [a, b, c, d, e, f, 0.0, 0.0]
        });
        (brief.block, brief.open) = (place.block, found);
        found
    }
}
