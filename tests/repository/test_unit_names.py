"""The unit of every public float of the core is in its name."""

from __future__ import annotations

import re
from pathlib import Path

from repository.rust_modules import code_of

CRATES = Path(__file__).parents[2] / "crates"

UNITS = """m m2 m3 mm cm s rad deg px px2 hz mps mps2 radps cd sr ev per_m per_m3 per_h per_intensity steps columns rows
    triangles"""
# What has no unit: signs, shares, slopes, phases, numbers by convention (KITTI's angles, an image's u and v, axes), and
# numbers of any kind.
PLAIN = """a b c d base exponent hi lo p t x y z u v mean sd value least most weight alpha alpha_squared rotation_y
    albedo amplification ceiling cell chance cloudiness clutter contrast cover deviate direction f0 factor fraction
    gain gloss greenery index intensity iou irradiance level luma noise opacity overlap phase power radiance ratio
    reflectance rise roughness scale score secant share side similarity sine slope specular tangent threshold
    transmission transmittance truncation wetness"""
NAMED = re.compile(
    rf"_(?:{'|'.join(UNITS.split())})$|(?:^|_)(?:{'|'.join(PLAIN.split())})$|(?:^|_)(?:cos|sin)(?:_|$)", re.IGNORECASE
)

FLOAT = r"(?:Option<)?f(?:32|64)>?\s*(?=[,;)=}\n]|$)"
VALUES = re.compile(rf"\bpub (?:const |static )?(\w+): {FLOAT}", re.MULTILINE)
FUNCTIONS = re.compile(r"\bpub (?:const )?fn \w+(?:<[^(]*>)?\(([^{;]*)\)")
PARAMETERS = re.compile(rf"(?:^|,)\s*(\w+): {FLOAT}", re.MULTILINE)


def test_public_floats_have_their_unit_in_their_name() -> None:
    found = []
    for path in sorted(CRATES.glob("*/src/**/*.rs")):
        if path.is_relative_to(CRATES / "cadet_py") or "tests" in path.with_suffix("").parts:
            continue
        code = re.sub(r";[^\];\n]*\]", "]", code_of(path))
        names = VALUES.findall(code) + [name for f in FUNCTIONS.findall(code) for name in PARAMETERS.findall(f)]
        found += [f"{path.relative_to(CRATES)}: {name}" for name in names if not NAMED.search(name)]
    assert not found
