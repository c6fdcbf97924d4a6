"""Scans as LIDARs' drivers and other programs write them: PCD, PLY, .npy, and .bin of four to six columns."""

from cadet.formats.scan_files.read import SUFFIXES, RecordedScan, read_scan

__all__ = ["SUFFIXES", "RecordedScan", "read_scan"]
