"""How large a detector may be."""

from __future__ import annotations

from typing import Final

MAX_PIXELS: Final = 2**23
"""The most pixels of the image after resizing, and the most cells of a map: for each the network keeps many numbers."""
MAX_ANCHORS: Final = 2**22
"""The most anchors of the whole grid; AVOD has 89,600."""
MAX_LAYERS: Final = 8
"""The most stages of an encoder, and the most hidden layers of the second stage."""
