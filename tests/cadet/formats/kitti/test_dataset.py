from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cadet.errors import CadetError, FrameExistsError, KittiFormatError, MissingFileError, NonFiniteError, ShapeError
from cadet.formats.kitti import Dataset, ImageSet, read_calib, read_frame, read_labels, write_frame, write_image_set
from cadet.formats.kitti.files import images
from cadet.formats.kitti.frame import Frame
from synthetic import make_frame


def all_files(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


def test_a_frame_comes_back_whole(tmp_path: Path) -> None:
    frame = make_frame(has_maps=True)
    write_frame(tmp_path, 12, frame)
    back = read_frame(tmp_path, "000012")
    assert np.array_equal(back.image, frame.image)
    assert back.points_velo.tobytes() == frame.points_velo.tobytes()
    assert back.calib == frame.calib
    assert back.plane is not None
    assert frame.plane is not None
    assert back.plane.tobytes() == frame.plane.tobytes()
    assert back.meta == frame.meta
    for read, written in ((back.instance, frame.instance), (back.semantic, frame.semantic)):
        assert read is not None
        assert written is not None
        assert np.array_equal(read, written)
    assert back.depth is not None
    assert frame.depth is not None
    assert np.array_equal(np.isinf(back.depth), np.isinf(frame.depth))
    is_stored = frame.depth < 255
    assert is_stored.sum() > 10_000
    assert np.abs(back.depth[is_stored] - frame.depth[is_stored]).max() <= 0.5 / 256
    assert [label.to_line() for label in back.labels] == [label.to_line() for label in frame.labels]
    assert back.labels[-1] == frame.labels[-1]


def test_files_lie_where_kitti_has_them(tmp_path: Path) -> None:
    write_frame(tmp_path, "000012", make_frame(has_maps=True), split=None)
    assert sorted(all_files(tmp_path)) == [
        f"training/{name}"
        for name in (
            "calib/000012.txt",
            "depth/000012.png",
            "image_2/000012.png",
            "instance/000012.png",
            "label_2/000012.txt",
            "meta/000012.json",
            "planes/000012.txt",
            "semantic/000012.png",
            "velodyne/000012.bin",
        )
    ]


def test_what_was_not_written_is_none(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(plane=None, meta=None, labels=()))
    frame = read_frame(tmp_path, 0)
    assert (frame.plane, frame.depth, frame.instance, frame.semantic, frame.meta) == (None, None, None, None, None)
    assert frame.labels == ()


def test_the_folder_of_the_samples_itself_is_a_root_and_labels_may_be_missing_altogether(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame())
    assert len(read_frame(tmp_path / "training", 0).labels) == 4
    (tmp_path / "training" / "label_2" / "000000.txt").unlink()
    with pytest.raises(MissingFileError, match=r"label_2/000000\.txt: no such file$"):
        read_frame(tmp_path, 0)
    (tmp_path / "training" / "label_2").rmdir()
    assert read_frame(tmp_path, 0).labels == ()


def test_what_kitti_lacks_is_not_read_where_it_is_not_wanted(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(has_maps=True))
    for kind in ("depth", "instance", "semantic"):
        (tmp_path / "training" / kind / "000000.png").write_bytes(b"no image")
    (tmp_path / "training" / "meta" / "000000.json").write_bytes(b"no JSON")
    frame, whole = read_frame(tmp_path, 0, has_extras=False), make_frame()
    assert (frame.depth, frame.instance, frame.semantic, frame.meta) == (None, None, None, None)
    np.testing.assert_array_equal(frame.image, whole.image)
    np.testing.assert_array_equal(frame.points_velo, whole.points_velo)
    assert frame.labels and frame.plane is not None
    with pytest.raises(CadetError):
        read_frame(tmp_path, 0)
    with pytest.raises(CadetError, match="has_extras: expected True or False, got 1"):
        read_frame(tmp_path, 0, has_extras=1)  # type: ignore[arg-type]


def test_a_frame_is_not_overwritten_unasked(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame(has_maps=True))
    before = all_files(tmp_path)
    with pytest.raises(FrameExistsError, match=r"frame 000000 exists; pass overwrite=True to replace it$"):
        write_frame(tmp_path, 0, make_frame(labels=()))
    assert all_files(tmp_path) == before
    write_frame(tmp_path, 0, make_frame(labels=()), overwrite=True)
    assert read_frame(tmp_path, 0).labels == ()
    assert read_frame(tmp_path, 0).depth is None


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    encode_png, counter = images.encode_png, itertools.count()

    def fail_at_the_second(image: NDArray[Any]) -> bytes:
        if next(counter):
            raise CadetError("no room")
        return encode_png(image)

    with monkeypatch.context() as patched:
        patched.setattr(images, "encode_png", fail_at_the_second)
        with pytest.raises(CadetError, match="no room"):
            write_frame(tmp_path, 0, make_frame(has_maps=True))
    with pytest.raises(CadetError, match=r"^meta: invalid JSON: "):
        write_frame(tmp_path, 0, make_frame(meta={"speed": float("nan")}))
    assert all_files(tmp_path) == {}


def test_a_full_disk_leaves_the_old_frame(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_frame(tmp_path, 0, make_frame())
    before = all_files(tmp_path)
    write_bytes = Path.write_bytes

    def fail_for_labels(path: Path, data: bytes) -> int:
        if "label_2" in str(path):
            write_bytes(path, data[:10])
            raise OSError(28, "No space left on device")
        return write_bytes(path, data)

    monkeypatch.setattr(Path, "write_bytes", fail_for_labels)
    with pytest.raises(OSError, match="No space left"):
        write_frame(tmp_path, 0, make_frame(labels=()), overwrite=True)
    assert all_files(tmp_path) == before


def test_same_frame_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_frame(tmp_path / name, 0, make_frame(has_maps=True))
    assert all_files(tmp_path / "a") == all_files(tmp_path / "b")


def test_a_dataset_lists_indexes_and_iterates(tmp_path: Path) -> None:
    for frame_id in (3, 1, 20):
        write_frame(tmp_path, frame_id, make_frame(meta={"sample": frame_id}), split=None)
    write_image_set(tmp_path, "val", ImageSet(("000020", "000001")))
    every, val = Dataset(tmp_path), Dataset(tmp_path, split="val")
    assert (len(every), len(val)) == (3, 2)
    assert every.ids == ("000001", "000003", "000020")
    assert [frame.meta for frame in val] == [{"sample": 20}, {"sample": 1}]
    assert val[1].meta == val["000001"].meta == every[-3].meta == {"sample": 1}
    with pytest.raises(KeyError):
        val["000003"]
    with pytest.raises(IndexError):
        val[2]
    with pytest.raises(MissingFileError, match=r"train\.txt: no such split$"):
        Dataset(tmp_path, "train")


def test_what_is_no_kitti_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MissingFileError, match=r"no KITTI folder: it is empty; expected training/image_2, "):
        Dataset(tmp_path)


@pytest.mark.parametrize(
    "frame_id", ["", ".", "..", ".hidden", "a/b", " a", "a\n", "a\x07", "\ud800", "x" * 201, True, None, -1, 1_000_000]
)
def test_what_is_no_id_is_refused(tmp_path: Path, frame_id: Any) -> None:
    with pytest.raises(CadetError, match=r"^frame id: expected the name of a frame's files without suffix, such as "):
        write_frame(tmp_path, frame_id, make_frame())


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("image_2/000000.png", b"no", "image_2/000000.png: no PNG, JPEG or WebP image (2 bytes); save it as PNG"),
        (
            "velodyne/000000.bin",
            bytes(17),
            "velodyne/000000.bin: truncated: 17 bytes are 1 points and 1 bytes: copy the file again",
        ),
        ("label_2/000000.txt", b"Car 0\n", "label_2/000000.txt:1: expected 15 fields, got 2"),
        ("label_2/000000.txt", b"Car 0\xff\n", "label_2/000000.txt:1: byte 0xff is not ASCII"),
        ("calib/000000.txt", b"", "calib/000000.txt: missing key 'P2'"),
        ("planes/000000.txt", b"", "planes/000000.txt: expected 4 lines, the last a b c d"),
        ("meta/000000.json", b"{\n,", "meta/000000.json:2: invalid JSON: Expecting property name enclosed in"),
        ("meta/000000.json", b'{"a": NaN}', "meta/000000.json: invalid JSON: NaN is not a number"),
        ("meta/000000.json", b"[" * 100_000, "meta/000000.json: invalid JSON: "),
        ("meta/000000.json", b"[]", "meta/000000.json:1: expected a JSON object, got list"),
        (
            "depth/000000.png",
            images.encode_png(np.zeros((2, 3), np.uint16)),
            "depth/000000.png: 3 x 2 pixels, the image has 620 x 190",
        ),
    ],
)
def test_a_damaged_file_is_named_with_its_line_and_the_reason(
    tmp_path: Path, name: str, data: bytes, message: str
) -> None:
    write_frame(tmp_path, 0, make_frame(has_maps=True))
    (tmp_path / "training" / name).write_bytes(data)
    with pytest.raises(KittiFormatError) as caught:
        read_frame(tmp_path, 0)
    assert str(caught.value).startswith(message)


