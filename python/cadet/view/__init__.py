"""Pictures of frames, real or generated: boxes, LIDAR returns, visible corners, and the view from above."""

from cadet.view.bev import bev_figure
from cadet.view.bev_maps import bev_maps_figure, view_bev_maps
from cadet.view.camera import boxes_figure, corners_figure, lidar_figure
from cadet.view.sheet import figures, overview, sheet, view_frame
from cadet.view.visibility import corner_visibility

__all__ = [
    "bev_figure",
    "bev_maps_figure",
    "boxes_figure",
    "corner_visibility",
    "corners_figure",
    "figures",
    "lidar_figure",
    "overview",
    "sheet",
    "view_bev_maps",
    "view_frame",
]
