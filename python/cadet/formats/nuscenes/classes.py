"""nuScenes' categories, attributes and visibility levels, and what ours become."""

from __future__ import annotations

from typing import Final

CATEGORIES: Final = {
    "noise": "Returns of what is no surface: fog, rain, spray, and snow in the air.",
    "animal": "Animals, such as dogs.",
    "human.pedestrian.adult": "Adults.",
    "human.pedestrian.child": "Children.",
    "human.pedestrian.construction_worker": "People who work at a construction site.",
    "human.pedestrian.personal_mobility": "Small electric or self-propelled vehicles, such as scooters.",
    "human.pedestrian.police_officer": "Police officers.",
    "human.pedestrian.stroller": "Prams, each with who pushes it.",
    "human.pedestrian.wheelchair": "Wheelchairs.",
    "movable_object.barrier": "Barriers that are put up to redirect traffic.",
    "movable_object.debris": "What lies on the carriageway and is too large to be driven over.",
    "movable_object.pushable_pullable": "What a person pushes or pulls, such as cases and rollators.",
    "movable_object.trafficcone": "Traffic cones.",
    "static_object.bicycle_rack": "Racks with the bicycles in them.",
    "vehicle.bicycle": "Bicycles with their riders; of points, parked ones too.",
    "vehicle.bus.bendy": "Articulated buses.",
    "vehicle.bus.rigid": "Buses, and each car of a tram.",
    "vehicle.car": "Passenger cars and vans.",
    "vehicle.construction": "Vehicles that are made for construction.",
    "vehicle.emergency.ambulance": "Ambulances.",
    "vehicle.emergency.police": "Police vehicles.",
    "vehicle.motorcycle": "Motorcycles.",
    "vehicle.trailer": "Trailers and caravans.",
    "vehicle.truck": "Trucks, semi-trailers with their tractors among them.",
    "flat.driveable_surface": "Carriageways and their markings.",
    "flat.other": "Other horizontal surfaces.",
    "flat.sidewalk": "Sidewalks and curbs.",
    "flat.terrain": "Grass, soil, gardens, and drives.",
    "static.manmade": "Buildings, fences, poles, signs, and street furniture.",
    "static.other": "Other things that stand.",
    "static.vegetation": "Trees, hedges, and shrubs.",
    "vehicle.ego": "The car that carries the sensors.",
}
"""Categories by nuScenes-lidarseg's names, in the order of its indices (nuscenes-devkit, docs/instructions_lidarseg.md
and category.json), with descriptions of what gets them here."""

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
