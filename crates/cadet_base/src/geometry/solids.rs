//! Solids that models are made of, all closed and turned outwards.

use super::mesh_builder::MeshBuilder;
use crate::math::{Vec3, cosf, powf, sinf};

/// The angle of one of so many corners about an axis; `shift` is a share of the angle between two.
fn turn_rad(corner: usize, sides: usize, shift: f32) -> f32 {
    std::f32::consts::TAU * (corner as f32 + shift) / sides as f32
}

/// A level ring about (0, 0, z), counter-clockwise seen from above: half extents along x and y; an ellipse at `power` 2, a
/// rectangle at infinity.
#[must_use]
pub fn level_ring([half_x, half_y]: [f32; 2], z: f32, sides: usize, power: f32) -> Vec<Vec3> {
    let bent = |c: f32| powf(c.abs(), 2.0 / power) * c.signum();
    let corners = (0..sides).map(|i| turn_rad(i, sides, 0.5));
    corners.map(|a| Vec3::new(half_x * bent(cosf(a)), half_y * bent(sinf(a)), z)).collect()
}

impl MeshBuilder {
    /// Adds a sheet of rows of points: its front is where the way from row to row, then the way along a row, turn
    /// counter-clockwise, unless it `is_flipped`. `slot` names the material of the cell behind row i, column j, or leaves
    /// it open.
    pub fn sheet(&mut self, rows: &[impl AsRef<[Vec3]>], is_flipped: bool, slot: impl Fn(usize, usize) -> Option<u8>) {
        let rows: Vec<&[Vec3]> = rows.iter().map(AsRef::as_ref).collect();
        let index: Vec<Vec<u32>> = rows.iter().map(|row| row.iter().map(|p| self.vertex(*p)).collect()).collect();
        for i in 1..rows.len() {
            for j in 1..rows[i].len().min(rows[i - 1].len()) {
                let Some(s) = slot(i - 1, j - 1) else { continue };
                let [a, b, c, d] = [index[i - 1][j - 1], index[i][j - 1], index[i][j], index[i - 1][j]];
                // The shorter diagonal bends less.
                let short = rows[i - 1][j - 1].distance_squared(rows[i][j])
                    <= rows[i][j - 1].distance_squared(rows[i - 1][j]) * 1.0001;
                let halves = if short { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                for [p, q, r] in halves {
                    self.face(if is_flipped { [p, r, q] } else { [p, q, r] }, s);
                }
            }
        }
    }

    /// Adds a box given by its middle and its edge lengths.
    pub fn block(&mut self, middle: Vec3, size: Vec3, slot: u8) {
        self.cuboid(middle - size * 0.5, middle + size * 0.5, slot);
    }

    /// Adds a tube through (center, radius) stations, capped at both ends; nothing without a station.
    pub fn tube(&mut self, stations: &[(Vec3, f32)], sides: usize, slot: u8) {
        let (Some(first), Some(last)) = (stations.first(), stations.last()) else { return };
        let axis = (last.0 - first.0).normalize_or(Vec3::Z);
        let side = if axis.z.abs() < 0.9 { Vec3::Z } else { Vec3::X };
        let e1 = side.cross(axis).normalize();
        let e2 = axis.cross(e1);
        let around = |a: f32| e1 * cosf(a) + e2 * sinf(a);
        let ring = |(center, radius): &(Vec3, f32)| -> Vec<Vec3> {
            (0..sides).map(|i| *center + around(turn_rad(i, sides, 0.5)) * *radius).collect()
        };
        self.loft(&stations.iter().map(ring).collect::<Vec<_>>(), slot, true);
    }

    /// Adds an outline extruded along an axis (0 is x) from `span.0` to `span.1`. Outlines are pairs of y and z along x, of
    /// x and z along y, of x and y along z, and run counter-clockwise with the first number to the right, the second up.
    pub fn prism(&mut self, axis: usize, outline: &[(f32, f32)], span: (f32, f32), slot: u8) {
        let ring = |at: f32| -> Vec<Vec3> {
            let corner = |(a, b): &(f32, f32)| match axis {
                0 => Vec3::new(at, *a, *b),
                1 => Vec3::new(*a, at, *b),
                _ => Vec3::new(*a, *b, at),
            };
            outline.iter().map(corner).collect()
        };
        // The plane of x and z is seen against y.
        let (first, last) = if axis == 1 { (span.1, span.0) } else { span };
        self.loft(&[ring(first), ring(last)], slot, true);
    }

    /// Adds a flat face whose corners run counter-clockwise: a fan about the first.
    pub fn polygon(&mut self, corners: &[Vec3], slot: u8) {
        for pair in corners.windows(2).skip(1) {
            self.triangle(corners[0], pair[0], pair[1], slot);
        }
    }

    /// Adds a disc (a regular polygon of `sides` corners) that faces +x.
    pub fn disc(&mut self, middle: Vec3, radius_m: f32, sides: usize, from_rad: f32, slot: u8) {
        let corner = |i: usize| from_rad + turn_rad(i, sides, 0.0);
        let corners: Vec<Vec3> =
            (0..sides).map(corner).map(|a| middle + Vec3::new(0.0, cosf(a), sinf(a)) * radius_m).collect();
        self.polygon(&corners, slot);
    }

    /// Adds a torus about the origin in the plane of x and z, of `around` pieces with `sides` faces each.
    pub fn hoop(&mut self, radius_m: f32, half_thickness_m: f32, (around, sides): (usize, usize), slot: u8) {
        let ring = |k: usize| -> Vec<Vec3> {
            let a = turn_rad(k % around, around, 0.0);
            let out = Vec3::new(cosf(a), 0.0, sinf(a));
            let corner =
                |t: f32| out * (radius_m + half_thickness_m * cosf(t)) + Vec3::Y * (half_thickness_m * sinf(t));
            (0..sides).map(|i| corner(turn_rad(i, sides, 0.0))).collect()
        };
        self.loft(&(0..=around).map(ring).collect::<Vec<_>>(), slot, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// The volume of a closed solid, and whether each of its edges is passed once each way.
    fn measured(draw: impl Fn(&mut MeshBuilder)) -> (f32, bool) {
        let mut b = MeshBuilder::new();
        draw(&mut b);
        let mesh = b.indexed(0.5);
        let place = |i: u32| mesh.vertices[i as usize].to_array().map(|c| (c * 1e4).round() as i32);
        let mut passed = std::collections::BTreeMap::new();
        let mut volume = 0.0;
        for face in &mesh.faces {
            let [a, b, c] = face.map(|i| mesh.vertices[i as usize]);
            volume += a.dot(b.cross(c)) / 6.0;
            for k in 0..3 {
                let (p, q) = (place(face[k]), place(face[(k + 1) % 3]));
                *passed.entry((p.min(q), p.max(q))).or_insert(0) += if p < q { 1 } else { -1 };
            }
        }
        (volume, passed.values().all(|n| *n == 0))
    }

    #[test]
    fn solids_are_closed_and_enclose_what_their_formulas_say() {
        let triangle = [(0.0, 0.0), (2.0, 0.0), (0.0, 1.0)];
        let pipe = [(Vec3::ZERO, 0.5), (Vec3::new(0.0, 3.0, 0.0), 0.5)];
        let cone = [level_ring([1.0, 2.0], 0.0, 96, 2.0), level_ring([0.5, 1.0], 3.0, 96, 2.0)];
        let square = [0.0, 2.0].map(|z| level_ring([1.0, 2.0], z, 4, f32::INFINITY));
        let (nine, frustum) = (96.0 * sinf(PI / 48.0) / 2.0, 3.0 / 3.0 * (2.0 + 0.5 + 1.0) * PI);
        for (name, expected, found) in [
            ("block", 6.0, measured(|b| b.block(Vec3::new(5.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 3.0), 0))),
            ("prism x", 3.0, measured(|b| b.prism(0, &triangle, (1.0, 4.0), 0))),
            ("prism y", 3.0, measured(|b| b.prism(1, &triangle, (1.0, 4.0), 0))),
            ("prism z", 3.0, measured(|b| b.prism(2, &triangle, (1.0, 4.0), 0))),
            ("tube", 0.25 * nine * 3.0, measured(|b| b.tube(&pipe, 96, 0))),
            ("cone", frustum * nine / PI, measured(|b| b.loft(&cone, 0, true))),
            ("rectangles", 16.0, measured(|b| b.loft(&square, 0, true))),
            ("hoop", 2.0 * PI * PI * 0.04, measured(|b| b.hoop(1.0, 0.2, (64, 64), 0))),
        ] {
            assert!((found.0 / expected - 1.0).abs() < 0.01 && found.1, "{name}: {found:?}, expected {expected}");
        }
    }

    #[test]
    fn a_disc_faces_x() {
        let mut b = MeshBuilder::new();
        b.disc(Vec3::Z, 2.0, 6, 0.3, 0);
        let mesh = b.build("disc", 0.5);
        assert!(mesh.num_faces() == 4 && mesh.normals().all(|n| n.x > 0.999));
    }
}
