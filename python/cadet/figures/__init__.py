"""Pictures of frames, real or generated: boxes, LIDAR returns, visible corners, and the view from above."""

from cadet.figures.bev_maps import bev_maps_figure, view_bev_maps
from cadet.figures.sheet import figures, overview, sheet, view_frame
from cadet.figures.show import view
from cadet.formats.kitti.drawing.bev import bev_figure
from cadet.formats.kitti.drawing.camera import boxes_figure, corners_figure, lidar_figure
from cadet.formats.kitti.drawing.visibility import corner_visibility

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
    "view",
    "view_bev_maps",
    "view_frame",
]
