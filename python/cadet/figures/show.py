"""A frame shown in a window, or written as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cadet._util.checks import check_kind
from cadet.formats.kitti.frame import Frame


def view(frame: Frame | Sequence[Frame], path: str | Path | None = None) -> Path:
    """Draw all figures of a frame on a sheet, as `cadet view` does, or several frames, a row each, and show them.

    Args:
        frame: the frame, or one or more.
        path: a PNG or JPEG file to write, in a folder that is there; None writes a PNG to the system's temporary folder
            and opens it with the viewer of pictures, if there is one.

    Returns:
        The file.

    Raises:
        CadetError: no frame, or a name that ends in no picture's suffix.
    """
    # Loaded when something is drawn: `import cadet` stays fast.
    import tempfile
    import webbrowser

    from cadet.figures.picture import check_picture_path, write_picture
    from cadet.figures.sheet import overview, sheet

    place = Path(tempfile.mkdtemp(prefix="cadet-")) / "frame.png" if path is None else check_picture_path(path)
    if isinstance(frame, Frame):
        write_picture(place, sheet(frame))
    else:
        for one in frame if isinstance(frame, (list, tuple)) else (frame,):
            check_kind("", "frame", one, Frame)
        overview(frame, place)
    if path is None:
        webbrowser.open(place.as_uri())
    return place
