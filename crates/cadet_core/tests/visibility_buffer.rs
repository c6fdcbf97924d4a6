//! Drawing into the visibility buffer against casting the same samples.
#![allow(missing_docs)]

mod common;

use std::sync::Arc;

use common::{place, posed, random_rotation, random_scene, soup, sphere};

use cadet_core::geometry::{IndexedFaces, Mesh};
use cadet_core::instance::Instance;
use cadet_core::material::Palette;
use cadet_core::math::{DPose3, DVec3, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{
    BLOCK, BeamGrid, DrawnFace, Hits, NO_HIT, PinholeGrid, PosedScene, SurfaceFilter, VisibilityBuffer, cast, rasterize,
};
use proptest::prelude::*;

fn camera(pose: DPose3, rows: usize, columns: usize) -> PinholeGrid {
    PinholeGrid::new(pose, [721.5, 721.5, 609.6, 172.9], [0.0, 0.0, 4.0, 4.0], rows, columns).expect("a valid camera")
}

fn quincunx(pose: DPose3, rows: usize, columns: usize) -> PinholeGrid {
    PinholeGrid::quincunx(pose, [180.4, 180.4, 150.2, 43.3], [-3.0, -1.0], rows, columns).expect("a valid camera")
}

/// Every other instance becomes transparent.
fn with_transparent_surfaces(mut instances: Vec<Instance>) -> Arc<PosedScene> {
    let mut materials = common::matt().materials().to_vec();
    materials[0].transmission = 0.8;
    let palette = Arc::new(Palette::new(materials));
    for instance in instances.iter_mut().skip(1).step_by(2) {
        instance.palette = Arc::clone(&palette);
    }
    posed(&instances)
}

/// How much the inverse depth of a face may be off along a beam, by rounding and, of two faces that are drawn as one, by
/// as much as they are bent and by the rounding of their corners.
fn tolerance(
    scene: &PosedScene,
    grid: &PinholeGrid,
    face: Option<&DrawnFace>,
    (row, column): (usize, usize),
    inverse_depth: f64,
) -> f64 {
    let rounding = 2e-6 * inverse_depth;
    let Some(face) = face.filter(|face| face.is_quad) else { return rounding };
    let [a, b, c] = scene.corners(face.instance, face.face).map(|p| p.as_dvec3());
    let slope = (b - a).cross(c - a).normalize().dot(grid.beam(row, column).direction_world).abs();
    rounding + 3e-4 / slope * inverse_depth * inverse_depth
}

/// Checks that drawing and casting see the same faces, but for rounding where two are equally deep; the buffer has been
/// used before.
fn assert_same(scene: &PosedScene, grid: &PinholeGrid, rows: usize, columns: usize, buffer: &mut VisibilityBuffer) {
    rasterize(scene, grid, buffer);
    let mut hits = Hits::new(rows, columns);
    cast(scene, grid, SurfaceFilter::Opaque, |_| true, &mut hits);
    let opaque = hits.clone();
    cast(scene, grid, SurfaceFilter::Transparent, |_| true, &mut hits);
    for row in 0..rows {
        for column in 0..columns {
            let at = row * columns + column;
            let (seen, inverse_depth) =
                buffer.front(row, column).map_or(((NO_HIT, NO_HIT), 0.0), |(face, inverse_depth)| {
                    let depth = face.depth_m_at(grid.columns_x(row)[column], grid.rows_y()[row]);
                    assert!((depth * inverse_depth - 1.0).abs() < 2e-6, "{depth} {inverse_depth}");
                    ((face.instance, face.face), inverse_depth)
                });
            let expected = 1.0 / f64::from(hits.depth_m[at]);
            let front = buffer.front(row, column).map(|(face, _)| face);
            let tolerance = |face, expected| tolerance(scene, grid, face, (row, column), expected);
            let close = (f64::from(inverse_depth) - expected).abs() <= tolerance(front, expected);
            assert!(close, "{row} {column}: {seen:?} {inverse_depth} {expected}");
            // Where the opaque layer alone is nearest, the transparent one says nothing.
            if seen != (hits.instance[at], hits.face[at]) {
                assert!(seen.0 != NO_HIT && hits.instance[at] != NO_HIT);
            }
            let block = buffer.opaque(row / BLOCK * buffer.blocks_across + column / BLOCK);
            let behind = block.inverse_depth_per_m[row % BLOCK][column % BLOCK];
            let face = (behind > 0.0).then(|| &buffer.faces[block.face[row % BLOCK][column % BLOCK] as usize]);
            let expected = 1.0 / f64::from(opaque.depth_m[at]);
            assert!((f64::from(behind) - expected).abs() <= tolerance(face, expected), "{row} {column}: opaque");
        }
    }
}

#[test]
fn drawing_sees_what_casting_sees() {
    let mut buffer = VisibilityBuffer::default();
    for seed in 0..12 {
        let mut s = Stream::from_seed("drawn scenes", seed);
        let center = DVec3::new(s.range(-400.0, 400.0), s.range(-400.0, 400.0), s.range(-5.0, 30.0));
        let scene = with_transparent_surfaces(random_scene(&mut s, center));
        // Also images that end within a block.
        for (rows, columns) in [(94, 311), (94, 311), (90, 314), (3, 17)] {
            let pose = DPose3 { rotation: random_rotation(&mut s), translation: center };
            for grid in [camera(pose, rows, columns), quincunx(pose, rows, columns)] {
                assert_same(&scene, &grid, rows, columns, &mut buffer);
            }
        }
    }
}

/// Flat kites turned every way, some of them hardly seen from their rims, near and far, beside and behind the camera.
fn cards(s: &mut Stream, n: usize, center_world: DVec3) -> Instance {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for k in 0..n {
        let middle = DVec3::new(s.normal(), s.normal(), s.normal()) * [0.5, 2.0, 8.0, 30.0][k % 4];
        let side = DVec3::new(s.normal(), s.normal(), s.normal()).normalize();
        let other = DVec3::new(s.normal(), s.normal(), s.normal());
        // Every third one stands nearly in a plane with the camera.
        let past = middle + other * 0.01;
        let up = if k % 3 == 0 { past } else { other }.cross(side).normalize();
        let side = if k % 3 == 0 { past.normalize() } else { side };
        let size = s.range(0.1, 1.5);
        let base = vertices.len() as u32;
        faces.extend([[0, 1, 2], [0, 2, 3]].map(|f: [u32; 3]| f.map(|i| base + i)));
        vertices.extend(
            [(0.0, -1.0), (0.6, 0.2), (0.0, 1.0), (-0.6, 0.2)]
                .map(|(x, y)| (middle + (side * x + side.cross(up) * y) * size).as_vec3()),
        );
    }
    let (normals, slots) = (vec![Vec3::Z; vertices.len()], vec![0; faces.len()]);
    let mesh = Mesh::new("cards", &IndexedFaces { vertices, normals, faces, slots }).expect("a valid mesh");
    place(mesh, DPose3 { rotation: random_rotation(s), translation: center_world }, 0)
}

#[test]
fn pairs_of_faces_are_seen_as_the_faces_are() {
    let mut pairs = 0;
    for seed in 0..8 {
        let mut s = Stream::from_seed("drawn cards", seed);
        let center = DVec3::new(s.range(-400.0, 400.0), s.range(-400.0, 400.0), s.range(-5.0, 30.0));
        let scene = with_transparent_surfaces(vec![cards(&mut s, 600, center), cards(&mut s, 200, center)]);
        let pose = DPose3 { rotation: random_rotation(&mut s), translation: center };
        let mut buffer = VisibilityBuffer::default();
        for grid in [camera(pose, 94, 311), quincunx(pose, 94, 311)] {
            assert_same(&scene, &grid, 94, 311, &mut buffer);
            pairs += buffer.faces.iter().filter(|face| face.is_quad).count();
        }
    }
    assert!(pairs > 150, "{pairs}");
}

#[test]
fn equal_depths_go_to_the_earlier_instance_and_face() {
    let at = |id| place(common::cuboid([1.0; 3].into()), common::at(0.0, 0.0, 10.0), id);
    let grid = camera(DPose3::IDENTITY, 94, 311);
    let mut buffer = VisibilityBuffer::default();
    rasterize(&posed(&[at(3), at(2), at(1)]), &grid, &mut buffer);
    let seen: Vec<u32> = (0..94)
        .flat_map(|r| (0..311).map(move |c| (r, c)))
        .filter_map(|(r, c)| Some(buffer.front(r, c)?.0.instance))
        .collect();
    assert!(seen.len() > 500 && seen.iter().all(|i| *i == 0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn triangle_soups_are_drawn_as_they_are_cast(seed in 0_u64..1_000_000, n in 1_usize..300) {
        let mut s = Stream::from_seed("drawn soup", seed);
        let center = DVec3::new(300.0, -250.0, 10.0);
        let scene = with_transparent_surfaces(vec![soup(&mut s, n, 12.0, center), soup(&mut s, n, 12.0, center)]);
        let pose = DPose3 { rotation: random_rotation(&mut s), translation: center };
        for grid in [camera(pose, 94, 311), quincunx(pose, 94, 311)] {
            assert_same(&scene, &grid, 94, 311, &mut VisibilityBuffer::default());
        }
    }

    #[test]
    fn nothing_is_seen_through_a_closed_mesh(seed in 0_u64..1_000_000, rings in 3_u32..40, radius in 0.5_f32..80.0) {
        let mut s = Stream::from_seed("drawn closed", seed);
        let scene = posed(&[place(sphere(radius, rings), DPose3::IDENTITY, 1)]);
        let inside = DVec3::new(s.normal(), s.normal(), s.normal()).normalize() * f64::from(radius) * 0.4;
        let mut buffer = VisibilityBuffer::default();
        rasterize(&scene, &camera(DPose3 { rotation: random_rotation(&mut s), translation: inside }, 94, 311), &mut buffer);
        prop_assert!((0..94).all(|r| (0..311).all(|c| buffer.front(r, c).is_some())));
    }
}
