//! The sky in the image, row by row.

use macro_rules_attribute::apply;

use crate::camera::light::Light;
use crate::camera::sensor::MIDDLE_PX;
use crate::camera::visibility::ImageRays;
use cadet_base::math::Vec3;

/// The sky in the image, from a coarse lattice: clouds are smooth over so few pixels.
pub struct SkyRows<'a> {
    rays: &'a ImageRays,
    light: &'a Light,
    /// Points of the lattice along a row.
    points: usize,
    /// Rows of the lattice, made when they are first needed.
    lattice: Vec<Vec<Vec3>>,
    /// Rows of the image that come near the horizon: the lattice is too coarse for its edge.
    has_horizon: Vec<bool>,
}

/// Pixels between the lattice's points.
const STEP: usize = 4;
/// Sine of an elevation: what is nearer to the horizon is not interpolated.
const NEAR_HORIZON: f32 = 0.015;
/// Air of a larger extinction is fog (1/m), which hides the sky as if that were so far away (meters).
const FOG_PER_M: f32 = 0.004;
const SKY_IN_FOG_M: f32 = 400.0;

impl<'a> SkyRows<'a> {
    /// No row yet.
    #[must_use]
    pub fn new(width: usize, height: usize, rays: &'a ImageRays, light: &'a Light) -> Self {
        let has_horizon = |row: usize| {
            // Linear in the column.
            let [a, b] = [0.0, width as f32].map(|u| rays.direction(u, row as f32 + MIDDLE_PX).z);
            a.min(b) < NEAR_HORIZON && a.max(b) > -NEAR_HORIZON
        };
        Self {
            rays,
            light,
            points: width / STEP + 2,
            lattice: vec![Vec::new(); height / STEP + 2],
            has_horizon: (0..height).map(has_horizon).collect(),
        }
    }

    /// The color of a pixel.
    #[inline]
    pub fn at(&mut self, column: usize, row: usize) -> [f32; 3] {
        let mut color = [0.0; 3];
        self.fill(column, row, &mut color);
        color
    }

    /// Colors of pixels side by side, interleaved.
    #[inline]
    pub fn fill(&mut self, column: usize, row: usize, colors: &mut [f32]) {
        let above = row / STEP;
        if self.lattice[above].is_empty() || self.lattice[above + 1].is_empty() {
            self.make(above);
        }
        let down = (row % STEP) as f32 / STEP as f32;
        let (a, b) = (&self.lattice[above], &self.lattice[above + 1]);
        for (column, pixel) in (column..).zip(colors.chunks_exact_mut(3)) {
            let (k, across) = (column / STEP, (column % STEP) as f32 / STEP as f32);
            let (from, to) = (a[k] + (b[k] - a[k]) * down, a[k + 1] + (b[k + 1] - a[k + 1]) * down);
            pixel.copy_from_slice(&(from + (to - from) * across).to_array());
        }
        if self.has_horizon[row] {
            let v = row as f32 + MIDDLE_PX;
            for (column, pixel) in (column..).zip(colors.chunks_exact_mut(3)) {
                let u = column as f32 + MIDDLE_PX;
                if self.rays.direction(u, v).z.abs() < NEAR_HORIZON {
                    pixel.copy_from_slice(&exact(self.light, self.rays.direction(u, v)).to_array());
                }
            }
        }
    }

    #[cold]
    fn make(&mut self, above: usize) {
        let mut planes = [const { Vec::new() }; 3];
        planes.iter_mut().for_each(|plane: &mut Vec<f32>| plane.resize(self.points, 0.0));
        for line in [above, above + 1] {
            let first = self.rays.direction(MIDDLE_PX, (line * STEP) as f32 + MIDDLE_PX);
            let [red, green, blue] = &mut planes;
            exact_row(self.light, first, self.rays.right * STEP as f32, [red, green, blue]);
            let [red, green, blue] = &planes;
            self.lattice[line] = red.iter().zip(green).zip(blue).map(|((r, g), b)| Vec3::new(*r, *g, *b)).collect();
        }
    }
}

/// The sky's radiance in a direction in which the camera looks.
#[inline(always)]
fn exact(light: &Light, direction: Vec3) -> Vec3 {
    let view_world = direction * (1.0 / direction.dot(direction).sqrt());
    let radiance = light.sky.visible_radiance(view_world);
    // Fog hides the sky as it hides what is far.
    let fog = light.extinction_per_m > FOG_PER_M;
    if fog { light.through_air(radiance, view_world, SKY_IN_FOG_M) } else { radiance }
}

/// [`exact`] in a row of directions, plane by plane.
#[apply(for_wide_registers)]
fn exact_row(light: &Light, first: Vec3, step: Vec3, [red, green, blue]: [&mut [f32]; 3]) {
    for (i, ((r, g), b)) in red.iter_mut().zip(green).zip(blue).enumerate() {
        let color = exact(light, first + step * (i as i32 as f32));
        (*r, *g, *b) = (color.x, color.y, color.z);
    }
}
