//! Labels: KITTI's boxes, truncation and both occlusion methods, by the definitions of `docs/labels.md`.

mod box_cam;
mod config;
mod corners;
mod labeler;
mod motion;
mod road_plane;
mod silhouette;

pub use box_cam::{BoxCam, Boxes, Rect};
pub use config::{LabelConfig, OcclusionMethod};
pub use labeler::{Label, Labeled, ObjectMeta, add_points, label_actors, may_label};
pub use motion::TakenView;
pub use road_plane::road_plane_cam;
