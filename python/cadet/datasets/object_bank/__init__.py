"""Objects cut out of labeled frames, with their points and pixels, to be pasted into others."""

from cadet.datasets.object_bank.cut import cut_objects
from cadet.datasets.object_bank.object import BankObject
from cadet.datasets.object_bank.store import ObjectBank, write_bank

__all__ = ["BankObject", "ObjectBank", "cut_objects", "write_bank"]
