//! How much of the sky a point sees: the horizon of a height map, asked where a point needs it.

use crate::camera::View;
use crate::camera::contact_occlusion::Occluder;
use crate::math::{DVec3, Vec3};
use crate::sense::{PosedInstance, PosedScene};

/// Cells of 1 m along a side.
const CELLS: usize = 144;
/// Heights at which the horizon is looked for, over the lowest surface of a cell.
const LEVELS_M: [f32; 4] = [0.3, 1.6, 4.0, 9.0];
/// Where what stands in the way is looked for, cells.
const STEPS: [f32; 7] = [1.2, 2.2, 3.5, 5.5, 9.0, 15.0, 26.0];

/// Towards +x, -x, +y, -y, +z, -z.
pub type Open = [f32; 6];

pub struct Ambient {
    min: [f32; 2],
    lowest: Vec<f32>,
    highest: Vec<f32>,
    occluders: Vec<Occluder>,
}

impl Ambient {
    pub fn new(scene: &PosedScene, view: &View) -> Self {
        let eye = view.world_from_cam.translation;
        let forward = view.world_from_cam.rotation * DVec3::Z;
        let middle = eye + DVec3::new(forward.x, forward.y, 0.0).normalize_or_zero() * 50.0;
        let min = [middle.x, middle.y].map(|c| (c - 72.0).floor() as f32);
        let (lowest, highest) = (vec![f32::INFINITY; CELLS * CELLS], vec![f32::NEG_INFINITY; CELLS * CELLS]);
        let occluders = scene.instances.iter().filter_map(Occluder::of).collect();
        let mut out = Self { min, lowest, highest, occluders };
        for instance in &scene.instances {
            out.mark_instance(instance);
        }
        let ground = (eye.z - 1.65) as f32;
        for (low, high) in out.lowest.iter_mut().zip(&mut out.highest).filter(|(low, _)| low.is_infinite()) {
            (*low, *high) = (ground, ground);
        }
        out
    }

    fn mark(&mut self, [x, y]: [f32; 2], low: f32, high: f32) {
        let (x, y) = (x - self.min[0], y - self.min[1]);
        if (0.0..CELLS as f32).contains(&x) && (0.0..CELLS as f32).contains(&y) {
            let cell = y as usize * CELLS + x as usize;
            self.lowest[cell] = self.lowest[cell].min(low);
            self.highest[cell] = self.highest[cell].max(high);
        }
    }

    /// Marks an instance's groups of faces: small ones and leaves as what they are about, others by their columns.
    fn mark_instance(&mut self, instance: &PosedInstance) {
        let foot_z = instance.center_world.as_vec3().z - 0.5 * instance.mesh.bounds.size().z;
        let is_plant = instance.palette.has_vegetation();
        // Crowns let light through, as if they were lower.
        let top = |z: f32| if is_plant { foot_z + (z - foot_z) * 0.6 } else { z };
        for (number, group) in instance.mesh.clusters.iter().enumerate() {
            let (c, r) = (instance.placement.pose(group.center), group.radius_m);
            if r < 0.6 {
                self.mark([c.x, c.y], c.z - 0.5 * r, top(c.z + 0.5 * r));
            } else if is_plant && r < 1.5 {
                let cells = |c: f32| (c - 0.5 * r).floor() as i32..=(c + 0.5 * r).floor() as i32;
                for (x, y) in cells(c.x)
                    .flat_map(|x| cells(c.y).map(move |y| [x as f32 + 0.5, y as f32 + 0.5]).map(|[x, y]| (x, y)))
                {
                    self.mark([x, y], c.z - 0.5 * r, top(c.z + 0.5 * r));
                }
            } else {
                for column in instance.mesh.columns_of(number) {
                    let half = 0.5 * (column.high - column.low);
                    let p = instance.placement.pose(Vec3::new(column.x, column.y, column.low + half));
                    self.mark([p.x, p.y], p.z - half, top(p.z + half));
                }
            }
        }
    }

