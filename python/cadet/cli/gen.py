"""`cadet-gen`: writes a dataset."""

from __future__ import annotations

import re
import shlex
import sys
import time
from dataclasses import replace
from pathlib import Path

import click
from rich.console import Console

from cadet import _cadet
from cadet._util.checks import check_number
from cadet._util.notices import notice
from cadet.cli.destination import Destination
from cadet.cli.progress import reporter
from cadet.cli.signals import exit_code, how_ended, signals_end
from cadet.errors import CadetError
from cadet.generate import ENGINES, EXPORTERS, EXTRAS, Settings, Summary, WorkerError, generate
from cadet.sensors.lidar import LIDAR_PRESETS, Lidar
from cadet.sensors.rig import RIG_PRESETS, Rig
from cadet.worlds.assets import Assets
from cadet.worlds.districts import DISTRICTS, District
from cadet.worlds.policy import POLICIES, ResetPolicy
from cadet.worlds.props import Props
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import weather_names

_LEAST_FRACTION = 1e-6


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("out", type=Destination())
@click.version_option(_cadet.__version__, prog_name="cadet-gen")
@click.option("-n", "num_frames", type=click.IntRange(1, 1_000_000), default=20, show_default=True, help="Frames.")
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True, help="Same seed, same bytes.")
@click.option(
    "--policy",
    type=click.Choice(POLICIES),
    default="kitti",
    show_default=True,
    help="The policy that draws the worlds.",
)
@click.option(
    "--district", "districts", type=click.Choice(DISTRICTS), multiple=True, help="A district; may be repeated."
)
@click.option("--rig", type=click.Choice(RIG_PRESETS), help="The sensors.  [default: the policy's, drawn by episode]")
@click.option("--lidar", metavar="NAME|FILE", help=f"{', '.join(LIDAR_PRESETS)}, or a TOML file (docs/lidars.md).")
@click.option("--map", "maps", metavar="FILE", multiple=True, help="An OpenDRIVE map; may be repeated.")
@click.option("--weather", "weathers", metavar="NAME", multiple=True, help="A preset; may be repeated.")
@click.option(
    "--assets",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Own vehicle meshes: a folder with an assets.toml (docs/assets.md).",
)
@click.option(
    "--props",
    metavar="DIR",
    type=click.Path(path_type=Path),
    help="Own props: a folder with a TOML file for each (docs/props.md).",
)
@click.option("--skip-bad-assets", is_flag=True, help="Leave out vehicles whose meshes are missing or broken.")
@click.option("--format", "dataset_format", type=click.Choice(list(EXPORTERS)), default="kitti", show_default=True)
@click.option("--shard-size", type=click.IntRange(1, 10_000), help="Samples per shard of webdataset.  [default: 1000]")
@click.option(
    "--sequence",
    is_flag=True,
    help="Take samples by time, not every 10 m; implied by sequence formats.",
)
@click.option("--hz", type=float, help="Samples a second of a sequence.  [default: 2]")
@click.option("--length", metavar="SECONDS", help="Length of a sequence, such as 20s.  [default: 20s]")
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
@click.option("--write", "write", metavar="LIST", default="", help=f"Write these too: {','.join(EXTRAS)}.")
@click.option("--resume", is_flag=True, help="Continue a run that the same command started.")
@click.option(
    "--val-fraction",
    type=click.FloatRange(0.0, 0.5),
    default=0.2,
    show_default=True,
    help="Share of the episodes in val.txt: the second of every round(1/F).",
)
@click.option(
    "--test-fraction",
    type=click.FloatRange(0.0, 0.34),
    default=0.0,
    show_default=True,
    help="Share of the episodes in testing/ and test.txt: the third of every round(1/F).",
)
def cadet_gen(
    out: str | Path,
    num_frames: int,
    seed: int,
    policy: str,
    districts: tuple[str, ...],
    rig: str | None,
    lidar: str | None,
    maps: tuple[str, ...],
    weathers: tuple[str, ...],
    assets: Path | None,
    props: Path | None,
    skip_bad_assets: bool,
    dataset_format: str,
    shard_size: int | None,
    sequence: bool,
    hz: float | None,
    length: str | None,
    workers: int | None,
    engine: str,
    address: str | None,
    image_size: str | None,
    write: str,
    resume: bool,
    val_fraction: float,
    test_fraction: float,
) -> int:
    """Write a dataset of procedurally generated suburbs to the folder or URL OUT: KITTI's, nuScenes', or shards.

    \b
    cadet-gen out -n 10000 --seed 0
    cadet-gen out -n 20000 --seed 0 --resume          # the first 10000 stay as they are
    cadet-gen scenes -n 160 --format nuscenes --hz 2 --length 20s
    cadet-gen drives -n 200 --format kitti_raw --hz 10 --length 20s
    cadet-gen s3://bucket/set -n 100000 --engine ray --address auto   # docs/scale.md
    cadet-gen shards -n 100000 --format webdataset --shard-size 1000
    cadet-gen fields -n 500 --district country_road   # or motorway
    cadet-gen rain -n 500 --weather hard_rain_noon --write depth,instance

    Weathers: {weathers}
    """  # noqa: D301 - click reads the backspace
    if skip_bad_assets and assets is None:
        raise CadetError("--skip-bad-assets: goes with --assets")
    if address is not None and engine != "ray":
        raise CadetError("--address: goes with --engine ray")
    own = None if assets is None else Assets.read(assets, skip_bad=skip_bad_assets)
    own_props = None if props is None else Props.read(props)
    chosen = _policy(policy, districts, maps, weathers, own, own_props)
    settings = Settings(
        seed=seed,
        num_frames=num_frames,
        policy=_in_time(
            _with_sensors(chosen, _rig_for(dataset_format, rig), image_size, lidar),
            sequence or EXPORTERS[dataset_format].needs_sequence,
            hz,
            length,
        ),
        format=dataset_format,
        shard_size=shard_size,
        extras=tuple(name.strip() for name in write.split(",") if name.strip()),
        val_period=_period("--val-fraction", val_fraction),
        test_period=_period("--test-fraction", test_fraction),
    )
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    start_s = time.monotonic()
    report = reporter(console, num_frames)
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
        console.print(f"{how_ended(error)}; {_how_to_go_on(num_done, num_frames)}", markup=False)
        return exit_code(error)
    except WorkerError as error:
        raise CadetError(f"{error}; {_how_to_go_on(num_done, num_frames)}") from None
    console.print(_closing(out, summary, time.monotonic() - start_s), markup=False)
    if summary.standing_episodes:
        console.print(_at_a_standstill(summary), markup=False)
    if settings.val_period > 0 and settings.num_episodes == 1:
        num_first = settings.policy.samples_per_episode
        console.print(f"val.txt is empty: frames from {num_first} on, the second episode, are its first", markup=False)
    return 0


