"""A process that is forked after the core has used its threads has none of them: it must not wait for them."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
import multiprocessing, sys
import numpy as np
import cadet

boxes = np.random.default_rng(0).random((60, 7)) * 10
label = cadet.kitti.Label("Car", 0.0, 0, 0.0, (0.0, 0.0, 50.0, 50.0), (1.5, 1.6, 3.9), (0.0, 1.7, 20.0), 0.0)
found = cadet.kitti.Label(**{**vars(label), "score": 0.5})

def work():
    iou = float(cadet.box_iou_bev(boxes, boxes).sum() + cadet.box_iou_3d(boxes, boxes).sum())
    report = cadet.evaluate([[label]] * 300, [[found]] * 300)
    return iou, report.ap["Car"]["3d"]["Moderate"]

def child(pipe, deep):
    pipe.send((work(), work(), in_child(deep - 1) if deep else None))

def in_child(deep=0):
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe()
    process = context.Process(target=child, args=(theirs, deep))
    process.start()
    theirs.close()
    got = ours.recv()
    process.join()
    assert process.exitcode == 0, process.exitcode
    return got

before = work()
first = in_child(deep=1)
assert first[:2] == (before, before), first
assert first[2] == (before, before, None), first
assert work() == before
print("same")
"""


def test_a_forked_child_and_its_child_work_after_the_parent_has() -> None:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", SCRIPT], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.stdout, done.stderr) == ("same\n", "")
