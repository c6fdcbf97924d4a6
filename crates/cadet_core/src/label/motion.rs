//! Whether a view shows something that the view before did not: the ego or a labelled object has moved.

use super::box_cam::Rect;
use super::labeler::Labeled;
use crate::math::DPose3;

/// A view that was taken: where the ego was, and the rectangles of what was labelled.
#[derive(Debug, Clone)]
pub struct TakenView {
    world_from_ego: DPose3,
    objects: Vec<(i32, Rect)>,
}

impl TakenView {
    /// The ego has moved if it is at least this far from where it was.
    pub const EGO_MOVED_M: f64 = 0.5;
    /// An object has moved visibly if a side of its rectangle has, by this fraction of the image's width: 8 px of KITTI's.
    pub const OBJECT_MOVED: f64 = 8.0 / 1242.0;

    /// Remembers a view.
    #[must_use]
    pub fn new(world_from_ego: DPose3, labels: &[Labeled]) -> Self {
        let objects = labels.iter().filter(|l| l.is_object()).map(|l| (l.meta.actor_id, l.label.bbox)).collect();
        Self { world_from_ego, objects }
    }

    /// Whether the ego has moved since.
    #[must_use]
    pub fn ego_has_moved(&self, world_from_ego: &DPose3) -> bool {
        (world_from_ego.translation - self.world_from_ego.translation).length() >= Self::EGO_MOVED_M
    }

    /// Whether a labelled object has come into view since, or moved visibly.
    #[must_use]
    pub fn object_has_moved(&self, labels: &[Labeled], image_width: usize) -> bool {
        let least_px = Self::OBJECT_MOVED * image_width as f64;
        labels.iter().filter(|l| l.is_object()).any(|l| {
            let before = self.objects.iter().find(|o| o.0 == l.meta.actor_id);
            before.is_none_or(|(_, before)| {
                let (a, b) = (before, &l.label.bbox);
                let sides = [a.u1 - b.u1, a.v1 - b.v1, a.u2 - b.u2, a.v2 - b.v2];
                sides.iter().any(|d| d.abs() >= least_px)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::box_cam::BoxCam;
    use super::super::labeler::{Label, ObjectMeta};
    use super::*;
    use crate::actor::ObjectClass;
    use crate::math::{DQuat, DVec3};

    const WIDTH: usize = 1242;

    fn labeled(actor_id: i32, class: ObjectClass, u1: f64) -> Labeled {
        let bbox = Rect { u1, v1: 150.0, u2: u1 + 80.0, v2: 210.0 };
        let box_cam =
            BoxCam { size_lwh: DVec3::new(4.0, 1.6, 1.5), location_cam: DVec3::new(0.0, 1.6, 18.0), rotation_y: 0.0 };
        Labeled {
            label: Label { class, truncated: 0.0, occluded: 0, alpha: 0.0, bbox, box_cam: Some(box_cam) },
            meta: ObjectMeta {
                actor_id,
                class: ObjectClass::Car,
                model: String::new(),
                visible_fraction: 1.0,
                visible_pixels: 4800.0,
                contrast: 1.0,
                least_points: 0,
                num_points: 0,
                velocity_world: DVec3::ZERO,
                silhouette_bbox: None,
                corner_visible: [true; 8],
                box_cam,
            },
        }
    }

    fn ego_at(x: f64) -> DPose3 {
        DPose3 { rotation: DQuat::IDENTITY, translation: DVec3::new(x, 0.0, 0.0) }
    }

    #[test]
    fn the_ego_moves_by_half_a_metre_or_not_at_all() {
        let taken = TakenView::new(ego_at(3.0), &[]);
        assert!(!taken.ego_has_moved(&ego_at(3.0)) && !taken.ego_has_moved(&ego_at(3.4)));
        assert!(taken.ego_has_moved(&ego_at(3.6)) && taken.ego_has_moved(&ego_at(2.4)));
    }

    #[test]
    fn objects_move_by_pixels_of_the_image_or_come_into_view() {
        let car = |u| labeled(1, ObjectClass::Car, u);
        let taken = TakenView::new(ego_at(0.0), &[car(500.0)]);
        assert!(!taken.object_has_moved(&[car(500.0)], WIDTH));
        assert!(!taken.object_has_moved(&[car(507.0)], WIDTH) && taken.object_has_moved(&[car(509.0)], WIDTH));
        assert!(taken.object_has_moved(&[car(495.0)], WIDTH / 2), "pixels scale with the image");
        assert!(taken.object_has_moved(&[car(500.0), labeled(2, ObjectClass::Pedestrian, 40.0)], WIDTH));
        // Who left is no reason to look again, and nobody sees what DontCare does.
        assert!(!taken.object_has_moved(&[], WIDTH));
        assert!(!taken.object_has_moved(&[car(500.0), labeled(2, ObjectClass::DontCare, 40.0)], WIDTH));
    }

    #[test]
    fn small_motions_add_up_against_the_view_that_was_taken() {
        let taken = TakenView::new(ego_at(0.0), &[labeled(1, ObjectClass::Car, 500.0)]);
        let moved: Vec<bool> = [503.0, 506.0, 509.0]
            .iter()
            .map(|u| taken.object_has_moved(&[labeled(1, ObjectClass::Car, *u)], WIDTH))
            .collect();
        assert_eq!(moved, [false, false, true]);
    }
}
