from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from cadet.errors import CadetError, KittiFormatError, NonFiniteError, ShapeError
from cadet.formats.kitti import ImageSet
from cadet.formats.kitti.files import images
from cadet.formats.kitti.files.dialects import collected
from cadet.formats.kitti.files.planes import plane_from_text, text_from_plane
from cadet.formats.kitti.files.velodyne import bytes_from_points, points_from_bytes


@given(arrays(np.float32, st.tuples(st.integers(0, 20), st.just(4)), elements=st.floats(-100, 100, width=32)))
def test_scans_come_back_to_the_last_bit(points_velo: NDArray[np.float32]) -> None:
    data = bytes_from_points(points_velo)
    assert len(data) == 16 * len(points_velo)
    assert points_from_bytes(data).tobytes() == points_velo.tobytes()


def test_a_scan_is_little_endian_and_row_by_row() -> None:
    assert bytes_from_points(np.array([[1.0, 0.0, -2.0, 0.5]], np.float32)).hex() == "0000803f00000000000000c00000003f"
    assert bytes_from_points(np.asfortranarray(np.arange(8, dtype=np.float32).reshape(2, 4)))[16:20].hex() == "00008040"


def test_a_scan_cut_off_is_named() -> None:
    with pytest.raises(KittiFormatError) as caught:
        points_from_bytes(bytes(39), "velodyne/000003.bin")
    assert str(caught.value) == "velodyne/000003.bin: truncated: 39 bytes are 2 points and 7 bytes: copy the file again"


def test_a_scan_with_nan_is_not_written() -> None:
    points_velo = np.zeros((3, 4), np.float32)
    points_velo[2, 1] = np.nan
    with pytest.raises(NonFiniteError, match=r"^points_velo: not finite at \[2, 1\]$"):
        bytes_from_points(points_velo)


@given(arrays(np.float64, 4, elements=st.floats(-1e3, 1e3)))
def test_planes_come_back_to_the_last_bit(plane: NDArray[np.float64]) -> None:
    assert plane_from_text(text_from_plane(plane)).tobytes() == plane.tobytes()


def test_planes_of_either_header_are_read() -> None:
    for header in ("# Matrix\nWIDTH 4\nHEIGHT 1", "# Plane\nWidth 4\nHeight 1"):
        assert plane_from_text(f"{header}\n0.0 -1.0 1e-2 1.65\n").tolist() == [0.0, -1.0, 0.01, 1.65]
    with collected() as found:
        assert plane_from_text("\ufeff\r\n0.0\t-1.0 1e-2 1.65 \r\n\r\n").tolist() == [0.0, -1.0, 0.01, 1.65]
    assert [one.kind for one in found] == ["plane-header"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a\n0 -1 0 1.65\n", "p.txt: expected 4 lines, the last a b c d of the plane, got 2"),
        ("a\nb\nc\n0 -1 0\n", "p.txt:4: expected 4 numbers, got 3"),
        ("a\nb\nc\n0 -1 0 up\n", "p.txt:4: expected a number, got 'up'"),
        ("a\nb\nc\n0 -1 0 inf\n", "p.txt:4: expected a finite number, got 'inf'"),
    ],
)
def test_a_malformed_plane_is_named(text: str, message: str) -> None:
    with pytest.raises(KittiFormatError) as caught:
        plane_from_text(text, "p.txt")
    assert str(caught.value) == message


@given(st.lists(st.integers(0, 999_999), unique=True), st.booleans())
def test_lists_come_back(numbers: list[int], ends_with_newline: bool) -> None:
    ids = tuple(f"{number:06d}" for number in numbers)
    text = ImageSet(ids, ends_with_newline).to_text()
    assert ImageSet.from_text(text).ids == ids
    assert ImageSet.from_text(text).to_text() == text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("000001\n.hidden\n", "train.txt:2: expected a frame's id such as 000012, got '.hidden'"),
        ("000001\na\x07\n", "train.txt:2: expected a frame's id such as 000012, got 'a\\x07'"),
        ("000001\n000002\n000001", "train.txt:3: id 000001 appears twice"),
    ],
)
def test_a_malformed_list_is_named(text: str, message: str) -> None:
    with pytest.raises(KittiFormatError) as caught:
        ImageSet.from_text(text, "train.txt")
    assert str(caught.value) == message


def test_images_keep_every_pixel_and_the_order_of_colors() -> None:
    image = np.random.default_rng(0).integers(0, 256, (7, 5, 3)).astype(np.uint8)
    image[0, 0] = [255, 0, 0]
    data = images.encode_png(image)
    assert data.startswith(b"\x89PNG")
    assert np.array_equal(images.decode_image(data), image)


@given(arrays(np.float32, (3, 4), elements=st.floats(0, 250, width=32) | st.just(np.inf)))
def test_depth_comes_back_to_half_a_step(depth: NDArray[np.float32]) -> None:
    back = images.depth_from_pixels(images.pixels_from_depth(depth))
    is_sky = np.isinf(depth)
    assert np.array_equal(np.isinf(back), is_sky)
    # The smallest step stands for zero, too, as zero itself means sky.
    assert np.abs(back[~is_sky] - depth[~is_sky]).max(initial=0.0) <= 1.0 / 256.0
    is_usual = ~is_sky & (depth > 0.01)
    assert np.abs(back[is_usual] - depth[is_usual]).max(initial=0.0) <= 0.5 / 256.0


def test_depth_beyond_the_format_is_written_as_its_largest() -> None:
    pixels = images.pixels_from_depth(np.array([[300.0, 255.99, 1.0, np.inf]], np.float32))
    assert pixels.tolist() == [[65535, 65533, 256, 0]]


@given(arrays(np.int32, (2, 3), elements=st.integers(-1, 65534)))
def test_instances_come_back(instance: NDArray[np.int32]) -> None:
    data = images.encode_png(images.pixels_from_instance(instance))
    assert np.array_equal(images.instance_from_pixels(images.decode_map(data, "i.png", np.uint16)), instance)


@pytest.mark.parametrize("actor_id", [-2, 65535])
def test_instances_beyond_the_format_are_refused(actor_id: int) -> None:
    with pytest.raises(CadetError, match=r"^instance: expected ids -1\.\.65534, got "):
        images.pixels_from_instance(np.array([[actor_id, 0]], np.int32))


def test_what_is_no_image_is_not_encoded() -> None:
    with pytest.raises(ShapeError, match=r"^image: expected \(H, W, 3\) uint8, got \(2, 3, 3\) float64; convert with"):
        images.encode_png(np.zeros((2, 3, 3)))
    with pytest.raises(ShapeError, match=r"^image: no pixels: \(0, 3\)$"):
        images.encode_png(np.zeros((0, 3), np.uint8))
    with pytest.raises(ShapeError, match=r"^image: 32768 x 2049 pixels, at most 67108864 are read again$"):
        images.encode_png(np.broadcast_to(np.uint8(0), (2049, 32768)))
