from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadet.errors import CadetError, KittiFormatError, NonFiniteError, ShapeError
from cadet.formats.kitti import TYPES, Label, labels_from_text, text_from_labels
from cadet.formats.kitti.files.dialects import collected

CAR = "Car 0.00 0 1.85 387.63 181.54 423.81 203.12 1.67 1.87 3.69 -16.53 2.39 58.49 1.57"
DONT_CARE = "DontCare -1 -1 -10 503.89 169.71 590.61 190.13 -1 -1 -1 -1000 -1000 -1000 -10"


def cents(low: float, high: float) -> st.SearchStrategy[float]:
    return st.integers(round(low * 100), round(high * 100)).map(lambda n: n / 100)


labels = st.builds(
    Label,
    type=st.sampled_from((*TYPES, "Bus", "vehicle.car")),
    truncated=st.just(-1.0) | cents(0, 1),
    occluded=st.integers(-1, 3),
    alpha=st.just(-10.0) | cents(-3.14, 3.14),
    bbox=st.tuples(*[cents(-50, 1300)] * 4),
    dimensions_hwl=st.tuples(*[st.just(-1.0) | cents(0, 20)] * 3),
    location_cam=st.tuples(*[st.just(-1000.0) | cents(-100, 100)] * 3),
    rotation_y=st.just(-10.0) | cents(-3.14, 3.14),
    score=st.none() | st.floats(-1e3, 1e3, allow_subnormal=False),
)


@given(labels)
def test_a_label_of_two_decimals_comes_back_from_its_line(label: Label) -> None:
    with collected():
        assert Label.from_line(label.to_line()) == label


@given(st.lists(labels))
def test_text_comes_back_from_the_labels_it_gave(many: list[Label]) -> None:
    text = text_from_labels(many)
    with collected():
        assert text_from_labels(labels_from_text(text)) == text


@pytest.mark.parametrize(
    "line", [CAR, DONT_CARE, f"{CAR} 0.9731", f"{CAR} 1.00", CAR.replace("1.85", "-0.00"), CAR.replace("0.00", "-1")]
)
def test_lines_keep_every_character(line: str) -> None:
    assert Label.from_line(line).to_line() == line


def test_fields_land_where_kitti_documents_them() -> None:
    label = Label.from_line(f"{CAR} 0.5")
    assert label == Label(
        type="Car",
        truncated=0.0,
        occluded=0,
        alpha=1.85,
        bbox=(387.63, 181.54, 423.81, 203.12),
        dimensions_hwl=(1.67, 1.87, 3.69),
        location_cam=(-16.53, 2.39, 58.49),
        rotation_y=1.57,
        score=0.5,
    )
    assert label.box_cam.tolist() == [-16.53, 2.39, 58.49, 3.69, 1.87, 1.67, 1.57]


LAYOUT = "type truncated occluded alpha, left top right bottom, height width length, x y z, rotation_y"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (CAR.rsplit(" ", 1)[0], f"000123.txt:4: expected 15 fields, got 14: {LAYOUT}"),
        (CAR.replace(" ", ","), f"000123.txt:4: expected 15 fields, got 1: {LAYOUT}"),
        ("", f"000123.txt:4: expected 15 fields, got 0: {LAYOUT}"),
        (CAR.replace("58.49", "nan"), "000123.txt:4: z: expected a finite number, got 'nan'"),
        (CAR.replace("1.85", "-inf"), "000123.txt:4: alpha: expected a finite number, got '-inf'"),
        (CAR.replace("1.67", "1,67"), "000123.txt:4: height: expected a number, got '1,67'"),
        (CAR.replace("1.67", "1_67"), "000123.txt:4: height: expected a number, got '1_67'"),
        (f"{CAR} nan", "000123.txt:4: score: expected a finite number, got 'nan'"),
        (CAR.replace("0.00 0 ", "0.00 0.5 "), "000123.txt:4: occluded: expected a whole number, got '0.5'"),
        (CAR.replace("0.00 0 ", "0.00 4 "), "000123.txt:4: occluded: expected a whole number -1..3, got 4"),
        (
            f"0 17 {CAR}",
            "000123.txt:4: type: expected a name, got '0'; a line of KITTI's tracking labels? Leave out its first two "
            "fields, and give each frame a file",
        ),
    ],
)
def test_a_malformed_line_is_named_with_file_line_and_reason(line: str, message: str) -> None:
    with pytest.raises(KittiFormatError) as caught:
        Label.from_line(line, "000123.txt", 4)
    assert str(caught.value) == message
    assert (caught.value.file, caught.value.line) == ("000123.txt", 4)
    assert isinstance(caught.value, CadetError)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("name", ["1.5", "nan", "-Infinity", "#Car", "b'Car'", "Auto\u00e4", "<b>", "x" * 65, ".", ""])
