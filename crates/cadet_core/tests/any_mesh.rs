//! The kernel on meshes that nobody would draw: no panic, no NaN, and what a plain ray test in double precision says.
#![allow(missing_docs)]

mod common;

use common::{at, place, posed, random_rotation, sphere};

use cadet_core::geometry::{IndexedFaces, Mesh};
use cadet_core::instance::Instance;
use cadet_core::math::{DPose3, DVec3, TAU, Vec3};
use cadet_core::rng::Stream;
use cadet_core::sense::{
    BeamGrid, Hits, LaserRing, NO_HIT, PinholeGrid, PosedScene, SpinningGrid, SurfaceFilter, cast,
};
use proptest::prelude::*;

/// Möller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), from either side: the distance, and
/// how far inside the triangle the ray passes (the least barycentric coordinate; negative outside).
fn moller_trumbore([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return None;
    }
    let t = origin - a;
    let q = t.cross(e1);
    let (u, v) = (t.dot(p) / det, direction.dot(q) / det);
    Some((e2.dot(q) / det, u.min(v).min(1.0 - u - v)))
}

/// Certainties about a beam: a depth that is surely met, and all depths that may be met.
struct Certain {
    surely: f64,
    perhaps: Vec<f64>,
}

fn by_brute_force(scene: &PosedScene, origin: DVec3, direction: DVec3) -> Certain {
    let mut certain = Certain { surely: f64::INFINITY, perhaps: Vec::new() };
    for (index, instance) in scene.instances.iter().enumerate() {
        for face in instance.mesh.face_numbers() {
            let corners = scene.corners(index as u32, face).map(|p| p.as_dvec3());
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            // Slivers, triangles seen edge-on and those that pass through the sensor have no answer that rounding
            // leaves alone.
            let thickness = normal.length() / longest.max(1e-300);
            let facing = normal.normalize_or_zero().dot(direction).abs() / direction.length();
            let reach = (a - origin).length().max((b - origin).length()).max((c - origin).length());
            let off_plane = (a - origin).dot(normal.normalize_or_zero()).abs();
            let is_good = thickness > 1e-6 * reach && facing > 1e-4 && off_plane > 1e-6 * reach;
            if let Some((depth, inside)) = moller_trumbore(corners, origin, direction) {
                if is_good && depth > 1e-9 * reach && inside > 1e-6 {
                    certain.surely = certain.surely.min(depth);
                }
                if !is_good || (depth > -1e-9 * reach && inside > -1e-6) {
                    certain.perhaps.push(if is_good { depth } else { f64::NAN });
                }
            }
        }
    }
    certain
}

fn check<G: BeamGrid>(scene: &PosedScene, grid: &G) -> Result<usize, TestCaseError> {
    let mut hits = Hits::new(grid.rows(), grid.columns());
    cast(scene, grid, SurfaceFilter::All, |_| true, &mut hits);
    let mut surely = 0;
    for row in 0..grid.rows() {
        for column in 0..grid.columns() {
            let i = row * grid.columns() + column;
            let depth = f64::from(hits.depth_m[i]);
            prop_assert!(depth > 0.0, "depth {depth} at {row}, {column}");
            prop_assert_eq!(hits.instance[i] == NO_HIT, depth.is_infinite());
            prop_assert_eq!(hits.face[i] == NO_HIT, depth.is_infinite());
            let beam = grid.beam(row, column);
            let certain = by_brute_force(scene, beam.origin_world, beam.direction_world);
            let close = |other: f64| (depth - other).abs() <= 1e-5 * other.abs() + 1e-9;
            prop_assert!(
                depth <= certain.surely || close(certain.surely),
                "beam {row}, {column}: {depth} behind {}",
                certain.surely
            );
            let explained = certain.perhaps.iter().any(|p| p.is_nan() || close(*p));
            prop_assert!(depth.is_infinite() || explained, "beam {row}, {column}: {depth} hits nothing");
            surely += usize::from(certain.surely.is_finite());
        }
    }
    Ok(surely)
}

fn spinning(pose: DPose3, heights: [f64; 2]) -> SpinningGrid {
    let ring = |i: u32| LaserRing {
        elevation_rad: (80.0 - 10.0 * f64::from(i)).to_radians(),
        height_m: heights[(i % 2) as usize],
        left_m: 0.1 * heights[(i % 2) as usize],
    };
    let azimuths: Vec<f64> = (0..60).map(|j| f64::from(j) * TAU / 60.0).collect();
    SpinningGrid::new(pose, &(0..17).map(ring).collect::<Vec<_>>(), &azimuths).expect("a valid spinning")
}

fn pinhole(pose: DPose3) -> PinholeGrid {
    PinholeGrid::new(pose, [20.0, 20.0, 15.5, 11.5], [0.0, 0.0, 1.0, 1.0], 24, 32).expect("a valid camera")
}

