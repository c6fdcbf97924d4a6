"""KITTI-format driving data from simulated suburbs."""
