//! Decides what gets a label, what is seen without one, and what is left out.

use crate::camera::CameraModel;
use crate::sense::{PosedScene, VisibilityBuffer};
use cadet_base::actor::ActorState;
use cadet_base::math::{self, DPose3};

use super::config::{LabelConfig, OcclusionMethod};
use super::corners::visible_corners;
use super::sighting::{Placed, Sighting};
use super::silhouette::{ActorInstances, ActorWindow, PinholeLook, SAMPLES_PER_PIXEL, Silhouette};

/// Whether some actor would get a label if nothing hid it: cheap, and `false` means that there is none to label.
#[must_use]
pub fn may_label(config: &LabelConfig, actors: &[ActorState], camera: &CameraModel, world_from_cam: &DPose3) -> bool {
    let cam_from_world = world_from_cam.inverse();
    actors.iter().any(|actor| {
        Placed::new(actor, config.boxes, camera, &cam_from_world).is_some_and(|placed| config.admits(&placed, actor))
    })
}

/// Counts the returns of each object, and takes the labels away that no sensor supports: labeled objects first, each
/// group by rising id. `point_actor_ids` names the actor of each return.
pub fn add_points(config: &LabelConfig, sightings: &mut [Sighting], point_actor_ids: &[i32]) {
    for sighting in sightings.iter_mut() {
        let id = sighting.actor_id;
        sighting.num_points = point_actor_ids.iter().filter(|of| **of == id).count();
        sighting.is_labeled &= config.is_supported(sighting);
    }
    put_labeled_first(sightings);
}

fn put_labeled_first(sightings: &mut [Sighting]) {
    sightings.sort_by_key(|s| (!s.is_labeled, s.actor_id));
}

