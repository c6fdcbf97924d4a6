//! The ground plan of a house in a closed row: a convex outline whose sides face streets, the court, or neighbors.

use cadet_base::geometry::MeshBuilder;
use cadet_base::math::{Vec2, Vec3};

use super::super::materials::house_slot as slot;
use super::super::wall_plane::WallPlane;
use super::kind::CityKind;

/// What a side of the house faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Face {
    /// A street.
    Street,
    /// The crossing, at the cut corner of a corner house.
    Crossing,
    /// The court behind the house.
    Court,
    /// The next house, if there is one: the roof ends on this wall.
    Neighbor,
}

/// One side, from corner to corner, counter-clockwise seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub from: Vec2,
    pub to: Vec2,
    pub face: Face,
}

impl Side {
    /// Its length.
    pub fn width(&self) -> f32 {
        (self.to - self.from).length()
    }

    /// Its wall.
    pub fn plane(&self) -> WallPlane {
        WallPlane { origin: self.from.extend(0.0), u: (self.to - self.from).normalize().extend(0.0) }
    }
}

/// The sides of a house; x is its depth with the street at +x, y its width. The corner of a corner house is cut by
/// `cut_m` along both streets.
pub(super) fn sides(kind: CityKind, depth_m: f32, width_m: f32, cut_m: f32) -> Vec<Side> {
    let (x, y) = (depth_m / 2.0, width_m / 2.0);
    let at = Vec2::new;
    let outline = match kind {
        CityKind::Row => vec![
            (at(x, -y), Face::Street),
            (at(x, y), Face::Neighbor),
            (at(-x, y), Face::Court),
            (at(-x, -y), Face::Neighbor),
        ],
        CityKind::FirstCorner => vec![
            (at(x, -y), Face::Street),
            (at(x, y - cut_m), Face::Crossing),
            (at(x - cut_m, y), Face::Street),
            (at(-x, y), Face::Neighbor),
            (at(-x, -y), Face::Neighbor),
        ],
        CityKind::LastCorner => vec![
            (at(x, cut_m - y), Face::Street),
            (at(x, y), Face::Neighbor),
            (at(-x, y), Face::Neighbor),
            (at(-x, -y), Face::Street),
            (at(x - cut_m, -y), Face::Crossing),
        ],
    };
    let n = outline.len();
    (0..n).map(|i| Side { from: outline[i].0, to: outline[(i + 1) % n].0, face: outline[i].1 }).collect()
}

/// The corners of the outline moved in by `inset` (out where negative); sides toward neighbors stay where they are.
fn ring(sides: &[Side], inset: f32, z: f32) -> Vec<Vec3> {
    let n = sides.len();
    let line = |side: &Side| {
        let along = (side.to - side.from).normalize();
        let by = if side.face == Face::Neighbor { 0.0 } else { inset };
        (side.from + along.perp() * by, along)
    };
    (0..n)
        .map(|i| {
            let ((p, a), (q, c)) = (line(&sides[(i + n - 1) % n]), line(&sides[i]));
            // Neighboring sides are never parallel.
            let t = (q - p).perp_dot(c) / a.perp_dot(c);
            (p + a * t).extend(z)
        })
        .collect()
}

/// Joins outlines at insets and heights one above the other, each belt in its slot, and closes the last one.
pub(super) fn belts(b: &mut MeshBuilder, sides: &[Side], stations: &[(f32, f32, u8)]) {
    let rings: Vec<Vec<Vec3>> = stations.iter().map(|(inset, z, _)| ring(sides, *inset, *z)).collect();
    for (pair, station) in rings.windows(2).zip(stations) {
        for (i, side) in sides.iter().enumerate() {
            let j = (i + 1) % sides.len();
            let belt = if side.face == Face::Neighbor { slot::WALL } else { station.2 };
            b.quad(pair[0][i], pair[0][j], pair[1][j], pair[1][i], belt);
        }
    }
    if let (Some(top), Some(last)) = (rings.last(), stations.last()) {
        for i in 1..top.len() - 1 {
            b.triangle(top[0], top[i], top[i + 1], last.2);
        }
    }
}
