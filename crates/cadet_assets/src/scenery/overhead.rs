//! Overhead lines of trams: masts with or without arms, contact wires, and the wires across a street that carry them.

use std::sync::Arc;

use super::draw::{CREASE_RAD, v};
use super::materials::furniture_palette;
use super::materials::furniture_slot as slot;
use super::{Detail, SceneryModel};
use cadet_base::geometry::MeshBuilder;
use cadet_base::instance::Instance;
use cadet_base::material::{Palette, Semantic};
use cadet_base::math::{DPose3, DQuat, DVec2, DVec3, Vec3};
use cadet_base::rng::Stream;

/// Height of contact wires over the rails.
pub const WIRE_HEIGHT_M: f64 = 5.5;
/// Radius of a contact wire, of a carrying wire, and of wires across the street.
const CONTACT_M: f32 = 0.007;
const CARRYING_M: f32 = 0.005;
/// Where levels of detail end. Wires grow with the distance to half a pixel of KITTI's camera, lest they break into
/// dots; their far levels return as many beams as wires of their true width would only where beams are as wide.
const LIMITS_M: [f32; 3] = [22.0, 60.0, 130.0];
const GROWTH: [f32; 3] = [1.0, 2.2, 4.5];
/// The carrying wire over the contact wire: how high at its ends, and in the middle between two masts.
const CARRIED_M: (f32, f32) = (0.9, 0.35);

/// A mast beside tracks or between them; its arms reach `arm_m` to both sides along x, or there are none.
#[must_use]
pub fn tram_mast(variant: usize, arm_m: f64) -> SceneryModel {
    let name = format!("tram-mast/{variant}");
    let mut s = Stream::from_seed(&name, 0);
    let body = [[0.27, 0.28, 0.28], [0.07, 0.10, 0.085], [0.33, 0.31, 0.28]][variant % 3];
    let palette = furniture_palette(&mut s, Semantic::Pole, body, [0.10, 0.05, 0.03]);
    let arm_m = arm_m as f32;
    let shape = Detail::levels([30.0, 80.0, 260.0], move |detail| {
        let mut b = MeshBuilder::new();
        let top = 8.4;
        let sides = detail.pick(12, 8, 5);
        b.tube(&[(v(0.0, 0.0, -0.5), 0.145), (v(0.0, 0.0, top), 0.095)], sides, slot::BODY);
        if detail == Detail::Near {
            b.block(v(0.0, 0.0, 0.02), v(0.42, 0.42, 0.06), slot::BACK);
        }
        let thin = detail.pick(0.022, 0.026, 0.035);
        let sides: &[f32] = if arm_m > 0.0 { &[-1.0, 1.0] } else { &[] };
        for side in sides {
            let reach = side * (arm_m + 0.25);
            // A tube out over the track with a stay above it, an insulator at the mast, and the arm that holds the wire.
            b.tube(&[(v(0.0, 0.0, 6.55), thin), (v(reach, 0.0, 6.6), thin)], 5, slot::BODY);
            b.tube(&[(v(0.0, 0.0, 7.7), 0.5 * thin), (v(reach * 0.92, 0.0, 6.63), 0.5 * thin)], 4, slot::BODY);
            let at_wire = v(side * arm_m, 0.0, WIRE_HEIGHT_M as f32 + 0.02);
            b.tube(&[(v(side * 0.25, 0.0, 6.1), 0.8 * thin), (at_wire, 0.5 * thin)], 4, slot::BODY);
            if detail != Detail::Far {
                b.tube(&[(v(side * 0.14, 0.0, 6.555), 0.05), (v(side * 0.42, 0.0, 6.56), 0.05)], 6, slot::ACCENT);
            }
        }
        b.build("tram-mast", CREASE_RAD)
    });
    SceneryModel::about_origin(name, shape, palette, DVec2::splat(0.15), 8.4)
}

/// A contact wire through points, with the wire that carries it.
#[must_use]
pub fn contact_wire(points: &[DVec3], palette: Arc<Palette>) -> Instance {
    let origin = points[0];
    let local: Vec<Vec3> = points.iter().map(|p| (*p - origin).as_vec3()).collect();
    let length_m = (local[local.len() - 1] - local[0]).length().max(0.1);
    let over = |p: &Vec3| {
        let t = 2.0 * (*p - local[0]).length() / length_m - 1.0;
        *p + Vec3::Z * (CARRIED_M.1 + (CARRIED_M.0 - CARRIED_M.1) * t * t)
    };
    let carried: Vec<Vec3> = local.iter().map(over).collect();
    wire(origin, palette, move |b, grown| {
        let run = |points: &[Vec3], radius: f32| points.iter().map(|p| (*p, radius)).collect::<Vec<_>>();
        b.tube(&run(&local, CONTACT_M * grown), 4, slot::DARK);
        b.tube(&run(&carried, CARRYING_M * grown), 4, slot::DARK);
        if grown < 3.0 {
            for (low, high) in local.iter().zip(&carried).skip(1).step_by(2) {
                b.tube(&[(*low, 0.004), (*high, 0.004)], 3, slot::DARK);
            }
        }
    })
}

/// A wire from mast to mast across a street that sags in the middle, with an insulator near each end.
#[must_use]
pub fn span_wire(from: DVec3, to: DVec3, sag_m: f64, palette: Arc<Palette>) -> Instance {
    let across = (to - from).as_vec3();
    let points: Vec<Vec3> =
        (0..=8).map(|k| k as f32 / 8.0).map(|t| across * t - Vec3::Z * (4.0 * sag_m as f32 * t * (1.0 - t))).collect();
    wire(from, palette, move |b, grown| {
        let run: Vec<(Vec3, f32)> = points.iter().map(|p| (*p, CARRYING_M * grown)).collect();
        b.tube(&run, 4, slot::DARK);
        for k in [1, 7] {
            let (a, e) = (points[k] - across * 0.008, points[k] + across * 0.008);
            b.tube(&[(a, 0.035), (e, 0.035)], 5, slot::ACCENT);
        }
    })
}

fn wire(
    origin: DVec3,
    palette: Arc<Palette>,
    draw: impl Fn(&mut MeshBuilder, f32) + Send + Sync + 'static,
) -> Instance {
    let shape = Detail::levels(LIMITS_M, move |detail| {
        let mut b = MeshBuilder::new();
        draw(&mut b, detail.pick(GROWTH[0], GROWTH[1], GROWTH[2]));
        b.build("wire", CREASE_RAD)
    });
    let world_from_local = DPose3 { rotation: DQuat::IDENTITY, translation: origin };
    Instance::new(shape, palette, world_from_local, 0)
}