/// Every actor that the camera sees well enough to be labeled or left out of scoring: labeled ones first, each group
/// in the order of their ids; [`add_points`] adds the returns.
///
/// # Frames and units
/// `world_from_cam` is the pose of the camera's frame, in which boxes are given; `extinction_per_m` is the air's.
#[must_use]
pub fn sightings(
    config: &LabelConfig,
    actors: &[ActorState],
    scene: &PosedScene,
    camera: &CameraModel,
    world_from_cam: &DPose3,
    looks: &[PinholeLook<'_>],
    extinction_per_m: f64,
) -> Vec<Sighting> {
    let cam_from_world = world_from_cam.inverse();
    let mut found = Vec::new();
    let instances = ActorInstances::new(scene);
    let mut buffer = VisibilityBuffer::default();
    for actor in actors {
        let Some(placed) = Placed::new(actor, config.boxes, camera, &cam_from_world) else { continue };
        let window = |look| ActorWindow::of(scene, &instances, actor.id, look);
        let windows: Vec<ActorWindow<'_>> = looks.iter().filter_map(window).collect();
        let visible_samples: usize = windows.iter().map(|window| window.visible_samples).sum();
        let visible_pixels = visible_samples as f64 / SAMPLES_PER_PIXEL as f64;
        let shows_enough = visible_pixels >= config.dontcare_min_pixels;
        let may_get_label =
            config.admits(&placed, actor) && (visible_samples > 0 || config.min_visible_fraction == 0.0);
        // What can appear in no list needs no outline.
        if !may_get_label && !shows_enough {
            continue;
        }
        let outlines = windows.iter().map(|window| window.silhouette(scene, &instances, &mut buffer));
        let outline = outlines.reduce(Silhouette::together).unwrap_or_default();
        let uncovered_fraction =
            if outline.samples == 0 { 0.0 } else { visible_samples as f64 / outline.samples as f64 };
        // Koschmieder: contrast falls exponentially with the way through the air.
        let away_m = (actor.center_world() - world_from_cam.translation).length();
        let contrast = math::exp(-extinction_per_m * away_m);
        let visible_fraction = uncovered_fraction * contrast;
        let corners_cam = placed.box_cam.corners_cam();
        let mut corner_visible = [false; 8];
        for PinholeLook { camera, world_from_cam: world_from_look, seen } in looks {
            let look_from_cam = world_from_look.inverse() * *world_from_cam;
            let is_own = *world_from_look == world_from_cam;
            let corners = if is_own { corners_cam } else { corners_cam.map(|p| look_from_cam.transform_point(p)) };
            let visible = visible_corners(&corners, camera, seen, config.corner_tolerance_m);
            corner_visible = std::array::from_fn(|k| corner_visible[k] || visible[k]);
        }
        let hidden_corners = corner_visible.iter().filter(|v| !**v).count();
        let occlusion_level = match config.method {
            OcclusionMethod::Pixels => {
                config.occlusion_levels.iter().filter(|limit| visible_fraction < **limit).count() as u8
            }
            OcclusionMethod::Corners => 0,
        };
        let is_hidden = config.method == OcclusionMethod::Corners && hidden_corners >= config.max_hidden_corners;
        let least_visible = config.least_visible_fraction(placed.box_cam.location_cam.z);
        let is_labeled = !is_hidden && may_get_label && visible_fraction >= least_visible;
        if !is_labeled && !shows_enough {
            continue;
        }
        let Placed { box_cam, bbox, truncation } = placed;
        found.push(Sighting {
            actor_id: actor.id,
            class: actor.class,
            model: actor.model.clone(),
            is_labeled,
            truncation,
            occlusion_level,
            observation_angle_rad: box_cam.alpha(),
            bbox,
            visible_fraction,
            visible_px: visible_pixels,
            contrast,
            num_points: 0,
            least_points: actor.annotated.least_points,
            velocity_world: actor.velocity_world,
            silhouette_bbox: outline.bounds.filter(|_| camera.warp().is_none() && camera.fisheye().is_none()),
            corner_visible,
            box_cam,
        });
    }
    put_labeled_first(&mut found);
    found
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::box_cam::Boxes;
    use super::*;
    use crate::camera::{View, kitti_like, visibility_pass};
    use cadet_base::actor::{AnnotatedBox, ObjectClass};
    use cadet_base::frames;
    use cadet_base::geometry::{LodSet, MeshBuilder};
    use cadet_base::instance::Instance;
    use cadet_base::material::{Material, Palette, Pattern, Semantic};
    use cadet_base::math::{DQuat, DVec3, Vec3};

    const EYE: DVec3 = DVec3::new(0.0, 0.0, 1.65);

    /// A box of a car's size, `ahead_m` before a camera that looks along x.
    fn car(id: i32, ahead_m: f64, left_m: f64) -> (ActorState, Instance) {
        let size_lwh = DVec3::new(4.0, 1.6, 1.5);
        let world_from_box = frames::upright(DVec3::new(ahead_m, left_m, 0.0), 0.0);
        let mut b = MeshBuilder::new();
        b.cuboid(Vec3::new(-2.0, -0.8, 0.0), Vec3::new(2.0, 0.8, 1.5), 0);
        let material = Material::matt(Semantic::Car, [0.3; 3], Pattern::Plain, 0.2);
        let instance = Instance::new(
            Arc::new(LodSet::single(b.build("car", 0.5))),
            Arc::new(Palette::new(vec![material])),
            world_from_box,
            id,
        );
        let actor = ActorState {
            id,
            class: ObjectClass::Car,
            model: "box".to_owned(),
            size_lwh,
            annotated: AnnotatedBox::exact(size_lwh),
            world_from_box,
            velocity_world: DVec3::ZERO,
            angular_velocity_world: DVec3::ZERO,
            brakes_for: None,
        };
        (actor, instance)
    }

    fn labels(config: &LabelConfig, cars: &[(ActorState, Instance)], extinction_per_m: f64) -> Vec<Sighting> {
        let (actors, instances): (Vec<ActorState>, Vec<Instance>) = cars.iter().cloned().unzip();
        let scene = PosedScene::new(&instances, EYE);
        let rotation = DQuat::from_mat3(&frames::cam_axes_from_velo_axes().transpose());
        let (camera, world_from_cam) = (kitti_like(), DPose3 { rotation, translation: EYE });
        let seen = visibility_pass(&scene, &View::new(&camera, &world_from_cam)).expect("a view");
        let looks = [PinholeLook { camera: &camera, world_from_cam: &world_from_cam, seen: &seen }];
        sightings(config, &actors, &scene, &camera, &world_from_cam, &looks, extinction_per_m)
    }

    fn exact() -> LabelConfig {
        LabelConfig { boxes: Boxes::Exact, ..LabelConfig::default() }
    }

    #[test]
    fn contrast_falls_exponentially_through_the_air_and_takes_visibility_with_it() {
        let cars = [car(1, 20.0, 0.0), car(2, 30.0, 6.0)];
        let clear = labels(&exact(), &cars, 0.0);
        assert_eq!(clear.len(), 2);
        for extinction_per_m in [0.01, 0.05] {
            for (foggy, clear) in labels(&exact(), &cars, extinction_per_m).iter().zip(&clear) {
                let center = cars[(foggy.actor_id - 1) as usize].0.center_world();
                let expected = math::exp(-extinction_per_m * (center - EYE).length());
                assert!((foggy.contrast - expected).abs() < 1e-12 && clear.contrast == 1.0);
                assert!((foggy.visible_fraction - clear.visible_fraction * expected).abs() < 1e-12);
                assert_eq!(foggy.visible_px, clear.visible_px);
            }
        }
    }

    #[test]
    fn what_fog_hides_is_no_longer_labeled() {
        let at_20_m = [car(1, 20.0, 0.0)];
        // ln 10 / 20 m leaves a tenth.
        for (extinction_per_m, occluded) in [(0.0, 0), (0.02, 1), (0.05, 2)] {
            let seen = &labels(&exact(), &at_20_m, extinction_per_m)[0];
            assert_eq!((seen.is_labeled, seen.occlusion_level), (true, occluded));
        }
        let hidden = &labels(&exact(), &at_20_m, 0.13)[0];
        assert!(!hidden.is_labeled && hidden.visible_px > 100.0);
    }

    #[test]
    fn what_one_of_two_pinholes_shows_is_half_seen_where_the_other_shows_nothing_of_it() {
        let [(actor, instance), (_, mut wall)] = [car(1, 20.0, 0.0), car(2, 4.0, 0.0)];
        wall.world_from_local.translation.z += 0.5;
        let open = PosedScene::new(std::slice::from_ref(&instance), EYE);
        let hidden = PosedScene::new(&[instance, wall], EYE);
        let rotation = DQuat::from_mat3(&frames::cam_axes_from_velo_axes().transpose());
        let (camera, world_from_cam) = (kitti_like(), DPose3 { rotation, translation: EYE });
        let view = View::new(&camera, &world_from_cam);
        let seen = [&open, &hidden].map(|scene| visibility_pass(scene, &view).expect("a view"));
        let look = |seen| PinholeLook { camera: &camera, world_from_cam: &world_from_cam, seen };
        let fraction = |looks: &[PinholeLook<'_>]| {
            sightings(&exact(), std::slice::from_ref(&actor), &open, &camera, &world_from_cam, looks, 0.0)
                .first()
                .map(|sighting| sighting.visible_fraction)
        };
        assert_eq!(fraction(&[look(&seen[0])]), Some(1.0));
        assert_eq!(fraction(&[look(&seen[1])]), None);
        assert_eq!(fraction(&[look(&seen[0]), look(&seen[1])]), Some(0.5));
    }

    #[test]
    fn returns_are_counted_and_what_has_no_support_loses_its_label_and_stands_last() {
        let config = LabelConfig { min_points: 2, ..exact() };
        let mut found = labels(&config, &[car(1, 20.0, 0.0), car(2, 30.0, 6.0)], 0.0);
        add_points(&config, &mut found, &[2, 0, 1, 2, -1, 7]);
        let of = |s: &Sighting| (s.actor_id, s.num_points, s.is_labeled);
        assert_eq!(found.iter().map(of).collect::<Vec<_>>(), [(2, 2, true), (1, 1, false)]);
    }
}
