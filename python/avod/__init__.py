"""AVOD-FPN in PyTorch: 3D objects from a LIDAR scan and an image, trained on KITTI's format.

`avod` reads KITTI folders with `cadet` and never the other way round.
"""
