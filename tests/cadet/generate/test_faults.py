"""Generation under faults ends with the undisturbed set's bytes: some schedules of `faults`, which plays any number."""

from __future__ import annotations

import sys

import pytest

from faults import failures

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs fork")


@pytest.mark.timeout(600)
def test_what_faults_leave_is_whole_and_resuming_ends_with_the_same_bytes() -> None:
    assert failures(iter(range(10)), ("kitti", "webdataset"), lambda text: None) == []
