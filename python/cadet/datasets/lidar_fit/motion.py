"""What moved a scan's points: drivers move each point to where the vehicle stood at the end of the turn.

Moved so, a laser's points lie on no cone. With their lasers known, the straight motion and the turning about x and y
that bring them back onto cones can be fitted; turning about z leaves cones what they are.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

_ITERATIONS: Final = 20
_MOST_POINTS: Final = 60_000
_NEAREST_M: Final = 1.0
_HEIGHT_SD_M: Final = 0.1
"""How far from the origin lasers sit, where their points do not tell."""
_LEAST_SCALE_M: Final = 0.0002

Array = NDArray[np.float64]


def phases(xyz: Array, ring: NDArray[np.int64], time: Array | None) -> Array | None:
    """Return when each point was fired, in turns: by its time, or by its azimuth if points are in firing order.

    Args:
        xyz: (N, 3).
        ring: (N,).
        time: (N,) in any unit, or None.

    Returns:
        (N,); None where nothing tells.
    """
    if time is not None:
        since: Array = time - time.min()
        return since / float(since.max())
    if np.mean(np.diff(ring) != 0) < 0.5:
        return None
    order = np.arange(len(xyz)) / len(xyz)
    turn = np.arctan2(xyz[:, 1], xyz[:, 0]) / (2.0 * np.pi)
    is_far = np.hypot(xyz[:, 0], xyz[:, 1]) > 5.0 * _NEAREST_M
    if is_far.sum() < 100:
        return None
    # Which way round: the way that agrees with the order, which runs through one turn.
    spreads = []
    for sign in (1.0, -1.0):
        angle = 2.0 * np.pi * (sign * turn[is_far] - order[is_far])
        spreads.append((abs(np.exp(1j * angle).mean()), sign, float(np.angle(np.exp(1j * angle).mean()))))
    sharp, sign, offset = max(spreads)
    if sharp < 0.8:
        return None
    phase = sign * turn - offset / (2.0 * np.pi)
    phase += np.round(order - phase)
    # What did not return was moved from the origin: its azimuth tells nothing.
    is_near = np.hypot(xyz[:, 0], xyz[:, 1]) < _NEAREST_M
    phase[is_near] = np.interp(order[is_near], order[is_far], phase[is_far])
    return phase


def undone(xyz: Array, ring: NDArray[np.int64] | None, time: Array | None) -> Array | None:
    """Return the points (N, 3) as the sensor saw them; None where lasers or times are not known."""
    if ring is None:
        return None
    every = np.unique(ring, return_inverse=True)[1]
    motion = np.zeros(9)
    is_used = np.zeros(len(xyz), np.bool_)
    is_used[:: max(1, len(xyz) // _MOST_POINTS)] = True
    is_used &= np.hypot(xyz[:, 0], xyz[:, 1]) > _NEAREST_M
    weight = np.ones(int(is_used.sum()))
    seen = xyz
    for _ in range(_ITERATIONS):
        phase = phases(seen, ring, time)
        if phase is None:
            return None
        late = phase - 1.0
        seen = _moved(xyz, late, motion)
        step, weight = _step(seen[is_used], every[is_used], late[is_used], weight)
        motion = motion + step
    return seen


def _moved(xyz: Array, late: Array, motion: Array) -> Array:
    """Take a motion back: how far in a turn, by which angles in a turn, and place and angles at its end."""
    straight, turning, aside, turn = motion[:3], motion[3:5], motion[5:7], motion[7:]
    x, y, z = (xyz - late[:, None] * straight - np.append(aside, 0.0)).T
    about_x, about_y = turn[0] + late * turning[0], turn[1] + late * turning[1]
    return np.column_stack([x - about_y * z, y + about_x * z, z - about_x * y + about_y * x])


def _step(seen: Array, ring: NDArray[np.intp], late: Array, weight: Array) -> tuple[Array, Array]:
    """Return by how much to change the motion's numbers, and the points' weights for the next time."""
    x, y, z = seen.T
    rho = np.hypot(x, y)
    tangent = _lines(np.column_stack([z]), rho, ring, weight)[0][ring, 0]
    across = np.column_stack([-tangent * x / rho, -tangent * y / rho, np.ones(len(x))])
    # By how much a unit of each changes a point's height over its cone.
    about = np.column_stack([across[:, 1] * z - across[:, 2] * y, -across[:, 0] * z + across[:, 2] * x])
    lately = late[:, None]
    effects = np.column_stack([-lately * across, lately * about, -across[:, :2], about])
    _, rest = _lines(np.column_stack([z, effects]), rho, ring, weight)
    left, columns = rest[:, 0], rest[:, 1:]
    weighted = columns * weight[:, None]
    square = weighted.T @ columns
    # Of what no point tells, nothing is said.
    step = -np.linalg.pinv(square, rcond=1e-10, hermitian=True) @ (weighted.T @ left)
    left = left + columns @ step
    scale = max(1.4826 * float(np.median(np.abs(left))), _LEAST_SCALE_M)
    return step, (1.0 + (left / (2.0 * scale)) ** 2) ** -2


def _lines(values: Array, rho: Array, ring: NDArray[np.intp], weight: Array) -> tuple[Array, Array]:
    """Fit each column of values as a line over rho for each ring; return the slopes (rings, C) and what is left."""
    count = int(ring.max()) + 1

    def total(numbers: Array) -> Array:
        return np.bincount(ring, numbers * weight, count).astype(np.float64)

    prior = (_LEAST_SCALE_M / _HEIGHT_SD_M) ** 2
    ones, firsts, seconds = total(np.ones(len(rho))) + prior, total(rho), total(rho * rho)
    sums = np.column_stack([total(column) for column in values.T])
    moments = np.column_stack([total(column * rho) for column in values.T])
    determinant = np.maximum(ones * seconds - firsts * firsts, 1e-12)[:, None]
    slopes = (ones[:, None] * moments - firsts[:, None] * sums) / determinant
    heights = (seconds[:, None] * sums - firsts[:, None] * moments) / determinant
    return slopes, values - heights[ring] - slopes[ring] * rho[:, None]
