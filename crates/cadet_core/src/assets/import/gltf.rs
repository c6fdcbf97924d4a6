//! Triangles and colors of glTF 2.0 files (Khronos Group, glTF 2.0 Specification, 2021).

use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::Source;
use gltf::material::AlphaMode;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic};

use super::triangles::{ImportOptions, Placing, SourceMaterial, Triangles, checked, has_area};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Extensions that change nothing of shapes and base colors, or that are read.
const KNOWN_EXTENSIONS: [&str; 9] = [
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_texture_transform",
];
/// Nodes within nodes: deeper ones go around in a circle.
const MAX_DEPTH: usize = 64;
/// Nodes of a scene, those met several times included.
const MAX_NODES: usize = 100_000;

/// Columns of a transform without its last row: three axes and the origin.
type Affine = [[f64; 3]; 4];

const IDENTITY: Affine = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

/// Reads the triangles of the default scene, or of the first. Skins and morph targets stay at rest.
///
/// # Errors
/// As [`super::triangles()`].
pub(super) fn gltf_triangles(
    name: &str,
    document: &[u8],
    buffers: &[Vec<u8>],
    image_colors: &[Option<[f32; 3]>],
    options: &ImportOptions,
) -> Result<Triangles> {
    let fail = |reason: String| Error::Mesh { name: name.to_owned(), reason };
    let placing = Placing::new(options)?;
    let (read, own_buffer) = validated(document).map_err(|reason| fail(format!("no glTF 2.0 file: {reason}")))?;
    check_extensions(&read).map_err(fail)?;
    let buffers = buffer_bytes(&read, own_buffer.as_deref(), buffers).map_err(fail)?;
    let materials: Vec<SourceMaterial> = read.materials().map(|m| source_material(&m, image_colors)).collect();
    let scene = read.default_scene().or_else(|| read.scenes().next()).ok_or_else(|| fail("no scene".to_owned()))?;
    let mut reader = Reader { buffers, placing, no_material: materials.len(), num_nodes: 0, triangles: Vec::new() };
    for node in scene.nodes() {
        reader.read_node(&node, &IDENTITY, 0).map_err(fail)?;
    }
    checked(reader.triangles, materials).map_err(fail)
}

/// The document and the buffer inside a binary container.
fn validated(bytes: &[u8]) -> std::result::Result<(Document, Option<Vec<u8>>), String> {
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|e| e.to_string())?;
    let root = document.into_json();
    // The crate's own validation takes for granted that a primitive's accessors exist.
    for index in root.meshes.iter().flat_map(|m| &m.primitives).flat_map(|p| p.attributes.values()) {
        if index.value() >= root.accessors.len() {
            return Err(format!("accessor {} of {}", index.value(), root.accessors.len()));
        }
    }
    Ok((Document::from_json(root).map_err(|e| e.to_string())?, blob))
}

fn check_extensions(document: &Document) -> std::result::Result<(), String> {
    match document.extensions_required().find(|extension| !KNOWN_EXTENSIONS.contains(extension)) {
        Some(unknown) => Err(format!("it requires the extension {unknown}, which is not read")),
        None => Ok(()),
    }
}

/// The bytes of every buffer, at least as many as the file says.
fn buffer_bytes<'a>(
    document: &Document,
    own: Option<&'a [u8]>,
    given: &'a [Vec<u8>],
) -> std::result::Result<Vec<&'a [u8]>, String> {
    document
        .buffers()
        .map(|buffer| {
            let bytes = own.filter(|_| matches!(buffer.source(), Source::Bin));
            let bytes = bytes.or_else(|| given.get(buffer.index()).map(Vec::as_slice)).unwrap_or_default();
            if bytes.len() < buffer.length() {
                return Err(format!("buffer {}: {} bytes of {}", buffer.index(), bytes.len(), buffer.length()));
            }
            Ok(bytes)
        })
        .collect()
}

