"""`cadet-gen`: writes a dataset."""

from __future__ import annotations

import json
import re
import shlex
import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import click
from click.core import ParameterSource
from rich.console import Console

from cadet import _cadet
from cadet._util.checks import shown
from cadet._util.notices import notice
from cadet.cli.destination import Destination
from cadet.cli.names import names_option
from cadet.cli.progress import reporter
from cadet.cli.signals import exit_code, how_ended, signals_end
from cadet.errors import CadetError
from cadet.formats.point_files import POINT_FILES
from cadet.generate import (
    ENGINES,
    EXPORTERS,
    EXTRAS,
    Recipe,
    Settings,
    Summary,
    WorkerError,
    generate,
    generate_frame,
)
from cadet.sensors.lidar import LIDAR_PRESETS, RETURN_MODES
from cadet.sensors.rig import RIG_PRESETS, Rig
from cadet.worlds.config import SceneConfig
from cadet.worlds.districts import DISTRICTS
from cadet.worlds.policy import POLICIES, ResetPolicy
from cadet.worlds.policy_table import changed
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import Weather, weather_names

_WORLD: Final = (
    *("districts", "maps", "weathers", "rig", "lidar", "rolling", "returns", "divergence_mrad", "image_size"),
    *("assets", "skip_bad", "props", "hz", "length_s"),
)
"""The options that change the policy, by the same keys as in a file."""
_OF_A_RUN: Final = ("out", "workers", "engine", "address", "resume", "recipe_file", "frame")
"""The parameters that change no byte, and those that go with a recipe."""
_OF_ALL_FRAMES: Final = ("num_frames", "workers", "engine", "address", "resume")
"""The parameters that say nothing where one frame is written."""
_A_WEATHER: Final = 'JSON such as {"fog_visibility_m": 80}'


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("out", type=Destination())
@click.version_option(_cadet.__version__, prog_name="cadet-gen")
@click.option(
    "-n", "--num-frames", type=click.IntRange(1, 1_000_000), default=20, show_default=True, help="Number of frames."
)
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True, help="Same seed, same bytes.")
@click.option(
    "--policy",
    metavar="NAME|FILE",
    default="kitti",
    show_default=True,
    help=f"The policy that draws the worlds: {', '.join(POLICIES)}, or a TOML file.",
)
@names_option("--districts", help=f"Some of {', '.join(DISTRICTS)}, or TOML files.")
@click.option(
    "--rig",
    metavar="NAME|FILE",
    help=f"The sensors: {', '.join(RIG_PRESETS)}, or a TOML file (docs/rigs.md).  [default: the policy's]",
)
@click.option("--lidar", metavar="NAME|FILE", help=f"{', '.join(LIDAR_PRESETS)}, or a TOML file (docs/lidars.md).")
@click.option(
    "--rolling/--no-rolling", default=None, help="Move the car and all actors while LIDARs turn (docs/scan.md)."
)
@click.option(
    "--returns", type=click.Choice(RETURN_MODES), help="What LIDARs report where a beam meets several surfaces."
)
@click.option("--divergence-mrad", type=float, help="How far LIDARs' beams open, the full cone.")
@click.option("--maps", metavar="FILE", multiple=True, help="An OpenDRIVE map; may be repeated.")
@names_option("--weathers", help="Some of the presets below.")
@click.option("--weather", metavar="JSON", help=f"Numbers of a weather, {_A_WEATHER} (docs/weather.md).")
@click.option("--assets", metavar="DIR", help="Own meshes: a folder with an assets.toml (docs/assets.md).")
@click.option(
    "--skip-bad", is_flag=True, default=None, help="Leave out those of --assets whose meshes are missing or broken."
)
@click.option("--props", metavar="DIR", help="Own props: a folder with a TOML file for each (docs/props.md).")
@click.option("--format", type=click.Choice(list(EXPORTERS)), default="kitti", show_default=True)
@click.option("--shard-size", type=click.IntRange(1, 10_000), help="Samples per shard.  [default: 1000]")
@click.option(
    "--hz",
    type=float,
    help="Samples per second: take them by time, not every 10 m.  [default of sequence formats: 2]",
)
@click.option("--length-s", type=float, help="Length of a sequence, seconds.  [default: 20]")
@click.option(
    "--workers",
    type=click.IntRange(1, 1024),
    help="Worker processes, or concurrent tasks.  [default: one per processor]",
)
@click.option(
    "--engine", type=click.Choice(ENGINES), default="local", show_default=True, help="Where episodes are made."
)
@click.option("--address", help="Address of the Ray cluster.  [default: RAY_ADDRESS, or a local Ray]")
@click.option("--image-size", metavar="WxH", help="Scale the image to this size, such as 621x188.")
@names_option("--points", help=f"Write scans so, too: {','.join(POINT_FILES)} (--write points_ply and so on).")
@names_option("--write", help=f"Write these too: {','.join(EXTRAS)}.")
@click.option("--resume", is_flag=True, help="Continue a run that the same command started.")
@click.option(
    "--recipe",
    "recipe_file",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="Make a dataset again from its recipe.toml, which holds all settings, and check that it is the same.",
)
@click.option(
    "--frame", type=click.IntRange(0, 999_999), help="Write the files of this frame alone, as the whole set has them."
)
@click.option(
    "--val-fraction",
    type=float,
    default=Settings.val_fraction,
    show_default=True,
    help="Share of the episodes in val.txt: the second of every round(1/F).",
)
@click.option(
    "--test-fraction",
    type=float,
    default=Settings.test_fraction,
    show_default=True,
    help="Share of the episodes in testing/ and test.txt: the third of every round(1/F).",
)
@click.pass_context
def cadet_gen(
    context: click.Context,
    /,
    out: str | Path,
    num_frames: int,
    seed: int,
    policy: str,
    format: str,
    shard_size: int | None,
    workers: int | None,
    engine: str,
    address: str | None,
    points: tuple[str, ...],
    write: tuple[str, ...],
    resume: bool,
    recipe_file: Path | None,
    frame: int | None,
    val_fraction: float,
    test_fraction: float,
    **world: Any,
) -> int:
    """Write a dataset of procedurally generated suburbs to the folder or URL OUT: KITTI's, nuScenes', shards, or bags.

    \b
    cadet-gen out -n 10000 --seed 0
    cadet-gen out -n 20000 --seed 0 --resume          # the first 10000 stay as they are
    cadet-gen scenes -n 160 --format nuscenes --hz 2 --length-s 20
    cadet-gen drives -n 200 --format kitti_raw --hz 10 --length-s 20
    cadet-gen bags -n 400 --format mcap --hz 10 --length-s 20   # ROS 2's messages
    cadet-gen s3://bucket/set -n 100000 --engine ray --address auto   # docs/scale.md
    cadet-gen shards -n 100000 --format webdataset --shard-size 1000
    cadet-gen rows -n 1000 --format parquet --shard-size 500   # for Hugging Face's datasets
    cadet-gen fields -n 500 --districts country_road   # or motorway
    cadet-gen rain -n 500 --weathers hard_rain_noon --write depth,instance
    cadet-gen again --recipe out/recipe.toml   # out once more, byte for byte; --frame 123 writes that one alone

    Weathers: {weathers}
    """  # noqa: D301 - click reads the backspace
    if address is not None and engine != "ray":
        raise CadetError("--address: goes with --engine ray")
    if frame is not None:
        _refuse(context, _OF_ALL_FRAMES, "--frame writes one frame alone; leave it out")
    if recipe_file is not None:
        settable = [name for name in context.params if name not in _OF_A_RUN]
        _refuse(context, settable, "the recipe has all settings; leave it out, or change the recipe")
        recipe = Recipe.read(recipe_file)
    else:
        recipe = Recipe(
            _settings(
                policy,
                points,
                world,
                seed=seed,
                num_frames=num_frames if frame is None else frame + 1,
                format=format,
                shard_size=shard_size,
                write=write,
                val_fraction=val_fraction,
                test_fraction=test_fraction,
            )
        )
    settings = recipe.settings
    if frame is not None:
        click.echo(f"wrote {len(generate_frame(out, settings, frame))} files of frame {frame:06d} to {out}", err=True)
        return 0
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    start_s = time.monotonic()
    report = reporter(console, settings.num_frames)
    num_done = 0

    def on_frame(is_new: bool) -> None:
        nonlocal num_done
        num_done += 1
        report.advance(is_new=is_new)

    def on_warning(text: str) -> None:
        console.print(text, markup=False)

    try:
        with signals_end(), report:
            summary = generate(
                out,
                settings,
                workers=workers,
                engine=engine,
                address=address,
                resume=resume,
                on_frame=on_frame,
                on_warning=on_warning,
            )
    except KeyboardInterrupt as error:
        console.print(f"{how_ended(error)}; {_how_to_go_on(context, num_done, settings.num_frames)}", markup=False)
        return exit_code(error)
    except WorkerError as error:
        raise CadetError(f"{error}; {_how_to_go_on(context, num_done, settings.num_frames)}") from None
    console.print(_closing(out, summary, time.monotonic() - start_s), markup=False)
    if summary.standing_episodes:
        console.print(_at_a_standstill(summary), markup=False)
    if settings.val_fraction > 0.0 and settings.num_episodes == 1:
        num_first = settings.policy.samples_per_episode
        console.print(
            f"val.txt is empty: validation starts with the second episode, at frame {num_first}", markup=False
        )
    if recipe.manifest_sha256 is not None:
        _check_manifest(out, summary, recipe, recipe_file)
        console.print("manifest.json is the recipe's, and so is every file", markup=False)
    return 0


