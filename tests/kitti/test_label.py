from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadet.errors import CadetError, KittiFormatError, NonFiniteError, ShapeError
from cadet.kitti import TYPES, Label, labels_from_text, text_from_labels

CAR = "Car 0.00 0 1.85 387.63 181.54 423.81 203.12 1.67 1.87 3.69 -16.53 2.39 58.49 1.57"
DONT_CARE = "DontCare -1 -1 -10 503.89 169.71 590.61 190.13 -1 -1 -1 -1000 -1000 -1000 -10"


def cents(low: float, high: float) -> st.SearchStrategy[float]:
    return st.integers(round(low * 100), round(high * 100)).map(lambda n: n / 100)


labels = st.builds(
    Label,
    type=st.sampled_from(TYPES),
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
    assert Label.from_line(label.to_line()) == label


@given(st.lists(labels))
def test_text_comes_back_from_the_labels_it_gave(many: list[Label]) -> None:
    text = text_from_labels(many)
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


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (CAR.rsplit(" ", 1)[0], "000123.txt:4: expected 15 fields, got 14"),
        (f"{CAR} 0.5 0.5", "000123.txt:4: expected 15 fields, got 17"),
        ("", "000123.txt:4: expected 15 fields, got 0"),
        (CAR.replace("58.49", "nan"), "000123.txt:4: z: expected a finite number, got 'nan'"),
        (CAR.replace("1.85", "-inf"), "000123.txt:4: alpha: expected a finite number, got '-inf'"),
        (CAR.replace("1.67", "1,67"), "000123.txt:4: height: expected a number, got '1,67'"),
        (CAR.replace("1.67", "1_67"), "000123.txt:4: height: expected a number, got '1_67'"),
        (f"{CAR} high", "000123.txt:4: score: expected a number, got 'high'"),
        (CAR.replace("0.00 0 ", "0.00 0.5 "), "000123.txt:4: occluded: expected a whole number, got '0.5'"),
        (CAR.replace("0.00 0 ", "0.00 4 "), "000123.txt:4: occluded: expected a whole number -1..3, got 4"),
        (
            CAR.replace("Car", "car"),
            "000123.txt:4: unknown type 'car', expected one of Car, Van, Truck, Pedestrian, Person_sitting, Cyclist, "
            "Tram, Misc, DontCare",
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


def test_a_blank_line_inside_a_file_is_an_error_with_its_number() -> None:
    with pytest.raises(KittiFormatError, match=r"^a\.txt:2: expected 15 fields, got 0$"):
        labels_from_text(f"{CAR}\n\n{CAR}\n", "a.txt")


def test_an_empty_file_has_no_labels() -> None:
    assert labels_from_text("") == ()


def test_labels_cannot_hold_what_a_file_cannot() -> None:
    with pytest.raises(NonFiniteError, match=r"^rotation_y: not finite: nan$"):
        Label("Car", 0, 0, 0, (0, 0, 1, 1), (1, 1, 1), (0, 0, 5), math.nan)
    with pytest.raises(ShapeError, match=r"^bbox: expected 4 numbers, got 3$"):
        Label("Car", 0, 0, 0, (0, 0, 1), (1, 1, 1), (0, 0, 5), 0.0)  # type: ignore[arg-type]
