"""KITTI frames in tar shards, as WebDataset names them: written, indexed, and read at any place."""

from cadet.webdataset.dataset import ShardDataset, expand_pattern, open_dataset
from cadet.webdataset.member import ArchiveError, Member
from cadet.webdataset.shard import Shard
from cadet.webdataset.tar_reading import read_members

__all__ = ["ArchiveError", "Member", "Shard", "ShardDataset", "expand_pattern", "open_dataset", "read_members"]
