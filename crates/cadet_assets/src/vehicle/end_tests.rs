//! Noses and tails have the depths of real ones.

use super::tests::is_pane;
use super::*;
use crate::rays::Target;

/// Where ends are seen from, as in KITTI, front and rear; and by how much its boxes stand over the ground and end below the roof.
const AWAY_M: f32 = 14.0;
const ASLANT_RAD: [f32; 2] = [0.25, 0.18];
const EYE_M: f32 = 1.73;
const BOX_BOTTOM_M: f32 = 0.045;
const BOX_TOP_M: f32 = -0.012;

/// Depths behind the middle of the bumper, meters: medians over 22 real cars seen from the front and 56 seen from behind, all
/// distinct, of 568 frames.
struct Row {
    name: &'static str,
    /// Which returns: between these shares of the height, and of the half width.
    heights: [f32; 2],
    lateral: [f32; 2],
    /// Which share of them lies before the depth.
    share: f32,
    /// Depth, and some 1.5 standard errors, of the middle of the bumper among them.
    front: [f32; 2],
    rear: [f32; 2],
}

const ALL: [f32; 2] = [0.0, 1.1];
const MIDDLE: [f32; 2] = [0.0, 0.2];
const LOW: [f32; 2] = [0.15, 0.6];

#[rustfmt::skip]
const ROWS: [Row; 9] = [
    Row { name: "quartile", heights: LOW, lateral: ALL, share: 0.25, front: [0.05, 0.03], rear: [0.008, 0.02] },
    Row { name: "median", heights: LOW, lateral: ALL, share: 0.5, front: [0.25, 0.07], rear: [0.053, 0.03] },
    Row { name: "corner", heights: LOW, lateral: [0.85, 1.0], share: 0.5, front: [0.41, 0.07], rear: [0.27, 0.07] },
    Row { name: "0.15 to 0.3", heights: [0.15, 0.3], lateral: ALL, share: 0.5, front: [0.107, 0.04], rear: [0.06, 0.04] },
    Row { name: "0.3 to 0.45", heights: [0.3, 0.45], lateral: ALL, share: 0.5, front: [0.139, 0.05], rear: [0.043, 0.04] },
    Row { name: "0.45 to 0.6", heights: [0.45, 0.6], lateral: ALL, share: 0.5, front: [0.40, 0.07], rear: [0.066, 0.035] },
    Row { name: "0.6 to 0.75", heights: [0.6, 0.75], lateral: ALL, share: 0.5, front: [1.08, 0.18], rear: [0.153, 0.04] },
    Row { name: "0.75 to 0.9", heights: [0.75, 0.9], lateral: ALL, share: 0.5, front: [1.67, 0.15], rear: [0.464, 0.08] },
    Row { name: "0.9 to 1.1", heights: [0.9, 1.1], lateral: ALL, share: 0.5, front: [1.83, 0.09], rear: [0.725, 0.10] },
];

fn quantile(mut values: Vec<f32>, share: f32) -> Option<f32> {
    values.sort_by(f32::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(values[(share * last as f32) as usize])
}

/// A return: depth behind the body's end, and its shares of the height and of the half width.
type Seen = (f32, f32, f32);

/// What a car returns of one end, at a level of detail; beams that meet panes do not come back.
fn scan(model: &VehicleModel, level: usize, end: f32) -> Vec<Seen> {
    let size = model.size_lwh.as_vec3();
    let body = Target::new(&model.body.levels[level].1, |_| true);
    let wheel = Target::new(&model.wheel.as_ref().unwrap().levels[level].1, |_| true);
    let aslant = ASLANT_RAD[usize::from(end < 0.0)];
    let ahead = Vec3::new(-end * cadet_base::math::cosf(aslant), -cadet_base::math::sinf(aslant), 0.0);
    let (eye, left) = (Vec3::Z * EYE_M - ahead * AWAY_M, Vec3::Z.cross(ahead));
    let mut seen = Vec::new();
    for row in -6..40 {
        for column in -40..=40 {
            let to = ahead + left * (0.003 * column as f32) - Vec3::Z * (0.004 * row as f32);
            let of_wheels = model.wheel_centers.iter().filter_map(|center| {
                let hit = wheel.cast(eye - *center, to)?;
                Some((hit.range_m, hit.point + *center))
            });
            let of_body = body.cast(eye, to).map(|hit| (hit.range_m, hit.point, is_pane(hit.slot)));
            let hits = of_wheels.map(|(distance, point)| (distance, point, false)).chain(of_body);
            let Some((_, point, false)) = hits.min_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
            let height = (point.z - BOX_BOTTOM_M) / (size.z - BOX_BOTTOM_M - BOX_TOP_M);
            seen.push((size.x / 2.0 - end * point.x, height, point.y.abs() / (size.y / 2.0)));
        }
    }
    seen
}

/// A quantile of the depths between shares of the height and of the half width.
fn depth(seen: &[Seen], heights: [f32; 2], lateral: [f32; 2], share: f32) -> Option<f32> {
    let is_in = |v: f32, [from, to]: [f32; 2]| (from..to).contains(&v);
    // The flank behind a corner is not of the end.
    let deepest = if lateral == ALL { f32::INFINITY } else { 1.0 };
    let chosen = seen.iter().filter(|(d, h, l)| *d < deepest && is_in(*h, heights) && is_in(*l, lateral));
    quantile(chosen.map(|(d, ..)| *d).collect(), share)
}

#[test]
fn noses_and_tails_are_as_deep_as_real_ones() {
    let models: Vec<VehicleModel> =
        (0..60).map(|seed| VehicleModel::of_traffic(ObjectClass::Car, seed).unwrap()).collect();
    for end in [1.0, -1.0] {
        for level in 0..3 {
            let scans: Vec<Vec<Seen>> = models.iter().map(|model| scan(model, level, end)).collect();
            for row in &ROWS {
                let depths = scans.iter().filter_map(|seen| {
                    let bumper = depth(seen, [0.15, 0.45], MIDDLE, 0.5).expect("a bumper");
                    Some(depth(seen, row.heights, row.lateral, row.share)? - bumper)
                });
                let got = quantile(depths.collect(), 0.5).expect("cars of this row");
                let (side, [real, within]) = if end > 0.0 { ("front", row.front) } else { ("rear", row.rear) };
                assert!(
                    (got - real).abs() < within,
                    "{side}, {}: {got} behind the bumper at level {level}, real cars {real}",
                    row.name
                );
            }
        }
    }
}
