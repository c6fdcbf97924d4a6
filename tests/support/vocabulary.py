"""Every setting by its one name: options of commands, keys of TOML files, fields and parameters of Python.

python tests/support/vocabulary.py --write        # renews docs/reference/names.md
"""

from __future__ import annotations

import dataclasses
import inspect
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, get_args, get_type_hints

import click

import avod
import cadet
from avod.adapt import Adaptation
from avod.cli.commands import avod as avod_command
from avod.evaluate import analyze_detectors
from avod.film import Film
from avod.train.settings import Run
from avod.worth import fixed_recipe, worth
from cadet import generate, kitti
from cadet.cli.tools import cadet as cadet_command
from cadet.datasets.lidar_fit import fit_lidar
from cadet.datasets.object_bank import cut_objects
from cadet.datasets.report import write_report
from cadet.figures.gallery import write_gallery
from cadet.formats.bdd100k import convert_bdd100k
from cadet.formats.convert import convert
from cadet.sensors.lidar import HOW
from cadet.sensors.rig_file import POSE

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "names.md"

FILES: dict[str, type[Any]] = {
    "a simulation": cadet.Simulation,
    "a policy": cadet.ResetPolicy,
    "a district": cadet.District,
    "a scene": cadet.SceneConfig,
    "a rig": cadet.Rig,
    "a LIDAR": cadet.Lidar,
    "a camera": cadet.Camera,
    "rules of evaluation": cadet.Rules,
    "a detector": avod.Config,
}
"""The kinds of TOML files, and what they are read as."""
CLASSES: tuple[type[Any], ...] = (generate.Settings, Run, Adaptation, *FILES.values())
FUNCTIONS: tuple[Callable[..., Any], ...] = (
    *(generate.generate, generate.generate_frame, generate.compare, cadet.stream, cadet.analyze, cadet.evaluate),
    *(kitti.lint, convert, convert_bdd100k),
    *(cut_objects, fit_lidar, write_report, write_gallery, analyze_detectors),
    *(cadet.Environment, cadet.Scene.random, cadet.Assets.read, cadet.ResetPolicy.as_sequence, avod.Detector),
    *(worth, fixed_recipe, Film),
)
"""The functions whose parameters are settings."""

COMMAND_ONLY: Mapping[str, str] = {
    "ablate": "`avod.evaluate.ablation`",
    "all": "prints every finding",
    "checkpoint": "the network of `avod.Detector`",
    "details": "all of `parts`, by distance and occlusion",
    "frame_id": "the frame that is drawn",
    "image_size": "`cadet.Camera.resized`",
    "json": "prints JSON",
    "last": "how many checkpoints are evaluated",
    "log": "the training whose losses are drawn",
    "markdown": "prints Markdown",
    "max_minutes": "`should_stop` of `avod.train.run.train`",
    "plot": "`cadet.Report.plot`",
    "points": "`points_ply` and so on of `write`",
    "rerun": "`cadet.figures.recording.view_episode`",
    "set": "any key of a detector's file",
    "sizes_from": "`avod.clusters.mean_sizes_of`",
    "source_split": "the `split` of the `Run` that `avod.adapt.adapt` takes",
    "test_split": "the list whose `ids` `avod.worth.worth` takes",
    "threads": "`torch.set_num_threads`",
    "video": "the path of an `avod.film.Film`",
    "version": "prints the version",
}
"""Options that are no field or parameter in Python, and what they stand for."""
NOT_ALIKE = (
    *({"weather", "weathers"}, {"map", "maps"}, {"district", "districts"}, {"rig", "rigs"}),
    *({"label", "labels"}, {"type", "types"}, {"image", "images"}, {"file", "files"}, {"path", "paths"}),
    *({"frame", "frames", "num_frames"}, {"cell_m", "cells"}, {"block_m", "blocks"}, {"firing", "firings"}),
    *({"height", "height_m"}, {"min_height_m", "min_height_px"}),
)
"""Names that look like one thing's: one of them and several, a thing and how many there are, pixels and meters."""
_UNITS = "m s deg mrad px hz mps rad minutes".split()


def commands() -> Iterator[tuple[str, click.Command]]:
    """Yield every command by its words."""
    yield from _commands(cadet_command, "cadet")
    yield from _commands(avod_command, "avod")


