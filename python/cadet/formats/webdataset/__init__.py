"""KITTI frames in tar shards, as WebDataset names them: written, indexed, and read at any place."""

from cadet.formats.webdataset.dataset import ShardDataset, expand_pattern, open_dataset
from cadet.formats.webdataset.member import ArchiveError, Member
from cadet.formats.webdataset.shard import Shard
from cadet.formats.webdataset.tar_reading import read_members

__all__ = ["ArchiveError", "Member", "Shard", "ShardDataset", "expand_pattern", "open_dataset", "read_members"]
