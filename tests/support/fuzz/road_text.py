"""A small OpenDRIVE map with a piece of each shape."""

from __future__ import annotations

_SHAPES = (
    "<line/>",
    '<arc curvature="0.02"/>',
    '<spiral curvStart="0.02" curvEnd="0"/>',
    '<poly3 a="0" b="0" c="0.01" d="0"/>',
    '<paramPoly3 pRange="arcLength" aU="0" bU="1" cU="0" dU="0" aV="0" bV="0" cV="0.01" dV="0"/>',
)


def _lane(number: int, kind: str, width_m: float) -> str:
    return f'<lane id="{number}" type="{kind}"><width sOffset="0" a="{width_m}" b="0" c="0" d="0"/></lane>\n'


def road(number: int, shape: str = "<line/>", *, x: float = 0.0, y: float = 0.0, length_m: float = 40.0) -> str:
    """Return a road with a lane and a sidewalk on either side."""
    right = _lane(-1, "driving", 3.2) + _lane(-2, "sidewalk", 2.0)
    left = _lane(2, "sidewalk", 2.0) + _lane(1, "driving", 3.2)
    return (
        f'<road id="{number}" length="{length_m}" junction="-1"><planView>\n'
        f'<geometry s="0" x="{x}" y="{y}" hdg="0" length="{length_m}">{shape}</geometry>\n</planView>\n'
        '<elevationProfile><elevation s="0" a="0" b="0.01" c="0" d="0"/></elevationProfile>\n'
        f'<lanes><laneSection s="0"><left>{left}</left><center><lane id="0" type="none"/></center>'
        f"<right>{right}</right></laneSection></lanes></road>\n"
    )


def map_of(roads: str) -> str:
    """Return the text of a map."""
    return f'<?xml version="1.0"?>\n<OpenDRIVE><header revMajor="1" revMinor="6"/>\n{roads}</OpenDRIVE>\n'


ROADS = map_of("".join(road(number, shape, y=40.0 * number) for number, shape in enumerate(_SHAPES)))
