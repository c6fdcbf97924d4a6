//! A user's mesh with what is to be known about it, and how it comes into its box frame.

use super::fit::{Fit, or_what_to_leave_out};
use super::materials::{MaterialRules, listed, matches};
use super::windows::Face;
use crate::source_mesh::{Placing, SourceMesh, SourceTriangle, check_num_materials, has_area};
use cadet_base::actor::ObjectClass;
use cadet_base::error::{Error, Result};
use cadet_base::geometry::Bounds;
use cadet_base::math::DVec3;

/// A user's mesh and what is to be known about it.
#[derive(Debug, Clone)]
pub struct MeshAsset {
    /// The model's name in labels' metadata.
    pub name: String,
    /// `Car`, `Van` or `Truck`, which drive and park, or any other, which stand or go where they are put.
    pub class: ObjectClass,
    /// The mesh's file, for messages.
    pub file: String,
    /// What the file holds.
    pub source: SourceMesh,
    /// Meters per unit of the file, above 0.
    pub scale: f64,
    /// Turns the mesh about the vertical, counter-clockwise seen from above, so that its front looks along +x.
    pub yaw_rad: f64,
    /// True where an OBJ file's y axis points up; else its z axis does.
    pub y_up: bool,
    /// Stretches the mesh to this length, width and height, meters.
    pub size_lwh: Option<DVec3>,
    /// Which materials are glass, tires, ...
    pub rules: MaterialRules,
    /// Patterns of the names of materials and parts that do not belong to it; `None` where nobody has thought of it.
    pub leave_out: Option<Vec<String>>,
}

/// A mesh in its box frame.
pub(super) struct Placed {
    pub faces: Vec<Face>,
    /// Length, width and height: those of its bounds.
    pub size: DVec3,
    /// A line each of what was assumed to belong to it.
    pub assumed: Vec<String>,
}

impl MeshAsset {
    /// The mesh in its box frame, with room for so many materials that may be assumed.
    ///
    /// # Errors
    /// [`Error::Mesh`], naming the file: no face with an area, a coordinate that is not finite, a rule that fits
    /// nothing, or a size that none of its class has.
    pub(super) fn placed(&self, num_assumed: usize) -> Result<Placed> {
        let fail = |reason| self.fail(reason);
        let materials = &self.source.materials;
        check_num_materials(&self.file, materials.len() + num_assumed)?;
        self.rules.check(&self.file, materials)?;
        let placing = Placing::new(self.scale, self.yaw_rad, self.y_up)?;
        let is_left_out = self.left_out().map_err(fail)?;
        let triangles = self.source.placed(&self.file, &placing, |triangle| !is_left_out(triangle))?;
        let bounds = Bounds::of(triangles.iter().flat_map(|triangle| triangle.corners));
        let fit = Fit::new(self.class, &bounds, self.size_lwh).map_err(|reason| match self.size_lwh {
            None => fail(or_what_to_leave_out(reason, self.class, &self.source, &triangles)),
            Some(_) => fail(reason),
        })?;
        let placed = triangles.iter().map(|t| (t.corners.map(|p| fit.point(p)), t.material as usize));
        // What a size that was asked for has pressed flat.
        let faces: Vec<Face> = placed.filter(|(corners, _)| has_area(corners)).collect();
        if faces.is_empty() {
            return Err(fail("no triangle with an area".to_owned()));
        }
        Ok(Placed { faces, size: fit.size, assumed: self.shadow_kept(&triangles) })
    }

    fn fail(&self, reason: String) -> Error {
        Error::Mesh { name: self.file.clone(), reason }
    }

    /// Tells of a triangle whether its material or part is to be left out.
    ///
    /// # Errors
    /// A pattern that fits nothing.
    fn left_out(&self) -> std::result::Result<impl Fn(&SourceTriangle) -> bool, String> {
        let patterns = self.leave_out.as_deref().unwrap_or_default();
        let SourceMesh { materials, parts, .. } = &self.source;
        let fits = |name: &String| patterns.iter().any(|pattern| matches(pattern, name));
        let names = || materials.iter().map(|m| &m.name).chain(parts.iter().flatten());
        if let Some(lost) = patterns.iter().find(|pattern| !names().any(|name| matches(pattern, name))) {
            let known = listed(names());
            return Err(format!(
                "materials.leave_out: no material, node, object or group is named {lost:?}; known: {known}"
            ));
        }
        let of_material: Vec<bool> = materials.iter().map(|m| fits(&m.name)).collect();
        let of_part: Vec<bool> = parts.iter().map(|names| names.iter().any(fits)).collect();
        let is_set = |flags: &[bool], index: u32| flags.get(index as usize).copied().unwrap_or_default();
        Ok(move |t: &SourceTriangle| is_set(&of_material, t.material) || is_set(&of_part, t.part))
    }

    /// Says what is named like a shadow, and belongs to its box since nobody has said otherwise.
    fn shadow_kept(&self, kept: &[SourceTriangle]) -> Vec<String> {
        let named = |t: &SourceTriangle| {
            let names = std::iter::once(&self.source.materials[t.material as usize].name);
            names.chain(&self.source.parts[t.part as usize]).find(|name| matches("*shadow*", name))
        };
        let shadow = if self.leave_out.is_none() { kept.iter().find_map(named) } else { None };
        let line = |name| {
            format!(
                "{}: {name:?} is taken as a part of the body (materials.leave_out = [{name:?}] in assets.toml leaves it \
                 out, [] says that it is one)",
                self.file
            )
        };
        shadow.map(line).into_iter().collect()
    }
}
