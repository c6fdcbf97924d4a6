"""KITTI's formats of sequences: the tracking benchmark's and the raw data's."""

from cadet.formats.kitti_sequences.raw import KittiRawExporter
from cadet.formats.kitti_sequences.raw_drive import RawDrive
from cadet.formats.kitti_sequences.tracking import KittiTrackingExporter

__all__ = ["KittiRawExporter", "KittiTrackingExporter", "RawDrive"]
