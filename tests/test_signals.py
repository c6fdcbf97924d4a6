"""Signals that end a command."""

from __future__ import annotations

import os
import signal

import pytest

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
