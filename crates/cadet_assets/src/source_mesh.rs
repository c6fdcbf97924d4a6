//! What a user's mesh file holds, as whoever has read it passes it on: triangles, and materials as the file states them.

use std::collections::HashMap;

use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{Vec3, cosf, sinf};

/// The most triangles of a mesh.
pub const MAX_TRIANGLES: usize = 2_000_000;
/// The most materials of a mesh, those that are assumed included: its slots are bytes.
pub const MAX_MATERIALS: usize = 256;
/// The most triangles that meet in one place: normals are made from all pairs of those.
const MAX_TRIANGLES_IN_A_PLACE: usize = 1_000;
/// Of triangles, m^4: below it the square of twice the area is none.
const LEAST_AREA: f32 = 1e-15;

/// A material as a file states it.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceMaterial {
    /// Its name; several may share one, and faces that name none have the empty one.
    pub name: String,
    /// Its diffuse color, linear, if it states one.
    pub albedo: Option<[f32; 3]>,
    /// From 0, clear, to 1.
    pub opacity: f32,
}

/// A triangle of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourceTriangle {
    /// Its corners, counter-clockwise from outside.
    pub corners: [Vec3; 3],
    /// An index into the materials.
    pub material: u32,
    /// An index into the parts.
    pub part: u32,
}

/// A mesh as its file states it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SourceMesh {
    /// Its triangles.
    pub triangles: Vec<SourceTriangle>,
    /// Its materials.
    pub materials: Vec<SourceMaterial>,
    /// The names of each part, the outermost first: nodes within nodes, or an object and its group.
    pub parts: Vec<Vec<String>>,
}

/// Makes a file's coordinates ours: x forward, y left, z up, meters.
pub(crate) struct Placing {
    scale: f32,
    sin: f32,
    cos: f32,
    y_up: bool,
}

impl Placing {
    /// Of a scale above 0, a turn about the vertical after it, and the axis that points up (y, or else z).
    pub(crate) fn new(scale: f64, yaw_rad: f64, y_up: bool) -> Result<Self> {
        if !(scale.is_finite() && scale > 0.0) {
            let (value, expected) = (scale.to_string(), "above 0 and finite".to_owned());
            return Err(Error::OutOfRange { what: "mesh scale", value, expected });
        }
        finite("mesh yaw", yaw_rad)?;
        let yaw_rad = yaw_rad as f32;
        Ok(Self { scale: scale as f32, sin: sinf(yaw_rad), cos: cosf(yaw_rad), y_up })
    }

    fn place(&self, p: Vec3) -> Vec3 {
        let p = if self.y_up { Vec3::new(p.x, -p.z, p.y) } else { p } * self.scale;
        Vec3::new(self.cos * p.x - self.sin * p.y, self.sin * p.x + self.cos * p.y, p.z)
    }
}

impl SourceMesh {
    /// The triangles that `keep` keeps and that have an area, in our axes: at least one.
    ///
    /// # Errors
    /// [`Error::Mesh`], naming the file: no triangle is left, too many are, or a coordinate is not finite.
    pub(crate) fn placed(
        &self,
        file: &str,
        placing: &Placing,
        keep: impl Fn(&SourceTriangle) -> bool,
    ) -> Result<Vec<SourceTriangle>> {
        let fail = |reason: String| Error::Mesh { name: file.to_owned(), reason };
        let mut placed = Vec::new();
        for triangle in self.triangles.iter().filter(|triangle| keep(triangle)) {
            let (material, part) = (triangle.material as usize, triangle.part as usize);
            if material >= self.materials.len() || part >= self.parts.len() {
                let (materials, parts) = (self.materials.len(), self.parts.len());
                return Err(fail(format!("a face of material {material} of {materials} and part {part} of {parts}")));
            }
            let corners = triangle.corners.map(|p| placing.place(p));
            if let Some(bad) = corners.iter().find(|corner| !corner.is_finite()) {
                return Err(fail(format!("a coordinate is not finite: {bad}")));
            }
            if has_area(&corners) {
                placed.push(SourceTriangle { corners, ..*triangle });
            }
        }
        if placed.is_empty() {
            return Err(fail("no triangle with an area".to_owned()));
        }
        check_triangles(&placed).map_err(fail)?;
        Ok(placed)
    }
}

/// Refuses more materials than a mesh's slots can name.
///
/// # Errors
/// [`Error::Mesh`].
pub(crate) fn check_num_materials(name: &str, num_materials: usize) -> Result<()> {
    if num_materials <= MAX_MATERIALS {
        return Ok(());
    }
    let reason = format!("{num_materials} materials, at most {MAX_MATERIALS}: join some of them");
    Err(Error::Mesh { name: name.to_owned(), reason })
}

/// True for a triangle with an area.
pub(crate) fn has_area([a, b, c]: &[Vec3; 3]) -> bool {
    (*b - *a).cross(*c - *a).length_squared() > LEAST_AREA
}

/// Refuses more triangles than a mesh may have, or more in one place.
fn check_triangles(triangles: &[SourceTriangle]) -> std::result::Result<(), String> {
    if triangles.len() > MAX_TRIANGLES {
        return Err(format!("{} triangles, at most {MAX_TRIANGLES}: simplify the mesh", triangles.len()));
    }
    // Looked up and never walked through, so its order does not matter.
    let mut in_place: HashMap<[u32; 3], usize> = HashMap::new();
    for corner in triangles.iter().flat_map(|triangle| triangle.corners) {
        // Adding zero makes -0 a 0.
        let count = in_place.entry(corner.to_array().map(|v| (v + 0.0).to_bits())).or_default();
        *count += 1;
        if *count > MAX_TRIANGLES_IN_A_PLACE {
            let [x, y, z] = corner.to_array();
            return Err(format!(
                "more than {MAX_TRIANGLES_IN_A_PLACE} triangles meet in one place, ({x}, {y}, {z}): check the mesh there"
            ));
        }
    }
    Ok(())
}