fn source_material(material: &gltf::Material<'_>, image_colors: &[Option<[f32; 3]>]) -> SourceMaterial {
    let number = material.index().unwrap_or_default();
    let surface = material.pbr_metallic_roughness();
    let [r, g, b, alpha] = surface.base_color_factor();
    let texture = surface.base_color_texture();
    let of_image = |texture: gltf::texture::Info<'_>| image_colors.get(texture.texture().source().index()).copied();
    let albedo = match texture.map(of_image) {
        None => Some([r, g, b]),
        // The factor alone says nothing of a surface whose picture can't be seen.
        Some(color) => color.flatten().map(|[x, y, z]| [r * x, g * y, b * z]),
    };
    let alpha = if material.alpha_mode() == AlphaMode::Opaque { 1.0 } else { alpha };
    let transmission = material.transmission().map_or(0.0, |t| t.transmission_factor());
    let opacity = alpha.clamp(0.0, 1.0) * (1.0 - transmission.clamp(0.0, 1.0));
    let name = material.name().map_or_else(|| format!("material {number}"), str::to_owned);
    SourceMaterial { name, albedo, opacity }
}

struct Reader<'a> {
    buffers: Vec<&'a [u8]>,
    placing: Placing,
    /// The slot of faces without a material.
    no_material: usize,
    num_nodes: usize,
    triangles: Vec<([Vec3; 3], usize)>,
}

impl Reader<'_> {
    fn read_node(&mut self, node: &Node<'_>, parent: &Affine, depth: usize) -> std::result::Result<(), String> {
        self.num_nodes += 1;
        if depth > MAX_DEPTH || self.num_nodes > MAX_NODES {
            let reason =
                format!("node {}: more than {MAX_DEPTH} within each other or {MAX_NODES} in all", node.index());
            return Err(reason);
        }
        let scene_from_node = product(parent, &affine(&node.transform().matrix()));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            self.read_primitive(&primitive, &scene_from_node)?;
        }
        for child in node.children() {
            self.read_node(&child, &scene_from_node, depth + 1)?;
        }
        Ok(())
    }

    fn read_primitive(
        &mut self,
        primitive: &Primitive<'_>,
        scene_from_node: &Affine,
    ) -> std::result::Result<(), String> {
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let positions = primitive.get(&Semantic::Positions).ok_or("a mesh without positions")?;
        if (positions.data_type(), positions.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err(format!("accessor {}: positions that are not three floats each", positions.index()));
        }
        let corners = self.elements(&positions, |bytes| {
            let [x, y, z] = [0, 4, 8].map(|at| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]))));
            // glTF: y up, z forward, x to the left.
            let [x, y, z] = transformed(scene_from_node, [x, y, z]);
            self.placing.place(Vec3::new(z as f32, x as f32, y as f32))
        })?;
        if let Some(bad) = corners.iter().find(|corner| !corner.is_finite()) {
            return Err(format!("a coordinate is not finite: {bad}"));
        }
        let indices: Vec<usize> = match primitive.indices() {
            None => (0..corners.len()).collect(),
            Some(accessor) => match (accessor.data_type(), accessor.dimensions()) {
                (DataType::U8, Dimensions::Scalar) => self.elements(&accessor, |b| usize::from(b[0]))?,
                (DataType::U16, Dimensions::Scalar) => {
                    self.elements(&accessor, |b| usize::from(u16::from_le_bytes([b[0], b[1]])))?
                }
                (DataType::U32, Dimensions::Scalar) => {
                    self.elements(&accessor, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)?
                }
                _ => return Err(format!("accessor {}: indices that are not whole numbers", accessor.index())),
            },
        };
        if let Some(bad) = indices.iter().find(|i| **i >= corners.len()) {
            return Err(format!("a face names corner {bad} of {}", corners.len()));
        }
        let slot = primitive.material().index().unwrap_or(self.no_material);
        let is_mirrored = determinant(scene_from_node) < 0.0;
        for face in faces(primitive.mode(), &indices) {
            let [a, b, c] = face.map(|i| corners[i]);
            let triangle = if is_mirrored { [a, c, b] } else { [a, b, c] };
            if has_area(&triangle) {
                self.triangles.push((triangle, slot));
            }
        }
        Ok(())
    }

    /// Every element of an accessor, read from its bytes.
    fn elements<T>(&self, accessor: &Accessor<'_>, read: impl Fn(&[u8]) -> T) -> std::result::Result<Vec<T>, String> {
        let fail = |reason: &str| format!("accessor {}: {reason}", accessor.index());
        if accessor.sparse().is_some() {
            return Err(fail("sparse values are not read"));
        }
        let view = accessor.view().ok_or_else(|| fail("no values"))?;
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        let bytes = view
            .offset()
            .checked_add(view.length())
            .and_then(|end| self.buffers[view.buffer().index()].get(view.offset()..end))
            .ok_or_else(|| fail("beyond the end of its buffer"))?;
        let bytes = bytes.get(accessor.offset()..).ok_or_else(|| fail("beyond the end of its view"))?;
        let needed = accessor.count().saturating_sub(1).checked_mul(stride).and_then(|n| n.checked_add(size));
        if accessor.count() > 0 && needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(fail("beyond the end of its view"));
        }
        Ok((0..accessor.count()).map(|i| read(&bytes[i * stride..i * stride + size])).collect())
    }
}