fn mesh(vertices: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Mesh {
    let (normals, slots) = (vec![Vec3::Z; vertices.len()], vec![0; faces.len()]);
    Mesh::new("any", &IndexedFaces { vertices, normals, faces, slots }).expect("finite")
}

/// Corners from a small set of places of every size, so that they coincide, line up and lie on axes and seams; some are
/// free.
fn any_corner(scale: f32) -> impl Strategy<Value = Vec3> {
    let axis = prop_oneof![
        4 => -1.0_f32..1.0,
        1 => Just(0.0_f32),
        1 => Just(-0.0_f32),
        1 => Just(1.0_f32),
        1 => Just(-1.0_f32),
        1 => -1e-6_f32..1e-6,
    ];
    [axis.clone(), axis.clone(), axis].prop_map(move |p| Vec3::from_array(p) * scale)
}

fn any_scene() -> impl Strategy<Value = Instance> {
    let scale = prop_oneof![Just(1e-3_f32), Just(1.0), Just(50.0), Just(5e3), Just(1e6)];
    scale.prop_flat_map(|scale| {
        let corners = prop::collection::vec(any_corner(scale), 3..40);
        (corners, prop::collection::vec(any::<[u8; 3]>(), 1..90)).prop_map(|(corners, faces)| {
            let n = corners.len() as u32;
            place(mesh(corners, faces.iter().map(|f| f.map(|i| u32::from(i) % n)).collect()), at(0.0, 0.0, 0.0), 1)
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 160, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_mesh_is_seen_as_plain_rays_see_it(instance in any_scene(), seed in 0_u64..1_000_000, turned in any::<bool>()) {
        let scene = posed(&[instance]);
        let mut s = Stream::from_seed("any mesh", seed);
        let mut pose = DPose3::IDENTITY;
        if turned {
            pose.rotation = random_rotation(&mut s);
        }
        let _ = check(&scene, &spinning(pose, [0.0, 0.0]))?;
        let _ = check(&scene, &spinning(pose, [0.21, 0.12]))?;
        let _ = check(&scene, &pinhole(pose))?;
    }

    #[test]
    fn a_sensor_in_a_mesh_meets_it_all_around(seed in 0_u64..1_000_000, radius in 0.01_f32..5e3) {
        let mut s = Stream::from_seed("inside", seed);
        let scene = posed(&[place(sphere(radius, 5), DPose3 { rotation: random_rotation(&mut s), ..at(3.0, -2.0, 1.0) }, 1)]);
        let pose = DPose3 { rotation: random_rotation(&mut s), ..at(3.0, -2.0, 1.0) };
        let grid = spinning(pose, [0.0, 0.0]);
        let mut hits = Hits::new(grid.rows(), grid.columns());
        cast(&scene, &grid, SurfaceFilter::All, |_| true, &mut hits);
        prop_assert!(hits.depth_m.iter().all(|d| d.is_finite()));
        let _ = check(&scene, &grid)?;
    }

    #[test]
    fn triangles_across_the_seam_and_over_the_poles_are_met(seed in 0_u64..1_000_000, where_to in 0..3) {
        let mut s = Stream::from_seed("seam and poles", seed);
        // Around +x, where azimuths begin and end, and around both ends of the axis.
        let middle = [DVec3::X, DVec3::Z, -DVec3::Z][where_to as usize] * s.range(0.5, 60.0);
        let size = middle.length() * s.range(0.05, 1.5);
        let corner = |turn: f64, s: &mut Stream| {
            let (x, y) = (size * cadet_core::math::cos(turn), size * cadet_core::math::sin(turn));
            let across = if where_to == 0 { DVec3::new(0.0, x, y) } else { DVec3::new(x, y, 0.0) };
            (middle + across + DVec3::new(s.normal(), s.normal(), s.normal()) * (0.05 * size)).as_vec3()
        };
        let start = s.range(0.0, TAU);
        let corners = (0..3).map(|k| corner(start + f64::from(k) * TAU / 3.0, &mut s)).collect();
        let scene = posed(&[place(mesh(corners, vec![[0, 1, 2]]), at(0.0, 0.0, 0.0), 0)]);
        let _ = check(&scene, &spinning(DPose3::IDENTITY, [0.0, 0.0]))?;
        let _ = check(&scene, &spinning(DPose3::IDENTITY, [0.21, 0.12]))?;
    }
}

#[test]
fn columns_of_any_spacing_see_the_same_walls() {
    // No encoder's ticks at all, few columns, and one alone: the beams of a round wall are all as long as its radius.
    let mut s = Stream::from_seed("columns", 0);
    let scene = posed(&[place(sphere(20.0, 60), at(0.0, 0.0, 0.0), 1)]);
    for n in [1, 2, 7, 8, 9, 500] {
        let mut azimuths: Vec<f64> = (0..n).map(|_| s.range(0.0, TAU)).collect();
        azimuths.sort_by(f64::total_cmp);
        let rings = [0.3_f64, -0.2].map(|elevation_rad| LaserRing::on_axis(elevation_rad, 0.0));
        let grid = SpinningGrid::new(DPose3::IDENTITY, &rings, &azimuths).expect("valid");
        let mut hits = Hits::new(2, n);
        cast(&scene, &grid, SurfaceFilter::All, |_| true, &mut hits);
        assert!(hits.depth_m.iter().all(|d| (19.9..20.001).contains(d)), "{n}: {:?}", hits.depth_m);
    }
}
