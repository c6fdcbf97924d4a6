"""Checks of the arrays that users hand in: exact dtype, shape, finite."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cadet.errors import NonFiniteError, ShapeError


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
        dtype: the exact dtype; None allows any floating point or integer one.
        finite: refuse NaN and infinity.

    Raises:
        ShapeError: no array, or its shape or dtype differ.
        NonFiniteError: NaN or infinity where `finite` is set.
    """
    wanted = f"({', '.join(str(n) for n in shape)}{',' if len(shape) == 1 else ''})"
    wanted_dtype = "number" if dtype is None else np.dtype(dtype).name
    if not isinstance(array, np.ndarray):
        raise ShapeError(f"{name}: expected an array {wanted} {wanted_dtype}, got {type(array).__name__}")
    fits = array.ndim == len(shape) and all(
        isinstance(want, str) or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    is_wanted = array.dtype.kind in "fiu" if dtype is None else array.dtype == np.dtype(dtype)
    if not fits or not is_wanted:
        hint = "" if is_wanted or dtype is None else f"; convert with .astype(np.{wanted_dtype})"
        raise ShapeError(f"{name}: expected {wanted} {wanted_dtype}, got {array.shape} {array.dtype.name}{hint}")
    if finite and not np.isfinite(array).all():
        index = np.argwhere(~np.isfinite(array))[0]
        where = ", ".join(str(i) for i in index)
        raise NonFiniteError(f"{name}: not finite at [{where}]")
    return array
