//! The equidistant fisheye: what a ray shows whose angle to the optical axis is a lies f a from the image's center.
//!
//! No plane holds a view of more than half of all directions, so the image is taken from up to five pinhole images of the
//! sides of a cube about the optical center.

use cadet_base::error::{Error, Result};
use cadet_base::math::{self, DMat3, DQuat, DVec2, DVec3, PI};

use super::maps::Maps;

/// The rim: what lies at a larger angle to the optical axis is black.
pub const MOST_ANGLE_RAD: f64 = 95.0 / 180.0 * PI;
/// Pixels beyond those that are taken: what the point spread and the interpolation reach, and one more.
const MARGIN_PX: f64 = 4.0;
/// The largest side of a pinhole image, pixels.
const MAX_SIDE_PX: f64 = 8192.0;
/// No side of the cube.
const NONE: u8 = u8::MAX;

/// A side of the cube, and the part of it that is taken.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Side {
    pub cam_from_side: DQuat,
    /// fx, fy, cx, cy.
    pub intrinsics_px: [f64; 4],
    pub width: usize,
    pub height: usize,
}

/// Where each pixel of a fisheye's image is taken from.
#[derive(Debug, Clone, PartialEq)]
pub struct Fisheye {
    intrinsics_px: [f64; 4],
    pub(crate) sides: Vec<Side>,
    /// Of each pixel, row-major: the number of its side, and column and row there.
    places: Vec<(u8, [f32; 2])>,
}

/// Right, down, and forward of the sides, in the camera's axes.
const SIDES: [[DVec3; 3]; 5] = [
    [DVec3::X, DVec3::Y, DVec3::Z],
    [DVec3::NEG_Z, DVec3::Y, DVec3::X],
    [DVec3::Z, DVec3::Y, DVec3::NEG_X],
    [DVec3::X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::X, DVec3::Z, DVec3::NEG_Y],
];

impl Fisheye {
    /// A fisheye with an image of `width` x `height` pixels and (fx, fy, cx, cy), focal lengths in pixels a radian.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for focal lengths whose pinhole images have more than 8192 pixels along a side.
    pub fn new(intrinsics_px: [f64; 4], width: usize, height: usize) -> Result<Self> {
        let [fx, fy, cx, cy] = intrinsics_px;
        let focal_px = if fx > fy { fx } else { fy };
        let mut found = Vec::with_capacity(width * height);
        let mut bounds = [[f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY]; SIDES.len()];
        for v in 0..height {
            for u in 0..width {
                let place = direction([(u as f64 - cx) / fx, (v as f64 - cy) / fy]).map(|ray| {
                    let side = (1..SIDES.len())
                        .fold(0, |best, k| if ray.dot(SIDES[k][2]) > ray.dot(SIDES[best][2]) { k } else { best });
                    let [right, down, forward] = SIDES[side].map(|axis| ray.dot(axis));
                    let at = [focal_px * right / forward, focal_px * down / forward];
                    let [u1, v1, u2, v2] = &mut bounds[side];
                    (*u1, *v1) = (u1.min(at[0]), v1.min(at[1]));
                    (*u2, *v2) = (u2.max(at[0]), v2.max(at[1]));
                    (side, at)
                });
                found.push(place);
            }
        }
        let mut sides = Vec::new();
        let mut number_of = [NONE; SIDES.len()];
        let mut first_px = [[0.0; 2]; SIDES.len()];
        for (k, [u1, v1, u2, v2]) in bounds.into_iter().enumerate().filter(|(_, bounds)| bounds[0] <= bounds[2]) {
            let least = [u1, v1].map(|x| x.floor() - MARGIN_PX);
            let size = [u2 - least[0], v2 - least[1]].map(|s| s.ceil() + MARGIN_PX);
            if size.iter().any(|s| *s > MAX_SIDE_PX) {
                let (value, expected) =
                    (focal_px.to_string(), "one that keeps its views within 8192 pixels".to_owned());
                return Err(Error::OutOfRange { what: "focal length of a fisheye", value, expected });
            }
            (number_of[k], first_px[k]) = (sides.len() as u8, least);
            let [right, down, forward] = SIDES[k];
            sides.push(Side {
                cam_from_side: DQuat::from_mat3(&DMat3::from_cols(right, down, forward)),
                intrinsics_px: [focal_px, focal_px, -least[0], -least[1]],
                width: size[0] as usize,
                height: size[1] as usize,
            });
        }
        let place = |(side, at): (usize, [f64; 2])| {
            let [u, v] = first_px[side];
            (number_of[side], [(at[0] - u) as f32, (at[1] - v) as f32])
        };
        let places = found.into_iter().map(|found| found.map_or((NONE, [0.0; 2]), place)).collect();
        Ok(Self { intrinsics_px, sides, places })
    }

