//! Shadow maps: the scene's triangles seen from the sun, fine near the camera and coarser beyond.

use crate::math::{DVec3, Vec3};
use crate::sense::PosedScene;

/// Texels along a side of each map.
const SIZE: usize = 1536;
/// (distance ahead of the camera of the middle, half the side), metres: near, far.
const CASCADES: [(f64, f64); 2] = [(15.0, 20.0), (58.0, 68.0)];

/// One orthographic map: for each texel the coordinate towards the sun of the first surface that its light meets.
#[derive(Debug, Clone)]
struct Map {
    /// Light coordinates of the texel corner (0, 0).
    min: [f32; 2],
    texel_m: f32,
    texels_per_m: f32,
    height: Vec<f32>,
}

/// The sun's view of a scene around a camera.
#[derive(Debug, Clone)]
pub struct Shadows {
    right: Vec3,
    up: Vec3,
    sun: Vec3,
    maps: Vec<Map>,
}

impl Shadows {
    /// Rasterises the casters. `sun_world` is the unit vector to the sun, `forward_world` the camera's axis.
    ///
    /// `buffers` are the maps of an earlier frame ([`Shadows::into_buffers`]), whose memory is used again.
    #[must_use]
    pub fn new(
        scene: &PosedScene,
        eye_world: DVec3,
        forward_world: DVec3,
        sun_world: Vec3,
        mut buffers: Vec<Vec<f32>>,
    ) -> Self {
        let helper = if sun_world.z.abs() < 0.95 { Vec3::Z } else { Vec3::X };
        let right = helper.cross(sun_world).normalize();
        let up = sun_world.cross(right);
        let mut shadows = Self { right, up, sun: sun_world, maps: Vec::new() };
        let flat = DVec3::new(forward_world.x, forward_world.y, 0.0).normalize_or_zero();
        for (ahead, half) in CASCADES {
            let middle = shadows.to_light((eye_world + flat * ahead - DVec3::Z * 1.6).as_vec3());
            let texel_m = (2.0 * half / SIZE as f64) as f32;
            // Whole texels, so that shadow edges do not crawl when the camera moves.
            let snap = |c: f32| ((c - half as f32) / texel_m).floor() * texel_m;
            let mut height = buffers.pop().unwrap_or_default();
            height.clear();
            height.resize(SIZE * SIZE, f32::NEG_INFINITY);
            shadows.maps.push(Map {
                min: [snap(middle.x), snap(middle.y)],
                texel_m,
                texels_per_m: 1.0 / texel_m,
                height,
            });
        }
        shadows.draw(scene);
        shadows
    }

    /// The maps' memory.
    #[must_use]
    pub fn into_buffers(self) -> Vec<Vec<f32>> {
        self.maps.into_iter().map(|m| m.height).collect()
    }

    #[inline]
    fn to_light(&self, p: Vec3) -> Vec3 {
        Vec3::new(self.right.dot(p), self.up.dot(p), self.sun.dot(p))
    }

    fn draw(&mut self, scene: &PosedScene) {
        let mut maps = std::mem::take(&mut self.maps);
        let mut points: Vec<Vec3> = Vec::new();
        for instance in &scene.instances {
            let center = self.to_light(instance.center_world.as_vec3());
            let radius = instance.radius_m as f32;
            let in_map: Vec<bool> = maps.iter().map(|m| m.touches(center, radius)).collect();
            if !in_map.contains(&true) {
                continue;
            }
            points.clear();
            points.extend(scene.vertices_world[instance.vertices.clone()].iter().map(|p| self.to_light(*p)));
            let glass: Vec<bool> = instance.palette.0.iter().map(|m| m.is_glass()).collect();
            let ground: Vec<bool> = instance.palette.0.iter().map(|m| m.semantic.is_ground()).collect();
            let vertices = &scene.vertices_world[instance.vertices.clone()];
            let is_level = |face: &[u32; 3]| {
                let [a, b, c] = face.map(|i| vertices[i as usize]);
                let normal = (b - a).cross(c - a);
                normal.z * normal.z > 0.9 * normal.length_squared()
            };
            for (map, _) in maps.iter_mut().zip(&in_map).filter(|(_, inside)| **inside) {
                for (face, slot) in instance.mesh.faces.iter().zip(&instance.mesh.slots) {
                    // Level ground fills the maps and shades nothing; kerbs and banks stay.
                    let slot = usize::from(*slot);
                    if !(glass[slot] || ground[slot] && is_level(face)) {
                        map.triangle(face.map(|i| points[i as usize]));
                    }
                }
            }
        }
        self.maps = maps;
    }

    /// Share of the sun that reaches a point, 0..1: `normal` is the unit geometric normal towards the viewer's side,
    /// `cos_sun` its cosine to the sun.
    #[inline]
    #[must_use]
    pub fn sunlit(&self, point_world: Vec3, normal: Vec3, cos_sun: f32) -> f32 {
        for (index, map) in self.maps.iter().enumerate() {
            // Normal offset: moves grazing surfaces off their own texels, where a depth bias alone leaks.
            let offset = map.texel_m * (0.6 + 1.6 * (1.0 - cos_sun.abs())) + 0.006;
            let p = self.to_light(point_world + normal * (offset * if cos_sun < 0.0 { -1.0 } else { 1.0 }));
            let x = (p.x - map.min[0]) * map.texels_per_m;
            let y = (p.y - map.min[1]) * map.texels_per_m;
            let margin = 8.0;
            let inside = margin..SIZE as f32 - margin;
            if inside.contains(&x) && inside.contains(&y) {
                return map.sunlit(x, y, p.z, if index == 0 { 1.0 } else { 0.9 });
            }
        }
        1.0
    }
}

