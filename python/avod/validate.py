"""How well a network in training does on frames that it does not learn from."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch

from avod.config import Config
from avod.data.dataset import readable_labels
from avod.data.loading import prepared
from avod.data.order import frame_number, torch_generator
from avod.data.packing import on_device
from avod.device import Processes
from avod.evaluate import score
from avod.model.network import AnyNetwork
from avod.results import detections
from avod.train.log import Validated
from cadet import kitti
from cadet.errors import CadetError
from cadet.evaluation import evaluate
from cadet.formats.kitti import labels_from_text, text_from_labels
from cadet.formats.kitti.files.unreadable import READING_ERRORS, Unreadable
from cadet.formats.kitti.image_sets import check_not_empty
from cadet.formats.webdataset import open_dataset


class Validator:
    """Computes losses and KITTI's AP of a network over a split, for `avod.train.train`.

    Mini-batches of the losses are drawn from a stream of the frame's own, so that validations can be compared with each
    other, and training is the same with and without them.

    Args:
        root: a KITTI folder with labels, or a folder of shards.
        split: a list of its `ImageSets`; None for every frame.
        config: of the detector.
        workers: processes that prepare frames; 0 does so in between.
        should_stop: called after each frame; on True the validation is abandoned.
        on_frame: called with the number of this process's frames done, and their total.

    Raises:
        MissingFileError: no folder, split, frame, or label file.
    """

    def __init__(
        self,
        root: str | Path,
        split: str | None,
        config: Config,
        *,
        workers: int = 0,
        should_stop: Callable[[], bool] = lambda: False,
        on_frame: Callable[[int, int], None] = lambda done, total: None,
    ) -> None:
        self._frames = open_dataset(root, split)
        check_not_empty(self._frames.ids, root, split)
        self._truths = readable_labels(self._frames, root)
        self.ids = tuple(self._truths)
        self._config, self._workers, self._should_stop = config, workers, should_stop
        self._on_frame = on_frame

    def __call__(self, network: AnyNetwork, step: int, processes: Processes) -> Validated | None:
        """Validate a network, which is left in evaluation mode.

        Args:
            network: the same in all processes, which share the frames out.
            step: how many steps are done, for messages.
            processes: of the training.

        Returns:
            What was found; None if the validation was told to stop.

        Raises:
            CadetError: more than half of the frames cannot be read, or outputs that are no numbers.
        """
        network.eval()
        ids = self.ids[processes.rank :: processes.world_size]
        unreadable = Unreadable(self._frames.folder)
        texts: dict[str, str] = {}
        losses: dict[str, dict[str, float]] = {}
        is_stopped = False
        with prepared(self._frames, ids, self._config, self._workers) as items:
            for done, (frame_id, item) in enumerate(zip(ids, items, strict=True), start=1):
                if isinstance(item, READING_ERRORS):
                    unreadable.add(frame_id, item)
                    continue
                texts[frame_id], losses[frame_id] = self._judge(network, *item, step=step, device=processes.device)
                self._on_frame(done, len(ids))
                if self._should_stop():
                    is_stopped = True
                    break
        if processes.any(is_stopped):
            return None
        unreadable.say(len(ids))
        shares = processes.gathered((texts, losses))
        found = {frame_id: labels_from_text(text) for share in shares for frame_id, text in share[0].items()}
        by_frame = {frame_id: terms for share in shares for frame_id, terms in share[1].items()}
        names = self._config.class_names
        # In the split's order, whoever computed what.
        judged = [frame_id for frame_id in self.ids if frame_id in found]
        truths = {frame_id: self._truths[frame_id] for frame_id in judged}
        report = evaluate(truths, {frame_id: found[frame_id] for frame_id in judged}, classes=names)
        means = {
            term: sum(by_frame[frame_id][term] for frame_id in judged) / len(judged) for term in by_frame[judged[0]]
        }
        return Validated(means, score(report, names), {name: score(report, (name,)) for name in names})

    def _judge(
        self,
        network: AnyNetwork,
        sample: Any,
        calib: kitti.Calibration,
        *,
        step: int,
        device: torch.device,
    ) -> tuple[str, dict[str, float]]:
        sample = on_device(sample, device)
        with torch.inference_mode():
            (features,) = network.extract([sample])
            outputs = network.judge(sample, features)
            generator = torch_generator(0, "validation", frame_number(sample.frame_id))
            losses = network.losses(network.judge(sample, features, generator), sample, generator)
            numbers = {name: float(value) for name, value in losses.items()}
            if not (outputs.is_finite and math.isfinite(numbers["total"])):
                raise CadetError(f"validation after step {step}: the outputs on frame {sample.frame_id} are not finite")
            labels = detections(network, outputs, sample, calib, self._config)
        return text_from_labels(labels), numbers
