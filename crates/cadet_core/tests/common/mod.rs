//! Scenes and comparisons for the tests of visibility.
#![allow(dead_code, missing_docs)]

use std::sync::Arc;

use cadet_core::geometry::{IndexedFaces, LodSet, Mesh, MeshBuilder};
use cadet_core::instance::Instance;
use cadet_core::material::{Material, Palette, Pattern, Semantic};
use cadet_core::math::{self, DPose3, DQuat, DVec3, TAU, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{BeamGrid, Hits, NO_HIT, PosedScene, RayCaster, SurfaceFilter, cast};

pub fn matt() -> Arc<Palette> {
    Arc::new(Palette::new(vec![Material::matt(Semantic::Building, [0.5; 3], Pattern::Plain, 0.4)]))
}

pub fn place(mesh: Mesh, world_from_local: DPose3, actor_id: i32) -> Instance {
    Instance::new(Arc::new(LodSet::single(mesh)), matt(), world_from_local, actor_id)
}

pub fn at(x: f64, y: f64, z: f64) -> DPose3 {
    DPose3 { rotation: DQuat::IDENTITY, translation: DVec3::new(x, y, z) }
}

pub fn cuboid(half: Vec3) -> Mesh {
    let mut b = MeshBuilder::new();
    b.cuboid(-half, half, 0);
    b.build("box", 0.5)
}

/// A closed sphere of `2 * rings * rings` quadrilaterals whose corners lie on radius `r`.
pub fn sphere(r: f32, rings: u32) -> Mesh {
    let mut b = MeshBuilder::new();
    let point = |i: u32, j: u32| {
        let (polar, turn) =
            (f64::from(i) * math::PI / f64::from(rings), f64::from(j % (2 * rings)) * math::PI / f64::from(rings));
        let s = math::sin(polar);
        (DVec3::new(s * math::cos(turn), s * math::sin(turn), math::cos(polar)) * f64::from(r)).as_vec3()
    };
    for i in 0..rings {
        for j in 0..2 * rings {
            b.quad(point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1), 0);
        }
    }
    b.build("sphere", 3.0)
}

pub fn random_rotation(s: &mut Stream) -> DQuat {
    let axis = DVec3::new(s.normal(), s.normal(), s.normal() + 1e-9).normalize();
    DQuat::from_axis_angle(axis, s.range(0.0, TAU))
}

/// Triangles without order: small and large, slivers, points and lines among them, through and around the origin.
pub fn soup(s: &mut Stream, n: usize, extent_m: f64, center_world: DVec3) -> Instance {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for k in 0..n {
        let spread = [0.05, 0.5, 4.0, extent_m][s.below(4)];
        let middle = DVec3::new(s.range(-1.0, 1.0), s.range(-1.0, 1.0), s.range(-0.5, 0.5)) * extent_m;
        let mut corners: Vec<Vec3> =
            (0..3).map(|_| (middle + DVec3::new(s.normal(), s.normal(), s.normal()) * spread).as_vec3()).collect();
        match k % 10 {
            0 => corners[2] = corners[1],
            1 => corners[2] = (corners[0] + corners[1]) * 0.5,
            2 => corners = vec![corners[0]; 3],
            _ => {}
        }
        faces.push([0, 1, 2].map(|i| (vertices.len() + i) as u32));
        vertices.extend(corners);
    }
    let normals = vec![Vec3::Z; vertices.len()];
    let slots = vec![0; faces.len()];
    let mesh = Mesh::new("soup", &IndexedFaces { vertices, normals, faces, slots }).expect("a valid soup");
    place(mesh, DPose3 { rotation: random_rotation(s), translation: center_world }, 0)
}

