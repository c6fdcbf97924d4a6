"""Whether a KITTI folder is whole, keeps to its definitions, and holds together."""

from cadet.formats.kitti.lint.finding import RULES, Finding
from cadet.formats.kitti.lint.folder import lint, lint_frame

__all__ = ["RULES", "Finding", "lint", "lint_frame"]
