"""Real KITTI files beside the repository, for the tests that compare with them."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3] / "shared" / "kitti"

needs_kitti = pytest.mark.skipif(not ROOT.is_dir(), reason="needs real KITTI frames in ../shared/kitti")


def files(pattern: str) -> list[Path]:
    """List the files under the folder that match, sorted; none where the folder is missing."""
    return sorted(ROOT.glob(pattern))
