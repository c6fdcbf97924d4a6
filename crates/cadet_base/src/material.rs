//! What surfaces are made of, for the eye and for a 905 nm laser.

use strum::{AsRefStr, VariantArray};

use std::sync::Arc;

use crate::lamp::Lamp;

/// What a pixel shows: the values of the semantic image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Semantic {
    /// Nothing was hit.
    Sky = 0,
    /// Carriageway.
    Road = 1,
    /// Paint on the carriageway.
    RoadMarking = 2,
    /// Sidewalk and curb.
    Sidewalk = 3,
    /// Grass, soil, gardens, drives.
    Terrain = 4,
    /// Houses and garages.
    Building = 5,
    /// Fences, walls, railings.
    Fence = 6,
    /// Trees, hedges, shrubs.
    Vegetation = 7,
    /// Posts of lamps and signs.
    Pole = 8,
    /// Traffic signs and lights.
    TrafficSign = 9,
    /// Other things: bins, cabinets, benches, and what people push, pull, or lead.
    Furniture = 10,
    /// Passenger cars.
    Car = 11,
    /// Vans.
    Van = 12,
    /// Trucks and buses.
    Truck = 13,
    /// People on foot or sitting.
    Person = 14,
    /// Riders with their bicycles.
    Cyclist = 15,
    /// Trams.
    Tram = 16,
    /// Any other vehicle, trailers and parked bicycles too.
    OtherVehicle = 17,
}

impl Semantic {
    /// True for what lies on the ground: carriageway, markings, sidewalk, terrain.
    #[inline]
    #[must_use]
    pub fn is_ground(self) -> bool {
        matches!(self, Self::Road | Self::RoadMarking | Self::Sidewalk | Self::Terrain)
    }

    /// True for vehicles, but for bicycles with their riders.
    #[inline]
    #[must_use]
    pub fn is_vehicle(self) -> bool {
        matches!(self, Self::Car | Self::Van | Self::Truck | Self::Tram | Self::OtherVehicle)
    }
}

/// How a surface returns a laser at 905 nm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LidarMaterial {
    /// Diffuse reflectance at normal incidence, 0..1.
    pub reflectance: f32,
    /// Refractive index of the clear coat over the diffuse part: 1 where there is none.
    pub coat_index: f32,
    /// Fresnel reflectance at normal incidence of a coat's face or of metal flakes, 0..1: 0 for what is matt, 0.04 for
    /// clear coat.
    pub gloss: f32,
    /// Beckmann roughness of the gloss: 0.05 is a polished sheet, 0.4 metallic paint.
    pub roughness: f32,
    /// One-way transmission, 0..1: above 0 the beam goes on behind the surface.
    pub transmission: f32,
    /// Number plates, signs, lane posts: saturates the receiver.
    pub retro: bool,
}

impl LidarMaterial {
    /// Refractive index of lacquer, enamel and glass at 905 nm.
    pub const LACQUER_INDEX: f32 = 1.5;

    /// A matt surface of the given reflectance, without a coat.
    #[must_use]
    pub const fn diffuse(reflectance: f32) -> Self {
        Self { reflectance, coat_index: 1.0, gloss: 0.0, roughness: 1.0, transmission: 0.0, retro: false }
    }
}

/// A procedural texture, evaluated at the hit in local coordinates (or in world coordinates for the ground).
#[derive(Debug, Clone, Copy, PartialEq, Eq, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Pattern {
    /// One color.
    Plain,
    /// Fine grain with patches and darker tire tracks.
    Asphalt,
    /// Square slabs with joints.
    Slabs,
    /// Setts or concrete blocks.
    Blocks,
    /// Brick courses.
    Bricks,
    /// Rendered wall: faint large-scale stains.
    Render,
    /// Rows of roof tiles.
    Tiles,
    /// Grass.
    Grass,
    /// Leaves of crowns and hedges: strong variation leaf by leaf.
    Leaves,
    /// Bark and wood.
    Wood,
    /// Cloth.
    Cloth,
    /// Paint on a road, worn: its albedo is that of a [`crate::road_paint::WornPaint`].
    Paint,
    /// A lamp that is lit: it shines in its color, whatever light falls on it.
    Lamp,
    /// Panes at night: its albedo's first number is the share of homes' windows that is lit, the second the radiance of
    /// those, the third that of shop windows, which are larger. A share above 1: all alike, as in buses.
    Window,
    /// A dark lens at night that throws light back to where it comes from.
    Reflector,
}

impl Pattern {
    /// Their names, in the order of their numbers.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        Self::VARIANTS.iter().map(AsRef::as_ref).collect()
    }
}

/// Radiance of lit lenses at night per unit of their color: a white surface under 100 lx, 31.8 cd/m², has 1.
pub const NIGHT_LAMP_RADIANCE: f32 = 55.0;

/// A surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Linear RGB albedo (metals: the color of the reflection), 0..1.
    pub albedo: [f32; 3],
    /// 0 is a mirror, 1 is chalk.
    pub roughness: f32,
    /// Reflectance at normal incidence of the coat: 0.04 for dielectrics, 0 for none, up to 1 for metals.
    pub specular: f32,
    /// One-way transmission for the camera; above 0 the surface is transparent.
    pub transmission: f32,
    /// Procedural variation.
    pub pattern: Pattern,
    /// The class in the semantic image.
    pub semantic: Semantic,
    /// For the LIDAR.
    pub lidar: LidarMaterial,
}