/// Offsets in texels of the taps, the four widest first.
const TAPS: [(f32, f32); 12] = [
    (-1.5, -0.5),
    (0.5, -1.5),
    (1.5, 0.5),
    (-0.5, 1.5),
    (-0.4, -0.6),
    (0.6, -0.4),
    (0.4, 0.6),
    (-0.6, 0.4),
    (-1.1, 0.9),
    (0.9, 1.1),
    (1.1, -0.9),
    (-0.9, -1.1),
];

impl Map {
    fn touches(&self, center: Vec3, radius: f32) -> bool {
        let side = SIZE as f32 * self.texel_m;
        let hit = |c: f32, min: f32| c + radius > min && c - radius < min + side;
        hit(center.x, self.min[0]) && hit(center.y, self.min[1])
    }

    #[inline]
    fn lit_at(&self, x: f32, y: f32, z: f32) -> f32 {
        let blocker = self.height[y as usize * SIZE + x as usize];
        f32::from(u8::from(blocker <= z))
    }

    #[inline]
    fn sunlit(&self, x: f32, y: f32, z: f32, spread: f32) -> f32 {
        let z = z + self.texel_m * 0.8;
        let tap = |(dx, dy): (f32, f32), wide: f32| self.lit_at(x + dx * wide, y + dy * wide, z);
        let first = tap(TAPS[0], spread) + tap(TAPS[1], spread) + tap(TAPS[2], spread) + tap(TAPS[3], spread);
        if first == 0.0 || first == 4.0 {
            return first * 0.25;
        }
        let rest: f32 = TAPS[4..].iter().map(|t| tap(*t, spread)).sum();
        (first + rest) * (1.0 / 12.0)
    }

    #[inline]
    fn triangle(&mut self, corners: [Vec3; 3]) {
        let to_texels =
            |p: Vec3| Vec3::new((p.x - self.min[0]) * self.texels_per_m, (p.y - self.min[1]) * self.texels_per_m, p.z);
        let [a, b, c] = corners.map(to_texels);
        let (min_x, max_x) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
        let (min_y, max_y) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let size = SIZE as f32;
        if max_x < 0.5 || max_y < 0.5 || min_x >= size - 0.5 || min_y >= size - 0.5 {
            return;
        }
        // Texel centres lie at +0.5: the first is the one at or after the bound.
        let x0 = (min_x + 0.5).max(0.0) as usize;
        let y0 = (min_y + 0.5).max(0.0) as usize;
        let x1 = ((max_x + 0.5).min(size)) as usize;
        let y1 = ((max_y + 0.5).min(size)) as usize;
        if x0 >= x1 || y0 >= y1 {
            return;
        }
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area.abs() < 1e-9 {
            return;
        }
        let (b, c, area) = if area < 0.0 { (c, b, -area) } else { (b, c, area) };
        let inverse = 1.0 / area;
        // Weights of b and c and the height are linear in x and y.
        let (bx, by) = ((c.y - a.y) * inverse, -(c.x - a.x) * inverse);
        let (cx, cy) = (-(b.y - a.y) * inverse, (b.x - a.x) * inverse);
        let (zb, zc) = (b.z - a.z, c.z - a.z);
        let (zx, zy) = (zb * bx + zc * cx, zb * by + zc * cy);
        if (x1 - x0) * (y1 - y0) <= 12 {
            // Small ones, which are most: three tests a texel cost less than the divisions below.
            for y in y0..y1 {
                let dy = y as f32 + 0.5 - a.y;
                for x in x0..x1 {
                    let dx = x as f32 + 0.5 - a.x;
                    let (wb, wc) = (bx * dx + by * dy, cx * dx + cy * dy);
                    if wb >= 0.0 && wc >= 0.0 && wb + wc <= 1.0 {
                        let texel = &mut self.height[y * SIZE + x];
                        *texel = texel.max(a.z + zx * dx + zy * dy);
                    }
                }
            }
            return;
        }
        for y in y0..y1 {
            let dy = y as f32 + 0.5 - a.y;
            let row = &mut self.height[y * SIZE..(y + 1) * SIZE];
            // Solve the three edges for the span of x: no test inside the loop.
            let (mut lo, mut hi) = (x0 as f32 + 0.5 - a.x, x1 as f32 - 0.5 - a.x);
            let mut clip = |slope: f32, at: f32| {
                // slope * dx + at >= 0
                if slope > 0.0 {
                    lo = lo.max(-at / slope);
                } else if slope < 0.0 {
                    hi = hi.min(-at / slope);
                } else if at < 0.0 {
                    hi = f32::NEG_INFINITY;
                }
            };
            clip(bx, by * dy);
            clip(cx, cy * dy);
            clip(-bx - cx, 1.0 - (by + cy) * dy);
            if lo > hi {
                continue;
            }
            let from = (lo + a.x + 0.5).max(x0 as f32) as usize;
            let to = ((hi + a.x + 0.5).max(0.0) as usize).min(x1);
            let mut z = a.z + zy * dy + zx * (from as f32 + 0.5 - a.x);
            for texel in row.get_mut(from..to).into_iter().flatten() {
                if z > *texel {
                    *texel = z;
                }
                z += zx;
            }
        }
    }
}
