from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from cadet._util import style
from cadet._util.style import dashes
from cadet.errors import CadetError
from cadet.figures import bev_maps
from cadet.figures.sheet import overview, sheet
from cadet.formats.kitti import boxes, read_frame
from cadet.formats.kitti.drawing import bev_figure, boxes_figure, corner_visibility, corners_figure, lidar_figure
from cadet.formats.kitti.files import images
from cadet.formats.kitti.frame import Frame
from real_kitti import ROOT, needs_kitti
from synthetic import DONT_CARE, make_calib, make_frame, make_label


def count(image: NDArray[np.uint8], color: style.Color) -> int:
    """Count the pixels of exactly this color."""
    return int((image == np.array(color, np.uint8)).all(axis=2).sum())


def figures(frame: Frame) -> dict[str, NDArray[np.uint8]]:
    draw = {"lidar": lidar_figure, "boxes": boxes_figure, "corners": corners_figure, "bev": bev_figure}
    return {name: figure(frame) for name, figure in draw.items()}


def read_png(path: Path) -> NDArray[np.uint8]:
    return images.decode_image(path.read_bytes())


def test_figures_have_the_images_size_and_leave_the_frame_alone() -> None:
    frame = make_frame(has_maps=True)
    before = frame.image.copy(), frame.points_velo.copy()
    drawn = figures(frame)
    assert {name: figure.shape for name, figure in drawn.items()} == {
        "lidar": (190, 620, 3),
        "boxes": (190, 620, 3),
        "corners": (190, 620, 3),
        "bev": (876, 960, 3),
    }
    assert all(figure.dtype == np.uint8 for figure in drawn.values())
    assert np.array_equal(frame.image, before[0])
    assert np.array_equal(frame.points_velo, before[1])


def test_a_frame_without_points_labels_and_plane_can_be_drawn() -> None:
    frame = make_frame(points_velo=np.zeros((0, 4), np.float32), labels=(), plane=None, meta=None)
    assert figures(frame)["boxes"].tobytes() == frame.image.tobytes()
    assert sheet(frame).shape[1] == 1920


def test_returns_are_drawn_where_they_project_and_by_depth() -> None:
    calib = make_calib()
    points_cam = np.array([[-1.0, 0.0, 5.0], [3.0, 0.0, 40.0], [0.0, 0.0, -8.0]])
    points_velo = np.hstack([calib.points_velo_from_cam(points_cam), np.zeros((3, 1))]).astype(np.float32)
    blank = np.zeros((190, 620, 3), np.uint8)
    empty = lidar_figure(make_frame(image=blank, points_velo=points_velo[:0]))
    drawn = lidar_figure(make_frame(image=blank, points_velo=points_velo))
    changed = np.argwhere((drawn != empty).any(axis=2))[:, ::-1]
    near_img, far_img = calib.project(points_cam[:2])
    distance = np.minimum(np.linalg.norm(changed - near_img, axis=1), np.linalg.norm(changed - far_img, axis=1))
    assert len(changed) > 4
    assert distance.max() < 4.0
    near, far = (drawn[round(v), round(u)].astype(int) for u, v in (near_img, far_img))
    assert near[0] > near[2]
    assert far[2] > far[0]


def test_boxes_are_drawn_in_their_classes_colors_where_they_are() -> None:
    frame = make_frame()
    drawn = boxes_figure(frame)
    assert count(drawn, style.CLASS_COLORS["Car"]) > 200
    assert count(drawn, style.CLASS_COLORS["Pedestrian"]) > 10
    assert count(drawn, style.CLASS_COLORS["Truck"]) == 0
    left, top, right, bottom = (round(x) for x in frame.labels[0].bbox)
    changed = (drawn != frame.image).any(axis=2)
    # The 2D box's edges, each for most of its length.
    for edge in (
        changed[top, left:right],
        changed[bottom, left:right],
        changed[top:bottom, left],
        changed[top:bottom, right],
    ):
        assert edge.mean() > 0.9
    assert not changed[:, 60:180].any()


