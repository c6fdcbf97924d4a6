//! What all fragments of a face share.

use strum::VariantArray;

use crate::camera::surfaces::{Flags, hash2, value_noise, window};
use crate::camera::visibility::ImageRays;
use crate::surface_cover::absorbs_water;
use cadet_base::geometry::LEAST_WEIGHT;
use cadet_base::material::{Material, Pattern, Semantic};
use cadet_base::math::{Mat3, Vec3};

/// The code that shades a face: faces of one shader variant are shaded together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShaderVariant {
    /// Its texture.
    pub pattern: Pattern,
    /// Its shading normal changes over the face.
    pub is_smooth: bool,
    /// It mirrors.
    pub is_glossy: bool,
    /// It is seen through.
    pub is_transparent: bool,
}

impl ShaderVariant {
    /// Number of variants.
    pub const COUNT: usize = Pattern::VARIANTS.len() * PER_PATTERN;

    /// A number below `COUNT`.
    pub fn index(self) -> usize {
        (self.pattern as usize) * PER_PATTERN
            + SMOOTH_BIT * usize::from(self.is_smooth)
            + GLOSSY_BIT * usize::from(self.is_glossy)
            + TRANSPARENT_BIT * usize::from(self.is_transparent)
    }

    /// One normal, that of the plane, goes for the whole face: what light comes from all around is found once for many
    /// pixels.
    pub fn is_flat(self) -> bool {
        !self.is_smooth && self.pattern != Pattern::Leaves
    }

    /// The variant of a number.
    pub fn of(index: usize) -> Self {
        Self {
            pattern: Pattern::VARIANTS[index / PER_PATTERN],
            is_smooth: index & SMOOTH_BIT > 0,
            is_glossy: index & GLOSSY_BIT > 0,
            is_transparent: index & TRANSPARENT_BIT > 0,
        }
    }
}

/// A face made ready for its fragments. Places are relative to the eye; vectors are in the world's frame.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct ShadingFace {
    // The first cache line is enough for leaves and for what is flat and plain.
    /// Unit normal of the triangle, towards the eye.
    pub face_normal: Vec3,
    pub albedo: Vec3,
    /// See [`Flags`].
    pub flags: u32,
    /// Shading normal in the first corner, towards the eye; see `normal_ab`.
    pub normal: Vec3,
    /// Coordinates of the texture at the eye, meters.
    pub at_eye_m: [f32; 2],
    pub face_hash: u32,
    pub place_hash: u32,
    pub f0: f32,
    pub roughness: f32,
    pub transmission: f32,
    /// Axes of the texture; those of leaves are the camera's.
    pub axes: [Vec3; 2],
    /// Changes of the shading normal to the second and third corner.
    pub normal_ab: Vec3,
    pub normal_ac: Vec3,
    /// Dual edges: their products with a hit's place, and what is added to them, are its weights of the second and third
    /// corner.
    pub to_b: Vec3,
    pub to_c: Vec3,
    pub weights_at_eye: [f32; 2],
    /// The least that a corner's weight may be; it is negative on the partner's half of a quadrilateral.
    pub least_weight: f32,
}

/// A face whose squared normal has less than this in the level plane is a floor or a roof: its texture lies along x and y.
const LEVEL: f32 = 0.03;
/// A shading normal whose cosine to the face's is smaller is bent, and one that changes by more than this squared is smooth.
const UNBENT_COS: f32 = 0.999_9;
const SMOOTH_CHANGE: f32 = 1e-6;
/// Faces whose normal rises less, as those of walls, get no contact occlusion.
const CONTACT_RISE: f32 = 0.3;
/// Clumps of leaves: how the axes of the noise lie askew in the plant's, its cells per meter, and the contrast.
const CLUMP_ASKEW: f32 = 0.7;
const CLUMPS_PER_M: f32 = 1.6;
const CLUMP_CONTRAST: f32 = 1.7;
/// See [`luminaire_share`].
const LENS_PER_RISE: f32 = 3.0;
const HOUSING: f32 = 0.03;
/// The least area of a face squared, four times, by which is divided.
const LEAST_AREA: f32 = 1e-20;
/// Variants of one pattern, and the bits that tell them apart.
const PER_PATTERN: usize = 8;
const SMOOTH_BIT: usize = 1;
const GLOSSY_BIT: usize = 2;
const TRANSPARENT_BIT: usize = 4;

/// Data of a face that is read from memory to make it ready.
pub struct FaceVertices {
    pub instance: u32,
    pub face: u32,
    /// Whether a sample that sees it may lie on its partner instead.
    pub is_quad: bool,
    pub slot: u8,
    pub vertices: [Vec3; 3],
    pub normals: [Vec3; 3],
}

/// An instance's transform, relative to the eye.
pub struct InstanceTransform {
    pub world_from_local: Mat3,
    /// The origin of the mesh's frame, relative to the eye.
    pub origin: Vec3,
    pub place_hash: u32,
    /// As the instance's.
    pub sheds_snow: bool,
}

