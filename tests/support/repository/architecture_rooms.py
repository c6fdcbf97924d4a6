"""The crates of the core, the rooms inside of some, and who may use whom, as ARCHITECTURE.md draws it."""

from __future__ import annotations

# A crate and those of this repository that it depends on; its tests may use others.
CRATES: dict[str, set[str]] = {
    "base": set(),
    "assets": {"base"},
    "town": {"assets", "base"},
    "world": {"assets", "base", "town"},
    "sensors": {"base"},
    "core": {"assets", "base", "sensors", "town", "world"},
}

# A room of a crate, or of a room of one, and those of its neighbors that it may use.
ROOMS: dict[str, dict[str, set[str]]] = {
    "base": {
        "error": set(),
        "math": set(),
        "parallel": set(),
        "plane": {"math"},
        "frames": {"error", "math"},
        "rng": {"error", "math"},
        "settings": {"error"},
        "lamp": {"frames", "math"},
        "road_paint": {"math"},
        "material": {"error", "lamp", "math"},
        "geometry": {"error", "frames", "material", "math"},
        "instance": {"geometry", "material", "math"},
        "actor": {"error", "material", "math"},
    },
    "town": {
        "network": set(),
        "opendrive": {"network"},
        "plan": {"network", "opendrive"},
        "signals": {"network"},
        "paint": {"network", "signals"},
        "ground": {"network", "paint", "signals"},
        "roadside": {"ground", "network"},
        "placement": {"ground"},
        "plots": {"ground", "network", "placement"},
        "street_things": {"network", "placement", "plots"},
        "lots": {"ground", "network", "placement", "plots", "street_things"},
        "countryside": {"ground", "network", "placement", "plots", "signals"},
        "props": {
            "countryside",
            "ground",
            "lots",
            "network",
            "paint",
            "placement",
            "plots",
            "roadside",
            "signals",
            "street_things",
        },
    },
    "sensors": {
        "image_file": set(),
        "wide_registers": set(),
        "zeros": set(),
        "surface_cover": set(),
        "weather": set(),
        "spray": {"weather"},
        "sense": {"wide_registers", "zeros"},
        "lidar": {"sense", "spray", "surface_cover", "weather", "zeros"},
        "camera": {"sense", "spray", "surface_cover", "weather", "wide_registers", "zeros"},
        "label": {"camera", "sense"},
        "rig": {"camera", "lidar"},
    },
    "sensors/lidar": {
        "detection": set(),
        "reflectance": set(),
        "scan_pattern": set(),
        "air": {"detection", "reflectance"},
        "sensor": {"detection", "scan_pattern"},
        "casting": {"scan_pattern", "sensor"},
        "echoes": {"casting", "reflectance", "sensor"},
        "returns": {"air", "detection", "echoes", "sensor"},
        "scan": {"air", "casting", "echoes", "returns", "sensor"},
    },
}