def test_a_dont_care_region_is_dashed() -> None:
    frame = make_frame(labels=(DONT_CARE,), image=np.zeros((190, 620, 3), np.uint8))
    row = boxes_figure(frame)[80, 300:321].any(axis=1)
    assert 0.3 < row.mean() < 0.8


def test_a_box_around_the_camera_can_be_drawn() -> None:
    calib = make_calib()
    around = make_label("Van", (0.2, 1.65, 1.0, 6.0, 2.0, 2.0, 1.5), calib)
    drawn, without = (figures(make_frame(labels=labels)) for labels in ((around,), ()))
    for name in ("boxes", "corners", "bev"):
        assert (drawn[name] != without[name]).any(), name
    # From above: the outline of 6 x 2 m, 12 pixels a meter, lies about the sensor's place at (480, 840).
    changed = np.argwhere((drawn["bev"] != without["bev"]).any(axis=2))
    rows, columns = changed[:, 0], changed[:, 1]
    assert 6.0 * 12 / 2 < np.ptp(rows) < 8.0 * 12 and 2.0 * 12 - 2 <= np.ptp(columns) < 3.0 * 12
    assert columns.min() < 480 < columns.max() and rows.min() < 840 < rows.max()


def corner_frame(depth_m: float, **changes: Any) -> tuple[Frame, NDArray[np.float64]]:
    """A car 20 m ahead, and a depth image that is `depth_m` everywhere."""
    calib = make_calib()
    label = make_label("Car", (0.0, 1.65, 20.0, 4.0, 1.7, 1.5, -np.pi / 2), calib)
    depth = np.full((190, 620), depth_m, np.float32)
    frame = make_frame(labels=(label,), depth=depth, **changes)
    return frame, boxes.corners_cam(label.box_cam[None])[0]


@pytest.mark.parametrize(
    ("depth_m", "num_visible"), [(17.85, 0), (17.95, 4), (18.05, 4), (21.85, 4), (21.95, 8), (np.inf, 8)]
)
def test_corners_are_hidden_by_what_is_nearer_by_more_than_10_cm(depth_m: float, num_visible: int) -> None:
    frame, corners = corner_frame(depth_m)
    is_visible, source = corner_visibility(frame, list(frame.labels))
    assert source == "by the depth image"
    assert is_visible.sum() == num_visible
    if num_visible == 4:
        assert corners[is_visible[0], 2] == pytest.approx(18.0)


def test_one_far_neighbor_is_enough_to_see_a_corner() -> None:
    frame, corners = corner_frame(5.0)
    assert frame.depth is not None
    u, v = np.floor(frame.calib.project(corners[:1])[0]).astype(int)
    frame.depth[v, u + 1] = 80.0
    assert corner_visibility(frame, list(frame.labels))[0][0].tolist() == [True] + [False] * 7


def test_corners_outside_the_image_count_as_hidden() -> None:
    calib = make_calib()
    label = make_label("Car", (5.6, 1.65, 7.5, 3.9, 1.6, 1.4, -1.62), calib)
    frame = make_frame(labels=(label,), depth=np.full((190, 620), np.inf, np.float32))
    corners_img = calib.project(boxes.corners_cam(label.box_cam[None])[0])
    is_visible, _ = corner_visibility(frame, [label])
    assert is_visible[0].tolist() == ((corners_img > 0) & (corners_img < [620, 190])).all(axis=1).tolist()
    assert 0 < is_visible.sum() < 8


def test_what_the_generator_noted_comes_first() -> None:
    noted = [True, False] * 4
    frame, _ = corner_frame(5.0, meta={"objects": [{"corner_visible": noted}]})
    is_visible, source = corner_visibility(frame, list(frame.labels))
    assert (is_visible[0].tolist(), source) == (noted, "by the generator")


