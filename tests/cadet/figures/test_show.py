from __future__ import annotations

import webbrowser
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import cv2
import numpy as np
import pytest

import cadet
from cadet import CadetError
from cadet.figures.sheet import sheet
from synthetic import make_frame


def decoded(data: bytes) -> np.ndarray:
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    return image[:, :, ::-1]


def test_a_frame_draws_itself_with_its_boxes_and_its_scan() -> None:
    frame = make_frame()
    drawn, no_points, no_labels = (
        one.draw() for one in (frame, replace(frame, points_velo=frame.points_velo[:0]), replace(frame, labels=()))
    )
    assert drawn.shape[1] == 1600 and drawn.dtype == np.uint8
    # Boxes in the image lie in the left upper part, returns below it, and the scan from above with boxes to the right.
    middle = drawn.shape[0] // 2
    parts = (np.s_[:middle, :900], np.s_[middle:, :900], np.s_[:, 960:])
    num_points, num_boxes = (
        [int((drawn[part] != other[part]).any(axis=2).sum()) for part in parts] for other in (no_points, no_labels)
    )
    assert num_points[0] == 0 and min(num_points[1:]) > 1000
    assert num_boxes[1] == 0 and min(num_boxes[0], num_boxes[2]) > 200


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
