"""Scans as other programs read them: PLY, PCD, LAS, and .npz, with the fields x, y, z, intensity, ring, and time."""

from cadet.formats.point_files.writers import POINT_FILES, columns_of_points

__all__ = ["POINT_FILES", "columns_of_points"]