def test_without_depth_a_wall_of_returns_hides_what_is_behind_it() -> None:
    calib = make_calib()
    label = make_label("Car", (0.0, 1.65, 20.0, 4.0, 1.7, 1.5, -np.pi / 2), calib)
    x, y = np.meshgrid(np.linspace(-3, 3, 200), np.linspace(0.0, 1.3, 60))
    for wall_m, num_visible in ((10.0, 0), (30.0, 8)):
        wall_cam = np.stack([x.ravel(), y.ravel(), np.full(x.size, wall_m)], axis=1) * (wall_m / 10.0, 1.0, 1.0)
        points_velo = np.hstack([calib.points_velo_from_cam(wall_cam), np.zeros((x.size, 1))]).astype(np.float32)
        frame = make_frame(labels=(label,), points_velo=points_velo)
        is_visible, source = corner_visibility(frame, [label])
        assert source == "estimated from the LIDAR"
        # The lowest corners lie beside the wall's foot.
        assert is_visible[0, 4:].sum() == num_visible // 2


def test_corners_are_red_where_hidden_and_green_where_visible() -> None:
    for depth_m, has_red, has_green in ((5.0, True, False), (20.0, True, True), (np.inf, False, True)):
        drawn = corners_figure(corner_frame(depth_m)[0])
        assert (count(drawn, style.HIDDEN) > 0) == has_red
        assert (count(drawn, style.VISIBLE) > 0) == has_green


@pytest.mark.parametrize(("x", "y", "u", "v"), [(30.0, 0.0, 480, 480), (60.0, 20.0, 240, 120), (10.0, -30.0, 840, 720)])
def test_a_return_seen_from_above_lies_12_pixels_a_meter_from_the_sensor(x: float, y: float, u: int, v: int) -> None:
    without = bev_figure(make_frame(labels=(), points_velo=np.zeros((0, 4), np.float32)))
    point = np.array([[x + 0.02, y - 0.02, 1.0, 1.0]], np.float32)
    drawn = bev_figure(make_frame(labels=(), points_velo=point))
    changed = np.argwhere((drawn != without).any(axis=2))
    assert len(changed) >= 1
    assert np.abs(changed - [v, u]).max() <= 1


@pytest.mark.parametrize(
    ("yaw_deg", "is_turned"), [(0.0, False), (44.0, False), (-44.0, False), (90.0, True), (180.0, True)]
)
def test_from_above_a_camera_that_looks_aside_or_back_looks_up(yaw_deg: float, is_turned: bool) -> None:
    """What lies 30 m ahead of the camera and 10 m to its left is drawn there."""
    yaw = np.radians(yaw_deg if is_turned else 0.0)
    ahead, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    point = np.array([[*(30.02 * ahead + 9.98 * left), 1.0, 1.0]], np.float32)
    calib, turn = make_calib(), np.eye(4)
    turn[:2, :2] = [
        [np.cos(np.radians(yaw_deg)), np.sin(np.radians(yaw_deg))],
        [-np.sin(np.radians(yaw_deg)), np.cos(np.radians(yaw_deg))],
    ]
    calib = replace(calib, Tr_velo_to_cam=calib.Tr_velo_to_cam @ turn)
    with_point, without = (
        bev_figure(replace(make_frame(labels=()), calib=calib, points_velo=points))
        for points in (point, np.zeros((0, 4), np.float32))
    )
    changed = np.argwhere((with_point != without).any(axis=2))
    assert len(changed) >= 1 and np.abs(changed - [480, 360]).max() <= 1


def test_boxes_seen_from_above_lie_in_the_velo_frame() -> None:
    frame = make_frame(points_velo=np.zeros((0, 4), np.float32))
    drawn = bev_figure(frame)
    is_car = (drawn == np.array(style.CLASS_COLORS["Car"], np.uint8)).all(axis=2)
    spots = np.argwhere(is_car)
    x, y = 70.0 - (spots[:, 0] + 0.5) / 12.0, 40.0 - (spots[:, 1] + 0.5) / 12.0
    for label in frame.labels[:2]:
        center = boxes.boxes_velo_from_cam(label.box_cam[None], frame.calib)[0]
        near = np.hypot(x - center[0], y - center[1]) < 4.0
        assert near.sum() > 20
        assert np.mean(y[near]) == pytest.approx(center[1], abs=0.3)
    assert y.max() - y.min() < 11.0


