"""nuScenes' categories, attributes and visibility levels, and what ours become."""

from __future__ import annotations

from typing import Final

CATEGORIES: Final = {
    "vehicle.car": (17, "Passenger cars and vans."),
    "vehicle.truck": (23, "Trucks, semi-trailers with their tractors among them."),
    "vehicle.bus.rigid": (16, "Buses, and each car of a tram."),
    "vehicle.bicycle": (14, "Bicycles with their riders."),
    "vehicle.motorcycle": (21, "Motorcycles."),
    "vehicle.trailer": (22, "Trailers and caravans."),
    "human.pedestrian.adult": (2, "Adults."),
    "human.pedestrian.child": (3, "Children."),
    "human.pedestrian.stroller": (7, "Prams, each with who pushes it."),
}
"""Categories that are written, by nuScenes' own names: their indices in nuScenes-lidarseg, and descriptions."""

_OF_TYPE: Final = {
    "Car": "vehicle.car",
    "Van": "vehicle.car",
    "Truck": "vehicle.truck",
    "Tram": "vehicle.bus.rigid",
    "Cyclist": "vehicle.bicycle",
    "Misc": "vehicle.trailer",
    "Pedestrian": "human.pedestrian.adult",
    "Person_sitting": "human.pedestrian.adult",
}
_OF_MODEL: Final = (
    ("Truck", "bus", "vehicle.bus.rigid"),
    ("Misc", "motorbike", "vehicle.motorcycle"),
    ("Pedestrian", "pram", "human.pedestrian.stroller"),
    ("Pedestrian", "child", "human.pedestrian.child"),
    ("Person_sitting", "child", "human.pedestrian.child"),
)
"""Types, words in their models' names, and the categories of both together: what KITTI's eight types don't tell."""

ATTRIBUTES: Final = {
    "vehicle.moving": "Vehicle is moving.",
    "vehicle.stopped": "Vehicle is stationary, but moves at another time of the scene.",
    "vehicle.parked": "Vehicle is stationary throughout the scene.",
    "cycle.with_rider": "There is a rider on the bicycle or motorcycle.",
    "cycle.without_rider": "There is no rider on the bicycle or motorcycle.",
    "pedestrian.moving": "The person is moving.",
    "pedestrian.standing": "The person is standing.",
    "pedestrian.sitting_lying_down": "The person is sitting.",
}
"""Attributes that are written, with descriptions."""

VISIBILITY: Final = {"1": (0.0, 0.4), "2": (0.4, 0.6), "3": (0.6, 0.8), "4": (0.8, 1.0)}
"""Levels by token: the share of an object that all images together show, from the first number up to the second."""

MOVING_MPS: Final = 0.2
"""Objects that are at least this fast move."""


def category(kind: str, model: str) -> str:
    """Return the category of an object.

    Args:
        kind: its type, one of KITTI's.
        model: its model's name, such as "child with dog/17"; a user's own mesh has no slash and tells nothing.
    """
    words = model.rpartition("/")[0].split(" ")
    return next((found for its, word, found in _OF_MODEL if its == kind and word in words), _OF_TYPE[kind])


def attribute(kind: str, model: str, speed_mps: float, fastest_mps: float) -> str:
    """Return the attribute of an object.

    Args:
        kind: its type.
        model: its model's name.
        speed_mps: its speed.
        fastest_mps: its highest speed in the scene.
    """
    is_moving = speed_mps >= MOVING_MPS
    what = category(kind, model)
    if what in ("vehicle.bicycle", "vehicle.motorcycle"):
        return "cycle.with_rider" if kind == "Cyclist" else "cycle.without_rider"
    if kind == "Person_sitting":
        return "pedestrian.sitting_lying_down"
    if what.startswith("human."):
        return "pedestrian.moving" if is_moving else "pedestrian.standing"
    if is_moving:
        return "vehicle.moving"
    return "vehicle.stopped" if fastest_mps >= MOVING_MPS else "vehicle.parked"


def visibility(share: float | None) -> str:
    """Return the token of a visible share; what no image shows has the lowest level."""
    return next(token for token, (_, below) in VISIBILITY.items() if (share or 0.0) < below or token == "4")
