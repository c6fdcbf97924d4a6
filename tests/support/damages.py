"""A small set as a generator writes it, and forty ways to damage it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from cadet.formats.kitti import ImageSet, Label, write_frame, write_image_set
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.folder import SUFFIXES
from cadet.formats.kitti.files.velodyne import bytes_from_points, points_from_bytes
from synthetic import IMAGE_SIZE, make_calib, make_frame, make_label, make_labels, make_points

Damage = Callable[[Path], object]

LISTS = {"train": (0, 1), "val": (2, 3), "trainval": (0, 1, 2, 3), "test": ()}
EPISODES = (0, 0, 1, 1)
FAR = (-3.0, 1.65, 40.0, 4.1, 1.7, 1.5, 1.5)
"""A box that lies in the image and has no point."""


def write_set(root: Path) -> None:
    """Write four frames of two episodes, as a generator does: maps, records, lists, and hashes of everything."""
    for number, episode in enumerate(EPISODES):
        frame = make_frame(has_maps=True, seed=number)
        write_frame(root, number, replace(frame, meta=meta_of(frame.labels, episode)), split=None)
        for kind, data in (
            ("image_3", images.encode_png(frame.image[:, ::-1])),
            ("point_labels", np.zeros(len(frame.points_velo), "<u4").tobytes()),
            ("point_times", np.zeros(len(frame.points_velo), "<f4").tobytes()),
        ):
            path = file(root, kind, number)
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(data)
    for split, numbers in LISTS.items():
        write_image_set(root, split, ImageSet(tuple(f"{number:06d}" for number in numbers)))
    seal(root)


def meta_of(labels: tuple[Label, ...], episode: int) -> dict[str, Any]:
    objects = [
        {"actor_id": number, "type": label.type, "location_cam": label.location_cam, "num_points": 200}
        for number, label in enumerate(labels, start=1)
    ]
    return {"seed": 5, "episode": episode, "image_size": IMAGE_SIZE, "objects": objects}


def seal(root: Path) -> None:
    """Write the hashes and counts of what is there, so that no damage is found by its hash alone."""
    names = [path for part in ("ImageSets", "training") for path in sorted((root / part).rglob("*")) if path.is_file()]
    hashes = {str(path.relative_to(root)): sha256(path.read_bytes()).hexdigest() for path in names}
    labels = Counter(
        line.split(" ")[0]
        for path in (root / "training" / "label_2").glob("*")
        for line in path.read_text().splitlines()
    )
    ids = {path.stem for path in names if path.parent.parent.name == "training"}
    counts = {"frames": len(ids), "labels": labels}
    (root / "manifest.json").write_text(json.dumps({"counts": counts, "sha256": hashes}))


def file(root: Path, kind: str, number: int = 1) -> Path:
    return next((root / "training" / kind).glob(f"{number:06d}.*"), root / "training" / kind / named(kind, number))


def named(kind: str, number: int = 1) -> str:
    return f"{number:06d}{SUFFIXES[kind]}"


def unlink(kind: str) -> Damage:
    return lambda root: file(root, kind).unlink()


def cut(kind: str, size: int) -> Damage:
    return lambda root: edit_bytes(root, kind, lambda data: data[:size])


def text(kind: str, old: str, new: str) -> Damage:
    def damage(root: Path) -> None:
        path = file(root, kind)
        assert old in path.read_text()
        path.write_text(path.read_text().replace(old, new, 1))

    return damage


def line(edit: Callable[[list[str]], list[str]]) -> Damage:
    """Edit the fields of the third label, a pedestrian."""

    def damage(root: Path) -> None:
        path = file(root, "label_2")
        lines = path.read_text().splitlines()
        lines[2] = " ".join(edit(lines[2].split(" ")))
        path.write_text("\n".join(lines) + "\n")

    return damage


def with_field(index: int, value: str) -> Damage:
    return line(lambda fields: [*fields[:index], value, *fields[index + 1 :]])


def edit_bytes(root: Path, kind: str, edit: Callable[[bytes], bytes]) -> None:
    path = file(root, kind)
    path.write_bytes(edit(path.read_bytes()))


def edit_points(edit: Callable[[Any], None]) -> Damage:
    def change(data: bytes) -> bytes:
        points_velo = points_from_bytes(data)
        edit(points_velo)
        return bytes_from_points(points_velo)

    return lambda root: edit_bytes(root, "velodyne", change)


def rewrite(number: int = 1, **changes: Any) -> Damage:
    """Write a frame anew, with other fields; its record follows its labels."""

    def damage(root: Path) -> None:
        frame = make_frame(has_maps=True, seed=number, **changes)
        meta = meta_of(frame.labels, EPISODES[number])
        write_frame(root, number, replace(frame, meta=meta), split=None, overwrite=True)
        for kind, data in (
            ("image_3", images.encode_png(frame.image)),
            ("point_labels", np.zeros(len(frame.points_velo), "<u4").tobytes()),
            ("point_times", np.zeros(len(frame.points_velo), "<f4").tobytes()),
        ):
            file(root, kind, number).write_bytes(data)

    return damage


def without_frame(root: Path) -> None:
    for path in (root / "training").rglob("000001.*"):
        path.unlink()
    lists(train=(0,), trainval=(0, 2, 3))(root)
    new = {
        name: sha256((root / name).read_bytes()).hexdigest()
        for name in ("ImageSets/train.txt", "ImageSets/trainval.txt")
    }
    manifest(lambda content: content["sha256"].update(new))(root)


def lists(**sets: tuple[int, ...]) -> Damage:
    def damage(root: Path) -> None:
        for split, numbers in sets.items():
            write_image_set(root, split, ImageSet(tuple(f"{number:06d}" for number in numbers)))

    return damage


def copied_frame(root: Path) -> None:
    """Give frame 3 the image and scan of frame 1, brighter and noisier, in files of its own."""
    rng = np.random.default_rng(1)
    image = cv2.imread(str(file(root, "image_2", 1)))
    assert image is not None
    noisy = np.clip(image * 1.1 + rng.normal(0.0, 4.0, image.shape), 0, 255).astype(np.uint8)
    cv2.imwrite(str(file(root, "image_2", 3)), noisy)
    points_velo = points_from_bytes(file(root, "velodyne", 1).read_bytes())
    points_velo[:, :3] += rng.normal(0.0, 0.01, (len(points_velo), 3)).astype(np.float32)
    file(root, "velodyne", 3).write_bytes(bytes_from_points(points_velo))


def mirrored_calib(root: Path) -> None:
    """Turn the LIDAR round: a proper rotation, but all that it sees ahead lies behind."""
    calib = make_calib()
    turned = calib.Tr_velo_to_cam.copy()
    turned[:, :3] = turned[:, :3] @ np.diag([-1.0, -1.0, 1.0])
    file(root, "calib").write_text(replace(calib, Tr_velo_to_cam=turned).to_text())


def ghost() -> tuple[Label, ...]:
    car, other, pedestrian, region = make_labels(make_calib())
    return car, other, pedestrian, make_label("Car", FAR, make_calib()), region


def road_scan(root: Path) -> None:
    """Put two cars before the sensors whose returns are not in the scan: the road's are."""
    calib = make_calib()
    cars = tuple(make_label("Car", (x, 1.65, z, 4.1, 1.7, 1.5, 1.5), calib) for x, z in ((-2.0, 14.0), (3.0, 11.0)))
    rewrite(labels=cars, points_velo=make_points(cars, calib, seed=9)[:4000])(root)


