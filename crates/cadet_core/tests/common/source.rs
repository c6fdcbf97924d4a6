//! Meshes as a reader of files passes them on, from a few lines of text.

use cadet_core::assets::source_mesh::{SourceMaterial, SourceMesh, SourceTriangle};
use cadet_core::math::Vec3;

/// A mesh of `v`, `usemtl`, `g` and `f` lines, polygons cut into fans; a material is a name, a color and an opacity.
pub fn mesh_of(text: &str, library: &[(&str, [f32; 3], f32)]) -> SourceMesh {
    let none = SourceMaterial { name: String::new(), albedo: None, opacity: 1.0 };
    let stated = library.iter().map(|(name, color, opacity)| SourceMaterial {
        name: (*name).to_owned(),
        albedo: Some(*color),
        opacity: *opacity,
    });
    let mut mesh = SourceMesh {
        materials: stated.chain([none]).collect(),
        parts: vec![vec![String::new()]],
        ..Default::default()
    };
    let mut corners = Vec::new();
    let (mut material, mut part) = (library.len(), 0);
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let key = words.next();
        let rest: Vec<&str> = words.collect();
        match key {
            Some("v") => {
                let v: Vec<f32> = rest.iter().map(|w| w.parse().expect("a number")).collect();
                corners.push(Vec3::new(v[0], v[1], v[2]));
            }
            Some("usemtl") => material = library.iter().position(|m| m.0 == rest[0]).expect("a material"),
            Some("g") => {
                part = mesh.parts.len();
                mesh.parts.push(vec![rest[0].to_owned()]);
            }
            Some("f") => {
                let face: Vec<Vec3> = rest
                    .iter()
                    .map(|w| corners[w.split('/').next().expect("one").parse::<usize>().expect("an index") - 1])
                    .collect();
                mesh.triangles.extend(face[1..].windows(2).map(|pair| SourceTriangle {
                    corners: [face[0], pair[0], pair[1]],
                    material: material as u32,
                    part: part as u32,
                }));
            }
            _ => {}
        }
    }
    mesh
}
