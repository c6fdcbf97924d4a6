"""Checks of the arrays that users hand in: exact dtype, shape, finite; and their .npy files."""

from __future__ import annotations

import io
import warnings
from tokenize import TokenError
from typing import Any, Final

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cadet.errors import FileFormatError, NonFiniteError, ShapeError

_WIDEST = 8
"""Bytes: the core computes in double precision."""
_NO_ARRAY: Final = (
    *(ValueError, EOFError, TypeError, SyntaxError, OverflowError, MemoryError, RecursionError, KeyError),
    *(AttributeError, TokenError),
)
"""What NumPy raises, which reads a header as Python's text."""


def check_array(
    array: object,
    name: str,
    shape: tuple[int | str, ...],
    dtype: DTypeLike | None = None,
    *,
    finite: bool = False,
) -> NDArray[Any]:
    """Return `array` unchanged if it is an array of this shape and dtype.

    Args:
        array: what the user gave.
        name: its name in messages.
        shape: sizes; a letter stands for any size.
        dtype: the exact dtype; None allows any floating point or integer one of up to 64 bits.
        finite: refuse NaN and infinity.

    Raises:
        ShapeError: no array, a masked array or a matrix, or its shape or dtype differ.
        NonFiniteError: NaN or infinity where `finite` is set.
    """
    wanted = f"({', '.join(str(n) for n in shape)}{',' if len(shape) == 1 else ''})"
    wanted_dtype = "number" if dtype is None else np.dtype(dtype).name
    if not isinstance(array, np.ndarray):
        raise ShapeError(f"{name}: expected an array {wanted} {wanted_dtype}, got {type(array).__name__}")
    if isinstance(array, np.ma.MaskedArray):
        # Reductions pass over what is masked, NaN too.
        raise ShapeError(f"{name}: expected a plain array, got a masked one; fill it with .filled(...)")
    if isinstance(array, np.matrix):
        raise ShapeError(f"{name}: expected a plain array, got a matrix; convert with np.asarray(...)")
    fits = array.ndim == len(shape) and all(
        isinstance(want, str) or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if dtype is None:
        is_wanted = array.dtype.kind in "fiu" and array.dtype.itemsize <= _WIDEST
    else:
        is_wanted = array.dtype == np.dtype(dtype)
    if not fits or not is_wanted:
        hint = "" if is_wanted or dtype is None else f"; convert with .astype(np.{wanted_dtype})"
        raise ShapeError(f"{name}: expected {wanted} {wanted_dtype}, got {array.shape} {array.dtype.name}{hint}")
    if finite and not np.isfinite(array).all():
        index = np.argwhere(~np.isfinite(array))[0]
        where = ", ".join(str(i) for i in index)
        raise NonFiniteError(f"{name}: not finite at [{where}]")
    return array


def as_array(
    values: object,
    name: str,
    shape: tuple[int | str, ...],
    dtype: DTypeLike | None = None,
    *,
    finite: bool = False,
) -> NDArray[Any]:
    """Return an array of numbers unchanged, and a list or tuple as float64.

    Args:
        values: what the user gave. An empty list stands for no rows.
        name: its name in messages.
        shape: sizes; a letter stands for any size.
        dtype: the exact dtype of an array; None allows any that `check_array` does.
        finite: refuse NaN and infinity.

    Raises:
        ShapeError: no numbers, or of another shape.
        NonFiniteError: NaN or infinity where `finite` is set.
    """
    if isinstance(values, (list, tuple)):
        wanted = tuple(0 if isinstance(size, str) else size for size in shape)
        try:
            array = np.array(values, dtype=np.float64) if values else np.empty((0, *wanted[1:]))
        except OverflowError:
            raise NonFiniteError(f"{name}: a number is too large for float64") from None
        except (TypeError, ValueError):
            raise ShapeError(f"{name}: expected numbers in rows of one length, got another kind of list") from None
        return check_array(array, name, shape, finite=finite)
    return check_array(values, name, shape, dtype, finite=finite)


def npy_from_array(array: NDArray[Any]) -> bytes:
    """Return an array in NumPy's .npy format."""
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return file.getvalue()


def array_from_npy(data: bytes, file: str) -> NDArray[Any]:
    """Read an array of NumPy's .npy format.

    Raises:
        FileFormatError: the data are damaged or of another format, or hold Python's objects.
    """
    try:
        # Files of Python 2 are read all the same.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            array: NDArray[Any] = np.load(io.BytesIO(data), allow_pickle=False)
    except _NO_ARRAY as error:
        raise FileFormatError(f"cannot be read as an array: {' '.join(str(error).split())[:200]}", file) from None
    if not isinstance(array, np.ndarray):
        raise FileFormatError("several arrays (.npz), expected one (.npy)", file)
    return array
