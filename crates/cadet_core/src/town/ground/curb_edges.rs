//! Where curbs stand: between carriageway and what is higher.

use crate::town::ground::mesh::{Cover, PlanMesh};

/// Edges with carriageway on the left and something else on the right.
pub(in crate::town) fn curb_edges(plan: &PlanMesh) -> Vec<[u32; 2]> {
    let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
    let is_road = |c: &Cover| c.is_low();
    // Curbs run between corners of the carriageway.
    let mut is_on_road = vec![false; plan.points.len()];
    for (face, _) in plan.faces.iter().zip(&plan.kinds).filter(|(_, c)| is_road(c)) {
        face.iter().for_each(|v| is_on_road[*v as usize] = true);
    }
    let mut raised: Vec<[u32; 2]> = plan
        .faces
        .iter()
        .zip(&plan.kinds)
        .filter(|(_, c)| !is_road(c))
        .flat_map(|(f, _)| sides(f))
        .filter(|[a, b]| is_on_road[*a as usize] && is_on_road[*b as usize])
        .map(|[a, b]| [b, a])
        .collect();
    raised.sort_unstable();
    plan.faces
        .iter()
        .zip(&plan.kinds)
        .filter(|(_, c)| is_road(c))
        .flat_map(|(f, _)| sides(f))
        .filter(|e| raised.binary_search(e).is_ok())
        .collect()
}
