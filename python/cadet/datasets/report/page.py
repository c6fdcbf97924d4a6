"""The page: one HTML file that needs nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterable
from html import escape
from pathlib import Path
from string import Template
from typing import Final

from cadet import _cadet
from cadet._util.checks import check_number
from cadet._util.user_files import check_out_path
from cadet.datasets.report.charts import distance, histogram
from cadet.datasets.report.gallery import Picture, class_color, pictures
from cadet.datasets.report.gather import Facts, gather
from cadet.datasets.report.quantities import CLASSES, POINTS, QUANTITIES
from cadet.datasets.report.statistics import Statistics, kitti_statistics, mix
from cadet.formats.kitti.files.folder import write_whole

PAPER_FRAMES: Final = 10_000
PAPER_COUNTS: Final = {"Car": 13_989, "Pedestrian": 4_895}
"""Objects in the 2019 paper's set (Brekke, Vatsendvik, and Lindseth, section 4)."""

_TEMPLATE: Final = Path(__file__).parent / "template"
_MOST_PICTURES: Final = 100
_OPEN: Final = ("Car", "Pedestrian")


def write_report(root: str | Path, path: str | Path, *, num_frames: int = 10, workers: int = 1) -> Path:
    """Write a page about a dataset, whole or not at all.

    Args:
        root: a KITTI folder, generated or real.
        path: of the page; ends in .html. A page that is there is replaced.
        num_frames: frames in the gallery.
        workers: processes that read frames; they change nothing in the page.

    Returns:
        The path.

    Raises:
        CadetError: another name, no folder for it, or numbers out of range.
        MissingFileError: no KITTI folder, or one without labels.
        CadetError: more than half of the frames cannot be read; `cadet check` finds all of them.
    """
    path = check_out_path(path, (".html", ".htm"))
    check_number("", "num_frames", num_frames, 0, _MOST_PICTURES, whole=True)
    facts = gather(root, workers=workers)
    write_whole({path: _page(facts, pictures(root, int(num_frames))).encode("utf-8", "backslashreplace")})
    return path


def _page(facts: Facts, gallery: list[Picture]) -> str:
    kitti = kitti_statistics()
    return Template(_part("page.html")).substitute(
        title=escape(facts.name),
        style=_part("style.css"),
        script=_part("cloud.js"),
        facts=_facts_line(facts),
        counts=_counts(facts.statistics, kitti),
        counts_note=_counts_note(facts.statistics),
        tiles=_tiles(facts),
        mix=_mix(facts),
        gallery=_gallery(gallery),
        clouds="".join(_cloud(picture) for picture in gallery),
        distributions="".join(_distributions(facts.statistics, kitti)),
        kitti_frames=f"{kitti.num_frames:,}",
        kitti_point_frames=_num_point_frames(kitti),
        version=escape(_cadet.__version__),
    )


def _part(name: str) -> str:
    return (_TEMPLATE / name).read_text(encoding="utf-8")


def _facts_line(facts: Facts) -> str:
    parts = [_many(facts.statistics.num_frames, "labeled frame")]
    if facts.num_unlabeled:
        parts.append(f"{facts.num_unlabeled:,} without labels")
    if facts.num_unreadable:
        parts.append(f"{facts.num_unreadable:,} that cannot be read")
    if facts.num_episodes:
        parts.append(_many(facts.num_episodes, "episode"))
    parts += [f"{split} {number:,}" for split, number in facts.splits.items()]
    parts += [f"{name} {value}" for name, value in facts.made_with.items()]
    return escape(" · ".join(parts))


def _counts(own: Statistics, kitti: Statistics) -> str:
    head = (
        '<thead><tr><th>Class</th><th>Objects</th><th class="frames-with">Frames with any</th>'
        "<th>Per 10,000 frames</th>"
        "<th>KITTI per 10,000</th><th>2019 paper in 10,000</th></tr></thead>"
    )
    rows = []
    others = sorted(set(own.labels) - {*CLASSES, "DontCare"})
    for name in (*CLASSES, *others, "DontCare"):
        paper = f"{PAPER_COUNTS[name]:,}" if name in PAPER_COUNTS else "-"
        with_any = f"{own.num_frames_with[name]:,}" if name in CLASSES else "-"
        cells = (_per_10000(own, name), _per_10000(kitti, name), paper)
        dot = f'<span class="dot" style="background:{class_color(name)}"></span>'
        rows.append(
            f'<tr><th>{dot}{escape(name)}</th><td>{own.labels[name]:,}</td><td class="frames-with">{with_any}</td>'
            + "".join(f"<td>{cell}</td>" for cell in cells)
            + "</tr>"
        )
    return f"{head}<tbody>{''.join(rows)}</tbody>"


def _counts_note(own: Statistics) -> str:
    parts = []
    for name, count in PAPER_COUNTS.items():
        ratio = own.labels[name] / own.num_frames * PAPER_FRAMES / count
        parts.append(f"{ratio:.2f} times as many {name.lower()}s")
    return f"Per frame, {' and '.join(parts)} as in the 2019 paper's set of {PAPER_FRAMES:,} samples."


def _per_10000(statistics: Statistics, name: str) -> str:
    return f"{statistics.labels[name] * PAPER_FRAMES / statistics.num_frames:,.0f}"


