//! Sheets of quadrilaterals that face the right way, and their mirror images.

use super::paint::slot;
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::{Mat3, Vec3, cosf, sinf};
use std::f32::consts::TAU;

/// Which side of a sheet is its outside.
#[derive(Debug, Clone, Copy)]
pub(super) enum Outward {
    /// Away from a point.
    From(Vec3),
    /// Towards a point: the inside of a hollow.
    Towards(Vec3),
    /// Along a direction.
    Along(Vec3),
}

/// Rows of points.
pub(super) type Grid = Vec<Vec<Vec3>>;

/// A row of points for each value of `rows`, with a point for each value of `columns`.
pub(super) fn grid<R, C>(rows: R, columns: C, place: impl Fn(R::Item, C::Item) -> Vec3) -> Grid
where
    R: IntoIterator<Item: Copy>,
    C: IntoIterator + Clone,
{
    rows.into_iter().map(|r| columns.clone().into_iter().map(|c| place(r, c)).collect()).collect()
}

/// A rectangle across the vehicle's length.
pub(super) fn upright(x: f32, y: [f32; 2], z: [f32; 2]) -> Grid {
    grid(z, y, |z, y| Vec3::new(x, y, z))
}

/// A level rectangle.
pub(super) fn level_sheet(x: [f32; 2], y: [f32; 2], z: f32) -> Grid {
    grid(x, y, |x, y| Vec3::new(x, y, z))
}

/// The rows of the sheet on the other side.
pub(super) fn mirror_image(rows: &[impl AsRef<[Vec3]>]) -> Grid {
    rows.iter().map(|row| row.as_ref().iter().map(|p| mirrored(*p)).collect()).collect()
}

/// The angles of so many corners around a circle.
pub(super) fn turns_rad(count: usize) -> impl Iterator<Item = f32> + Clone {
    (0..count).map(move |k| k as f32 / count as f32 * TAU)
}

/// A mesh in the making, fed with sheets.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub builder: MeshBuilder,
}

/// The point mirrored at the plane y = 0.
pub(super) fn mirrored(p: Vec3) -> Vec3 {
    Vec3::new(p.x, -p.y, p.z)
}

/// The material of the mirror image: turn signals are of one side.
fn mirrored_slot(of_left: u8) -> u8 {
    if of_left == slot::LEFT_SIGNAL { slot::RIGHT_SIGNAL } else { of_left }
}

impl Surface {
    /// Adds a sheet of rows of points; `slot` names the material of the cell behind row i, column j, or leaves it open.
    pub fn sheet(&mut self, grid: &[impl AsRef<[Vec3]>], outward: Outward, slot: impl Fn(usize, usize) -> Option<u8>) {
        self.builder.sheet(grid, is_flipped(&rows(grid), outward), slot);
    }

    /// Adds a sheet of one material.
    pub fn panel(&mut self, grid: &[impl AsRef<[Vec3]>], outward: Outward, slot: u8) {
        self.sheet(grid, outward, |_, _| Some(slot));
    }

    /// Adds a sheet of the left side and its mirror image on the right.
    pub fn pair(&mut self, grid: &[impl AsRef<[Vec3]>], outward: Outward, slot: impl Fn(usize, usize) -> Option<u8>) {
        let left = rows(grid);
        let flipped = is_flipped(&left, outward);
        self.builder.sheet(&left, flipped, &slot);
        self.builder.sheet(&mirror_image(&left), !flipped, |i, j| slot(i, j).map(mirrored_slot));
    }

    /// Adds a sheet of one material on the left side and its mirror image on the right.
    pub fn panel_pair(&mut self, grid: &[impl AsRef<[Vec3]>], outward: Outward, slot: u8) {
        self.pair(grid, outward, |_, _| Some(slot));
    }

    /// Adds a soft-edged block: a superellipse section swept along the local z axis of `axes`, half extents `half`.
    /// Four sides make a plain box.
    pub fn block(&mut self, center: Vec3, half: Vec3, axes: Mat3, sides: usize, slot: u8) {
        let soft = [(-1.0, 0.72), (-0.8, 1.0), (0.8, 1.0), (1.0, 0.72)];
        let plain = [(-1.0, 0.95), (1.0, 0.95)];
        let profile: &[(f32, f32)] = if sides > 4 { &soft } else { &plain };
        let corners = (0..sides).map(|k| soft_square((k as f32 + 0.5) / sides as f32));
        let rings =
            grid(profile, corners, |(z, scale), (x, y)| center + axes * (Vec3::new(x * scale, y * scale, *z) * half));
        self.builder.loft(&rings, slot, true);
    }

    /// Adds a block and its mirror image.
    pub fn block_pair(&mut self, center: Vec3, half: Vec3, axes: Mat3, sides: usize, slot: u8) {
        self.block(center, half, axes, sides, slot);
        let mirror = Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0));
        self.block(mirrored(center), half, mirror * axes * mirror, sides, mirrored_slot(slot));
    }

    /// Adds a plain box from and to along x, y, and z.
    pub fn cuboid(&mut self, [x0, x1]: [f32; 2], [y0, y1]: [f32; 2], [z0, z1]: [f32; 2], slot: u8) {
        self.builder.cuboid(Vec3::new(x0, y0, z0), Vec3::new(x1, y1, z1), slot);
    }

    /// Adds a plain box and its mirror image.
    pub fn cuboid_pair(&mut self, x: [f32; 2], [y0, y1]: [f32; 2], z: [f32; 2], slot: u8) {
        self.cuboid(x, [y0, y1], z, slot);
        self.cuboid(x, [-y1, -y0], z, mirrored_slot(slot));
    }
}

/// A rounded square of half width 1, once around for t in 0..1.
fn soft_square(t: f32) -> (f32, f32) {
    let (c, s) = (cosf(t * TAU), sinf(t * TAU));
    // The exponent 4 superellipse, radially.
    let scale = 1.0 / (c * c * c * c + s * s * s * s).sqrt().sqrt();
    (c * scale, s * scale)
}

fn rows(grid: &[impl AsRef<[Vec3]>]) -> Vec<&[Vec3]> {
    grid.iter().map(AsRef::as_ref).collect()
}

fn is_flipped(grid: &[&[Vec3]], outward: Outward) -> bool {
    let mut sum = 0.0;
    for i in 1..grid.len() {
        for j in 1..grid[i].len().min(grid[i - 1].len()) {
            let [a, b, c, d] = [grid[i - 1][j - 1], grid[i][j - 1], grid[i][j], grid[i - 1][j]];
            let normal = (c - a).cross(d - b);
            sum += match outward {
                Outward::From(p) => normal.dot((a + b + c + d) * 0.25 - p),
                Outward::Towards(p) => normal.dot(p - (a + b + c + d) * 0.25),
                Outward::Along(v) => normal.dot(v),
            };
        }
    }
    sum < 0.0
}