impl Material {
    /// A matt surface.
    #[must_use]
    pub const fn matt(semantic: Semantic, albedo: [f32; 3], pattern: Pattern, reflectance: f32) -> Self {
        Self {
            albedo,
            roughness: 0.9,
            specular: 0.0,
            transmission: 0.0,
            pattern,
            semantic,
            lidar: LidarMaterial::diffuse(reflectance),
        }
    }

    /// Returns this surface under a coat: its roughness, and its reflectance at normal incidence.
    #[must_use]
    pub const fn polished(self, roughness: f32, specular: f32) -> Self {
        Self { roughness, specular, ..self }
    }

    /// Makes it a room at night, that is lit by so much light: its radiance in units of 31.8 cd/m² is that times its albedo.
    pub fn shine(&mut self, irradiance: f32) {
        self.albedo = self.albedo.map(|a| a * (irradiance / NIGHT_LAMP_RADIANCE));
        self.pattern = Pattern::Lamp;
    }

    /// True if the camera and the laser look through.
    #[inline]
    #[must_use]
    pub fn is_transparent(&self) -> bool {
        self.transmission > 0.0
    }
}

/// The bit of a slot where many of them are a number; those beyond 63 share one.
#[inline]
#[must_use]
pub fn slot_bit(slot: u8) -> u64 {
    1 << slot.min(63)
}

/// The materials of an instance; a mesh's face names a slot of it. What sensors ask of all of them is found once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Palette {
    materials: Vec<Material>,
    opaque_slots: u64,
    transparent_slots: u64,
    leaf_slots: u64,
    is_plant: bool,
    has_vegetation: bool,
    /// What shines at night, in the instance's frame.
    lamps: Vec<Lamp>,
    at_night: Option<Arc<Palette>>,
}

impl Palette {
    /// A palette whose slots have these materials.
    #[must_use]
    pub fn new(materials: Vec<Material>) -> Self {
        let slots_of = |is: fn(&Material) -> bool| {
            let slots = materials.iter().zip(0_u8..);
            slots.filter(|(m, _)| is(m)).fold(0, |bits, (_, slot)| bits | slot_bit(slot))
        };
        let (opaque_slots, transparent_slots) = (slots_of(|m| !m.is_transparent()), slots_of(Material::is_transparent));
        let leaf_slots = slots_of(|m| m.pattern == Pattern::Leaves);
        let is_vegetation = |m: &Material| m.semantic == Semantic::Vegetation;
        let (is_plant, has_vegetation) =
            (leaf_slots != 0 && materials.iter().all(is_vegetation), materials.iter().any(is_vegetation));
        let (lamps, at_night) = (Vec::new(), None);
        Self { materials, opaque_slots, transparent_slots, leaf_slots, is_plant, has_vegetation, lamps, at_night }
    }

    /// Returns this palette with light sources, in the instance's frame.
    #[must_use]
    pub fn with_lamps(self, lamps: Vec<Lamp>) -> Self {
        Self { lamps, ..self }
    }

    /// Returns this palette with another that is worn at night, with the same slots.
    #[must_use]
    pub fn with_night(self, at_night: Self) -> Self {
        debug_assert_eq!(self.materials.len(), at_night.materials.len());
        Self { at_night: Some(Arc::new(at_night)), ..self }
    }

    /// Returns this palette with panes that are lit at night: `panes` are slots, each with a window's albedo
    /// ([`Pattern::Window`]).
    #[must_use]
    pub fn with_lit_panes(self, panes: &[(u8, [f32; 3])]) -> Self {
        let mut materials = self.materials.clone();
        for (slot, albedo) in panes {
            let pane = &mut materials[usize::from(*slot)];
            (pane.albedo, pane.pattern) = (*albedo, Pattern::Window);
        }
        self.with_night(Self::new(materials))
    }

    /// Light sources, in the instance's frame.
    #[must_use]
    pub fn lamps(&self) -> &[Lamp] {
        &self.lamps
    }

    /// The palette that is worn at night, where that is another.
    #[must_use]
    pub fn at_night(&self) -> Option<&Arc<Self>> {
        self.at_night.as_ref()
    }

    /// Slot by slot.
    #[inline]
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The bits ([`slot_bit`]) of opaque materials.
    #[inline]
    #[must_use]
    pub fn opaque_slots(&self) -> u64 {
        self.opaque_slots
    }

    /// The bits of transparent materials.
    #[inline]
    #[must_use]
    pub fn transparent_slots(&self) -> u64 {
        self.transparent_slots
    }

    /// The bits of leaves.
    #[inline]
    #[must_use]
    pub fn leaf_slots(&self) -> u64 {
        self.leaf_slots
    }

    /// Leaves and what bears them, and nothing else.
    #[must_use]
    pub fn is_plant(&self) -> bool {
        self.is_plant
    }

    /// Some of it grows.
    #[must_use]
    pub fn has_vegetation(&self) -> bool {
        self.has_vegetation
    }
}