def _commands(command: click.Command, name: str) -> Iterator[tuple[str, click.Command]]:
    if isinstance(command, click.Group):
        for word, inner in command.commands.items():
            yield from _commands(inner, f"{name} {word}")
    else:
        yield name, command


def options() -> dict[str, list[str]]:
    """Return the commands of each option, by the option's name as Python would have it."""
    found: dict[str, list[str]] = defaultdict(list)
    for words, command in commands():
        for option in command.params:
            if isinstance(option, click.Option):
                (long,) = [text for text in option.opts if text.startswith("--")]
                found[long[2:].replace("-", "_")].append(words)
    return found


def fields() -> dict[str, list[str]]:
    """Return the classes that have each field, those of fields that are classes among them."""
    found: dict[str, list[str]] = defaultdict(list)
    seen: set[type[Any]] = set()

    def visit(cls: type[Any]) -> None:
        if cls in seen or not dataclasses.is_dataclass(cls):
            return
        seen.add(cls)
        hints = get_type_hints(cls)
        for field in dataclasses.fields(cls):
            found[field.name].append(cls.__name__)
            for kind in _kinds(hints[field.name]):
                visit(kind)

    for cls in CLASSES:
        visit(cls)
    return found


def _kinds(hint: Any) -> Iterator[type[Any]]:
    if isinstance(hint, type):
        yield hint
    for inner in get_args(hint):
        yield from _kinds(inner)


def parameters() -> dict[str, list[str]]:
    """Return the functions that have each parameter."""
    found: dict[str, list[str]] = defaultdict(list)
    for function in FUNCTIONS:
        for name in inspect.signature(function).parameters:
            found[name].append(function.__qualname__)
    return found


def keys() -> dict[str, list[str]]:
    """Return the kinds of files that have each key, at their top or, of rigs, in the tables of sensors."""
    found: dict[str, list[str]] = defaultdict(list)
    for kind, cls in FILES.items():
        names = cls._keys() if issubclass(cls, cadet.ResetPolicy) else [f.name for f in dataclasses.fields(cls)]
        names = {
            cadet.Simulation: ("seed", *cadet.ResetPolicy._keys()),
            cadet.Rig: ("name", "origin_in_ego_m", "camera", "lidar", "extrinsics", *POSE, *HOW),
            cadet.Lidar: (*HOW, *(f.name for f in dataclasses.fields(cadet.BeamTable))),
            avod.Config: ("base", *names),
        }.get(cls, tuple(names))
        for name in dict.fromkeys(names):
            found[name].append(kind)
    return found


def normal(name: str) -> str:
    """Return what two names of one thing would have in common."""
    for prefix in ("is_", "has_", "num_"):
        name = name.removeprefix(prefix)
    stem, _, unit = name.rpartition("_")
    return (stem if stem and unit in _UNITS else name).removesuffix("s")


def page() -> str:
    """Return the page that lists all settings by name."""
    of_command, of_file, of_class, of_function = options(), keys(), fields(), parameters()
    lines = [
        "# Names of settings",
        "",
        "Each setting has one name: the option `--val-fraction` of a command is the field or parameter `val_fraction`",
        "in Python, and would be the key `val_fraction` in TOML. `--x` and `--no-x` are `x = true` and `x = false`.",
        "Units stand at the end. Lists are separated by commas (`--weathers snow,dusk`), or the option is repeated.",
        "`python tests/support/vocabulary.py --write` writes this page.",
        "",
        "| name | commands | TOML of | Python |",
        "|---|---|---|---|",
    ]
    for name in sorted({*of_command, *of_file, *of_class}):
        python = [f"`{one}`" for one in dict.fromkeys([*of_class.get(name, ()), *of_function.get(name, ())])]
        python += [COMMAND_ONLY[name]] if name in COMMAND_ONLY else []
        commands = ", ".join(f"`{one}`" for one in of_command.get(name, ()))
        lines.append(f"| `{name}` | {commands} | {', '.join(of_file.get(name, ()))} | {', '.join(python)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    if sys.argv[1:] != ["--write"]:
        sys.exit("expected --write")
    PAGE.write_text(page(), encoding="utf-8")
