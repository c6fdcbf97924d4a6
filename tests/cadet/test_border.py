"""What leaves the compiled core: errors for panics, too much, and scenes in use; and other threads run on."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import subprocess
import sys
import threading
import time
from typing import Any

import numpy as np
import pytest

import cadet
from cadet import bev
from cadet.errors import CadetError, InternalError


def small_rig() -> cadet.Rig:
    return cadet.Rig(camera=cadet.Camera.kitti().resized(124, 38), lidar=cadet.Lidar.vlp16())


def test_a_panic_is_an_error_that_asks_for_a_report_and_prints_nothing() -> None:
    lines = ("from cadet import _cadet, errors", "try:", "  _cadet._panic('len\\nis 3')")
    code = "\n".join((*lines, "except errors.InternalError as error:", "  print(error)"))
    # Read when the core is loaded.
    environment = {name: value for name, value in os.environ.items() if name != "RUST_BACKTRACE"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert re.fullmatch(r"internal error: len is 3 \(\S*lib\.rs:\d+\); please report it, .*\n", done.stdout)
    assert issubclass(InternalError, CadetError)


def test_too_many_pairs_of_boxes_are_refused() -> None:
    boxes = np.ones((200_000, 7))
    with pytest.raises(CadetError, match=r"^number of pairs of boxes is 200000 x 200000, expected at most 268435456"):
        cadet.box_iou_bev(boxes, boxes)


def test_a_scene_in_another_threads_hands_says_so() -> None:
    scene = cadet.Scene.empty(rig=small_rig())

    def step() -> None:
        # It may be this thread that is refused.
        is_done = False
        while not is_done:
            with contextlib.suppress(CadetError):
                scene.step(3000.0)
                is_done = True

    thread = threading.Thread(target=step)
    thread.start()
    message = None
    while thread.is_alive() and message is None:
        try:
            scene._native.sensor_poses()
        except CadetError as error:
            message = str(error)
    thread.join()
    assert message == "scene: another thread is using it; give each thread its own, or let them take turns"
    assert scene.time_s == pytest.approx(3000.0)


def test_other_threads_run_while_maps_and_triangles_are_made() -> None:
    scene = cadet.Scene.random(seed=1, rig=small_rig())
    points = np.random.default_rng(0).uniform((-40, 0, 0), (40, 3, 70), (1_500_000, 3))
    plane = np.array([0.0, -1.0, 0.0, 1.65])
    for call in (lambda: bev.maps(points, plane), lambda: [scene.triangles() for _ in range(20)]):
        begun: list[float] = []
        ended: list[float] = []
        ticks: list[float] = []

        def work(call: Any = call, begun: list[float] = begun, ended: list[float] = ended) -> None:
            begun.append(time.perf_counter())
            call()
            ended.append(time.perf_counter())

        thread = threading.Thread(target=work)
        thread.start()
        while thread.is_alive():
            ticks.append(time.perf_counter())
            time.sleep(0.0005)
        thread.join()
        inside = sorted([begun[0], *(tick for tick in ticks if begun[0] <= tick <= ended[0]), ended[0]])
        longest = max(b - a for a, b in itertools.pairwise(inside))
        assert longest < 0.5 * (ended[0] - begun[0]), (longest, ended[0] - begun[0])