    /// Where a ray of the camera's axes meets the image; also beyond the rim.
    #[must_use]
    pub fn pixel_of_ray(&self, ray: DVec3) -> DVec2 {
        let [fx, fy, cx, cy] = self.intrinsics_px;
        let across = math::hypot(ray.x, ray.y);
        let per_length = if across > 0.0 { math::atan2(across, ray.z) / across } else { 0.0 };
        DVec2::new(cx + fx * ray.x * per_length, cy + fy * ray.y * per_length)
    }

    /// [`Fisheye::pixel_of_ray`], of what is inside the rim.
    #[must_use]
    pub fn pixel_within_rim(&self, ray: DVec3) -> Option<DVec2> {
        let angle_rad = math::atan2(math::hypot(ray.x, ray.y), ray.z);
        (angle_rad < MOST_ANGLE_RAD).then(|| self.pixel_of_ray(ray))
    }

    /// Whether each pixel sees anything, row-major.
    pub(crate) fn is_within(&self) -> impl Iterator<Item = bool> {
        self.places.iter().map(|(side, _)| *side != NONE)
    }

    /// Takes colors from the image of a side, interleaved RGB, between its pixels by their distances.
    pub(crate) fn take_colors(&self, side: usize, rgb: &[f32], out: &mut [f32]) {
        let width = self.sides[side].width;
        for (pixel, (_, [u, v])) in
            out.chunks_exact_mut(3).zip(&self.places).filter(|(_, (of, _))| usize::from(*of) == side)
        {
            let (column, row) = (*u as usize, *v as usize);
            let (right, below) = (u - column as f32, v - row as f32);
            let first = (row * width + column) * 3;
            let second = first + width * 3;
            for (k, value) in pixel.iter_mut().enumerate() {
                let mix = |at: usize| rgb[at + k] * (1.0 - right) + rgb[at + 3 + k] * right;
                *value = mix(first) * (1.0 - below) + mix(second) * below;
            }
        }
    }

    /// Takes maps from those of a side, of each pixel the nearest: depth becomes the distance from the optical center, and
    /// vectors are turned into the camera's axes.
    pub(crate) fn take_maps(&self, side: usize, maps: &Maps, out: &mut Maps) {
        let Side { cam_from_side, intrinsics_px: [fx, fy, cx, cy], width, .. } = &self.sides[side];
        let turned = |v: [f32; 3]| {
            let v = *cam_from_side * DVec3::from_array(v.map(f64::from));
            [v.x as f32, v.y as f32, v.z as f32]
        };
        for (pixel, (_, [u, v])) in self.places.iter().enumerate().filter(|(_, (of, _))| usize::from(*of) == side) {
            let (column, row) = ((u + 0.5) as usize, (v + 0.5) as usize);
            let at = row * width + column;
            let (x, y) = ((column as f64 - cx) / fx, (row as f64 - cy) / fy);
            out.depth_m[pixel] = (f64::from(maps.depth_m[at]) * (1.0 + x * x + y * y).sqrt()) as f32;
            (out.instance[pixel], out.semantic[pixel]) = (maps.instance[at], maps.semantic[at]);
            let (from, to) = (&maps.surfaces, &mut out.surfaces);
            if !from.normal_cam.is_empty() {
                to.normal_cam[pixel] = turned(from.normal_cam[at]);
            }
            if !from.velocity_cam_m_per_s.is_empty() {
                to.velocity_cam_m_per_s[pixel] = turned(from.velocity_cam_m_per_s[at]);
            }
            if !from.flow_px.is_empty() {
                to.flow_px[pixel] = from.flow_px[at];
            }
        }
    }
}

