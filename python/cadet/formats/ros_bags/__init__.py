"""ROS 2's messages in MCAP files, one for each episode."""

from cadet.formats.ros_bags.exporter import McapExporter

__all__ = ["McapExporter"]