impl ShadingFace {
    /// Makes a face ready, and finds its shader variant.
    #[inline(always)]
    pub fn make(
        raw: &FaceVertices,
        transform: &InstanceTransform,
        material: &Material,
        rays: &ImageRays,
        is_raining: bool,
    ) -> (Self, ShaderVariant) {
        let ([a, b, c], [na, nb, nc]) = (raw.vertices, raw.normals);
        let turn = |v: Vec3| transform.world_from_local * v;
        let (ab, ac) = (b - a, c - a);
        let normal_local = ab.cross(ac).normalize_or_zero();
        let origin = turn(a) + transform.origin;
        let face_normal = turn(normal_local);
        let side = if face_normal.dot(origin) > 0.0 { -1.0 } else { 1.0 };
        let face_normal = face_normal * side;

        let is_leaf = material.pattern == Pattern::Leaves;
        let is_ground = material.semantic.is_ground() && face_normal.z > 0.5;
        let (axes, at_eye) = if is_ground {
            ([Vec3::X, Vec3::Y], [rays.eye.x, rays.eye.y])
        } else if is_leaf {
            let axes = [rays.across, rays.downwards];
            (axes, [-axes[0].dot(origin), -axes[1].dot(origin)])
        } else {
            let n = normal_local;
            let flat = n.x * n.x + n.y * n.y;
            let (along, up) = if flat < LEVEL {
                (Vec3::X, Vec3::Y)
            } else {
                // Along the wall, and up its slope.
                let along = Vec3::new(-n.y, n.x, 0.0) * (1.0 / flat.sqrt());
                (along, n.cross(along))
            };
            let axes = [turn(along), turn(up)];
            (axes, [along.dot(a) - axes[0].dot(origin), up.dot(a) - axes[1].dot(origin)])
        };

        let (mut at_eye, mut face_hash) = (at_eye, hash2(raw.face as i32, 0, transform.place_hash));
        if material.pattern == Pattern::Window {
            let (hash, middle) = window(raw.vertices, normal_local, transform.place_hash);
            // From the middle of the pane.
            let middle = turn(middle) + transform.origin;
            (at_eye, face_hash) = ([-axes[0].dot(middle), -axes[1].dot(middle)], hash);
        }
        let (nab, nac) = (nb - na, nc - na);
        let is_bent = !is_leaf && na.dot(normal_local) < UNBENT_COS;
        let is_smooth = is_bent || nab.length_squared().max(nac.length_squared()) > SMOOTH_CHANGE;
        let is_vehicle = material.semantic.is_vehicle();
        let is_wet = is_ground && is_raining;
        let variant = ShaderVariant {
            pattern: material.pattern,
            is_smooth,
            is_glossy: !is_leaf && material.specular > 0.0 || is_wet,
            is_transparent: material.is_transparent(),
        };
        let flag = |bit: u32, is: bool| if is { bit } else { 0 };
        let none = Vec3::ZERO;
        let (normal_ab, normal_ac, to_b, to_c) = if is_smooth {
            let (d11, d12, d22) = (ab.dot(ab), ab.dot(ac), ac.dot(ac));
            let inverse = 1.0 / (d11 * d22 - d12 * d12).max(LEAST_AREA);
            let (to_b, to_c) = (ab * d22 - ac * d12, ac * d11 - ab * d12);
            (turn(nab) * side, turn(nac) * side, turn(to_b) * inverse, turn(to_c) * inverse)
        } else {
            (none, none, none, none)
        };
        let face = Self {
            face_normal,
            axes,
            at_eye_m: at_eye,
            normal: turn(na) * side,
            normal_ab,
            normal_ac,
            to_b,
            to_c,
            weights_at_eye: [-to_b.dot(origin), -to_c.dot(origin)],
            least_weight: if raw.is_quad { LEAST_WEIGHT } else { 0.0 },
            albedo: if is_leaf {
                clump(a, ab, transform.place_hash) * Vec3::from(material.albedo)
            } else if material.pattern == Pattern::Lamp && material.semantic == Semantic::Pole {
                Vec3::from(material.albedo) * luminaire_share(face_normal.z)
            } else {
                material.albedo.into()
            },
            f0: material.specular,
            roughness: material.roughness,
            transmission: material.transmission,
            face_hash,
            place_hash: transform.place_hash,
            flags: flag(Flags::GROUND, is_ground)
                | flag(Flags::CONTACT, face_normal.z > CONTACT_RISE && !is_vehicle && !is_leaf)
                | flag(Flags::SHEDS_SNOW, transform.sheds_snow && is_vehicle)
                | flag(Flags::ABSORBS, absorbs_water(material))
                | flag(Flags::RETRO, material.lidar.retro || material.pattern == Pattern::Reflector),
        };
        (face, variant)
    }
}

/// How bright a leaf card of a plant is, by its corner and edge in the plant's frame: clumps of leaves stand out, others lie in
/// their shade.
#[inline(always)]
pub(crate) fn clump(at: Vec3, edge: Vec3, place_hash: u32) -> f32 {
    let (u, v) = (at.x + CLUMP_ASKEW * at.y, at.z + CLUMP_ASKEW * (at.y - at.x));
    // What is longer than a clump, as the inside of hedges, has the mean of many.
    let size = edge.dot(edge);
    1.0 + (value_noise(u * CLUMPS_PER_M, v * CLUMPS_PER_M, place_hash) - 0.5) * CLUMP_CONTRAST / (1.0 + size * size)
}

/// How brightly the head of a street lamp shines where its surface rises by this: below it the lens, at its sides the housing,
/// above it nothing.
#[inline(always)]
pub(crate) fn luminaire_share(rise: f32) -> f32 {
    (LENS_PER_RISE * -rise + HOUSING).clamp(0.0, 1.0)
}
