"""nuScenes' categories, attributes and visibility levels, and what ours become."""

from __future__ import annotations

from typing import Final

CATEGORIES: Final = {
    "vehicle.car": "Passenger cars and vans.",
    "vehicle.truck": "Trucks.",
    "vehicle.bus.rigid": "Buses and trams.",
    "vehicle.bicycle": "Bicycles with their riders.",
    "vehicle.trailer": "Trailers and any other vehicle.",
    "human.pedestrian.adult": "People.",
}
"""Categories that are written, with descriptions."""

CATEGORY_OF: Final = {
    "Car": "vehicle.car",
    "Van": "vehicle.car",
    "Truck": "vehicle.truck",
    "Tram": "vehicle.bus.rigid",
    "Cyclist": "vehicle.bicycle",
    "Misc": "vehicle.trailer",
    "Pedestrian": "human.pedestrian.adult",
    "Person_sitting": "human.pedestrian.adult",
}
"""The category of each of our classes."""

ATTRIBUTES: Final = {
    "vehicle.moving": "Vehicle is moving.",
    "vehicle.stopped": "Vehicle is stationary, but moves at another time of the scene.",
    "vehicle.parked": "Vehicle is stationary throughout the scene.",
    "cycle.with_rider": "There is a rider on the bicycle.",
    "pedestrian.moving": "The person is moving.",
    "pedestrian.standing": "The person is standing.",
    "pedestrian.sitting_lying_down": "The person is sitting.",
}
"""Attributes that are written, with descriptions."""

VISIBILITY: Final = {"1": (0.0, 0.4), "2": (0.4, 0.6), "3": (0.6, 0.8), "4": (0.8, 1.0)}
"""Levels by token: the share of an object that all images together show, from the first number up to the second."""

MOVING_MPS: Final = 0.2
"""Objects that are at least this fast move."""


def attribute(kind: str, speed_mps: float, fastest_mps: float) -> str:
    """Return the attribute of an object.

    Args:
        kind: its class.
        speed_mps: its speed.
        fastest_mps: its highest speed in the scene.
    """
    is_moving = speed_mps >= MOVING_MPS
    if kind == "Cyclist":
        return "cycle.with_rider"
    if kind == "Person_sitting":
        return "pedestrian.sitting_lying_down"
    if kind == "Pedestrian":
        return "pedestrian.moving" if is_moving else "pedestrian.standing"
    if is_moving:
        return "vehicle.moving"
    return "vehicle.stopped" if fastest_mps >= MOVING_MPS else "vehicle.parked"


def visibility(share: float | None) -> str:
    """Return the token of a visible share; what no image shows has the lowest level."""
    return next(token for token, (_, below) in VISIBILITY.items() if (share or 0.0) < below or token == "4")