cadet_gen.help = (cadet_gen.help or "").replace("{weathers}", ", ".join(weather_names()))


def _check_manifest(out: Path | str, summary: Summary, recipe: Recipe, recipe_file: Path | None) -> None:
    """Refuse a dataset that is not the one that its recipe was written for."""
    if recipe.manifest_sha256 != summary.manifest_sha256:
        raise CadetError(
            f"{out} is whole, but not the dataset that {recipe_file} was written for: its manifest.json has another "
            "hash; was the recipe made by another build of cadet?"
        )


def _refuse(context: click.Context, names: Iterable[str], why: str) -> None:
    """Refuse options that would be left out of account."""
    for name in names:
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            raise CadetError(f"{_option(name)}: {why}")


def _option(key: str) -> str:
    return f"--{key.replace('_', '-')}"


def _settings(policy: str, points: tuple[str, ...], world: Mapping[str, Any], **plain: Any) -> Settings:
    """Return the settings that the options say."""
    for suffix in points:
        if suffix not in POINT_FILES:
            raise CadetError(f"--points: unknown {shown(suffix)}; known: {', '.join(POINT_FILES)}")
    plain["write"] = tuple(dict.fromkeys((*plain["write"], *(f"points_{suffix}" for suffix in points))))
    try:
        return Settings(policy=_policy(policy, plain["format"], world), **plain)
    except CadetError as error:
        # The settings' names are the options'.
        raise CadetError(re.sub(r"^Settings\.(\w+)", lambda m: _option(m[1]), str(error))) from None


