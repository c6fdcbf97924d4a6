//! What all hits of a face share, and which faces were seen lately: neighbouring pixels mostly show the same one.

use super::ambient::Openness;
use super::look::{Rays, View};
use super::pattern::hash2;
use super::shade::Light;
use crate::material::{Pattern, Semantic};
use crate::math::{Mat3, Vec3};
use crate::sense::{DrawnFace, PosedScene};

/// How a face is shaded: faces of one kind are shaded together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// Its texture.
    pub pattern: Pattern,
    /// Its shading normal changes over the face.
    pub is_smooth: bool,
    /// It mirrors.
    pub is_glossy: bool,
    /// It is seen through.
    pub is_pane: bool,
}

impl Kind {
    /// Number of kinds.
    pub const COUNT: usize = Pattern::ALL.len() * 8;

    /// A number below `COUNT`.
    pub fn index(self) -> usize {
        (self.pattern as usize) * 8
            + usize::from(self.is_smooth)
            + 2 * usize::from(self.is_glossy)
            + 4 * usize::from(self.is_pane)
    }

    /// The kind of a number.
    pub fn of(index: usize) -> Self {
        Self {
            pattern: Pattern::ALL[index / 8],
            is_smooth: index & 1 > 0,
            is_glossy: index & 2 > 0,
            is_pane: index & 4 > 0,
        }
    }
}

/// A face made ready for its hits. Places are relative to the eye; vectors are in the world's frame.
#[derive(Debug, Clone, Copy)]
pub struct Face {
    /// First corner.
    pub origin: Vec3,
    /// Unit normal of the triangle, towards the eye.
    pub face_normal: Vec3,
    /// Axes of the texture, and its coordinates in the first corner, metres.
    pub axes: [Vec3; 2],
    pub at_origin: [f32; 2],
    /// Shading normal in the first corner, towards the eye, and its changes to the second and third corner.
    pub normal: Vec3,
    pub normal_ab: Vec3,
    pub normal_ac: Vec3,
    /// Dual edges: their products with a hit's offset are its weights of the second and third corner.
    pub to_b: Vec3,
    pub to_c: Vec3,
    pub albedo: Vec3,
    pub specular: f32,
    pub roughness: f32,
    pub transmission: f32,
    pub face_hash: u32,
    pub place_hash: u32,
    /// See [`Flags`].
    pub flags: u32,
    pub kind: u32,
    instance: u32,
    /// The image point for which the sky's visibility was last found, and where it is kept.
    open_at: (f32, f32, u32),
}

impl Face {
    #[inline]
    fn is_leaf(&self) -> bool {
        self.kind as usize / 8 == Pattern::Leaves as usize
    }
}

/// Bits of [`Face::flags`].
pub struct Flags;

impl Flags {
    /// Lies on the ground, level.
    pub const GROUND: u32 = 1;
    /// Vehicles near by hide the sky.
    pub const CONTACT: u32 = 2;
    /// Snow does not lie on vehicles.
    pub const VEHICLE: u32 = 4;
    /// Snow is worn by traffic.
    pub const ROAD: u32 = 8;
}

/// What is known of a drawn face that was made ready.
#[derive(Debug, Clone, Copy)]
pub struct Made {
    /// Index in [`Faces::faces`].
    pub index: u32,
    /// Number of its kind.
    pub kind: u32,
    /// The instance whose leaf it is, or [`NO_PLANT`].
    pub plant: u32,
}

const NOT_MADE: Made = Made { index: u32::MAX, kind: 0, plant: UNKNOWN };
const UNKNOWN: u32 = u32::MAX;

/// What shading needs of an instance, in single precision.
struct Placed {
    world_from_local: Mat3,
    /// The origin of the mesh's frame, relative to the eye.
    origin: Vec3,
    place_hash: u32,
    /// Slots whose material is leaves.
    leaf_slots: u64,
}

/// What is read from memory to make a face ready.
struct Raw {
    instance: u32,
    face: u32,
    slot: u8,
    corners: [u32; 3],
    vertices: [Vec3; 3],
    normals: [Vec3; 3],
}

/// Faces and visibilities of the sky that were seen lately. Faces go by their numbers in the visibility buffer.
pub struct Faces<'a> {
    scene: &'a PosedScene,
    light: &'a Light,
    rays: &'a Rays,
    drawn: &'a [DrawnFace],
    placed: Vec<Placed>,
    /// For each drawn face, `NOT_MADE` at first.
    made: Vec<Made>,
    /// Drawn faces that are to be made.
    asked: Vec<u32>,
    raw: Vec<Raw>,
    /// All since the last `forget`.
    pub faces: Vec<Face>,
    /// The sky's visibility; padded, so that it is one load.
    pub open: Vec<[f32; 8]>,
    /// Instance and cell of the image, and index of the visibility in crowns.
    recent_crowns: Vec<(u32, u32, u32)>,
}

