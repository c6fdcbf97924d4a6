//! Meshes from Wavefront OBJ files, with their colors.

use std::io::BufReader;
use std::path::Path;

use super::super::mesh_limits::check_library;
use super::triangles::{ImportOptions, Placing, SourceMaterial, Triangles, check_num_materials, checked, has_area};
use crate::error::{Error, Result};
use crate::geometry::{Bounds, Mesh, MeshBuilder};
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::math::Vec3;

/// Shading is smooth across edges flatter than this.
const CREASE_RAD: f32 = 0.7;
const GREY: [f32; 3] = [0.4; 3];

/// A mesh and the materials that its slots name.
#[derive(Debug, Clone)]
pub struct ImportedMesh {
    /// The mesh in our axes.
    pub mesh: Mesh,
    /// One material for each of the file's, in its order; a last gray one where faces name none.
    pub palette: Palette,
}

/// Reads an OBJ file and the material libraries beside it.
///
/// # Errors
/// [`Error::Mesh`], naming the file and the reason: unreadable, no OBJ, no triangles with an area, coordinates that are
/// not finite, more than 256 materials, a missing library. [`Error::OutOfRange`] for a scale that is not above 0.
pub fn read_obj(path: &Path, options: &ImportOptions) -> Result<ImportedMesh> {
    let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    let text = std::fs::read_to_string(path).map_err(|e| Error::Mesh { name: name.clone(), reason: e.to_string() })?;
    obj(&name, &text, options, |library| {
        // Libraries lie beside the file, whatever folder it names.
        let library = Path::new(library).file_name().ok_or("names no file")?;
        std::fs::read_to_string(path.with_file_name(library)).map_err(|e| e.to_string())
    })
}

/// Reads the text of an OBJ file; `library` gives the text of a material library by the name that the file uses.
///
/// # Errors
/// As [`read_obj`].
pub fn obj(
    name: &str,
    text: &str,
    options: &ImportOptions,
    library: impl Fn(&str) -> std::result::Result<String, String>,
) -> Result<ImportedMesh> {
    let Triangles { triangles, materials } = obj_triangles(name, text, options, library)?;
    let mut palette: Vec<Material> = materials.iter().map(|m| material(m, options.semantic)).collect();
    if triangles.iter().any(|(_, slot)| *slot == palette.len()) {
        palette.push(Material::matt(options.semantic, GREY, Pattern::Plain, 0.3));
    }
    check_num_materials(name, palette.len())?;
    let foot = if options.on_ground {
        let bounds = Bounds::of(triangles.iter().flat_map(|(corners, _)| *corners));
        Vec3::new(bounds.center().x, bounds.center().y, bounds.min.z)
    } else {
        Vec3::ZERO
    };
    let mut builder = MeshBuilder::new();
    for ([a, b, c], slot) in triangles {
        builder.triangle(a - foot, b - foot, c - foot, slot as u8);
    }
    Ok(ImportedMesh { mesh: builder.build(name, CREASE_RAD), palette: Palette::new(palette) })
}

