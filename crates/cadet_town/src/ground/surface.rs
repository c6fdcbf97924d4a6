//! The ground in space: its plan raised to its heights, and cut into tiles to look at.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::ground::{Asphalt, PlanMesh, palette};
use crate::network::{CURB_HEIGHT_M, PaintedQuad, RoadNetwork};
use crate::paint::Wear;
use cadet_base::geometry::{IndexedFaces, Mesh};
use cadet_base::instance::Instance;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::edges;

/// Side of a tile of visible ground.
const TILE_M: f64 = 50.0;

/// How high a ground lies.
pub(crate) struct Heights<'a> {
    /// Of carriageways.
    pub(crate) road: &'a dyn Fn(DVec2) -> f64,
    /// What lies beside them, over that.
    pub(crate) beside: &'a dyn Fn(DVec2) -> f64,
    /// Whether curbs stand between.
    pub(crate) has_curbs: bool,
}

impl<'a> Heights<'a> {
    /// Of a town: all but the carriageways is as high as its curbs.
    pub(crate) fn town(road: &'a dyn Fn(DVec2) -> f64) -> Self {
        Self { road, beside: &|_| CURB_HEIGHT_M, has_curbs: true }
    }

    /// Of a network's roads alone: with curbs where it has any.
    pub(crate) fn beside_roads(road: &'a dyn Fn(DVec2) -> f64, network: &RoadNetwork) -> Self {
        if network.is_curbless() || network.is_rural() {
            return Self { road, beside: &|_| 0.0, has_curbs: false };
        }
        Self::town(road)
    }
}

fn tile_of(p: DVec2) -> (i64, i64) {
    let cell = (p / TILE_M).floor();
    (cell.x as i64, cell.y as i64)
}

/// The surface in space: plan points at road level, plan points at curb level, and the curbs' faces between.
pub(crate) struct Surface {
    pub(crate) corners: Vec<DVec3>,
    /// One a plan triangle in the same order, then two a curb edge.
    pub(crate) faces: Arc<Vec<[u32; 3]>>,
}

impl Surface {
    pub(crate) fn raise(plan: &PlanMesh, heights: &Heights<'_>) -> Self {
        let n = plan.points.len();
        let ground: Vec<f64> = plan.points.iter().map(|p| (heights.road)(*p)).collect();
        let mut corners = Vec::with_capacity(n + n / 2);
        let mut low = vec![u32::MAX; n];
        let mut high = vec![u32::MAX; n];
        let mut faces: Vec<[u32; 3]> = Vec::with_capacity(plan.faces.len());
        for (face, cover) in plan.covered() {
            let raised = !cover.is_low();
            faces.push(face.map(|i| {
                let slot = if raised { &mut high[i as usize] } else { &mut low[i as usize] };
                if *slot == u32::MAX {
                    let lift = if raised { (heights.beside)(plan.points[i as usize]) } else { 0.0 };
                    *slot = corners.len() as u32;
                    corners.push(plan.points[i as usize].extend(ground[i as usize] + lift));
                }
                *slot
            }));
        }
        let curbs = if heights.has_curbs { curb_edges(plan) } else { Vec::new() };
        for [a, b] in curbs {
            let ([a0, b0], [a1, b1]) = ([a, b].map(|i| low[i as usize]), [a, b].map(|i| high[i as usize]));
            faces.push([b0, a0, a1]);
            faces.push([b0, a1, b1]);
        }
        Self { corners, faces: Arc::new(faces) }
    }

    /// The visible surface, cut into tiles, with markings over it.
    pub(crate) fn tiles(&self, plan: &PlanMesh, markings: &[PaintedQuad], wear: &Wear) -> Vec<Instance> {
        let mut normals = vec![DVec3::ZERO; self.corners.len()];
        let num_flat = plan.faces.len();
        let at = |f: &[u32; 3]| f.map(|i| self.corners[i as usize]);
        for face in &self.faces[..num_flat] {
            let [a, b, c] = at(face);
            for i in face {
                normals[*i as usize] += (b - a).cross(c - a);
            }
        }
        let mut members: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
        for (i, face) in self.faces.iter().enumerate() {
            let [a, b, c] = at(face);
            members.entry(tile_of(((a + b + c) / 3.0).truncate())).or_default().push(i);
        }
        let mut markings_by_tile: BTreeMap<(i64, i64), Vec<&PaintedQuad>> = BTreeMap::new();
        for quad in markings {
            markings_by_tile
                .entry(tile_of((quad.corners[0] + quad.corners[2]).truncate() / 2.0))
                .or_default()
                .push(quad);
        }
        let palette = Arc::new(palette::palette(Asphalt::of_town(wear)));
        let mut local = vec![u32::MAX; self.corners.len()];
        let mut tiles = Vec::with_capacity(members.len());
        for ((i, j), members) in members {
            let corner = DVec2::new(i as f64, j as f64) * TILE_M;
            let lowest = members.first().map_or(0.0, |m| self.corners[self.faces[*m][0] as usize].z);
            let origin = corner.extend(lowest.round());
            let mut parts = IndexedFaces::default();
            let mut used = Vec::new();
            let mut upright = members.iter().filter(|m| **m >= num_flat);
            for m in members.iter().filter(|m| **m < num_flat) {
                let face = self.faces[*m].map(|v| {
                    let slot = &mut local[v as usize];
                    if *slot == u32::MAX {
                        *slot = parts.vertices.len() as u32;
                        used.push(v);
                        parts.vertices.push((self.corners[v as usize] - origin).as_vec3());
                        parts.normals.push(normals[v as usize].normalize_or(DVec3::Z).as_vec3());
                    }
                    *slot
                });
                parts.faces.push(face);
                parts.slots.push(palette::slot(plan.kinds[*m]));
            }
            for v in used {
                local[v as usize] = u32::MAX;
            }
            // Curb faces come in pairs, and both of a pair may fall in different tiles: each is drawn on its own.
            for m in upright.by_ref() {
                let [a, b, c] = at(&self.faces[*m]);
                let normal = (b - a).cross(c - a).normalize_or(DVec3::X);
                parts.triangle([a, b, c].map(|p| (p - origin).as_vec3()), normal.as_vec3(), palette::CURB);
            }
            for PaintedQuad { corners, color, line } in markings_by_tile.get(&(i, j)).into_iter().flatten() {
                let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalize_or_zero();
                let slot = palette::paint(*color, wear.level(*line));
                let [a, b, c, d] = corners.map(|p| (p - origin).as_vec3());
                parts.triangle([a, b, c], normal.as_vec3(), slot);
                parts.triangle([a, c, d], normal.as_vec3(), slot);
            }
            if let Ok(mesh) = Mesh::new("ground", &parts) {
                tiles.push(Instance::standing(mesh, Arc::clone(&palette), origin));
            }
        }
        tiles
    }
}

/// Edges with carriageway on the left and something else on the right.
fn curb_edges(plan: &PlanMesh) -> Vec<[u32; 2]> {
    let sides = |is_low: bool| plan.covered().filter(move |(_, c)| c.is_low() == is_low).flat_map(|(f, _)| edges(f));
    // Curbs run between corners of the carriageway.
    let mut is_on_road = vec![false; plan.points.len()];
    sides(true).for_each(|[a, _]| is_on_road[a as usize] = true);
    let is_between = |[a, b]: &[u32; 2]| is_on_road[*a as usize] && is_on_road[*b as usize];
    let mut raised: Vec<[u32; 2]> = sides(false).filter(is_between).map(|[a, b]| [b, a]).collect();
    raised.sort_unstable();
    sides(true).filter(|e| raised.binary_search(e).is_ok()).collect()
}