/// No leaf.
pub const NO_PLANT: u32 = u32::MAX - 1;
const RECENT_CROWNS: usize = 1024;
const NONE: (u32, u32, u32) = (u32::MAX, u32::MAX, 0);
/// Pixels of a face so close together share the sky's visibility.
const SHARED_PX: (f32, f32) = (8.0, 4.0);
/// Leaves of a plant share it in squares of `1 << CROWN_SHIFT` pixels.
const CROWN_SHIFT: u32 = 3;
/// Faces and visibilities are forgotten when there are so many.
const MAX_FACES: usize = 6000;
const MAX_OPEN: usize = 16_000;

impl<'a> Faces<'a> {
    pub fn new(scene: &'a PosedScene, view: &View, rays: &'a Rays, light: &'a Light, drawn: &'a [DrawnFace]) -> Self {
        let eye = view.world_from_cam.translation;
        let placed = scene.instances.iter().map(|i| Placed {
            world_from_local: i.placement.rotation.as_mat3(),
            origin: (i.placement.translation - eye).as_vec3(),
            place_hash: hash2((i.center_world.x * 8.0) as i32, (i.center_world.y * 8.0) as i32, 0x97AC),
            leaf_slots: (i.palette.0.iter().take(64).enumerate())
                .map(|(slot, m)| u64::from(m.pattern == Pattern::Leaves) << slot)
                .sum(),
        });
        Self {
            made: vec![NOT_MADE; drawn.len()],
            asked: Vec::new(),
            raw: Vec::new(),
            drawn,
            placed: placed.collect(),
            scene,
            light,
            rays,
            faces: Vec::with_capacity(2 * MAX_FACES),
            open: Vec::with_capacity(2 * MAX_OPEN),
            recent_crowns: vec![NONE; RECENT_CROWNS],
        }
    }

    /// Drops what has been made if it has become so much that it leaves the cache.
    pub fn forget_if_many(&mut self) {
        if self.faces.len() > MAX_FACES || self.open.len() > MAX_OPEN {
            self.faces.clear();
            self.open.clear();
            self.made.fill(NOT_MADE);
            self.recent_crowns.fill(NONE);
        }
    }

    /// Notes a drawn face for [`Faces::make_asked`], unless it is made.
    #[inline]
    pub fn ask(&mut self, number: u32) {
        let made = &mut self.made[number as usize];
        if made.index == NOT_MADE.index {
            made.index = (self.faces.len() + self.asked.len()) as u32;
            self.asked.push(number);
        }
    }

    /// As [`Faces::ask`], for the two faces of a pixel: of two leaves of one plant the first is enough.
    #[inline]
    pub fn ask_two(&mut self, first: u32, second: u32) {
        self.ask(first);
        if first != second {
            let plant = self.plant(first);
            if plant == NO_PLANT || plant != self.plant(second) {
                self.ask(second);
            }
        }
    }

    /// The instance of which a drawn face is a leaf, or [`NO_PLANT`].
    #[inline]
    pub fn plant(&mut self, number: u32) -> u32 {
        let known = self.made[number as usize].plant;
        if known != UNKNOWN {
            return known;
        }
        let DrawnFace { instance, face, .. } = self.drawn[number as usize];
        let leaf_slots = self.placed[instance as usize].leaf_slots;
        let is_leaf = leaf_slots != 0 && {
            let slot = self.scene.instances[instance as usize].mesh.slots[face as usize];
            slot < 64 && leaf_slots >> slot & 1 == 1
        };
        let plant = if is_leaf { instance } else { NO_PLANT };
        self.made[number as usize].plant = plant;
        plant
    }

    /// Makes the faces that were asked for. They are read step by step, so that the processor waits for the memory of
    /// many at once.
    pub fn make_asked(&mut self) {
        let (mut raw, mut asked) = (std::mem::take(&mut self.raw), std::mem::take(&mut self.asked));
        raw.clear();
        let (none, unread) = ([Vec3::ZERO; 3], [0; 3]);
        raw.extend(asked.iter().map(|number| {
            let DrawnFace { instance, face, .. } = self.drawn[*number as usize];
            Raw { instance, face, slot: 0, corners: unread, vertices: none, normals: none }
        }));
        for r in &mut raw {
            let mesh = &self.scene.instances[r.instance as usize].mesh;
            (r.slot, r.corners) = (mesh.slots[r.face as usize], mesh.faces[r.face as usize]);
        }
        for r in &mut raw {
            let mesh = &self.scene.instances[r.instance as usize].mesh;
            r.vertices = r.corners.map(|i| mesh.vertices[i as usize]);
            r.normals = r.corners.map(|i| mesh.normals[i as usize]);
        }
        for (number, raw) in asked.iter().zip(&raw) {
            let face = self.make(raw);
            self.made[*number as usize].kind = face.kind;
            self.faces.push(face);
        }
        asked.clear();
        (self.raw, self.asked) = (raw, asked);
    }

    /// A drawn face that was asked for and made.
    #[inline]
    pub fn made(&self, number: u32) -> Made {
        self.made[number as usize]
    }

