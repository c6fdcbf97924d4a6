"""Films of detections in a raw drive."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result

from avod.cli.commands import avod
from cadet.errors import CadetError
from raw_drives import write_raw_drive
from synthetic import make_frame


def call(*arguments: object) -> Result:
    result = CliRunner().invoke(avod, [str(argument) for argument in arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result


def test_a_raw_drive_becomes_a_film_whole_or_not_at_all(tmp_path: Path) -> None:
    frame = make_frame(labels=())
    drive, film = write_raw_drive(tmp_path, [frame] * 3), tmp_path / "film.mp4"
    arguments = ("predict", "--data", drive, "--video", film, "--hz", 5, "--workers", 0)
    assert f"in 3 frames in {film}" in call(*arguments).output
    video = cv2.VideoCapture(str(film))
    assert (video.get(cv2.CAP_PROP_FRAME_COUNT), video.get(cv2.CAP_PROP_FPS)) == (3, 5)
    is_read, picture = video.read()
    height, width = frame.image.shape[:2]
    assert is_read and picture.shape == (height, width + height, 3)
    # Far from boxes the image is as it was, but for the film's compression.
    assert np.abs(picture[:40, :width].astype(int) - frame.image[:40, :, ::-1]).mean() < 25.0
    film.unlink()
    scan = drive / "velodyne_points" / "data" / "0000000001.bin"
    scan.write_bytes(b"?")
    with pytest.raises(CadetError, match=r"1 of 3 frames cannot be read \(0000000001: .*they are not in .*film\.mp4"):
        call(*arguments)
    assert film.is_file()
    film.unlink()
    with pytest.raises(CadetError, match="a raw drive has no split 'val': take --split all"):
        call(*arguments, "--split", "val")
    (drive.parent / "calib_cam_to_cam.txt").unlink()
    with pytest.raises(CadetError, match=r"calib_cam_to_cam\.txt: no such file"):
        call(*arguments)
    assert not list(tmp_path.glob("*.mp4"))
