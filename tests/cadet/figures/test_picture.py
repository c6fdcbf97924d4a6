"""Pictures are of the kind that their name says, and refused before any work is done."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from cadet.cli import run_cadet
from cadet.errors import CadetError, MissingFileError
from cadet.figures.picture import check_picture_path, write_picture

STARTS = {".png": b"\x89PNG\r\n\x1a\n", ".jpg": b"\xff\xd8\xff", ".jpeg": b"\xff\xd8\xff", ".JPG": b"\xff\xd8\xff"}


@pytest.mark.parametrize("suffix", STARTS)
def test_the_suffix_chooses_the_encoding(tmp_path: Path, suffix: str) -> None:
    image = np.zeros((64, 80, 3), np.uint8)
    image[:, 40:] = (250, 120, 10)
    path = write_picture(tmp_path / f"a{suffix}", image)
    assert path.read_bytes().startswith(STARTS[suffix])
    read = cv2.imread(str(path))
    assert read is not None
    difference = np.abs(read[..., ::-1].astype(int) - image)
    assert difference.max() <= (0 if suffix == ".png" else 60)
    assert difference.mean() <= (0 if suffix == ".png" else 3)
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


def test_what_is_no_picture_is_refused(tmp_path: Path) -> None:
    for name in ("a.gif", "a", "a.png.txt"):
        with pytest.raises(CadetError, match=r"expected a name that ends in \.png, \.jpg, \.jpeg$"):
            check_picture_path(tmp_path / name)
    (tmp_path / "b.png").mkdir()
    with pytest.raises(CadetError, match=r"b\.png: is a folder$"):
        check_picture_path(tmp_path / "b.png")
    with pytest.raises(MissingFileError, match=r"^/nodir/x\.png: no such folder: /nodir$"):
        check_picture_path("/nodir/x.png")
    assert not Path("/nodir").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ["view", "nothing/000000", "-o"],
        ["view", "nothing", "-o"],
        ["view", "nothing/000000", "--bev", "-o"],
        ["eval", "nothing", "nothing", "--plot"],
    ],
)
def test_the_commands_refuse_before_they_read(
    arguments: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["cadet", *arguments, "/nodir/x.png"])
    with pytest.raises(SystemExit) as ended:
        run_cadet()
    assert ended.value.code == 2
    assert capsys.readouterr().err == "cadet: /nodir/x.png: no such folder: /nodir\n"
