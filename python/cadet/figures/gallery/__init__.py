"""Contact sheets of what scenes are made of: every family of actors, every district in several weathers, scans."""

from cadet.figures.gallery.pages import PAGES, write_gallery

__all__ = ["PAGES", "write_gallery"]
