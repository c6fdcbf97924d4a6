//! What the land between country roads is used for: parcels of meadows, fields and woods.

use strum::VariantArray;

use crate::ground::Roadside;
use crate::network::RoadNetwork;
use cadet_base::math::{self, DVec2};
use cadet_base::plane::{edges, unit};
use cadet_base::rng::{Stream, StreamKey};

/// What grows on a parcel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, VariantArray)]
pub(crate) enum Crop {
    /// Grass, mown.
    Meadow,
    /// Stalks that are left of grain.
    Stubble,
    /// Plowed soil.
    Soil,
    /// Beets, clover, young rapeseed.
    Greens,
    /// Maize, as high as a man.
    Maize,
    /// A wood's floor.
    Wood,
}

/// Shares of the crops near roads, and of woods far from all.
const SHARES: [f64; 6] = [0.28, 0.17, 0.13, 0.12, 0.08, 0.22];
const FAR_WOODS_SHARE: f64 = 0.75;
const FAR_M: f64 = 85.0;
/// Parcels are cut in two until they are no larger than this, drawn for each.
const PARCEL_M2: (f64, f64) = (5_000.0, 22_000.0);
/// Parcels beside motorways are cut in two until they are no larger than this, drawn for each.
const MOTORWAY_PARCEL_M2: (f64, f64) = (12_000.0, 55_000.0);
/// Where a parcel is cut, and how far the cut is from a right angle.
const CUT_AT: (f64, f64) = (0.36, 0.64);
const CUT_SKEW: f64 = 0.14;

/// A parcel before the roads are taken out of it.
#[derive(Debug, Clone)]
pub(crate) struct Parcel {
    /// Its outline, counter-clockwise.
    pub outline: Vec<DVec2>,
    /// What grows on the pieces that roads leave of it.
    pub crops: [Crop; 4],
}

/// The open country about the roads of a network.
#[derive(Debug, Clone)]
pub(crate) struct Land {
    /// The ground beside the roads.
    pub roadside: Roadside,
    /// Parcels without overlaps, all over the ground.
    pub parcels: Vec<Parcel>,
}

impl Land {
    /// The land about a network between two corners; `None` where it is no open country.
    pub fn of(network: &RoadNetwork, key: &StreamKey, (min, max): (DVec2, DVec2)) -> Option<Self> {
        if !network.is_rural() {
            return None;
        }
        let verges = network.lanes.iter().filter(|l| l.kind == crate::LaneKind::Verge && l.junction.is_none());
        let verge_m = verges.map(|l| l.width_at(l.length_m() / 2.0)).fold(f64::INFINITY, f64::min).clamp(0.5, 4.0);
        let s = &mut key.stream("land/roadside");
        let is_motorway = network.is_motorway();
        let roadside = if is_motorway { Roadside::beside_motorway(s, verge_m) } else { Roadside::new(s, verge_m) };
        let s = &mut key.stream("land/parcels");
        let whole = vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        let mut outlines = Vec::new();
        split(whole, if is_motorway { MOTORWAY_PARCEL_M2 } else { PARCEL_M2 }, s, &mut outlines);
        let near: Vec<DVec2> =
            network.driving().flat_map(|l| l.center.iter().step_by(5).map(|p| p.truncate())).collect();
        let parcels = outlines
            .into_iter()
            .map(|outline| {
                let middle = outline.iter().sum::<DVec2>() / outline.len() as f64;
                let is_far = near.iter().all(|p| (*p - middle).length() > FAR_M);
                let mut crop = || {
                    let (drawn, is_wood) = (Crop::VARIANTS[s.weighted(&SHARES)], s.chance(FAR_WOODS_SHARE));
                    if is_far && is_wood { Crop::Wood } else { drawn }
                };
                Parcel { crops: std::array::from_fn(|_| crop()), outline }
            })
            .collect();
        Some(Self { roadside, parcels })
    }
}

fn area_m2(outline: &[DVec2]) -> f64 {
    edges(outline).map(|[a, b]| a.perp_dot(b)).sum::<f64>() / 2.0
}

/// Cuts a convex outline across its longest edge until the pieces are small enough.
fn split(outline: Vec<DVec2>, parcel_m2: (f64, f64), s: &mut Stream, out: &mut Vec<Vec<DVec2>>) {
    let enough_m2 = s.within(parcel_m2);
    let (at, skew) = (s.within(CUT_AT), s.range(-CUT_SKEW, CUT_SKEW));
    if area_m2(&outline) <= enough_m2 {
        out.push(outline);
        return;
    }
    let edge = |i: usize| outline[(i + 1) % outline.len()] - outline[i];
    let longest =
        (0..outline.len()).max_by(|i, j| edge(*i).length_squared().total_cmp(&edge(*j).length_squared())).unwrap_or(0);
    let along = edge(longest).normalize_or(DVec2::X);
    let normal = unit(skew).rotate(along);
    let reach = outline
        .iter()
        .map(|p| p.dot(normal))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
    let cut = math::lerp(reach.0, reach.1, at);
    for side in [1.0, -1.0] {
        let piece = half_of(&outline, normal * side, cut * side);
        if piece.len() >= 3 {
            split(piece, parcel_m2, s, out);
        }
    }
}

/// What of a convex outline lies at most `limit` along `normal`.
fn half_of(outline: &[DVec2], normal: DVec2, limit: f64) -> Vec<DVec2> {
    let mut out = Vec::with_capacity(outline.len() + 2);
    for [a, b] in edges(outline) {
        let (da, db) = (a.dot(normal) - limit, b.dot(normal) - limit);
        if da <= 0.0 {
            out.push(a);
        }
        if (da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0) {
            out.push(a.lerp(b, da / (da - db)));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parcels_fill_the_land_and_are_of_a_fields_size() {
        for seed in 0..10 {
            let whole = [(-300.0, -200.0), (420.0, -200.0), (420.0, 310.0), (-300.0, 310.0)].map(DVec2::from).to_vec();
            let mut parcels = Vec::new();
            split(whole, PARCEL_M2, &mut Stream::from_seed("parcels", seed), &mut parcels);
            let sum: f64 = parcels.iter().map(|p| area_m2(p)).sum();
            assert!((sum - 720.0 * 510.0).abs() < 1.0, "seed {seed}: {sum}");
            assert!(parcels.iter().all(|p| area_m2(p) > 1000.0 && area_m2(p) <= PARCEL_M2.1), "seed {seed}");
            assert!(parcels.len() > 20, "seed {seed}: {}", parcels.len());
        }
    }
}