def manifest(edit: Callable[[dict[str, Any]], None]) -> Damage:
    def damage(root: Path) -> None:
        content = json.loads((root / "manifest.json").read_text())
        edit(content)
        (root / "manifest.json").write_text(json.dumps(content))

    return damage


def drop_frame_from_manifest(content: dict[str, Any]) -> None:
    content["sha256"] = {name: digest for name, digest in content["sha256"].items() if "000001" not in name}
    content["counts"]["frames"] = 3


Found = tuple[str, str, str]
IMAGE, SCAN, CALIB, LABELS = "image_2/000001.png", "velodyne/000001.bin", "calib/000001.txt", "label_2/000001.txt"

# Name: (damage, whether the set is sealed again, file with line, rule, part of the message).
KINDS: dict[str, tuple[Damage, bool, str, str, str]] = {
    "no image": (unlink("image_2"), True, IMAGE, "missing-file", "missing"),
    "no labels": (unlink("label_2"), True, LABELS, "missing-file", "missing"),
    "no plane where others have one": (unlink("planes"), True, "planes/000001.txt", "missing-file", "most other"),
    "a file that the manifest names": (unlink("image_3"), False, "image_3/000001.png", "missing-file", "manifest"),
    "no frame": (without_frame, False, IMAGE, "missing-file", "as is all of a frame"),
    "half an image": (cut("image_2", 2000), True, IMAGE, "damaged-file", "PNG"),
    "half a point": (cut("velodyne", 16 * 900 + 7), True, SCAN, "damaged-file", "truncated"),
    "a matrix missing": (text("calib", "P2:", "P9:"), True, CALIB, "damaged-file", "missing key 'P2'"),
    "half a label": (line(lambda fields: fields[:9]), True, f"{LABELS}:3", "damaged-file", "15"),
    "a depth map of another size": (
        lambda root: edit_bytes(root, "depth", lambda data: images.encode_png(np.ones((4, 4), np.uint16))),
        True,
        "depth/000001.png",
        "damaged-file",
        "4 x 4 pixels",
    ),
    "a right image of another size": (
        lambda root: edit_bytes(root, "image_3", lambda data: images.encode_png(np.ones((4, 4, 3), np.uint8))),
        True,
        "image_3/000001.png",
        "damaged-file",
        "4 x 4 pixels",
    ),
    "labels of other points": (
        cut("point_labels", 400),
        True,
        "point_labels/000001.label",
        "damaged-file",
        "100 points",
    ),
    "times of other points": (
        cut("point_times", 200),
        True,
        "point_times/000001.bin",
        "damaged-file",
        "50 points",
    ),
    "a file of no frame": (
        lambda root: (root / "training" / "planes" / "000009.txt").write_text(""),
        False,
        "planes/000009.txt",
        "stray-file",
        "belongs to no frame",
    ),
    "a pixel of another gray": (
        lambda root: edit_bytes(
            root, "image_2", lambda data: images.encode_png(np.maximum(images.decode_image(data), 41))
        ),
        False,
        IMAGE,
        "wrong-hash",
        "not the file that manifest.json names",
    ),
    "an edited list": (
        lists(train=(1, 0)),
        False,
        "ImageSets/train.txt",
        "wrong-hash",
        "not the file",
    ),
    "a manifest without a frame": (
        manifest(drop_frame_from_manifest),
        False,
        IMAGE,
        "manifest",
        "does not name this frame",
    ),
    "a manifest of other labels": (
        manifest(lambda content: content["counts"]["labels"].update(Car=9)),
        False,
        "manifest.json",
        "manifest",
        "9 Car (found 8)",
    ),
    "a list of frames that are not there": (
        lists(small=(0, 2, 7)),
        True,
        "ImageSets/small.txt:3",
        "image-set",
        "000007",
    ),
    "a frame in two splits": (
        lists(train=(0, 1, 2, 3), val=(2,)),
        True,
        "ImageSets/val.txt:1",
        "split-overlap",
        "000002 is in train, too",
    ),
    "an episode in two splits": (
        lists(train=(0, 1, 2), val=(3,)),
        True,
        "ImageSets/val.txt:1",
        "episode-overlap",
        "000003 is of episode 1, of which 000002 is in train",
    ),
    "a frame twice, changed": (copied_frame, True, "image_2/000003.png", "duplicate-frame", "nearly those of 000001"),
    "an image twice": (
        lambda root: file(root, "image_2", 3).write_bytes(file(root, "image_2", 1).read_bytes()),
        True,
        "image_2/000003.png",
        "duplicate-frame",
        "the same pixels as 000001's",
    ),
    "a scan twice": (
        lambda root: file(root, "velodyne", 3).write_bytes(file(root, "velodyne", 1).read_bytes()),
        True,
        "velodyne/000003.bin",
        "duplicate-frame",
        "the same points as 000001's",
    ),
    "a matrix that is no rotation": (
        lambda root: (
            file(root, "calib").write_text(
                replace(make_calib(), Tr_imu_to_velo=2.0 * make_calib().Tr_imu_to_velo).to_text()
            )
            and None
        ),
        True,
        CALIB,
        "calibration",
        "Tr_imu_to_velo: not a rotation",
    ),
    "a LIDAR turned round": (mirrored_calib, True, SCAN, "scan-off-image", "falls into the image"),
    "a plane upside down": (
        rewrite(plane=np.array([0.0, 1.0, 0.0, 1.65])),
        True,
        "planes/000001.txt:4",
        "ground-plane",
        "must point up",
    ),
    "intensities of another scale": (
        edit_points(lambda points_velo: np.multiply(points_velo[:, 3], 255, out=points_velo[:, 3])),
        True,
        SCAN,
        "scan",
        "intensity",
    ),
    "another frame's scan": (road_scan, True, SCAN, "scan-off-labels", "2 unhidden boxes"),
    "another frame's depth": (
        lambda root: edit_bytes(
            root, "depth", lambda data: images.encode_png(images.decode_map(data, "depth", np.uint16) // 2)
        ),
        True,
        "depth/000001.png",
        "depth-off-scan",
        "0.50 times",
    ),
    "a truncation above 1": (with_field(1, "1.40"), True, f"{LABELS}:3", "label-field", "expected 0..1"),
    "sizes in another order": (
        rewrite(labels=(replace(make_labels(make_calib())[0], dimensions_hwl=(1.5, 4.1, 1.7)),)),
        True,
        f"{LABELS}:1",
        "label-field",
        "expected h w l",
    ),
    "a 2D box outside the image": (with_field(6, "800.00"), True, f"{LABELS}:3", "label-bbox", "leaves"),
    "a 2D box elsewhere": (with_field(4, "200.00"), True, f"{LABELS}:3", "label-projection", "IoU"),
    "a truncation of no part": (with_field(1, "0.30"), True, f"{LABELS}:3", "label-truncation", "expected 0.00"),
    "an angle of another heading": (with_field(3, "2.00"), True, f"{LABELS}:3", "label-alpha", "alpha 2.0"),
    "an object that nothing shows": (rewrite(labels=ghost()), True, f"{LABELS}:4", "label-evidence", "no pixel of it"),
    "a DontCare with a size": (
        text("label_2", "-1 -1 -1 -1000", "-1 1.5 -1 -1000"),
        True,
        f"{LABELS}:4",
        "dont-care",
        "dimensions_hwl",
    ),
    "a DontCare before an object": (
        rewrite(labels=tuple(make_labels(make_calib())[index] for index in (0, 1, 3, 2))),
        True,
        f"{LABELS}:4",
        "other-readers",
        "objects must come first",
    ),
    "another frame's record": (text("meta", '"Pedestrian"', '"Cyclist"'), True, "meta/000001.json", "meta", "Cyclist"),
}
