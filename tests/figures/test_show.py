from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np
import pytest

import cadet
from cadet import CadetError
from cadet._util import style
from cadet.figures import sheet
from synthetic import make_frame


def decoded(data: bytes) -> np.ndarray:
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    return image[:, :, ::-1]


def test_a_frame_draws_itself_with_its_boxes_and_its_scan() -> None:
    frame, bare = make_frame(), make_frame(labels=(), points_velo=np.zeros((0, 4), np.float32))
    drawn, without = frame.draw(), bare.draw()
    assert drawn.shape[1] == 1600 and drawn.dtype == np.uint8 and drawn.shape == without.shape
    # The image's boxes lie in the left upper part, the returns below them, the scan from above to the right.
    is_other = (drawn != without).any(axis=2)
    height = drawn.shape[0]
    for part in (is_other[: height // 2, :900], is_other[height // 2 :, :900], is_other[:, 960:]):
        assert part.sum() > 500
    is_car = is_other & (np.abs(drawn - np.array(style.CLASS_COLORS["Car"], float)) < 40).all(axis=2)
    assert is_car[: height // 2, :900].sum() > 50 and is_car[:, 960:].sum() > 50


def test_a_notebook_shows_the_drawing() -> None:
    frame = make_frame()
    np.testing.assert_array_equal(decoded(frame._repr_png_()), frame.draw())
    assert frame.draw(400).shape[1] == 400
    with pytest.raises(CadetError, match=r"^width: expected a whole number from 200 to 16384, got 10$"):
        frame.draw(10)


def test_a_frame_or_several_are_written_where_a_path_says(tmp_path: Path) -> None:
    frame = make_frame()
    path = cadet.view(frame, tmp_path / "one.png")
    assert path == tmp_path / "one.png"
    np.testing.assert_array_equal(decoded(path.read_bytes()), sheet(frame))
    rows = decoded(cadet.view([frame, frame], tmp_path / "two.png").read_bytes())
    assert (rows[20 : 20 + len(frame.draw())] == frame.draw()).all()
    assert rows.shape[0] == 2 * len(frame.draw()) + 3 * 20
    with pytest.raises(CadetError, match="expected a name that ends in"):
        cadet.view(frame, tmp_path / "one.tiff")
    with pytest.raises(CadetError, match=r"^frame: expected a Frame, got 'out'"):
        cadet.view(cast(Any, "out"), tmp_path / "one.png")


def test_without_a_path_the_systems_viewer_opens(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    path = cadet.view(make_frame())
    assert opened == [path.as_uri()] and decoded(path.read_bytes()).shape[1] == 1920
    path.unlink()
    path.parent.rmdir()
