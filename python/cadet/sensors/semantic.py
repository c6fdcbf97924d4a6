"""The classes of the semantic image."""

from __future__ import annotations

from enum import IntEnum


class Semantic(IntEnum):
    """What a pixel shows: the values of `Frame.semantic` and of the files in `semantic/`."""

    SKY = 0
    """Nothing was hit."""
    ROAD = 1
    """Carriageway."""
    ROAD_MARKING = 2
    """Paint on the carriageway."""
    SIDEWALK = 3
    """Sidewalk and curb."""
    TERRAIN = 4
    """Grass, soil, gardens, drives."""
    BUILDING = 5
    """Houses and garages."""
    FENCE = 6
    """Fences, walls, railings."""
    VEGETATION = 7
    """Trees, hedges, shrubs."""
    POLE = 8
    """Posts of lamps and signs."""
    TRAFFIC_SIGN = 9
    """Traffic signs and lights."""
    FURNITURE = 10
    """Other things: bins, cabinets, benches, prams, dogs."""
    CAR = 11
    """Passenger cars."""
    VAN = 12
    """Vans."""
    TRUCK = 13
    """Trucks and buses."""
    PERSON = 14
    """People on foot or sitting."""
    CYCLIST = 15
    """Riders with their bicycles."""
    TRAM = 16
    """Trams."""
    OTHER_VEHICLE = 17
    """Any other vehicle, trailers and parked bicycles too."""