/// Ground, boxes and spheres about a place, some of them around it.
pub fn random_scene(s: &mut Stream, center_world: DVec3) -> Vec<Instance> {
    let mut instances = Vec::new();
    let mut ground = MeshBuilder::new();
    let h = |i: i32, j: i32| Vec3::new(i as f32 * 8.0, j as f32 * 8.0, math::sinf((i * 3 + j) as f32) * 0.3 - 1.9);
    for i in -12..12 {
        for j in -12..12 {
            ground.quad(h(i, j), h(i + 1, j), h(i + 1, j + 1), h(i, j + 1), 0);
        }
    }
    let ground_pose = DPose3 { rotation: DQuat::IDENTITY, translation: center_world };
    instances.push(place(ground.build("ground", 0.5), ground_pose, 0));
    for id in 1..25 {
        let offset = DVec3::new(s.normal() * 20.0, s.normal() * 20.0, s.range(-2.0, 2.0));
        let pose = DPose3 { rotation: random_rotation(s), translation: center_world + offset };
        let mesh = if id % 3 == 0 {
            sphere(s.range(0.3, 3.0) as f32, 6 + s.below(20) as u32)
        } else {
            cuboid(Vec3::new(s.range(0.1, 3.0) as f32, s.range(0.1, 3.0) as f32, s.range(0.1, 2.0) as f32))
        };
        instances.push(place(mesh, pose, id));
    }
    if s.chance(0.5) {
        let pose = DPose3 { rotation: random_rotation(s), translation: center_world };
        instances.push(place(sphere(s.range(30.0, 60.0) as f32, 24), pose, 99));
    }
    instances
}

pub fn posed(instances: &[Instance]) -> Arc<PosedScene> {
    Arc::new(PosedScene::new(instances, DVec3::ZERO))
}

/// Least angle between the ray and an edge of the triangle, as seen from the ray's origin; about, for small angles.
pub fn angle_to_edges(corners: [Vec3; 3], origin: DVec3, direction: DVec3) -> f64 {
    let unit = direction.normalize();
    let flat = corners.map(|p| {
        let r = p.as_dvec3() - origin;
        (r - unit * r.dot(unit), r.dot(unit))
    });
    (0..3)
        .map(|i| {
            let ((a, ra), (b, rb)) = (flat[i], flat[(i + 1) % 3]);
            let along = b - a;
            let t = (-a.dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
            (a + along * t).length() / (ra + (rb - ra) * t).abs().max(1e-9)
        })
        .fold(f64::INFINITY, f64::min)
}

#[derive(Debug, Default)]
pub struct Agreement {
    pub beams: usize,
    pub hits: usize,
    pub disagreements: usize,
    /// The largest angle between a disagreeing ray and the nearest edge of the triangle that one of the two missed.
    pub farthest_from_edge_rad: f64,
}

/// Compares the kernel with rays cast one by one, along the very same beams.
pub fn compare<G: BeamGrid>(scene: &Arc<PosedScene>, grid: &G) -> Agreement {
    let mut hits = Hits::new(grid.rows(), grid.columns());
    cast(scene, grid, SurfaceFilter::All, |_| true, &mut hits);
    let caster = RayCaster::new(Arc::clone(scene));
    let mut out = Agreement::default();
    for row in 0..grid.rows() {
        for column in 0..grid.columns() {
            let i = row * grid.columns() + column;
            let beam = grid.beam(row, column);
            let hit = caster.cast(beam.origin_world, beam.direction_world).expect("a finite ray");
            let kernel_m = f64::from(hits.depth_m[i]) * beam.direction_world.length();
            let single_m = hit.map_or(f64::INFINITY, |h| h.range_m);
            out.beams += 1;
            out.hits += usize::from(hit.is_some());
            let agree = kernel_m == single_m || (kernel_m - single_m).abs() < 1e-3;
            if !agree {
                out.disagreements += 1;
                // The nearer of the two triangles is the one that the other method let pass.
                let (instance, face) = if kernel_m < single_m {
                    (hits.instance[i], hits.face[i])
                } else {
                    hit.map_or((NO_HIT, NO_HIT), |h| (h.instance, h.face))
                };
                let angle = angle_to_edges(scene.corners(instance, face), beam.origin_world, beam.direction_world);
                out.farthest_from_edge_rad = out.farthest_from_edge_rad.max(angle);
            }
        }
    }
    out
}
