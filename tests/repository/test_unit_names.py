"""The unit of every public float of the core is in its name."""

from __future__ import annotations

import re
from pathlib import Path

from repository.rust_modules import code_of

CORE = Path(__file__).parents[2] / "crates" / "cadet_core" / "src"
# Rooms whose names are still to be gone over.
LATER = {"assets", "town", "world"}

UNITS = """m m2 m3 mm cm s rad deg px px2 hz mps cd sr per_m per_m3 per_h per_intensity steps columns rows
    share ratio factor scale tangent secant sine"""
# What has no unit: shares, numbers by convention (KITTI's angles, an image's u and v, axes), and numbers of any kind.
PLAIN = """a b base exponent hi lo p t x y z u v mean sd value least most weight cos sin alpha rotation_y albedo
    amplification chance cloudiness contrast cover f0 fraction gain gloss index intensity iou irradiance luma noise
    occlusion overlap power radiance reflectance rise roughness score similarity specular threshold transmission
    transmittance truncation wetness ceiling deviate cell"""
NAMED = re.compile(rf"(?:^|_)(?:{'|'.join(UNITS.split())})$|(?:^|_)(?:{'|'.join(PLAIN.split())})(?:_|$)", re.IGNORECASE)

FLOAT = r"(?:Option<)?f(?:32|64)>?\s*(?=[,;)=}\n]|$)"
VALUES = re.compile(rf"\bpub (?:const |static )?(\w+): {FLOAT}", re.MULTILINE)
FUNCTIONS = re.compile(r"\bpub (?:const )?fn \w+(?:<[^(]*>)?\(([^{;]*)\)")
PARAMETERS = re.compile(rf"(?:^|,)\s*(\w+): {FLOAT}", re.MULTILINE)


def test_public_floats_have_their_unit_in_their_name() -> None:
    found = []
    for path in sorted(CORE.rglob("*.rs")):
        parts = path.relative_to(CORE).with_suffix("").parts
        if parts[0] in LATER or "tests" in parts:
            continue
        code = re.sub(r";[^\];\n]*\]", "]", code_of(path))
        names = VALUES.findall(code) + [name for f in FUNCTIONS.findall(code) for name in PARAMETERS.findall(f)]
        found += [f"{path.relative_to(CORE)}: {name}" for name in names if not NAMED.search(name)]
    assert not found
