//! What holds up the deck of a bridge, to look at: parapets along its sides, their outer faces, and its underside.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::DECK_DEPTH_M;
use crate::ground::{PlanMesh, Surface};
use cadet_base::geometry::MeshBuilder;
use cadet_base::instance::Instance;
use cadet_base::material::{Material, Palette, Pattern, Semantic};
use cadet_base::math::{DVec2, DVec3, Vec3};
use cadet_base::plane;

/// Height of a parapet over the edge of the deck, and its thickness.
const PARAPET_M: (f64, f64) = (0.95, 0.22);
/// Corners of less than this are seen as smooth.
const CREASE_RAD: f32 = 0.6;

/// An edge of the deck: where it begins and ends, with the deck on its left.
struct Edge {
    plan: [u32; 2],
    corners: [DVec3; 2],
}

/// The concrete of a deck. Its edges within `is_side` are its sides, the others are its ends.
pub(super) fn structure(plan: &PlanMesh, surface: &Surface, is_side: &dyn Fn(DVec2) -> bool) -> Instance {
    let sides: Vec<Edge> =
        edges(plan, surface).into_iter().filter(|e| is_side((e.corners[0] + e.corners[1]).truncate() / 2.0)).collect();
    // Outward at each point: of both edges that meet there.
    let mut outward: BTreeMap<u32, (DVec2, usize)> = BTreeMap::new();
    for Edge { plan, corners: [a, b] } in &sides {
        let out = -(*b - *a).truncate().normalize_or_zero().perp();
        for point in plan {
            let sum = outward.entry(*point).or_default();
            *sum = (sum.0 + out, sum.1 + 1);
        }
    }
    let origin = surface.corners.first().map_or(DVec3::ZERO, |p| p.round());
    let local = |p: DVec3| (p - origin).as_vec3();
    let mut b = MeshBuilder::new();
    for Edge { plan, corners } in &sides {
        let [(low, top, inner, inner_top), (next_low, next_top, next_inner, next_inner_top)] = [0, 1].map(|k| {
            let inward = -outward[&plan[k]].0.normalize_or_zero() * PARAPET_M.1;
            let (edge, inside) = (corners[k], corners[k] + inward.extend(0.0));
            let raised = DVec3::Z * PARAPET_M.0;
            let all = (edge - DVec3::Z * DECK_DEPTH_M, edge + raised, inside, inside + raised);
            (local(all.0), local(all.1), local(all.2), local(all.3))
        });
        b.quad(low, next_low, next_top, top, 0);
        b.quad(next_inner, inner, inner_top, next_inner_top, 0);
        b.quad(top, next_top, next_inner_top, inner_top, 0);
        // Where a side ends, so does its parapet.
        if outward[&plan[0]].1 == 1 {
            b.quad(inner, low, top, inner_top, 0);
        }
        if outward[&plan[1]].1 == 1 {
            b.quad(next_low, next_inner, next_inner_top, next_top, 0);
        }
    }
    let below = |i: u32| local(surface.corners[i as usize]) - Vec3::Z * DECK_DEPTH_M as f32;
    for [i, j, k] in &surface.faces[..plan.faces.len()] {
        b.triangle(below(*i), below(*k), below(*j), 0);
    }
    let concrete = Material::matt(Semantic::Fence, [0.30, 0.29, 0.27], Pattern::Render, 0.32);
    Instance::standing(b.build("bridge", CREASE_RAD), Arc::new(Palette::new(vec![concrete])), origin)
}

/// The edges of the deck's triangles that no other triangle shares.
fn edges(plan: &PlanMesh, surface: &Surface) -> Vec<Edge> {
    let mut open: BTreeMap<[u32; 2], Edge> = BTreeMap::new();
    for (face, corners) in plan.faces.iter().zip(surface.faces.iter()) {
        for ([a, b], corners) in plane::edges(face).zip(plane::edges(corners)) {
            if open.remove(&[b, a]).is_none() {
                let corners = corners.map(|c| surface.corners[c as usize]);
                open.insert([a, b], Edge { plan: [a, b], corners });
            }
        }
    }
    open.into_values().collect()
}