cadet_gen.help = (cadet_gen.help or "").replace("{weathers}", ", ".join(weather_names()))


def _period(option: str, fraction: float) -> int:
    """Return every how many episodes one is taken; 0 for none."""
    # click lets NaN through any range.
    check_number("", option, fraction, 0, 0.5)
    if 0.0 < fraction < _LEAST_FRACTION:
        raise CadetError(f"{option}: expected 0 or at least {_LEAST_FRACTION:g}, got {fraction:g}")
    return round(1.0 / fraction) if fraction > 0.0 else 0


def _policy(
    name: str,
    districts: tuple[str, ...],
    maps: tuple[str, ...],
    weathers: tuple[str, ...],
    assets: Assets | None,
    props: Props | None,
) -> ResetPolicy:
    policy = ResetPolicy.named(name)
    if districts:
        policy = policy.with_districts(*map(District.named, districts))
    if maps:
        policy = replace(policy, maps=tuple(RoadMap.read(path) for path in maps))
        for road_map in policy.maps:
            _check_drivable(road_map)
    if weathers:
        policy = policy.with_weathers(*weathers)
    if assets is not None:
        policy = replace(policy, assets=assets)
    return policy if props is None else policy.with_props(props)


def _check_drivable(road_map: RoadMap) -> None:
    """Build the map once, so that a bad one is refused before anything is written."""
    native = Rig.kitti().to_native()
    config = ResetPolicy.kitti().draw(0, 0).config.to_native()
    scene = _cadet.Scene.empty(
        map_name=road_map.name, map_xodr=road_map.xodr, weather="clear_noon", rig=native, config=config, assets=None
    )
    notice(scene.map_warnings(), about=road_map)


def _rig_for(dataset_format: str, rig: str | None) -> str | None:
    """Return the rig that was asked for; nuScenes' own for its format if none was."""
    return "nuscenes" if rig is None and dataset_format == "nuscenes" else rig


def _in_time(policy: ResetPolicy, sequence: bool, hz: float | None, length: str | None) -> ResetPolicy:
    """Let samples follow each other by time, if that was asked for."""
    if not sequence:
        for name, value in (("--hz", hz), ("--length", length)):
            if value is not None:
                raise CadetError(f"{name}: only for a --sequence")
        return policy
    match = re.fullmatch(r"(\d{1,5}(?:\.\d{1,3})?)s?", "20s" if length is None else length)
    if match is None:
        raise CadetError(f"--length: expected seconds such as 20s, got {length!r}")
    try:
        return policy.as_sequence(hz=2.0 if hz is None else hz, length_s=float(match[1]))
    except CadetError as error:
        raise CadetError(f"--{error}") from None


def _with_sensors(policy: ResetPolicy, rig: str | None, image_size: str | None, lidar: str | None) -> ResetPolicy:
    """Put the sensors that were asked for into each of the policy's rigs, or in their place."""
    if rig is not None:
        policy = policy.with_rig(Rig.named(rig))
    if lidar is not None:
        named = Lidar.named(lidar)
        policy = policy.with_each_rig(lambda rig: rig.with_lidar(named))
    if image_size is None:
        return policy
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", image_size)
    if match is None:
        raise CadetError(f"--image-size: expected WxH such as 1242x375, got {image_size!r}")
    width, height = int(match[1]), int(match[2])
    return policy.with_each_rig(lambda rig: rig.with_image_size(width, height))


def _how_to_go_on(num_done: int, num_frames: int) -> str:
    arguments = sys.argv[1:]
    command = shlex.join(["cadet-gen", *arguments, *([] if "--resume" in arguments else ["--resume"])])
    return f"at least {num_done} of {num_frames} frames are whole; go on with: {command}"


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
        f"more than half of these episodes': {episodes}; a longer --length or a larger --map shows more motion"
    )
