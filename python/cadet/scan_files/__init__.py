"""Scans as LIDARs' drivers and other programs write them: PCD, PLY, .npy, and .bin of four to six columns."""

from cadet.scan_files.read import RecordedScan, read_scan

__all__ = ["RecordedScan", "read_scan"]