def test_sheets_and_overviews_are_written_whole(tmp_path: Path) -> None:
    page = sheet(make_frame(), title="000001")
    assert page.shape[1] == 1920 and 900 < page.shape[0] < 1300
    picture = read_png(overview([make_frame() for _ in range(3)], tmp_path / "overview.png"))
    assert picture.shape[1] == 1600
    assert sorted(path.name for path in tmp_path.glob("*.png")) == ["overview.png"]
    with pytest.raises(CadetError, match=r"^overview: no frames$"):
        overview([], tmp_path / "none.png")
    assert not (tmp_path / "none.png").exists()


def test_the_three_configurations_maps_are_drawn(tmp_path: Path) -> None:
    frame = make_frame()
    drawn = read_png(bev_maps.view_bev_maps(frame, tmp_path / "maps.png"))
    # Rows of 6, 6 and 3 panels of 400 x 350 cells.
    assert drawn.shape == (3 * (30 + 376 + 12) + 12, 6 * 412 + 12, 3)
    blank = np.all(drawn == style.BACKGROUND, axis=2)
    assert blank[12 + 2 * 418 + 30 :, 3 * 412 + 12 :].all() and not blank[: 12 + 2 * 418].all()
    empty = bev_maps.bev_maps_figure(replace(frame, points_velo=frame.points_velo[:0], plane=None))
    assert (empty != drawn).any() and empty.shape == drawn.shape


def test_figures_are_the_same_every_time() -> None:
    first, second = sheet(make_frame(has_maps=True)), sheet(make_frame(has_maps=True))
    assert first.tobytes() == second.tobytes()


@needs_kitti
@pytest.mark.parametrize("frame_id", ["000000", "000001"])
def test_a_real_frame_is_drawn(frame_id: str) -> None:
    frame = read_frame(ROOT, frame_id)
    drawn = figures(frame)
    for name in ("lidar", "boxes", "corners"):
        assert drawn[name].shape == frame.image.shape
        assert (drawn[name] != frame.image).any()
    # A turn of the HDL-64E covers a good part of the ground: the figure from above is no empty board.
    gray = cv2.cvtColor(drawn["bev"], cv2.COLOR_RGB2GRAY)
    assert (np.asarray(gray) > 80).mean() > 0.02
    # Returns lie on the pedestrian and on the road, none in the sky.
    changed = np.abs(drawn["lidar"].astype(int) - style.dimmed(frame.image, 0.5, 0.35)).max(axis=2) > 30
    assert changed[250:].mean() > 0.2
    assert changed[:60].mean() < 0.01


def test_damaged_numbers_far_away_cost_neither_memory_nor_warnings() -> None:
    lines = list(dashes(np.array([-1e18, 0.0]), np.array([1e18, 3.0])))
    assert 1_000 < len(lines) < 100_000
    frame = make_frame()
    far = np.array([[3e38, -3e38, 1.0, 0.5]], np.float32)
    with np.errstate(over="ignore"):
        drawn = bev_figure(replace(frame, points_velo=np.concatenate([frame.points_velo, far])))
    np.testing.assert_array_equal(drawn, bev_figure(frame))
    label = replace(frame.labels[0], location_cam=(1e308, 1.5, 10.0))
    assert boxes_figure(replace(frame, labels=(label,))).shape == frame.image.shape
    calib = make_calib()
    velo_to_cam = calib.Tr_velo_to_cam.copy()
    velo_to_cam[2, 3] = -1e308
    bev_figure(replace(frame, calib=replace(calib, Tr_velo_to_cam=velo_to_cam)))
