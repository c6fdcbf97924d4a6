"""`cadet lidar` and `cadet fit-lidar`: sensors as TOML, known ones and fitted ones."""

from __future__ import annotations

from pathlib import Path

import click

from cadet._util.plain_tables import toml_of_table
from cadet._util.text_tables import aligned
from cadet.datasets.lidar_fit import LidarFit, fit_lidar
from cadet.errors import CadetError, MissingFileError
from cadet.formats.kitti.files.folder import write_whole
from cadet.sensors.lidar import LIDAR_PRESETS, Lidar


@click.command(name="lidar")
@click.argument("name", metavar="NAME|FILE")
def lidar_command(name: str) -> None:
    """Print a LIDAR as TOML, to check it or to start one's own from.

    \b
    cadet lidar vlp16 > mine.toml
    cadet-gen out -n 100 --lidar mine.toml

    Known: {presets}
    """  # noqa: D301 - click reads the backspace
    lidar = Lidar.named(name)
    click.echo(toml_of_table({**lidar._table(), **lidar.beam_table()._table()}), nl=False)


lidar_command.help = (lidar_command.help or "").replace("{presets}", ", ".join(LIDAR_PRESETS))


@click.command(name="fit-lidar")
@click.argument("scans", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o", "--out", required=True, type=click.Path(path_type=Path, dir_okay=False), help="The TOML file to write."
)
@click.option("--name", help="The sensor's name.  [default: the file's]")
def fit_lidar_command(scans: tuple[Path, ...], out: Path, name: str | None) -> None:
    """Fit a LIDAR to scans (.bin, .pcd, .ply, .npy), folders of them, or KITTI's or nuScenes' folders.

    \b
    cadet fit-lidar kitti/training/velodyne -o mine.toml
    cadet-gen out -n 100 --lidar mine.toml
    """  # noqa: D301 - click reads the backspace
    if out.suffix != ".toml":
        raise CadetError(f"-o: expected a file that ends in .toml, got {str(out)!r}")
    if not out.parent.is_dir():
        raise MissingFileError(f"{out}: no such folder: {out.parent}")
    fit = fit_lidar(scans, out.stem if name is None else name)
    text = fit.to_toml()
    # Nothing is written that the generator would refuse.
    Lidar.custom(fit.table)
    _print(fit)
    write_whole({out: text.encode("utf-8")})
    click.echo(f"wrote {out}")


_HEADS = (
    *(("ring", ""), ("elev.", "deg"), ("+-", "deg"), ("height", "mm"), ("+-", "mm"), ("offset", "deg")),
    *(("range", "mm"), ("points", ""), ("resid.", "mm"), ("outl.", "%"), ("lost", "%"), ("zero", "%"), ("gain", "")),
)


def _ring_table(fit: LidarFit) -> list[str]:
    """Return a line for each ring, narrow enough for a terminal of 80 columns."""
    rows = [tuple(cells) for cells in zip(*_HEADS, strict=True)]
    for number, ring in enumerate(fit.rings):
        laser = ring.laser
        row = (
            str(number),
            f"{laser.elevation_deg:+.3f}",
            f"{ring.elevation_sd_deg:.4f}",
            f"{1e3 * laser.height_m:.1f}",
            f"{1e3 * ring.height_sd_m:.2f}",
            f"{laser.azimuth_offset_deg:.3f}",
            f"{1e3 * laser.range_offset_m:+.0f}",
            _points(ring.num_points),
            f"{1e3 * ring.median_residual_m:.2f}",
            f"{100.0 * ring.outlier_share:.1f}",
            f"{100.0 * ring.missing_share:.0f}",
            f"{100.0 * ring.zero_share:.0f}",
            f"{laser.gain:.2f}",
        )
        rows.append(row)
    return aligned(rows, num_left=0, gap=" ")


def _points(count: int) -> str:
    return str(count) if count < 10_000_000 else f"{1e-6 * count:.1f}M"


def _print(fit: LidarFit) -> None:
    beams = fit.table
    lines = _ring_table(fit)
    lines.append(
        f"{len(fit.rings)} rings, {beams.num_columns} columns; {fit.num_points} points of {fit.num_scans} scans, "
        f"median residual {1e3 * fit.median_residual_m:.2f} mm; range {beams.min_range_m:g} to "
        f"{beams.max_range_m:g} m, noise about {1e3 * beams.range_noise_m:.0f} mm"
    )
    click.echo("\n".join([*lines, *fit.remarks()]))
