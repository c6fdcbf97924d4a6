"""Objects cut out of frames: what is taken, where its crop belongs, and that a bank gives back what was put in."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from cadet.cli.tools import cadet
from cadet.datasets.object_bank import BankObject, ObjectBank, cut_objects, write_bank
from cadet.datasets.object_bank.silhouette import is_solid, refined_silhouette, silhouette_from_points
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti import write_frame
from cadet.formats.kitti.boxes import corners_cam, points_in_boxes
from cadet.formats.kitti.files.images import encode_png
from cadet.formats.kitti.frame import Frame
from image_bytes import PNG_START, header
from synthetic import make_frame

TYPES = ("Car", "Pedestrian", "Cyclist")


def cut(frame: Frame, **options: Any) -> list[BankObject]:
    return list(cut_objects(frame, TYPES, "set/000000", **options))


def test_only_what_is_seen_whole_is_cut() -> None:
    frame = make_frame(has_maps=True)
    # Of a car, one that the image cuts off, and a pedestrian that a car hides.
    (car,) = cut(frame)
    assert car.type == "Car" and car.source == "set/000000"
    inside = points_in_boxes(frame.calib.points_cam_from_velo(frame.points_velo), frame.labels[0].box_cam[None])[:, 0]
    assert len(car.points_scan) == inside.sum() >= 190
    assert cut(frame, min_points=int(inside.sum()) + 1) == []
    assert list(cut_objects(frame, ("Pedestrian",), "x")) == []
    for change in ({"occluded": 1}, {"truncated": 0.3}, {"truncated": -1.0}, {"bbox": (260.0, 90.0, 300.0, 110.0)}):
        assert cut(replace(frame, labels=(replace(frame.labels[0], **change),))) == []


def test_points_and_box_stand_about_the_lidar() -> None:
    frame = make_frame(has_maps=True)
    (car,) = cut(frame)
    inside = points_in_boxes(frame.calib.points_cam_from_velo(frame.points_velo), frame.labels[0].box_cam[None])[:, 0]
    velo = frame.points_velo[inside]
    ranges = np.linalg.norm(car.points_scan[:, :3], axis=1)
    np.testing.assert_allclose(ranges, np.linalg.norm(velo[:, :3], axis=1), rtol=1e-5)
    np.testing.assert_array_equal(car.points_scan[:, 3], velo[:, 3])
    assert points_in_boxes(car.points_scan, car.box_scan[None], 1e-4).all()


@pytest.mark.parametrize("has_maps", [False, True])
def test_the_crops_corners_are_where_it_was_cut(has_maps: bool) -> None:
    frame = make_frame(has_maps=has_maps)
    (car,) = cut(frame)
    corners_cam = car.corners_scan + frame.calib.cam_from_velo[:3, 3]
    (left, top), _, (right, bottom), _ = frame.calib.project(corners_cam)
    assert (right - left, bottom - top) == pytest.approx((car.crop.shape[1], car.crop.shape[0]), abs=1e-6)
    window = frame.image[round(top + 0.5) : round(bottom + 0.5), round(left + 0.5) : round(right + 0.5)]
    np.testing.assert_array_equal(window, car.crop[..., :3])
    # On a plane through the middle of the box, upright and facing the camera.
    center = np.array(frame.labels[0].location_cam) - [0.0, 0.75, 0.0]
    away = (center - frame.calib.eye_cam) * [1.0, 0.0, 1.0]
    np.testing.assert_allclose((corners_cam - center) @ away, 0.0, atol=1e-6)


def test_an_instance_map_gives_the_silhouette_to_the_pixel() -> None:
    frame = make_frame(has_maps=True)
    assert frame.instance is not None
    (car,) = cut(frame)
    rows, columns = np.nonzero(frame.instance == 1)
    expected = frame.instance[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1] == 1
    np.testing.assert_array_equal(car.crop[..., 3] == 255, expected)
    # Where the points lie on nothing that has an instance, the map is another frame's.
    assert cut(replace(frame, instance=np.zeros_like(frame.instance))) == []


def test_without_an_instance_map_the_points_hull_fills_the_rectangle() -> None:
    frame = make_frame()
    left, top, right, bottom = frame.labels[0].bbox
    cam = frame.calib.points_cam_from_velo(frame.points_velo)
    points_img = frame.calib.project(cam[points_in_boxes(cam, frame.labels[0].box_cam[None])[:, 0]])
    corners_img = frame.calib.project(corners_cam(frame.labels[0].box_cam[None])[0])
    mask = silhouette_from_points(frame.image_size, points_img, corners_img, frame.labels[0].bbox)
    assert mask is not None
    rows, columns = np.nonzero(mask)
    assert (rows.min(), rows.max()) == pytest.approx((top, bottom), abs=1.0)
    assert (columns.min(), columns.max()) == pytest.approx((left, right), abs=1.0)
    # Convex: between any two of its pixels all are.
    for row in np.unique(rows):
        inside = columns[rows == row]
        assert len(inside) == inside.max() - inside.min() + 1
    # A few points in a corner say nothing of an outline.
    is_low = points_in_boxes(cam, frame.labels[0].box_cam[None])[:, 0] & (cam[:, 1] < 1.0)
    assert cut(replace(frame, points_velo=frame.points_velo[~is_low]), min_points=2) == []


def test_colors_refine_a_rough_silhouette() -> None:
    rng = np.random.default_rng(0)
    rows, columns = np.mgrid[:80, :120]
    radii = np.sqrt(((columns - 60) / 30.0) ** 2 + ((rows - 40) / 20.0) ** 2)
    truth = radii <= 1.0
    colors = np.where(truth[..., None], (170, 60, 50), (90, 110, 100)) + rng.normal(0, 12, (80, 120, 3))
    image: NDArray[np.uint8] = np.clip(colors, 0, 255).astype(np.uint8)
    # Too large on the left and too small on the right.
    rough = np.where(radii <= np.where(columns < 60, 1.2, 0.85), 255, 0).astype(np.uint8)
    box = (30.0, 20.0, 90.0, 60.0)
    found = refined_silhouette(image, rough, box) > 0
    assert overlap(found, truth) > 0.96 > 0.8 > overlap(rough > 0, truth)
    cv2.setRNGSeed(77)
    np.testing.assert_array_equal(refined_silhouette(image, rough, box) > 0, found)
    # Without colors to tell them apart the rough one stays, or nearly.
    plain = np.full_like(image, 100)
    assert overlap(refined_silhouette(plain, rough, box) > 0, rough > 0) > 0.5


def overlap(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> float:
    return float(np.count_nonzero(a & b) / np.count_nonzero(a | b))


def test_a_vehicle_that_something_hides_in_part_is_not_solid() -> None:
    mask = np.zeros((60, 80), np.uint8)
    mask[10:50, 10:70] = 255
    assert is_solid(mask)
    mask[30:50, 10:35] = 0
    assert not is_solid(mask)


def test_a_bank_gives_back_what_was_put_in(tmp_path: Path) -> None:
    objects = cut(make_frame(has_maps=True)) + cut(make_frame())
    assert write_bank(tmp_path / "bank", objects) == {"Car": 2}
    bank = ObjectBank(tmp_path / "bank")
    assert len(bank) == 2 and bank.types == ("Car", "Car")
    for item, found in zip(objects, (bank[0], pickle.loads(pickle.dumps(bank))[1]), strict=True):
        np.testing.assert_array_equal(found.points_scan, item.points_scan)
        np.testing.assert_array_equal(found.crop, item.crop)
        np.testing.assert_allclose(found.box_scan, item.box_scan, atol=1e-6)
        np.testing.assert_allclose(found.corners_scan, item.corners_scan, atol=1e-6)
        assert (found.type, found.source) == (item.type, item.source)
    with pytest.raises(IndexError):
        bank[2]
    with pytest.raises(CadetError, match="holds a bank already"):
        write_bank(tmp_path / "bank", objects)
    with pytest.raises(CadetError, match="no object to put into a bank"):
        write_bank(tmp_path / "empty", [])
    assert not (tmp_path / "empty" / "bank.json").exists()
    write_bank(tmp_path / "again", objects)
    assert ObjectBank(tmp_path / "again").crc32 == bank.crc32
    write_bank(tmp_path / "other", objects[:1])
    assert ObjectBank(tmp_path / "other").crc32 != bank.crc32


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "x"}, "not the list of an object bank of version 1"),
        ({"objects": []}, "objects: expected a list of at least one"),
        ({"objects": [3]}, r"objects\[0\]: expected a table"),
        ({"type": 3}, r"objects\[0\]: type: expected a string"),
        ({"box_scan": [1, 2]}, r"objects\[0\]: expected box_scan of 7 numbers"),
        ({"corners_scan": [[1, 2, 3]]}, r"objects\[0\]: expected box_scan of 7 numbers and corners_scan of 4 rows"),
        ({"num_points": None}, r"objects\[0\]: num_points: expected a whole number"),
        ({"num_points": 5}, r"000000.bin: \d+ points, expected 5"),
        ({"type": "1.5"}, r"objects\[0\]: type: expected a type of objects such as Car, got '1.5'"),
        ({"box_scan": [0, 0, 9, 0, 1, 1, 0]}, r"objects\[0\]: expected an object with a size"),
    ],
)
def test_a_damaged_list_is_named(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    write_bank(tmp_path, cut(make_frame(has_maps=True)))
    path = tmp_path / "bank.json"
    table = json.loads(path.read_text())
    table["objects"][0] |= {key: value for key, value in change.items() if key in table["objects"][0]}
    table |= {key: value for key, value in change.items() if key in table}
    path.write_text(json.dumps(table))
    with pytest.raises(CadetError, match=message):
        ObjectBank(tmp_path)[0]


def test_damaged_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"bank\.json: no such file: expected a bank"):
        ObjectBank(tmp_path)
    write_bank(tmp_path, cut(make_frame(has_maps=True)))
    for end, data, message in (
        ("png", b"", r"000000\.png: the file is empty"),
        ("png", b"no picture", r"000000\.png: no PNG, JPEG or WebP image"),
        ("png", encode_png(np.zeros((4, 5, 3), np.uint8)), r"000000\.png: expected a PNG image of four channels"),
        ("png", PNG_START + header(32_768, 32_768), r"000000\.png: 32768 x 32768 pixels, at most"),
        ("bin", bytes(5), "000000.bin: truncated"),
    ):
        path = tmp_path / "objects" / f"000000.{end}"
        before = path.read_bytes()
        path.write_bytes(data)
        with pytest.raises(CadetError, match=message):
            ObjectBank(tmp_path)[0]
        path.write_bytes(before)
    (tmp_path / "objects" / "000000.png").unlink()
    with pytest.raises(MissingFileError, match="no such file"):
        ObjectBank(tmp_path)[0]


def test_the_command_cuts_a_folder(tmp_path: Path) -> None:
    for number in range(2):
        write_frame(tmp_path / "set", number, make_frame(has_maps=True))
    command = ["bank", str(tmp_path / "set"), "-o", str(tmp_path / "bank"), "--split", "train", "--class", "Car"]
    done = CliRunner().invoke(cadet, command, catch_exceptions=False)
    assert f"wrote {tmp_path / 'bank'}: 2 Car from 2 frames" in done.output
    assert [item.source.rpartition("/")[2] for item in map(ObjectBank(tmp_path / "bank").__getitem__, range(2))] == [
        "000000",
        "000001",
    ]