def test_what_is_no_name_is_no_type(name: str) -> None:
    with pytest.raises(KittiFormatError, match=r"^type: expected a name such as Car, of letters, digits and _\.:/"):
        Label.in_image(name, (0, 0, 1, 1))


@pytest.mark.parametrize(
    ("line", "expected", "messages"),
    [
        (CAR.replace("Car", "car"), CAR, ["type car is read as Car"]),
        (CAR.replace("Car", "PERSON_SITTING"), CAR.replace("Car", "Person_sitting"), ["type PERSON"]),
        *(
            (CAR.replace("Car", name), CAR.replace("Car", name), [f"type {name} is not one of KITTI's"])
            for name in ("Trafficcone", "motorcycle", "vehicle.car", "Car/Van", "2wheeler", "traffic-light", "Man(x)")
        ),
        (CAR.replace("0.00 0 ", "0.00 0.0 "), CAR, ["occluded 0.0 is read as 0"]),
        (f"{CAR} 436 2018_03_07 0002", CAR, ["fields past the 15th are ignored"]),
        (f"{CAR} a1-b2", CAR, ["fields past the 15th are ignored"]),
        (f"{CAR} 7 3", CAR, ["fields past the 15th are ignored"]),
        (f"{CAR} 0.00", f"{CAR} 0.00", []),
        (f"\t{CAR}  ".replace(" ", "\t "), CAR, []),
    ],
)  # fmt: skip
def test_dialects_are_read_and_said_once_a_file(line: str, expected: str, messages: list[str]) -> None:
    with collected() as found:
        read = labels_from_text(f"{line}\n" * 3, "a.txt")
    assert text_from_labels(read) == f"{expected}\n" * 3
    assert [(one.file, one.line) for one in found] == [("a.txt", 1)] * len(messages)
    assert all(one.message.startswith(message) for one, message in zip(found, messages, strict=True))


def test_kittis_types_are_spelled_as_kitti_does() -> None:
    assert Label.in_image("dontcare", (0, 0, 1, 1)) == Label.in_image("DontCare", (0, 0, 1, 1))
    assert Label.in_image("bus", (0, 0, 1, 1)).type == "bus"


def test_blank_lines_and_ends_of_any_kind_are_passed_over() -> None:
    expected = labels_from_text(f"{CAR}\n{DONT_CARE}\n")
    for text in (
        f"\ufeff{CAR}\n{DONT_CARE}",
        f"\n \t\n{CAR}\n\n{DONT_CARE}\n\n",
        f"{CAR}\r\n{DONT_CARE}\r\n",
        f"{CAR}\r{DONT_CARE}\r",
    ):
        assert labels_from_text(text) == expected
    with pytest.raises(KittiFormatError, match=r"^a\.txt:3: expected 15 fields, got 1"):
        labels_from_text(f"{CAR}\n\nCar\n", "a.txt")


@pytest.mark.parametrize("given", [None, b"Car", 5, [CAR]])
def test_only_text_is_parsed_and_only_labels_are_written(given: Any) -> None:
    for parse in (labels_from_text, Label.from_line):
        with pytest.raises(CadetError, match=r"^(text|line): expected a string, got "):
            parse(given)
    with pytest.raises(CadetError, match=r"^labels: expected a Label, got "):
        text_from_labels([given])


def test_an_empty_file_has_no_labels() -> None:
    assert labels_from_text("") == ()


def test_labels_cannot_hold_what_a_file_cannot() -> None:
    with pytest.raises(NonFiniteError, match=r"^rotation_y: not finite: nan$"):
        Label("Car", 0, 0, 0, (0, 0, 1, 1), (1, 1, 1), (0, 0, 5), math.nan)
    with pytest.raises(ShapeError, match=r"^bbox: expected 4 numbers, got 3$"):
        Label("Car", 0, 0, 0, (0, 0, 1), (1, 1, 1), (0, 0, 5), 0.0)  # type: ignore[arg-type]
