"""Numbers that only Python reads, and calibrations without a way back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cadet.errors import CadetError, KittiFormatError
from cadet.formats.kitti import Calibration
from cadet.formats.kitti.files.planes import plane_from_text
from synthetic import make_calib


@pytest.mark.parametrize("number", ["1_0", "٣", "1__0"])
def test_numbers_that_only_python_reads_are_refused(number: str) -> None:
    text = make_calib().to_text()
    first = text.split("P0: ")[1].split(" ")[0]
    with pytest.raises(KittiFormatError, match=r"^c\.txt:1: P0: expected a number, got "):
        Calibration.from_text(text.replace(first, number, 1), "c.txt")
    with pytest.raises(KittiFormatError, match=r"^p\.txt:4: expected a number, got "):
        plane_from_text(f"# Matrix\nWIDTH 4\nHEIGHT 1\n{number} -1 0 1.65\n", "p.txt")


def test_singular_calibrations_have_no_way_back_and_say_so() -> None:
    calib = make_calib()
    flat = replace(calib, R0_rect=np.diag([1.0, 1.0, 0.0]))
    with pytest.raises(CadetError, match=r"^calib: R0_rect times Tr_velo_to_cam is singular"):
        flat.points_velo_from_cam(np.ones((1, 3)))
    blind = replace(calib, P2=np.zeros((3, 4)))
    with pytest.raises(CadetError, match=r"^calib: the first three columns of P2 are singular"):
        blind.eye_cam  # noqa: B018


def test_the_eye_is_where_p2_maps_to_nothing() -> None:
    calib = make_calib()
    np.testing.assert_allclose(calib.P2 @ [*calib.eye_cam, 1.0], 0.0, atol=1e-9)
