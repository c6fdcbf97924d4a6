"""What a frame costs on its way to the network: `python benches/avod/loader.py DATA [--config NAME] [--bank BANK]`.

DATA is a KITTI folder. Milliseconds of processor time on one thread: of each step the least of several runs, averaged
over frames; a whole frame as training reads it, averaged over all augmentations, from the file to what the parent gets.
"""

from __future__ import annotations

import argparse
import pickle
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from avod.cli.process import set_up_process
from avod.config import Config
from avod.config.augmentation import AugmentationConfig
from avod.data.augmentation import Augmentation
from avod.data.build import _points_cam_in_image, build_sample, ground_plane
from avod.data.images import jitter_colors, resize_bilinear, shift_colors
from avod.data.mirror import mirror_image
from avod.data.object_sizes import resize_objects
from avod.data.packing import packed
from avod.data.paste import paste_objects
from avod.data.sample import Sample
from avod.data.scan_changes import drop_points, shift_ranges
from avod.data.world import WorldChange
from avod.geometry.anchors import anchors_over, occupancy
from cadet import bev, kitti
from cadet.datasets.object_bank import ObjectBank
from cadet.formats.kitti import boxes_cam_from_labels
from cadet.formats.kitti.files.velodyne import points_from_bytes
from cadet.formats.kitti.frame import Frame

_EVERYTHING = AugmentationConfig(
    rotation_deg=10.0,
    scaling=0.05,
    translation_m=(1.0, 0.1, 1.0),
    point_dropout=0.3,
    range_noise_m=0.02,
    object_scaling=0.1,
)
_CHANGES = [Augmentation(is_mirrored, has_jitter) for is_mirrored in (False, True) for has_jitter in (False, True)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Time how avod prepares a frame.")
    parser.add_argument("data", type=Path)
    parser.add_argument("--config", default="car_default")
    parser.add_argument("--bank", type=Path, help="time pasting objects of this bank too")
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--rounds", type=int, default=7)
    args = parser.parse_args()
    set_up_process()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    config = Config.named(args.config)
    times: dict[str, list[float]] = {}
    dataset = kitti.Dataset(args.data)
    bank = None if args.bank is None else ObjectBank(args.bank)
    for frame_id in dataset.ids[: args.frames]:
        for name, run in (*steps(dataset.folder, frame_id, config), *pasting(dataset.folder, frame_id, config, bank)):
            best = float("inf")
            for _ in range(args.rounds):
                start = time.process_time()
                run()
                best = min(best, time.process_time() - start)
            times.setdefault(name, []).append(1e3 * best)
    print(f"{args.config}, {args.frames} frames, OpenCV {cv2.__version__}, milliseconds of processor time")
    for name, values in times.items():
        print(f"{name:32s} {np.mean(values):7.2f}")


def steps(folder: Path, frame_id: str, config: Config) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield what is done to a frame, by name."""
    frame = kitti.read_frame(folder, frame_id, has_extras=False)
    scan, image, calib = frame.points_velo, frame.image, frame.calib
    plane = ground_plane(scan, calib, frame.plane, config)
    points = _points_cam_in_image(scan, calib, frame.image_size)
    cells = occupancy(points, plane, config.anchors, config.bev)
    memory = np.empty(config.bev.shape, np.float32)

    def made(change: Augmentation, frame: Frame) -> Sample:
        return build_sample(
            frame.points_velo, frame.image, frame.calib, frame.plane, config,
            labels=frame.labels, augmentation=change, ground=plane, maps=memory,
        )  # fmt: skip

    sample = made(_CHANGES[0], frame)
    sent = pickle.loads(pickle.dumps(packed(sample), protocol=5))
    png, binary = (folder / kind / f"{frame_id}.{end}" for kind, end in (("image_2", "png"), ("velodyne", "bin")))
    yield "reading a frame", lambda: kitti.read_frame(folder, frame_id, has_extras=False)
    yield "  of it, the image", lambda: kitti.files.images.decode_image(png.read_bytes())
    yield "  of it, the scan", lambda: points_from_bytes(binary.read_bytes())
    yield "ground, once a frame", lambda: ground_plane(scan, calib, frame.plane, config)
    yield "points in the image", lambda: _points_cam_in_image(scan, calib, frame.image_size)
    yield "jitter, half of the samples", lambda: jitter_colors(image, np.random.default_rng(0))
    yield "mirroring the image, half", lambda: mirror_image(image)
    yield "resizing", lambda: resize_bilinear(image, config.image.size)
    yield "occupied cells", lambda: occupancy(points, plane, config.anchors, config.bev)
    yield "anchors", lambda: anchors_over(cells, plane, config.classes, config.anchors, config.bev)
    yield "maps", lambda: bev.maps(points, plane, config.bev, memory)
    yield "packing and pickling", lambda: pickle.dumps(packed(sample), protocol=5)
    yield "unpacking, in the parent", lambda: sent.unpacked(torch.device("cpu"))
    yield from switches(frame, points, config)
    for change in _CHANGES:
        # The mean over all changes, as training takes them in turn.
        yield (
            "a whole frame, in the worker",
            lambda change=change: pickle.dumps(  # type: ignore[misc]
                packed(made(change, kitti.read_frame(folder, frame_id, has_extras=False))), protocol=5
            ),
        )


def switches(frame: Frame, points: NDArray[np.float64], config: Config) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield what `[augmentation]` may add, by name."""
    change = Augmentation(settings=_EVERYTHING)
    boxes, lidar = boxes_cam_from_labels(frame.labels), frame.calib.cam_from_velo[:3, 3]
    boxes = boxes[boxes[:, 3] > 0.0]
    classes = np.ones(len(boxes), np.int64)
    world = WorldChange.drawn(change)
    assert world is not None
    resized = resize_bilinear(frame.image, config.image.size)
    yield "+ rotation, scaling, translation", lambda: (world.points(points), world.projection(frame.calib.P2))
    yield "+ point drop-out", lambda: drop_points(points, change)
    yield "+ range noise", lambda: shift_ranges(points, lidar, change)
    yield "+ object sizes", lambda: resize_objects(points, boxes, classes, change)
    yield "+ brightness, contrast, hue", lambda: shift_colors(resized, 0.1, 1.2, 10.0)


def pasting(
    folder: Path, frame_id: str, config: Config, bank: ObjectBank | None
) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield what up to 4 and up to 12 pasted objects cost, from several seeds."""
    if bank is None:
        return
    frame = kitti.read_frame(folder, frame_id, has_extras=False)
    plane = ground_plane(frame.points_velo, frame.calib, frame.plane, config)
    for count in (4, 12):
        settings = AugmentationConfig(pasted_objects=count)
        for seed in range(8):
            change = Augmentation(settings=settings, seed=(seed,))
            yield (
                f"+ up to {count} objects pasted",
                lambda change=change: paste_objects(  # type: ignore[misc]
                    frame, plane, bank, config.class_names, change
                ),
            )


if __name__ == "__main__":
    main()
