"""A frame drawn: its boxes and returns in the image, its corners, the scan from above, and a panel of them."""

from cadet.formats.kitti.drawing.bev import bev_figure
from cadet.formats.kitti.drawing.camera import boxes_figure, corners_figure, far_to_near, lidar_figure
from cadet.formats.kitti.drawing.drawable import Drawable
from cadet.formats.kitti.drawing.panel import panel
from cadet.formats.kitti.drawing.visibility import corner_visibility

__all__ = [
    "Drawable",
    "bev_figure",
    "boxes_figure",
    "corner_visibility",
    "corners_figure",
    "far_to_near",
    "lidar_figure",
    "panel",
]