def _policy(name: str, format: str, world: Mapping[str, Any]) -> ResetPolicy:
    """Return the policy of a name or file with what the options say in place of its own."""
    try:
        policy = ResetPolicy.named(name)
    except CadetError as error:
        raise CadetError(f"--policy: {error}") from None
    table = {key: world[key] for key in _WORLD if world[key] not in (None, ())}
    if world["weather"] is not None:
        if "weathers" in table:
            raise CadetError("--weather: expected it or --weathers, not both")
        table["weathers"] = {"custom": _numbers(world["weather"])}
    if "image_size" in table:
        table["image_size"] = _image_size(table["image_size"])
    if format == "nuscenes":
        table.setdefault("rig", "nuscenes")
    weathers = "--weathers" if world["weather"] is None else "--weather"
    policy = changed(policy, table, Path(), lambda key: weathers if key == "weathers" else _option(key))
    for road_map in policy.maps:
        _check_drivable(road_map)
    return policy.as_sequence() if EXPORTERS[format].needs_sequence and policy.time_step_s is None else policy


def _check_drivable(road_map: RoadMap) -> None:
    """Build the map once, so that a bad one is refused before anything is written."""
    native = Rig.kitti()._to_native()
    config = SceneConfig()._to_native()
    scene = _cadet.Scene.empty(
        map_name=road_map.name,
        map_xodr=road_map.xodr,
        weather=Weather()._to_native(),
        rig=native,
        config=config,
        assets=None,
    )
    notice(scene.map_warnings(), about=road_map)


def _image_size(text: str) -> list[int]:
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if match is None:
        raise CadetError(f"--image-size: expected WxH such as 1242x375, got {text!r}")
    return [int(match[1]), int(match[2])]


def _numbers(text: str) -> dict[str, Any]:
    try:
        numbers = json.loads(text)
    except json.JSONDecodeError as error:
        raise CadetError(f"--weather: expected {_A_WEATHER}, got {text!r} ({error})") from None
    if not isinstance(numbers, dict):
        raise CadetError(f"--weather: expected {_A_WEATHER}, got {text!r}")
    return numbers


def _how_to_go_on(context: click.Context, num_done: int, num_frames: int) -> str:
    command = [str(context.find_root().info_name), *sys.argv[1:]]
    command += [] if "--resume" in command else ["--resume"]
    return f"at least {num_done} of {num_frames} frames are whole; go on with: {shlex.join(command)}"


def _closing(out: str | Path, summary: Summary, seconds: float) -> str:
    labels = ", ".join(f"{count} {name}" for name, count in summary.labels.most_common())
    all_kept = "" if summary.num_new else ": it was complete"
    kept = f" ({summary.num_kept} were there{all_kept})" if summary.num_kept else ""
    rate = f" at {summary.num_new / seconds:.1f}/s" if summary.num_new else ""
    return f"{summary.num_new + summary.num_kept} frames{kept} in {out}{rate}: {labels or 'no labels'}"


def _at_a_standstill(summary: Summary) -> str:
    first, rest = summary.standing_episodes[:5], len(summary.standing_episodes[5:])
    episodes = ", ".join(map(str, first)) + (f", and {rest} more" if rest else "")
    return (
        f"{summary.num_standing} of {summary.num_new + summary.num_kept} frames were taken at a standstill, among them "
        f"more than half of these episodes': {episodes}; a longer --length-s or larger --maps shows more motion"
    )
