//! What surfaces are made of, for the eye and for a 905 nm laser.

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
    /// Pavement and kerb.
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
    /// Other street furniture: bins, cabinets, benches.
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
    /// True for what lies on the ground: carriageway, markings, pavement, terrain.
    #[must_use]
    pub fn is_ground(self) -> bool {
        matches!(self, Self::Road | Self::RoadMarking | Self::Sidewalk | Self::Terrain)
    }
}

/// How a surface returns a laser at 905 nm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LidarMaterial {
    /// Diffuse reflectance at normal incidence, 0..1.
    pub reflectance: f32,
    /// The diffuse part falls as cos^exponent of the incidence angle: 1 is Lambert's; under clear coat it is 2-3.
    pub lobe_exponent: f32,
    /// Fresnel reflectance at normal incidence of a coat or of metal flakes, 0..1: 0 for what is matt, 0.04 for clear
    /// coat.
    pub gloss: f32,
    /// Beckmann roughness of the gloss: 0.05 is a polished sheet, 0.4 metallic paint.
    pub roughness: f32,
    /// One-way transmission, 0..1: above 0 the beam goes on behind the surface.
    pub transmission: f32,
    /// Number plates, signs, lane posts: saturates the receiver.
    pub retro: bool,
}

impl LidarMaterial {
    /// A Lambertian surface of the given reflectance.
    #[must_use]
    pub const fn diffuse(reflectance: f32) -> Self {
        Self { reflectance, lobe_exponent: 1.0, gloss: 0.0, roughness: 1.0, transmission: 0.0, retro: false }
    }
}

/// A procedural texture, evaluated at the hit in local coordinates (or in world coordinates for the ground).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pattern {
    /// One colour.
    Plain,
    /// Fine grain with patches and darker tyre tracks.
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
}

impl Pattern {
    /// All of them, in their order.
    pub const ALL: [Self; 11] = [
        Self::Plain,
        Self::Asphalt,
        Self::Slabs,
        Self::Blocks,
        Self::Bricks,
        Self::Render,
        Self::Tiles,
        Self::Grass,
        Self::Leaves,
        Self::Wood,
        Self::Cloth,
    ];
}

/// A surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Linear RGB albedo (metals: the colour of the reflection), 0..1.
    pub albedo: [f32; 3],
    /// 0 is a mirror, 1 is chalk.
    pub roughness: f32,
    /// Reflectance at normal incidence of the coat: 0.04 for dielectrics, 0 for none, up to 1 for metals.
    pub specular: f32,
    /// One-way transmission for the camera; above 0 the surface is glass.
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

    /// True for panes: the camera and the laser look through.
    #[must_use]
    pub fn is_glass(&self) -> bool {
        self.transmission > 0.0
    }
}

/// The materials of an instance; a mesh's face names a slot of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Palette(pub Vec<Material>);

impl Palette {
    /// The same materials, all of one semantic class.
    #[must_use]
    pub fn with_semantic(mut self, semantic: Semantic) -> Self {
        for m in &mut self.0 {
            m.semantic = semantic;
        }
        self
    }
}
