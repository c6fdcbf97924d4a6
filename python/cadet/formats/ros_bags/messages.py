"""A sample as ROS 2's messages: frames and units by REP 103 and REP 105, times on the clock of sequences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cadet.formats.point_files import columns_of_points
from cadet.formats.ros_bags.message_types import new
from cadet.formats.sequences import seen_agents, time_us
from cadet.sensors.camera import Camera
from cadet.sensors.pose import product, quaternion_of
from cadet.sensors.sample import Agent, Sample

MAP: Final = "map"
EGO: Final = "base_link"
ODOMETRY: Final = "/odom"
_FIELDS: Final = ("x", "y", "z", "intensity", "ring", "time")
"""In the order and at the offsets of velodyne_pointcloud's messages."""
_DATATYPES: Final = {"<f4": 7, "<u2": 4}
"""PointField's FLOAT32 and UINT16."""
_NO_COVARIANCE: Final = np.zeros(36)


def stamp_ns(sample: Sample) -> int:
    """Return the sample's Unix time in nanoseconds."""
    return time_us(sample.origin["episode"], sample.time_s) * 1000


def messages_of(sample: Sample) -> Iterator[tuple[str, Any]]:
    """Yield the topics and messages of a sample."""
    yield ODOMETRY, _odometry(sample)
    yield "/tf", _transforms(sample)
    yield "/objects", _objects(sample)
    for name in sample.scan_names:
        yield f"/{name}/points", _point_cloud(sample, name)
    for name in sample.image_names:
        yield f"/{name}/camera_info", _camera_info(sample, name)
        yield (
            f"/{name}/image_raw/compressed",
            new("sensor_msgs/CompressedImage", _header(sample, name), "png", np.frombuffer(sample.png(name), np.uint8)),
        )


def _header(sample: Sample, frame: str) -> Any:
    seconds, nanoseconds = divmod(stamp_ns(sample), 1_000_000_000)
    return new("std_msgs/Header", new("builtin_interfaces/Time", seconds, nanoseconds), frame)


def _odometry(sample: Sample) -> Any:
    ego_from_world = sample.world_from_ego[:3, :3].T
    twist = new(
        "geometry_msgs/Twist",
        _vector(product(ego_from_world, np.array([sample.ego_velocity_world]).T)[:, 0]),
        _vector(product(ego_from_world, np.array([sample.ego_angular_velocity_world]).T)[:, 0]),
    )
    return new(
        "nav_msgs/Odometry",
        _header(sample, MAP),
        EGO,
        new("geometry_msgs/PoseWithCovariance", _pose(sample.world_from_ego), _NO_COVARIANCE),
        new("geometry_msgs/TwistWithCovariance", twist, _NO_COVARIANCE),
    )


def _transforms(sample: Sample) -> Any:
    """Return the ego's place and those of its sensors; not on /tf_static, whose listeners need a latched publisher."""
    poses = {EGO: (MAP, sample.world_from_ego)}
    for name in (*sample.scan_names, *sample.image_names):
        poses[name] = (EGO, sample.rig.ego_from_sensor(name))
    return new(
        "tf2_msgs/TFMessage",
        [
            new("geometry_msgs/TransformStamped", _header(sample, parent), child, _transform(pose))
            for child, (parent, pose) in poses.items()
        ],
    )


def _objects(sample: Sample) -> Any:
    header = _header(sample, MAP)
    return new("vision_msgs/Detection3DArray", header, [_detection(header, agent) for agent, _ in seen_agents(sample)])


def _detection(header: Any, agent: Agent) -> Any:
    length, width, height = agent.size_lwh
    middle = np.eye(4)
    middle[2, 3] = 0.5 * height
    center = _pose(product(agent.world_from_agent, middle))
    hypothesis = new(
        "vision_msgs/ObjectHypothesisWithPose",
        new("vision_msgs/ObjectHypothesis", agent.type, 1.0),
        new("geometry_msgs/PoseWithCovariance", center, _NO_COVARIANCE),
    )
    box = new("vision_msgs/BoundingBox3D", center, new("geometry_msgs/Vector3", length, width, height))
    return new("vision_msgs/Detection3D", header, [hypothesis], box, str(agent.id))


def _point_cloud(sample: Sample, name: str) -> Any:
    scan = sample.scan(name)
    columns = columns_of_points(scan.points_velo, scan.ring, scan.time_s)
    rows = np.empty(len(scan.ring), [(field, columns[field].dtype) for field in _FIELDS])
    fields, size = [], 0
    for field in _FIELDS:
        rows[field] = columns[field]
        fields.append(new("sensor_msgs/PointField", field, size, _DATATYPES[columns[field].dtype.str], 1))
        size += columns[field].itemsize
    data = np.frombuffer(rows.tobytes(), np.uint8)
    return new(
        "sensor_msgs/PointCloud2",
        *(_header(sample, name), 1, len(rows), fields, False, size, size * len(rows), data, True),
    )


def _camera_info(sample: Sample, name: str) -> Any:
    camera = sample.rig.sensor(name)
    assert isinstance(camera, Camera)
    intrinsic = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    # OpenCV's k1, k2, p1, p2, k3 is ROS's order, too; its equidistant model has four coefficients.
    is_fisheye = camera.model == "fisheye"
    model, lens = ("equidistant", np.zeros(4)) if is_fisheye else ("plumb_bob", np.array(camera.distortion))
    return new(
        "sensor_msgs/CameraInfo",
        *(_header(sample, name), camera.height, camera.width, model, lens),
        *(intrinsic.ravel(), np.eye(3).ravel(), np.hstack([intrinsic, np.zeros((3, 1))]).ravel(), 0, 0),
        new("sensor_msgs/RegionOfInterest", 0, 0, 0, 0, False),
    )


def _vector(values: NDArray[np.float64]) -> Any:
    return new("geometry_msgs/Vector3", *values.tolist())


def _quaternion(pose: NDArray[np.float64]) -> Any:
    w, x, y, z = quaternion_of(pose[:3, :3])
    return new("geometry_msgs/Quaternion", x, y, z, w)


def _pose(pose: NDArray[np.float64]) -> Any:
    return new("geometry_msgs/Pose", new("geometry_msgs/Point", *pose[:3, 3].tolist()), _quaternion(pose))


def _transform(pose: NDArray[np.float64]) -> Any:
    return new("geometry_msgs/Transform", _vector(pose[:3, 3]), _quaternion(pose))