/// The unit vector of the ray that lies (x, y) radians from the image's center; `None` beyond the rim.
fn direction([x, y]: [f64; 2]) -> Option<DVec3> {
    let angle_rad = math::hypot(x, y);
    if angle_rad > MOST_ANGLE_RAD {
        return None;
    }
    let per_angle = if angle_rad > 0.0 { math::sin(angle_rad) / angle_rad } else { 1.0 };
    Some(DVec3::new(x * per_angle, y * per_angle, math::cos(angle_rad)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 190 degrees across 400 pixels.
    fn fisheye() -> Fisheye {
        let focal_px = 200.0 / MOST_ANGLE_RAD;
        Fisheye::new([focal_px, focal_px, 199.5, 199.5], 400, 400).expect("a lens")
    }

    #[test]
    fn angles_are_distances_from_the_center() {
        let lens = fisheye();
        for angle_deg in [0.0, 10.0, 60.0, 90.0, 95.0, 120.0] {
            let angle_rad = f64::to_radians(angle_deg);
            for around_rad in [0.0, 1.0, 2.5, -2.0] {
                let (sin, cos) = (math::sin(angle_rad), math::cos(angle_rad));
                let ray = DVec3::new(sin * math::cos(around_rad), sin * math::sin(around_rad), cos) * 7.0;
                let off = lens.pixel_of_ray(ray) - DVec2::splat(199.5);
                assert!((off.length() - 200.0 / 95.0 * angle_deg).abs() < 1e-9, "{angle_deg}");
                assert!(angle_deg == 0.0 || (math::atan2(off.y, off.x) - around_rad).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn each_pixel_is_taken_where_its_ray_meets_a_side_and_none_beyond_the_rim() {
        let lens = fisheye();
        assert_eq!(lens.sides.len(), 5);
        let mut sides_seen = [0; 5];
        for (pixel, (side, [column, row])) in lens.places.iter().enumerate() {
            let (u, v) = ((pixel % 400) as f64, (pixel / 400) as f64);
            let radius = math::hypot(u - 199.5, v - 199.5);
            assert_eq!(*side == NONE, radius > 200.0, "{u} {v}");
            if *side == NONE {
                continue;
            }
            sides_seen[usize::from(*side)] += 1;
            let Side { cam_from_side, intrinsics_px: [f, _, cx, cy], width, height } = &lens.sides[usize::from(*side)];
            let ray = *cam_from_side * DVec3::new((f64::from(*column) - cx) / f, (f64::from(*row) - cy) / f, 1.0);
            assert!((lens.pixel_of_ray(ray) - DVec2::new(u, v)).length() < 1e-3, "{u} {v}");
            assert!(*column >= 3.0 && f64::from(*column) <= *width as f64 - 4.0, "{column} {width}");
            assert!(*row >= 3.0 && f64::from(*row) <= *height as f64 - 4.0);
        }
        assert!(sides_seen.iter().all(|n| *n > 10_000), "{sides_seen:?}");
    }

    #[test]
    fn a_side_too_large_is_refused() {
        let text = Fisheye::new([6000.0, 6000.0, 4000.0, 100.0], 8000, 200).expect_err("too large").to_string();
        assert!(text.contains("fisheye") && text.contains("8192"), "{text}");
    }
}
