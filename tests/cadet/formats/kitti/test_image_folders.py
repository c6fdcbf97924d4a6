"""Folders whose camera images other programs wrote: every command reads them, or says which image it can't read."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

import image_bytes as made
from cadet import kitti
from cadet._util import notices
from cadet.cli.tools import cadet as command
from cadet.errors import CadetError, CadetWarning, MissingFileError
from cadet.formats.convert import convert
from cadet.formats.kitti.lint import lint
from cadet.formats.webdataset import open_dataset
from gen_process import tree
from synthetic import make_frame

Encode = Callable[[NDArray[np.uint8]], bytes]


def jpeg(image: NDArray[np.uint8]) -> bytes:
    done, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98])
    assert done
    return data.tobytes()


def rgba(image: NDArray[np.uint8]) -> bytes:
    return made.png(np.dstack([image, np.full(image.shape[:2], 255, np.uint8)]), made.RGBA)


def gray(image: NDArray[np.uint8]) -> bytes:
    return made.png(image[..., 1:2], made.GRAY)


FOLDERS: dict[str, tuple[str, Encode, list[str]]] = {
    "nuScenes' and Waymo's .jpg": (".jpg", jpeg, [".jpg is read where KITTI has .png"]),
    ".jpeg": (".jpeg", jpeg, [".jpeg is read where KITTI has .png"]),
    ".JPG of a camera": (".JPG", jpeg, [".JPG is read where KITTI has .png"]),
    ".jpg that was renamed": (".png", jpeg, ["is JPEG, whatever its name says"]),
    "RGBA of matplotlib": (".png", rgba, ["RGBA whose opacity is 255 everywhere is read as RGB"]),
    "gray": (".png", gray, ["a gray image is read as RGB of three equal channels"]),
}


def folder_of(root: Path, suffix: str, encode: Encode) -> Path:
    """Write two frames whose images differ in size from each other, as those of several cameras do."""
    for number in range(2):
        kitti.write_frame(root, number, make_frame(seed=number))
        path = root / "training" / "image_2" / f"{number:06d}.png"
        image = kitti.read_frame(root, number).image
        path.unlink()
        path.with_suffix(suffix).write_bytes(encode(image if number == 0 else image[:-2, :-8]))
    return root


def run(*arguments: object) -> str:
    done = CliRunner().invoke(command, [str(one) for one in arguments], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.parametrize("name", FOLDERS)
@pytest.mark.filterwarnings("ignore::cadet.errors.CadetWarning")
def test_every_command_reads_the_images_and_check_says_what_they_are(name: str, tmp_path: Path) -> None:
    suffix, encode, messages = FOLDERS[name]
    root = folder_of(tmp_path / "set", suffix, encode)
    found = [one for one in lint(root) if one.rule in ("dialect", "missing-file", "damaged-file", "stray-file")]
    assert [one.message for one in found if one.frame_id == "000000"] == messages
    assert all(one.rule == "dialect" and one.file.endswith(suffix) for one in found)
    image, expected = kitti.read_frame(root, 0).image, make_frame(seed=0).image
    expected = expected[..., 1:2].repeat(3, axis=2) if name == "gray" else expected
    assert np.abs(image.astype(int) - expected).mean() < 5.0
    assert kitti.Dataset(root)[1].image.shape == (188, 612, 3)
    run("view", root / "000001", "-o", tmp_path / "a.png")
    run("bank", root, "-o", tmp_path / "bank", "--split", "train")
    run("report", root, "-o", tmp_path / "r.html", "--workers", "1")
    # A conversion keeps every byte and each file's suffix.
    convert(root, tmp_path / "shards", "webdataset")
    np.testing.assert_array_equal(open_dataset(tmp_path / "shards", "train")["000000"].image, image)
    assert convert(tmp_path / "shards", tmp_path / "back", "kitti").left_out == ()
    assert tree(tmp_path / "back" / "training") == tree(root / "training")


def test_a_set_of_others_warns_once_of_each_kind_outside_of_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(notices, "_said", set())
    root = folder_of(tmp_path, ".jpg", jpeg)
    with pytest.warns(CadetWarning) as warned:
        assert len(list(kitti.Dataset(root))) == 2
    assert [str(one.message) for one in warned] == ["image_2/000000.jpg: .jpg is read where KITTI has .png"]


@pytest.mark.parametrize("data", [b"", jpeg(make_frame().image)[:-3000], made.PNG_START + made.header(2**15, 2**15)])
def test_an_image_that_cannot_be_read_is_one_finding_and_stops_no_report(data: bytes, tmp_path: Path) -> None:
    for number in range(3):
        kitti.write_frame(tmp_path / "set", number, make_frame(seed=number))
    path = tmp_path / "set" / "training" / "image_2" / "000001.png"
    path.write_bytes(data)
    found = [one for one in lint(tmp_path / "set") if one.severity == "error"]
    assert [(one.file, one.rule) for one in found] == [("image_2/000001.png", "damaged-file")]
    with pytest.warns(CadetWarning, match=r"1 of 3 frames cannot be read \(000001: image_2/000001\.png: "):
        run("report", tmp_path / "set", "-o", tmp_path / "r.html", "--workers", "1")
    page = (tmp_path / "r.html").read_text()
    assert page.count('aria-label="Frame ') == 2


def test_what_lies_in_an_images_place_is_named(tmp_path: Path) -> None:
    kitti.write_frame(tmp_path, 0, make_frame())
    path = tmp_path / "training" / "image_2" / "000000.png"
    path.rename(path.with_suffix(".bmp"))
    said = r"000000\.png: no such file; 000000\.bmp is there: save it as 000000\.png$"
    with pytest.raises(MissingFileError, match=said):
        kitti.read_frame(tmp_path, 0)
    os.mkfifo(path.with_suffix(".jpg"))
    with pytest.raises(CadetError, match=r"^image_2/000000\.jpg: not a regular file$"):
        kitti.read_frame(tmp_path, 0)


def test_png_is_read_where_both_are_and_check_says_so(tmp_path: Path) -> None:
    frame = make_frame()
    kitti.write_frame(tmp_path, 0, frame)
    path = tmp_path / "training" / "image_2" / "000000.jpg"
    path.write_bytes(jpeg(frame.image[:4]))
    np.testing.assert_array_equal(kitti.read_frame(tmp_path, 0).image, frame.image)
    found = [(one.file, one.rule, one.message) for one in lint(tmp_path) if one.rule in ("stray-file", "dialect")]
    assert found == [("image_2/000000.jpg", "stray-file", "not read, since 000000.png is there")]
    # Written anew, a frame has one image.
    path.with_suffix(".png").rename(path)
    kitti.write_frame(tmp_path, 0, frame, overwrite=True)
    assert not path.exists() and path.with_suffix(".png").is_file()


@pytest.mark.filterwarnings("ignore::cadet.errors.CadetWarning")
def test_right_images_are_found_by_the_same_suffixes(tmp_path: Path) -> None:
    frame = make_frame()
    kitti.write_frame(tmp_path, 0, frame)
    right = tmp_path / "training" / "image_3" / "000000.jpg"
    right.parent.mkdir()
    right.write_bytes(jpeg(frame.image))
    assert [one.message for one in lint(tmp_path) if one.file == "image_3/000000.jpg"] == [
        ".jpg is read where KITTI has .png"
    ]
    right.write_bytes(jpeg(frame.image[:-2]))
    assert ("damaged-file", "image_3/000000.jpg") in [(one.rule, one.file) for one in lint(tmp_path)]