/// The corners of each face; in strips every other one is turned around (specification, section 3.7.2.1).
fn faces(mode: Mode, indices: &[usize]) -> Vec<[usize; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Mode::TriangleFan => {
            let Some((first, rest)) = indices.split_first() else { return Vec::new() };
            rest.windows(2).map(|w| [*first, w[0], w[1]]).collect()
        }
        _ => indices.chunks_exact(3).map(|w| [w[0], w[1], w[2]]).collect(),
    }
}

fn affine(columns: &[[f32; 4]; 4]) -> Affine {
    columns.map(|[x, y, z, _]| [f64::from(x), f64::from(y), f64::from(z)])
}

fn turned(transform: &Affine, [x, y, z]: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| transform[0][i] * x + transform[1][i] * y + transform[2][i] * z)
}

fn transformed(transform: &Affine, point: [f64; 3]) -> [f64; 3] {
    let turned = turned(transform, point);
    std::array::from_fn(|i| turned[i] + transform[3][i])
}

fn product(a: &Affine, b: &Affine) -> Affine {
    [turned(a, b[0]), turned(a, b[1]), turned(a, b[2]), transformed(a, b[3])]
}

fn determinant([a, b, c, _]: &Affine) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) + c[0] * (a[1] * b[2] - a[2] * b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pyramid's bytes: four corners as floats, then four faces as 16-bit indices.
    fn bytes() -> Vec<u8> {
        let corners: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]];
        let faces: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
        let floats = corners.iter().flatten().flat_map(|v| v.to_le_bytes());
        floats.chain(faces.iter().flat_map(|i| i.to_le_bytes())).collect()
    }

    fn document(node: &str, primitive: &str) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{node}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1{primitive}}}]}}],
            "materials":[{{"name":"red","pbrMetallicRoughness":{{"baseColorFactor":[0.8,0.1,0.1,1]}}}},
              {{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorFactor":[1,1,1,0.25]}}}},
              {{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}},"baseColorFactor":[0.5,1,1,1]}}}}],
            "textures":[{{"source":0}}],"images":[{{"uri":"a.png"}}],
            "buffers":[{{"uri":"a.bin","byteLength":72}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":24}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,2,4]}},
              {{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}}]}}"#
        )
    }

    fn read(document: &str) -> Result<Triangles> {
        gltf_triangles("a.gltf", document.as_bytes(), &[bytes()], &[Some([0.2, 0.4, 0.6])], &ImportOptions::default())
    }

    fn volume(triangles: &[([Vec3; 3], usize)]) -> f32 {
        triangles.iter().map(|([a, b, c], _)| a.dot(b.cross(*c)) / 6.0).sum()
    }

    #[test]
    fn z_becomes_forward_and_nodes_move_what_they_hold() {
        let plain = read(&document(r#"{"mesh":0}"#, "")).unwrap().triangles;
        assert_eq!(plain.len(), 4);
        let most = plain.iter().flat_map(|(c, _)| *c).fold(Vec3::ZERO, Vec3::max);
        assert_eq!(most, Vec3::new(4.0, 1.0, 2.0));
        assert!((volume(&plain) - 8.0 / 6.0).abs() < 1e-6, "faces look outward: {}", volume(&plain));
        // Twice as large and mirrored, inside a node that is moved up by 3.
        let nested = r#"{"children":[1],"translation":[0,3,0]},{"mesh":0,"scale":[-2,2,2]}"#;
        let moved = read(&document(nested, "")).unwrap().triangles;
        let least = moved.iter().flat_map(|(c, _)| *c).fold(Vec3::INFINITY, Vec3::min);
        assert_eq!(least, Vec3::new(0.0, -2.0, 3.0));
        let centered: Vec<_> = moved.iter().map(|(c, slot)| (c.map(|p| p - Vec3::Z * 3.0), *slot)).collect();
        assert!((volume(&centered) - 64.0 / 6.0).abs() < 1e-4, "{}", volume(&centered));
    }

    #[test]
    fn colors_come_from_factors_and_pictures() {
        let materials = read(&document(r#"{"mesh":0}"#, r#","material":1"#)).unwrap();
        assert!(materials.triangles.iter().all(|(_, slot)| *slot == 1));
        let [red, clear, textured] = &materials.materials[..] else { panic!() };
        assert_eq!((red.name.as_str(), red.albedo, red.opacity), ("red", Some([0.8, 0.1, 0.1]), 1.0));
        assert_eq!((clear.name.as_str(), clear.opacity), ("material 1", 0.25));
        assert_eq!(textured.albedo, Some([0.1, 0.4, 0.6]));
        let unnamed = read(&document(r#"{"mesh":0}"#, "")).unwrap();
        assert!(unnamed.triangles.iter().all(|(_, slot)| *slot == 3));
    }

    #[test]
    fn strips_and_fans_are_the_triangles_of_the_specification() {
        assert_eq!(faces(Mode::TriangleStrip, &[5, 6, 7, 8, 9]), [[5, 6, 7], [6, 8, 7], [7, 8, 9]]);
        assert_eq!(faces(Mode::TriangleFan, &[5, 6, 7, 8]), [[5, 6, 7], [5, 7, 8]]);
        assert_eq!(faces(Mode::Triangles, &[1, 2, 3, 4, 5, 6, 7]), [[1, 2, 3], [4, 5, 6]]);
        assert!(faces(Mode::TriangleFan, &[]).is_empty() && faces(Mode::TriangleStrip, &[1]).is_empty());
    }

    #[test]
    fn broken_files_are_refused_with_their_name_and_reason() {
        let refuse = |document: String| read(&document).map(|_| ()).unwrap_err().to_string();
        let good = document(r#"{"mesh":0}"#, "");
        assert!(read(&good).is_ok());
        assert!(refuse("{}".to_owned()).starts_with("a.gltf: no glTF 2.0 file: "));
        let circle = document(r#"{"mesh":0,"children":[1]},{"children":[0]}"#, "");
        assert!(refuse(circle).starts_with("a.gltf: node "));
        let swap = |from: &str, to: &str| refuse(good.replace(from, to));
        assert_eq!(swap(r#""byteLength":72"#, r#""byteLength":73"#), "a.gltf: buffer 0: 72 bytes of 73");
        assert_eq!(swap(r#""POSITION":0"#, r#""POSITION":7"#), "a.gltf: no glTF 2.0 file: accessor 7 of 2");
        assert_eq!(swap(r#""count":4"#, r#""count":5"#), "a.gltf: accessor 0: beyond the end of its view");
        assert_eq!(
            swap(r#""byteOffset":48"#, r#""byteOffset":50"#),
            "a.gltf: accessor 1: beyond the end of its buffer"
        );
        assert_eq!(swap(r#""count":12"#, r#""count":13"#), "a.gltf: accessor 1: beyond the end of its view");
        let required = r#""extensionsRequired":["KHR_draco_mesh_compression"],"scene":0"#;
        assert!(swap(r#""scene":0"#, required).contains("KHR_draco_mesh_compression"));
        assert_eq!(swap(r#""indices":1"#, r#""mode":0"#), "a.gltf: no triangle with an area");
    }
}