def test_labels_can_be_read_alone(tmp_path: Path) -> None:
    write_frame(tmp_path, 0, make_frame())
    labels = read_labels(tmp_path, 0)
    assert [label.type for label in labels] == ["Car", "Car", "Pedestrian", "DontCare"]
    file = tmp_path / "training" / "label_2" / "000000.txt"
    assert read_labels(file) == labels and read_labels(str(file)) == labels
    assert read_calib(tmp_path / "training" / "calib" / "000000.txt") == read_calib(tmp_path, 0)
    with pytest.raises(MissingFileError, match="a folder: name a file of label_2, or say which frame"):
        read_labels(tmp_path)
    with pytest.raises(MissingFileError, match=r"000009\.txt: no such file"):
        read_labels(file.with_name("000009.txt"))
    file.write_text("Car 0 0\n")
    with pytest.raises(KittiFormatError, match=r"^label_2/000000\.txt:1: expected 15 fields, got 3"):
        read_labels(file)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"image": np.zeros((4, 4), np.uint8)}, ShapeError, "image: expected (H, W, 3) uint8, got (4, 4) uint8"),
        (
            {"points_velo": np.zeros((3, 4))},
            ShapeError,
            "points_velo: expected (N, 4) float32, got (3, 4) float64; convert with .astype(np.float32)",
        ),
        ({"points_velo": np.full((3, 4), np.nan, np.float32)}, NonFiniteError, "points_velo: not finite at [0, 0]"),
        ({"depth": np.zeros((2, 2), np.float32)}, ShapeError, "depth: expected (190, 620) float32, got (2, 2) float32"),
        ({"depth": np.full((190, 620), np.nan, np.float32)}, NonFiniteError, "depth: not finite at [0, 0]"),
        ({"plane": np.zeros(3)}, ShapeError, "plane: expected (4,) float64, got (3,) float64"),
        ({"labels": []}, ShapeError, "labels: expected a tuple of Label, got list"),
    ],
)
def test_a_frame_cannot_hold_what_is_wrong(changes: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error) as caught:
        make_frame(**changes)
    assert str(caught.value) == message


def test_frames_are_frozen() -> None:
    frame: Any = make_frame()
    with pytest.raises(AttributeError):
        frame.labels = ()
    assert isinstance(frame, Frame)
    assert frame.image_size == (620, 190)