    /// Index of the sky's visibility at a hit of a face.
    #[inline]
    pub fn open_index(&mut self, made: &Made, u: f32, v: f32, depth: f32) -> u32 {
        let face = &self.faces[made.index as usize];
        let (u0, v0, index) = face.open_at;
        if (u - u0).abs() < SHARED_PX.0 && (v - v0).abs() < SHARED_PX.1 {
            return index;
        }
        let is_leaf = face.is_leaf();
        let cell = (u.max(0.0) as u32) >> CROWN_SHIFT | (v.max(0.0) as u32) >> CROWN_SHIFT << 16;
        let slot = (cell ^ (cell >> 10) ^ face.instance.wrapping_mul(97)) as usize % RECENT_CROWNS;
        if is_leaf {
            let (i, c, index) = self.recent_crowns[slot];
            if (i, c) == (face.instance, cell) {
                return index;
            }
        }
        let point_world = self.rays.eye + self.rays.direction(u, v) * depth;
        // Leaves turn to all sides.
        let normal = if is_leaf { Vec3::ZERO } else { face.face_normal };
        let open: Openness = self.light.sky_view.openness(point_world, normal);
        let [a, b, c, d, e, f] = open;
        let index = self.open.len() as u32;
        self.open.push([a, b, c, d, e, f, 0.0, 0.0]);
        if is_leaf {
            self.recent_crowns[slot] = (face.instance, cell, index);
        } else {
            self.faces[made.index as usize].open_at = (u, v, index);
        }
        index
    }

    fn make(&self, raw: &Raw) -> Face {
        let placed = &self.placed[raw.instance as usize];
        let material = &self.scene.instances[raw.instance as usize].palette.0[usize::from(raw.slot)];
        let ([a, b, c], [na, nb, nc]) = (raw.vertices, raw.normals);
        let turn = |v: Vec3| placed.world_from_local * v;
        let (ab, ac) = (b - a, c - a);
        let normal_local = ab.cross(ac).normalize_or_zero();
        let origin = turn(a) + placed.origin;
        let face_normal = turn(normal_local);
        let side = if face_normal.dot(origin) > 0.0 { -1.0 } else { 1.0 };
        let face_normal = face_normal * side;

        let is_ground = material.semantic.is_ground() && face_normal.z > 0.5;
        let (axes, at_origin) = if is_ground {
            ([Vec3::X, Vec3::Y], [origin.x + self.rays.eye.x, origin.y + self.rays.eye.y])
        } else {
            let n = normal_local;
            let flat = n.x * n.x + n.y * n.y;
            let (along, up) = if flat < 0.03 {
                (Vec3::X, Vec3::Y)
            } else {
                // Along the wall, and up its slope.
                let along = Vec3::new(-n.y, n.x, 0.0) * (1.0 / flat.sqrt());
                (along, n.cross(along))
            };
            ([turn(along), turn(up)], [along.dot(a), up.dot(a)])
        };

        let (nab, nac) = (nb - na, nc - na);
        let is_smooth = nab.length_squared().max(nac.length_squared()) > 1e-6;
        let (d11, d12, d22) = (ab.dot(ab), ab.dot(ac), ac.dot(ac));
        let inverse = 1.0 / (d11 * d22 - d12 * d12).max(1e-20);
        let is_vehicle = is_vehicle(material.semantic);
        let is_leaf = material.pattern == Pattern::Leaves;
        let is_wet = is_ground && self.light.wetness > 0.0;
        let kind = Kind {
            pattern: material.pattern,
            is_smooth,
            is_glossy: !is_leaf && material.specular > 0.0 || is_wet,
            is_pane: material.is_glass(),
        };
        let flag = |bit: u32, is: bool| if is { bit } else { 0 };
        Face {
            origin,
            face_normal,
            axes,
            at_origin,
            normal: turn(na) * side,
            normal_ab: turn(nab) * side,
            normal_ac: turn(nac) * side,
            to_b: turn(ab * d22 - ac * d12) * inverse,
            to_c: turn(ac * d11 - ab * d12) * inverse,
            albedo: material.albedo.into(),
            specular: material.specular,
            roughness: material.roughness,
            transmission: material.transmission,
            face_hash: hash2(raw.face as i32, 0, placed.place_hash),
            place_hash: placed.place_hash,
            flags: flag(Flags::GROUND, is_ground)
                | flag(Flags::CONTACT, face_normal.z > 0.3 && !is_vehicle)
                | flag(Flags::VEHICLE, is_vehicle)
                | flag(Flags::ROAD, material.semantic == Semantic::Road),
            kind: kind.index() as u32,
            instance: raw.instance,
            open_at: (f32::NEG_INFINITY, 0.0, 0),
        }
    }
}

fn is_vehicle(semantic: Semantic) -> bool {
    matches!(semantic, Semantic::Car | Semantic::Van | Semantic::Truck | Semantic::Tram | Semantic::OtherVehicle)
}
