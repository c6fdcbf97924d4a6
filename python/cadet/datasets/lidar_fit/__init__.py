"""A sensor fitted to recorded scans: lasers, firing pattern, ranges, noise and gains."""

from cadet.datasets.lidar_fit.fit import LidarFit, RingFit, fit_lidar

__all__ = ["LidarFit", "RingFit", "fit_lidar"]
