"""Signals that end a command, and long calls of the core."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable

import numpy as np
import pytest

import cadet
from cadet.cli.signals import Terminated, exit_code, signals_end


def be_terminated() -> None:
    with signals_end():
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            signal.pause()
        except Terminated:
            # As libraries in C++ do, which ask Python whether a signal has come.
            raise KeyboardInterrupt from None


def be_interrupted() -> None:
    with signals_end():
        raise KeyboardInterrupt


def test_a_signal_that_a_library_passes_on_as_ctrl_c_is_still_named() -> None:
    with pytest.raises(Terminated) as ended:
        be_terminated()
    assert exit_code(ended.value) == 128 + signal.SIGTERM
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_ctrl_c_stays_ctrl_c() -> None:
    with pytest.raises(KeyboardInterrupt) as ended:
        be_interrupted()
    assert type(ended.value) is KeyboardInterrupt


def _long_step(scene: cadet.Scene) -> None:
    scene.step(3600.0)


def _many_pairs(scene: cadet.Scene) -> None:
    boxes = np.tile([0.0, 1.5, 20.0, 4.0, 1.6, 1.5, 0.3], (8_000, 1))
    cadet.box_iou_3d(boxes, boxes)


def _many_rays(scene: cadet.Scene) -> None:
    rays = np.tile([0.6, 0.0, -0.8], (2_000_000, 1))
    scene.cast_rays(np.zeros_like(rays), rays)


@pytest.fixture(scope="module")
def scene() -> cadet.Scene:
    return cadet.Scene.random(seed=0)


@pytest.mark.parametrize("call", [_long_step, _many_pairs, _many_rays])
def test_ctrl_c_ends_long_calls_within_a_second(call: Callable[[cadet.Scene], None], scene: cadet.Scene) -> None:
    usual = signal.signal(signal.SIGALRM, signal.default_int_handler)
    start_s = time.monotonic()
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            call(scene)
        assert time.monotonic() - start_s < 1.2
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, usual)
    before_s = scene.time_s
    scene.step(0.5)
    assert scene.time_s == pytest.approx(before_s + 0.5)