/// Reads the triangles that have an area, scaled, turned upright and by the yaw, at least one.
///
/// # Errors
/// As [`read_obj`].
pub(super) fn obj_triangles(
    name: &str,
    text: &str,
    options: &ImportOptions,
    library: impl Fn(&str) -> std::result::Result<String, String>,
) -> Result<Triangles> {
    let fail = |reason: String| Error::Mesh { name: name.to_owned(), reason };
    let placing = Placing::new(options)?;
    // The loader reports a missing library only as such: the reason is kept here.
    let missing = std::cell::RefCell::new(None);
    let load = tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let loaded = tobj::load_obj_buf(&mut BufReader::new(text.as_bytes()), &load, |file| {
        let file = file.to_string_lossy();
        match library(&file).and_then(|text| check_library(&text).map(|()| text)) {
            Ok(text) => tobj::load_mtl_buf(&mut BufReader::new(text.as_bytes())),
            Err(reason) => {
                let _ = missing.borrow_mut().get_or_insert(format!("material library {file}: {reason}"));
                Err(tobj::LoadError::OpenFileFailed)
            }
        }
    });
    if let Some(reason) = missing.into_inner() {
        return Err(fail(reason));
    }
    let (models, materials) = loaded.map_err(|e| fail(e.to_string()))?;
    let materials = materials.map_err(|e| fail(format!("material library: {e}")))?;
    let materials: Vec<SourceMaterial> = materials.into_iter().map(source_material).collect();
    let place = |p: &[f32]| {
        placing.place(if options.y_up { Vec3::new(p[0], -p[2], p[1]) } else { Vec3::new(p[0], p[1], p[2]) })
    };
    let mut triangles = Vec::new();
    for model in &models {
        let slot = model.mesh.material_id.unwrap_or(materials.len());
        if slot > materials.len() {
            return Err(fail(format!("material {slot} of {}", materials.len())));
        }
        let corners: Vec<Vec3> = model.mesh.positions.chunks_exact(3).map(place).collect();
        if let Some(bad) = corners.iter().find(|c| !c.is_finite()) {
            return Err(fail(format!("a coordinate is not finite: {bad}")));
        }
        for face in model.mesh.indices.chunks_exact(3) {
            let corner = |i: usize| corners.get(face[i] as usize).copied();
            let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
                return Err(fail(format!("a face names corner {:?} of {}", face.iter().max(), corners.len())));
            };
            if has_area(&[a, b, c]) {
                triangles.push(([a, b, c], slot));
            }
        }
    }
    if models.iter().all(|m| m.mesh.indices.is_empty()) {
        return Err(fail("no faces: is it a Wavefront OBJ file?".to_owned()));
    }
    checked(triangles, materials).map_err(fail)
}

fn source_material(stated: tobj::Material) -> SourceMaterial {
    let opacity = stated.dissolve.filter(|d| d.is_finite()).map_or(1.0, |d| d.clamp(0.0, 1.0));
    SourceMaterial { name: stated.name, albedo: stated.diffuse, opacity }
}

/// The diffuse color as albedo; what is dissolved is glass.
fn material(source: &SourceMaterial, semantic: Semantic) -> Material {
    let value = |v: f32, default: f32| if v.is_finite() { v.clamp(0.0, 1.0) } else { default };
    let albedo = source.albedo.unwrap_or(GREY).map(|c| value(c, 0.4));
    let luma = 0.2126 * albedo[0] + 0.7152 * albedo[1] + 0.0722 * albedo[2];
    // Most paints are clearer at 905 nm than they look.
    let mut m = Material::matt(semantic, albedo, Pattern::Plain, (0.08 + 0.7 * luma).min(0.8));
    let opacity = source.opacity;
    if opacity < 0.99 {
        m.transmission = 1.0 - opacity;
        m.lidar.transmission = 1.0 - opacity;
        m.roughness = 0.05;
        m.specular = 0.04;
    }
    m
}

#[cfg(test)]
#[allow(clippy::print_stderr)]
mod tests {
    use super::*;

    const TETRAHEDRON: &str = "mtllib two.mtl\nv 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nusemtl red\nf 1 3 2\nf 1 2 4\n\
                               usemtl pane\nf 1 4 3\nf 2 3 4\n";
    const TWO: &str = "newmtl red\nKd 0.8 0.1 0.1\nnewmtl pane\nKd 0.2 0.2 0.2\nd 0.3\n";

    fn tetrahedron(options: &ImportOptions) -> ImportedMesh {
        obj("t.obj", TETRAHEDRON, options, |_| Ok(TWO.to_owned())).unwrap()
    }

    #[test]
    fn corners_are_scaled_turned_and_set_on_the_ground() {
        let options = ImportOptions { scale: 0.5, yaw_rad: std::f64::consts::FRAC_PI_2, ..Default::default() };
        let imported = tetrahedron(&options);
        let (min, max) = (imported.mesh.bounds.min, imported.mesh.bounds.max);
        assert!((min - Vec3::new(-0.5, -0.5, 0.0)).length() < 1e-6, "{min}");
        assert!((max - Vec3::new(0.5, 0.5, 1.0)).length() < 1e-6, "{max}");
        assert_eq!(imported.mesh.faces.len(), 4);
        let kept = ImportOptions { on_ground: false, y_up: true, ..Default::default() };
        let bounds = tetrahedron(&kept).mesh.bounds;
        assert!((bounds.min - Vec3::new(0.0, -2.0, 0.0)).length() < 1e-6 && (bounds.max.z - 2.0).abs() < 1e-6);
    }

