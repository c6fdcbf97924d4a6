"""The tests of a cell: its checkpoint is chosen on the first set's validation frames, and tested on those of all."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Final

from avod.detector import Detector
from avod.evaluate import Scored, best, score
from avod.predict import predict_all
from avod.train.checkpoint import forget_old, keep_checkpoint, read_checkpoint
from cadet import evaluate, kitti
from cadet._util.sink import LocalSink
from cadet.evaluation import Report
from cadet.formats.kitti import labels_from_text, text_from_labels
from tools.experiments.cells import REAL, Cell
from tools.experiments.machine import Machine
from tools.experiments.outcome import numbers_of, outcome_file, write_outcome
from tools.experiments.record import cell_folder
from tools.experiments.sets import FrameSet, Sets
from tools.experiments.training import BEST, candidates

_LEVELS: Final = "kitti"


def run_tests(cell: Cell, out: Path, sets: Sets, machine: Machine) -> bool:
    """Run those tests of a cell that are not done.

    Args:
        cell: trained to its end.
        out: the experiments' folder.
        sets: of frames, by name.
        machine: that it runs on.

    Returns:
        Whether all are done; else it was told to stop.
    """
    folder = cell_folder(out, cell.name)
    for number, tested in enumerate(cell.tests):
        if outcome_file(folder, tested).is_file():
            continue
        paths = candidates(cell, out) if number == 0 or not cell.stops else [folder / BEST]
        if not _test(cell, folder, paths, tested, sets[tested], machine):
            return False
        if number == 0 and cell.stops and machine.processes.is_first:
            # A hundred of them would fill a disk.
            forget_old(paths[-1].parent, 1)
    return True


def _test(cell: Cell, folder: Path, paths: Sequence[Path], tested: str, frames: FrameSet, machine: Machine) -> bool:
    processes = machine.processes
    detectors = [Detector(path, device=processes.device, precision=machine.precision) for path in paths]
    ids = frames.val_ids
    found = _detect(detectors, frames, ids, f"{cell.name} on {tested} frames", machine)
    if found is None:
        return False
    if processes.is_first:
        reports = [_evaluate(frames, ids, texts, cell.class_name, _LEVELS) for texts in found]
        names = (cell.class_name,)
        scored = [Scored(path, report, score(report, names)) for path, report in zip(paths, reports, strict=True)]
        chosen = best(scored)
        texts = found[scored.index(chosen)]
        by_levels = {_LEVELS: chosen.report}
        if tested != REAL:
            by_levels["large_small"] = _evaluate(frames, ids, texts, cell.class_name, "large_small")
        sink = LocalSink(folder / f"detections_{tested}")
        for frame_id, text in texts.items():
            sink.put(f"{frame_id}.txt", text.encode("ascii"))
        sink.remove_partial()
        if cell.stops and chosen.path.name != BEST:
            keep_checkpoint(chosen.path, folder / BEST)
        step = read_checkpoint(chosen.path).step
        write_outcome(folder, tested, step, len(ids), numbers_of(by_levels, cell.class_name))
    processes.any(False)  # Nobody goes on before all is written.
    return True


def _detect(
    detectors: Sequence[Detector], frames: FrameSet, ids: tuple[str, ...], name: str, machine: Machine
) -> list[dict[str, str]] | None:
    """Return each detector's result files by id, in the ids' order; None if it was told to stop."""
    processes = machine.processes
    share = ids[processes.rank :: processes.world_size]
    texts: list[dict[str, str]] = [{} for _ in detectors]
    is_stopped = False
    with (
        machine.progress(len(share), name, "frames") as advance,
        closing(predict_all(detectors, frames.folder, share, workers=machine.workers)) as results,
    ):
        for done, (frame_id, by_detector) in enumerate(results, start=1):
            for own, labels in zip(texts, by_detector, strict=True):
                own[frame_id] = text_from_labels(labels)
            advance(done, "")
            if machine.should_stop():
                is_stopped = True
                break
    if processes.any(is_stopped):
        return None
    shares = processes.gathered(texts)
    merged = [{key: text for part in shares for key, text in part[index].items()} for index in range(len(detectors))]
    return [{frame_id: by_id[frame_id] for frame_id in ids} for by_id in merged]


def _evaluate(frames: FrameSet, ids: tuple[str, ...], texts: dict[str, str], class_name: str, levels: str) -> Report:
    truths = {frame_id: kitti.read_labels(frames.folder, frame_id) for frame_id in ids}
    found = {frame_id: labels_from_text(text) for frame_id, text in texts.items()}
    return evaluate(truths, found, classes=(class_name,), levels=levels)