def _tiles(facts: Facts) -> str:
    own = facts.statistics
    num_objects = own.labels.total() - own.labels["DontCare"]
    tiles = [
        ("Objects a frame", f"{num_objects / own.num_frames:.2f}"),
        ("DontCare regions a frame", f"{own.labels['DontCare'] / own.num_frames:.2f}"),
        ("Frames with a car", f"{100.0 * own.num_frames_with['Car'] / own.num_frames:.0f} %"),
        ("Frames with a pedestrian", f"{100.0 * own.num_frames_with['Pedestrian'] / own.num_frames:.0f} %"),
    ]
    if facts.num_points:
        tiles.append(("Returns a scan", f"{facts.num_points / own.num_frames:,.0f}"))
    return "".join(f"<div><dt>{escape(name)}</dt><dd>{value}</dd></div>" for name, value in tiles)


def _mix(facts: Facts) -> str:
    cards = []
    for name, counts in facts.recorded.items():
        expected = facts.expected.get(name, {})
        # What the policy draws, but has not yet, is part of the mix.
        rows = mix({**dict.fromkeys(expected, 0), **counts})
        highest = max([share for _, _, share in rows] + list(expected.values()))
        bars = "".join(_bar(value, count, share, expected.get(value), highest) for value, count, share in rows)
        note = '<p class="note">Shares of frames; the mark is what the policy draws.</p>' if expected else ""
        cards.append(f'<div class="card"><h3>{escape(name.capitalize())}</h3>{bars}{note}</div>')
    none = '<p class="note">No frame has a record (<code>meta</code>) of its weather, district, map, or rig.</p>'
    return "".join(cards) or none


def _bar(name: str, count: int, share: float, expected: float | None, highest: float) -> str:
    mark = "" if expected is None else f'<span class="mark" style="left:{100.0 * expected / highest:.1f}%"></span>'
    shown = escape(name.replace("_", " "))
    return (
        f'<div class="bar"><span class="name" title="{shown}">{shown}</span><span class="track">'
        f'<span class="fill" style="width:{100.0 * share / highest:.1f}%"></span>{mark}</span>'
        f'<span class="value">{count:,} · {100.0 * share:.1f} %</span></div>'
    )


def _gallery(gallery: list[Picture]) -> str:
    if not gallery:
        return '<p class="note">None were asked for.</p>'
    switches = "".join(
        f'<label><input type="checkbox" name="{name}"{checked}> {title}</label>'
        for name, title, checked in (
            ("box3d", "3D boxes", " checked"),
            ("box2d", "2D boxes", ""),
            ("dontcare", "DontCare", " checked"),
        )
    )
    options = "".join(f'<option value="{escape(one.frame_id)}">{escape(one.frame_id)}</option>' for one in gallery)
    views = "".join(f'<button data-view="{name}">From {name}</button>' for name in ("behind", "above", "side"))
    viewer = (
        '<div class="viewer"><div class="row"><label>Scan of frame '
        f'<select id="cloud-frame">{options}</select></label>{views}</div>'
        '<canvas id="cloud" tabindex="0" role="img" aria-label="The scan; a drag or the arrow keys turn it"></canvas>'
        '<p class="note">Drag to turn, pinch or click and scroll to zoom; arrow keys, + and - do the same. Every n-th '
        "return, up to 60 m; color is height, brightness is intensity.</p></div>"
    )
    figures = "".join(
        f"<figure>{one.svg}<figcaption><span>{escape(' · '.join(filter(None, (one.frame_id, one.caption))))}</span>"
        f'<button data-cloud="{escape(one.frame_id)}">Show its scan</button></figcaption></figure>'
        for one in gallery
    )
    return f'{viewer}<div class="switches">{switches}</div><div class="frames">{figures}</div>'


def _cloud(picture: Picture) -> str:
    content = json.dumps(picture.cloud, separators=(",", ":"))
    return f'<script type="application/json" id="cloud-{escape(picture.frame_id)}">{content}</script>\n'


def _distributions(own: Statistics, kitti: Statistics) -> Iterable[str]:
    for name in CLASSES:
        number, real = own.labels[name], kitti.labels[name]
        is_open = " open" if name in _OPEN else ""
        cards = "".join(_chart(quantity, name, own, kitti) for quantity in QUANTITIES)
        yield (
            f"<details{is_open}><summary>{escape(name.replace('_', ' '))}: {number:,} objects, KITTI {real:,}</summary>"
            f'<div class="cards">{cards}</div></details>'
        )


def _chart(key: str, name: str, own: Statistics, kitti: Statistics) -> str:
    quantity = QUANTITIES[key]
    ours, real = own.counts(key, name), kitti.counts(key, name)
    apart = distance(ours, real)
    shown = "" if apart is None else f'<span class="js">JS {apart:.2f}</span>'
    return f'<div class="card"><h3>{shown}{escape(quantity.title)}</h3>{histogram(quantity, ours, real)}</div>'


def _num_point_frames(kitti: Statistics) -> str:
    """Return how many of KITTI's boxes have their returns counted, as text."""
    total = sum(int(counts.sum()) for counts in kitti.histograms.get(POINTS.name, {}).values())
    return f"{total:,} boxes of 200"


def _many(number: int, name: str) -> str:
    return f"{number:,} {name}{'' if number == 1 else 's'}"
