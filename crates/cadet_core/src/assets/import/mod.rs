//! Meshes from files: Wavefront OBJ and glTF 2.0.

mod gltf;
mod obj;
mod triangles;

use self::gltf::gltf_triangles;
use self::obj::obj_triangles;
pub use self::obj::{ImportedMesh, obj, read_obj};
pub use self::triangles::ImportOptions;
pub(crate) use self::triangles::SourceMaterial;
pub(super) use self::triangles::{Triangles, check_num_materials};
use crate::error::Result;

/// What a mesh's files hold.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshSource {
    /// Wavefront OBJ.
    Obj {
        /// The text of the file.
        text: String,
        /// Material libraries: the name that the file uses, and the text.
        libraries: Vec<(String, String)>,
    },
    /// glTF 2.0, as JSON or as a binary container (GLB).
    Gltf {
        /// The bytes of the file.
        document: Vec<u8>,
        /// The bytes of each of its buffers by index; what the container itself holds may be left empty.
        buffers: Vec<Vec<u8>>,
        /// The mean linear color of each of its images by index, where that is known.
        image_colors: Vec<Option<[f32; 3]>>,
    },
}

/// Reads the triangles that have an area, scaled, turned upright and by the yaw, at least one.
///
/// # Errors
/// [`crate::error::Error::Mesh`], naming the file and the reason: not of its format, no triangle with an area, a coordinate that is not
/// finite, a missing part, or too much of something. [`crate::error::Error::OutOfRange`] for a scale that is not above 0.
pub(super) fn triangles(name: &str, source: &MeshSource, options: &ImportOptions) -> Result<Triangles> {
    match source {
        MeshSource::Obj { text, libraries } => obj_triangles(name, text, options, |library| {
            let known = libraries.iter().find(|(name, _)| name == library);
            known.map(|(_, text)| text.clone()).ok_or_else(|| "no such file".to_owned())
        }),
        MeshSource::Gltf { document, buffers, image_colors } => {
            gltf_triangles(name, document, buffers, image_colors, options)
        }
    }
}