    /// The highest surface of a cell that may lie beyond the map.
    fn top_of(&self, x: i32, y: i32) -> Option<f32> {
        let is_inside = |c: i32| (0..CELLS as i32).contains(&c);
        (is_inside(x) && is_inside(y)).then(|| self.highest[y as usize * CELLS + x as usize])
    }

    /// What is seen of the sky from a height over a cell.
    fn open_above(&self, x: i32, y: i32, over: f32) -> Open {
        let z = self.lowest[y as usize * CELLS + x as usize] + over;
        let free: [f32; 8] = std::array::from_fn(|k| {
            let turn = k as f32 * std::f32::consts::FRAC_PI_4;
            let (dx, dy) = (crate::math::cosf(turn), crate::math::sinf(turn));
            let slope = |s: &f32| {
                let top = self.top_of(x + (dx * s).round() as i32, y + (dy * s).round() as i32);
                top.map_or(0.0, |top| (top - z) / s)
            };
            let horizon = STEPS.iter().map(slope).fold(0.0, f32::max);
            // The squared cosine of its elevation.
            1.0 / (1.0 + horizon * horizon)
        });
        let covered = |dx: i32, dy: i32| {
            let near = |c: i32| c.clamp(0, CELLS as i32 - 1);
            let top = self.top_of(near(x + dx), near(y + dy)).unwrap_or(z);
            ((top - z - 0.8) * 0.7).clamp(0.0, 1.0)
        };
        let beside = covered(1, 0) + covered(-1, 0) + covered(0, 1) + covered(0, -1);
        let cover = 1.0 - 0.45 * (0.4 * covered(0, 0) + 0.15 * beside);
        let zenith = free.iter().sum::<f32>() / 8.0;
        let side = |k: usize| (free[k] + 0.7 * (free[(k + 7) % 8] + free[(k + 1) % 8])) / 2.4 * (0.5 + 0.5 * cover);
        [side(0), side(4), side(2), side(6), zenith * cover, (0.4 + 0.6 * zenith) * cover]
    }

    /// What a point sees of the sky: between four cells, and between two heights over each.
    pub fn open(&self, world: Vec3, normal: Vec3) -> Open {
        // Off the surface, else a wall would sit in its own house.
        let p = world + normal * 1.7;
        let (gx, gy) = (p.x - self.min[0] - 0.5, p.y - self.min[1] - 0.5);
        let limit = CELLS as f32 - 1.001;
        if !(0.0..limit).contains(&gx) || !(0.0..limit).contains(&gy) {
            return [0.85; 6];
        }
        let mut sum = [0.0; 6];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (x, y) = (gx as i32 + dx, gy as i32 + dy);
            let weight = (1.0 - (gx - x as f32).abs()) * (1.0 - (gy - y as f32).abs());
            let over = world.z - self.lowest[y as usize * CELLS + x as usize];
            let below = LEVELS_M.iter().rposition(|l| over >= *l).unwrap_or(0);
            let above = (below + 1).min(LEVELS_M.len() - 1);
            let rise = (LEVELS_M[above] - LEVELS_M[below]).max(1e-6);
            let t = ((over - LEVELS_M[below]) / rise).clamp(0.0, 1.0);
            let [a, b] = [below, above].map(|level| self.open_above(x, y, LEVELS_M[level]));
            for k in 0..6 {
                sum[k] += weight * (a[k] + (b[k] - a[k]) * t);
            }
        }
        sum
    }

    /// What vehicles and people near by leave of the sky's light to the ground.
    pub fn contact(&self, world: Vec3) -> f32 {
        let (x, y) = (world.x - self.min[0], world.y - self.min[1]);
        let is_inside = (0.0..CELLS as f32).contains(&x) && (0.0..CELLS as f32).contains(&y);
        let left = |b: &Occluder| b.leaves(world - b.center);
        if is_inside { self.occluders.iter().map(left).product() } else { 1.0 }
    }
}
