//! What every format gives: triangles in our axes, and materials as a file states them.

use crate::assets::mesh_limits::check_triangles;
use crate::error::{Error, Result};
use crate::material::Semantic;
use crate::math::{Vec3, cosf, sinf};

/// A mesh's slots are bytes.
const MAX_MATERIALS: usize = 256;
/// Of triangles, m^4: below it the square of twice the area is none.
const LEAST_AREA: f32 = 1e-15;

/// How a file's coordinates become ours (x forward, y left, z up, meters).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImportOptions {
    /// Meters per unit of the file, above 0.
    pub scale: f64,
    /// True where an OBJ file's y axis points up; else its z axis does. A glTF file's axes are known: y up, z forward.
    pub y_up: bool,
    /// Turn about the vertical after that, counter-clockwise seen from above.
    pub yaw_rad: f64,
    /// Moves the mesh so that the middle of its bounds lies above the origin and its lowest point at z = 0.
    pub on_ground: bool,
    /// The class that all of it has in the semantic image.
    pub semantic: Semantic,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { scale: 1.0, y_up: false, yaw_rad: 0.0, on_ground: true, semantic: Semantic::OtherVehicle }
    }
}

/// A material as a file states it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SourceMaterial {
    /// Its name.
    pub name: String,
    /// Its diffuse color, linear.
    pub albedo: Option<[f32; 3]>,
    /// From 0, clear, to 1.
    pub opacity: f32,
}

/// A file's triangles in our axes and its materials as it states them.
pub(crate) struct Triangles {
    /// Corners and material: an index into `materials`, or one past its end where the file names none.
    pub triangles: Vec<([Vec3; 3], usize)>,
    /// The materials.
    pub materials: Vec<SourceMaterial>,
}

/// Refuses more materials than a mesh's slots can name.
///
/// # Errors
/// [`Error::Mesh`].
pub(crate) fn check_num_materials(name: &str, num_materials: usize) -> Result<()> {
    if num_materials <= MAX_MATERIALS {
        return Ok(());
    }
    let reason = format!("{num_materials} materials, at most {MAX_MATERIALS}");
    Err(Error::Mesh { name: name.to_owned(), reason })
}

/// Scales and turns points that are upright already.
pub(super) struct Placing {
    scale: f32,
    sin: f32,
    cos: f32,
}

impl Placing {
    pub(super) fn new(options: &ImportOptions) -> Result<Self> {
        if !(options.scale.is_finite() && options.scale > 0.0) {
            let (value, expected) = (options.scale.to_string(), "above 0 and finite".to_owned());
            return Err(Error::OutOfRange { what: "mesh scale", value, expected });
        }
        crate::error::finite("mesh yaw", options.yaw_rad)?;
        let yaw_rad = options.yaw_rad as f32;
        Ok(Self { scale: options.scale as f32, sin: sinf(yaw_rad), cos: cosf(yaw_rad) })
    }

    pub(super) fn place(&self, upright: Vec3) -> Vec3 {
        let p = upright * self.scale;
        Vec3::new(self.cos * p.x - self.sin * p.y, self.sin * p.x + self.cos * p.y, p.z)
    }
}

/// True for a triangle with an area.
pub(super) fn has_area([a, b, c]: &[Vec3; 3]) -> bool {
    (*b - *a).cross(*c - *a).length_squared() > LEAST_AREA
}

/// Refuses no triangles, and too many.
///
/// # Errors
/// The reason.
pub(super) fn checked(
    triangles: Vec<([Vec3; 3], usize)>,
    materials: Vec<SourceMaterial>,
) -> std::result::Result<Triangles, String> {
    if triangles.is_empty() {
        return Err("no triangle with an area".to_owned());
    }
    check_triangles(&triangles)?;
    Ok(Triangles { triangles, materials })
}
