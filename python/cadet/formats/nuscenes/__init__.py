"""nuScenes' format: tables of scenes, key frames and instances over time, and the files of every sensor."""

from cadet.formats.nuscenes.exporter import VERSION, NuscenesExporter

__all__ = ["VERSION", "NuscenesExporter"]