    #[test]
    fn colors_come_with_the_faces() {
        let imported = tetrahedron(&ImportOptions::default());
        assert_eq!(imported.palette.materials()[0].albedo, [0.8, 0.1, 0.1]);
        assert!(!imported.palette.materials()[0].is_transparent() && imported.palette.materials()[1].is_transparent());
        assert_eq!(imported.mesh.slots, [0, 0, 1, 1]);
    }

    #[test]
    fn bad_files_are_refused_with_their_name_and_reason() {
        let refuse = |text: &str| {
            let error = obj("bad.obj", text, &ImportOptions::default(), |_| Err("not found".to_owned())).unwrap_err();
            assert!(matches!(&error, Error::Mesh { name, .. } if name == "bad.obj"), "{error}");
            error.to_string()
        };
        assert_eq!(refuse(""), "bad.obj: no faces: is it a Wavefront OBJ file?");
        assert_eq!(refuse("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), "bad.obj: no triangle with an area");
        assert_eq!(refuse(TETRAHEDRON), "bad.obj: material library two.mtl: not found");
        assert!(refuse("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").contains("not finite"));
        for (library, expected) in [
            ("newmtl red\nKd 0.5\n", "line 2: Kd: expected three numbers, got \"0.5\""),
            ("Ks 0.1 x 1", "line 1: Ks: expected three numbers, got \"0.1 x 1\""),
            ("\n\nKa", "line 3: Ka: expected three numbers, got \"\""),
        ] {
            let error = obj("a.obj", TETRAHEDRON, &ImportOptions::default(), |_| Ok(library.to_owned())).unwrap_err();
            assert_eq!(error.to_string(), format!("a.obj: material library two.mtl: {expected}"));
        }
        let fan: String = (0..1200).map(|i| format!("v {} {i} 1\n", i % 2)).collect();
        let corners: String = (1..1200).map(|i| format!(" {i}")).collect();
        assert!(
            refuse(&format!("{fan}f{corners}\n")).contains("more than 1000 triangles meet in one place, (0, 0, 1)")
        );
        for text in ["v 0 0\n", "v 0 0 0\nf 1 2 9\n", "f 1 2 3\n", "v a b c\n", "\u{0}\u{1}\n v 1 f / / /"] {
            assert!(refuse(text).starts_with("bad.obj: "));
        }
        let scale = ImportOptions { scale: 0.0, ..Default::default() };
        let error = obj("t.obj", TETRAHEDRON, &scale, |_| Ok(TWO.to_owned())).unwrap_err();
        assert_eq!(error.to_string(), "mesh scale is 0, expected above 0 and finite");
        let nowhere = read_obj(Path::new("nowhere/none.obj"), &ImportOptions::default()).unwrap_err();
        assert!(nowhere.to_string().starts_with("none.obj: "), "{nowhere}");
    }

    #[test]
    fn real_meshes_come_out_with_the_size_their_models_state() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/meshes");
        if !Path::new(folder).is_dir() {
            eprintln!("skipped: no ../shared/meshes");
            return;
        }
        for (file, length_m) in
            [("hatchback/hatchback.obj", 3.2..5.0), ("suv/suv.obj", 4.0..6.0), ("bus/bus.obj", 7.0..19.0)]
        {
            let path = Path::new(folder).join(file);
            let text = std::fs::read_to_string(&path).unwrap();
            let model = std::fs::read_to_string(path.with_file_name("model.sdf")).unwrap();
            let scale = model.split("<scale>").nth(1).and_then(|t| t.split_whitespace().next()).unwrap();
            let options = ImportOptions { scale: scale.parse().unwrap(), ..Default::default() };
            let mesh = read_obj(&path, &options).unwrap().mesh;
            let size = mesh.bounds.size();
            assert!(length_m.contains(&size.x.max(size.y)), "{file}: {size}");
            let named = text.lines().filter(|l| l.trim_start().starts_with("f ")).count();
            assert!(mesh.faces.len() >= named * 9 / 10, "{file}: {} of {named} faces", mesh.faces.len());
            assert!(mesh.bounds.min.z.abs() < 1e-4);
        }
    }
}
