"""A page of figures about a dataset, beside KITTI's and the 2019 paper's."""

from cadet.datasets.report.page import write_report

__all__ = ["write_report"]
