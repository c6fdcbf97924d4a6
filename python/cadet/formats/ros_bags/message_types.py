"""ROS 2's types of messages: those that the library rosbags knows, and those of `vision_msgs` that are written."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

from cadet._util.extras import load_extra

_EXTRA: Final = "mcap"
_PURPOSE: Final = "--format mcap"
_VISION: Final = {
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score\n",
    "vision_msgs/msg/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n"
    ),
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    "vision_msgs/msg/Detection3D": (
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox3D bbox\nstring id\n"
    ),
    "vision_msgs/msg/Detection3DArray": "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n",
}
"""Names and types of the fields, as of vision_msgs 4 (ROS 2 Humble and later)."""


def check_libraries() -> None:
    """Make sure that what writes bags is there.

    Raises:
        CadetError: a library is not installed.
    """
    load_extra("mcap", _EXTRA, _PURPOSE)
    load_extra("rosbags", _EXTRA, _PURPOSE)


def load(module: str) -> Any:
    """Import a module of one of the libraries.

    Raises:
        CadetError: it is not installed.
    """
    return load_extra(module, _EXTRA, _PURPOSE)


@cache
def types() -> Any:
    """Return rosbags' store of types, with classes by name in its `types`.

    Raises:
        CadetError: rosbags is not installed.
    """
    typesys = load("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    for name, fields in _VISION.items():
        store.register(typesys.get_types_from_msg(fields, name))
    return store


def definition(name: str) -> str:
    """Return the text of a type and of those that it is made of, as MCAP's schemas of `ros2msg` hold it."""
    text: str = types().generate_msgdef(name, ros_version=2)[0]
    return text


def new(name: str, *fields: Any) -> Any:
    """Make a message.

    Args:
        name: of its type, such as "std_msgs/Header".
        fields: in the order of the type's definition.
    """
    return types().types[name.replace("/", "/msg/")](*fields)


def encoded(message: Any) -> bytes:
    """Return a message in CDR, the lowest byte of a number first."""
    return bytes(types().serialize_cdr(message, message.__msgtype__, little_endian=True))
