//! Shadow maps by plain loops: heights towards the sun on a grid of texels, in whole steps.

use crate::sense::{PosedInstance, PosedScene};
use cadet_base::geometry::Cluster;
use cadet_base::math::{DVec3, Vec3};

const SIZE: usize = 1536;
/// Texels at a map's rim that it does not answer for.
const MARGIN: f64 = 8.0;

/// An orthographic map that the sun sees.
pub struct ShadowMap {
    /// Right, up, and towards the sun.
    axes: [DVec3; 3],
    /// Where the map's first texel and the heights begin on them.
    origin: DVec3,
    /// Texels and steps of height in a meter.
    per_m: DVec3,
    /// Steps.
    height: Vec<f64>,
}

impl ShadowMap {
    /// A map of 40 m about 15 m ahead, and one of 136 m about 58 m ahead with every second leaf.
    pub fn both(scene: &PosedScene, eye: DVec3, forward: DVec3, sun: Vec3) -> Vec<Self> {
        let sun = sun.as_dvec3();
        let right = DVec3::Z.cross(sun).normalize();
        let axes = [right, sun.cross(right), sun];
        let flat = DVec3::new(forward.x, forward.y, 0.0).normalize_or_zero();
        let map = |(ahead, half, steps_per_m, leaf_step): (f64, f64, f64, usize)| {
            let middle = eye + flat * ahead - DVec3::Z * 1.6;
            let [x, y, z] = axes.map(|axis| axis.dot(middle));
            let texel_m = 2.0 * half / SIZE as f64;
            let [x, y] = [x, y].map(|c| ((c - half) / texel_m).floor() * texel_m);
            let per_m = DVec3::new(1.0 / texel_m, 1.0 / texel_m, steps_per_m);
            let height = vec![f64::NEG_INFINITY; SIZE * SIZE];
            let mut map = Self { axes, origin: DVec3::new(x, y, z), per_m, height };
            for instance in &scene.instances {
                for group in instance.shadow_proxy.clusters.iter() {
                    map.draw_group(instance, &group, leaf_step);
                }
            }
            map
        };
        [(15.0, 20.0, 256.0, 1), (58.0, 68.0, 128.0, 2)].map(map).into()
    }

    /// Draws the faces of a group; of leaves alone one in `leaf_step`, enlarged so that they cover as much.
    fn draw_group(&mut self, instance: &PosedInstance, group: &Cluster<'_>, leaf_step: usize) {
        let slot_of = |first: u8| group.faces[usize::from(first)].slot;
        let is_leaf = |slot: u8| instance.palette.leaf_slots() >> slot & 1 == 1;
        let step = if group.pieces.iter().all(|p| is_leaf(slot_of(p.first))) { leaf_step } else { 1 };
        let scale = (group.pieces.len() as f64 / group.pieces.len().div_ceil(step) as f64).sqrt();
        for piece in group.pieces.iter().step_by(step) {
            let material = &instance.palette.materials()[usize::from(slot_of(piece.first))];
            let corners = piece.corners.map(|i| instance.placement.pose(group.place(i)).as_dvec3());
            let [a, b, c, _] = corners;
            let normal = (b - a).cross(c - a);
            // Level ground shades nothing; kerbs and banks do.
            let is_level = normal.z * normal.z > 0.9 * normal.length_squared();
            if material.is_transparent() || material.semantic.is_ground() && is_level {
                continue;
            }
            let middle = corners.iter().sum::<DVec3>() * 0.25;
            let [a, b, c, d] = corners.map(|p| self.on_map(middle + (p - middle) * scale));
            self.draw([a, b, c]);
            self.draw([a, c, d]);
        }
    }

    /// Columns, rows, and steps towards the sun.
    fn on_map(&self, world: DVec3) -> DVec3 {
        (DVec3::from(self.axes.map(|axis| axis.dot(world))) - self.origin) * self.per_m
    }

    /// Raises the texels whose middles lie in a triangle.
    fn draw(&mut self, [a, b, c]: [DVec3; 3]) {
        let cross = |u: DVec3, v: DVec3| u.x * v.y - u.y * v.x;
        let area = cross(b - a, c - a);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let texels = |from: f64, to: f64| {
            from.round().clamp(0.0, SIZE as f64) as usize..to.round().clamp(0.0, SIZE as f64) as usize
        };
        for row in texels(low.y, high.y) {
            for column in texels(low.x, high.x) {
                let p = DVec3::new(column as f64 + 0.5, row as f64 + 0.5, 0.0);
                let weights = [cross(b - p, c - p), cross(c - p, a - p), cross(a - p, b - p)].map(|w| w / area);
                if weights.iter().all(|w| *w >= 0.0) {
                    let texel = &mut self.height[row * SIZE + column];
                    *texel = texel.max((weights[0] * a.z + weights[1] * b.z + weights[2] * c.z).round());
                }
            }
        }
    }

    /// The share of three by three texels about a point that lie no higher than it, and how much that counts: less over the
    /// last 80 texels of the map. Level ground shades nothing: there is no need to move it or to lower what may shade it.
    pub fn lit(&self, world: Vec3, normal: Vec3, cos_sun: f32, is_ground: bool) -> [f32; 2] {
        let is_level = is_ground && normal.z * normal.z > 0.9;
        // Moved along the normal, the further the flatter light falls, so that surfaces do not shade themselves.
        let texel_m = 1.0 / self.per_m.x;
        let offset = if is_level { 0.0 } else { texel_m as f32 * (0.8 + 2.2 * (1.0 - cos_sun.abs())) + 0.006 };
        let p = self.on_map((world + normal * offset.copysign(cos_sun)).as_dvec3());
        let z = (p.z + if is_level { 0.006 } else { 0.8 * texel_m } * self.per_m.z).round();
        let inside = p.x.min(p.y).min(SIZE as f64 - p.x.max(p.y)) - MARGIN;
        if inside <= 0.0 {
            return [0.0; 2];
        }
        let overlap = |texel: usize, c: f64| ((texel + 1) as f64).min(c + 1.5) - (texel as f64).max(c - 1.5);
        let reach = |c: f64| (c - 1.5).floor() as usize..(c + 1.5).ceil() as usize;
        // Steps that ground rises from texel to texel.
        let slope = |axis: DVec3| {
            let cos_sun = f64::from(cos_sun).max(0.03);
            if is_level { (-axis.dot(normal.as_dvec3()) / cos_sun) * texel_m * self.per_m.z } else { 0.0 }
        };
        let slopes = [slope(self.axes[0]), slope(self.axes[1])];
        let mut area = 0.0;
        for row in reach(p.y) {
            for column in reach(p.x) {
                let rise = slopes[0] * (column as f64 + 0.5 - p.x) + slopes[1] * (row as f64 + 0.5 - p.y);
                if self.height[row * SIZE + column] <= z + rise.max(0.0) {
                    area += overlap(column, p.x) * overlap(row, p.y);
                }
            }
        }
        [(area / 9.0) as f32, (inside / 80.0).min(1.0) as f32]
    }
}
