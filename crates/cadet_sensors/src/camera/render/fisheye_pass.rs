//! The image of a fisheye, taken from pinhole images of a cube's sides.

use super::{Foreground, Rendered, Scratch, radiance};
use crate::camera::model::{CameraModel, Fisheye, Maps, Side, SurfaceMaps};
use crate::camera::overlays::{add_halos, spray};
use crate::camera::sensor::{MeteredPixels, ROWS_BEFORE, blur};
use crate::camera::visibility::{Motions, SurfaceMapKinds, View, Visibility};
use crate::sense::PosedScene;
use crate::weather::Weather;
use cadet_base::material::Semantic;
use cadet_base::math::{DPose3, DVec2, DVec3};
use cadet_base::rng::Stream;

/// Renders as [`super::render_through`] does, through a fisheye, with its maps: depth is the distance from the optical center, and
/// what lies beyond the rim is sky in maps and without light in the image.
///
/// `sides` are the views of the camera's [`CameraModel::pinholes`] and what is seen in them, `world_from_cam` is the pose of the
/// camera's frame; `maps` says which are made, and how what is seen moves.
#[must_use]
pub fn render_fisheye(
    scene: &PosedScene,
    (camera, fisheye, sides): (&CameraModel, &Fisheye, Vec<(View, Visibility)>),
    world_from_cam: &DPose3,
    weather: &Weather,
    foreground: &Foreground<'_>,
    maps: Option<(&SurfaceMapKinds, &Motions<'_>)>,
    stream: &mut Stream,
) -> Rendered {
    let (width, height, is_night) = (camera.width, camera.height, weather.is_night());
    let (mut rgb, mut scratch) = (vec![0.0; width * height * 3], Scratch::default());
    let mut found = maps.map(|(kinds, motions)| (kinds, motions, sky(width * height, kinds)));
    let mut ceiling = f32::INFINITY;
    for ((number, side), (view, seen)) in fisheye.sides.iter().enumerate().zip(sides) {
        let light = radiance(scene, &view, weather, &seen, &mut scratch);
        let below = &mut scratch.rgb[ROWS_BEFORE * view.width * 3..];
        spray::draw(&foreground.spray, below, &view, &seen, &light);
        if let Some(precipitation) = &foreground.precipitation {
            precipitation.draw(below, &view, &seen, &light);
        }
        ceiling = light.glare_ceiling();
        let _ = blur(&mut scratch.rgb, view.width, view.height, ceiling);
        scratch.reuse(light);
        fisheye.take_colors(number, &scratch.rgb, &mut rgb);
        if let Some((kinds, motions, out)) = &mut found {
            let surfaces = seen.surface_maps(scene, |ray| pixel_of(fisheye, side, ray), motions, kinds);
            fisheye.take_maps(number, &Maps { surfaces, ..seen.maps(scene) }, out);
        }
    }
    foreground.lens_drops.draw(&mut rgb, &View::new(camera, world_from_cam));
    if is_night {
        add_halos(&mut rgb, width, height);
    }
    let lit: Vec<[f32; 3]> =
        rgb.as_chunks::<3>().0.iter().zip(fisheye.is_within()).filter_map(|(pixel, is)| is.then_some(*pixel)).collect();
    let mut sums = [0.0; 3];
    for pixel in &lit {
        for (sum, value) in sums.iter_mut().zip(pixel) {
            *sum += f64::from(value.min(ceiling));
        }
    }
    let Foreground { development, metering, .. } = foreground;
    let exposed =
        MeteredPixels::of(&lit).exposure(sums, lit.len(), is_night, *metering, development.response.aim_factor());
    let rendered = foreground.develop(&rgb, (width, height), exposed, stream);
    Rendered { maps: found.map(|(.., maps)| maps), ..rendered }
}

/// Maps that show the sky alone.
fn sky(num_pixels: usize, kinds: &SurfaceMapKinds) -> Maps {
    let room = |is_wanted: bool| if is_wanted { num_pixels } else { 0 };
    Maps {
        depth_m: vec![f32::INFINITY; num_pixels],
        instance: vec![-1; num_pixels],
        semantic: vec![Semantic::Sky as u8; num_pixels],
        surfaces: SurfaceMaps {
            normal_cam: vec![[0.0; 3]; room(kinds.normals)],
            velocity_cam_m_per_s: vec![[0.0; 3]; room(kinds.scene_flow)],
            flow_px: vec![[f32::NAN; 2]; room(kinds.optical_flow_s.is_some())],
        },
    }
}

fn pixel_of(fisheye: &Fisheye, side: &Side, ray_side: DVec3) -> Option<DVec2> {
    (ray_side != DVec3::ZERO).then(|| fisheye.pixel_of_ray(side.cam_from_side * ray_side))
}
