"""What every network of a detector does: feature maps of samples, what it finds in them, its losses, its boxes."""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, TypeVar, cast

import torch
from torch import Tensor, nn

from avod.config import Config, DetectionConfig
from avod.data.sample import Sample
from avod.model.boxes import Boxes, classes_by_length, kept_boxes
from avod.model.parts import Part
from avod.model.refinement import PointRefinement, RefinementOutputs


@dataclass(frozen=True, eq=False, kw_only=True)
class Outputs:
    """What a network finds in a frame; by itself, only what its last stage learns from.

    Attributes:
        refinement: boxes as the points in them correct them; None where nothing is drawn, or without that stage.
    """

    refinement: RefinementOutputs | None = None

    @property
    def is_finite(self) -> bool:
        """Whether all that boxes are made of are numbers."""
        return True


FeaturesT = TypeVar("FeaturesT")
OutputsT = TypeVar("OutputsT", bound=Outputs)


class DetectionNetwork(nn.Module, ABC, Generic[FeaturesT, OutputsT]):
    """A network that finds objects in samples.

    Args:
        config: the detector.
    """

    TERMS: ClassVar[tuple[str, ...]]
    """Names of its own losses."""

    def __init__(self, config: Config) -> None:
        super().__init__()
        self.config = config
        self.refinement = PointRefinement(config.refinement) if config.refinement.max_points else None
        self.precision: torch.dtype | None = None
        """Type of the convolutions' and layers' arithmetic; None for float32. Boxes are always float32."""

    def forward(
        self,
        samples: Sequence[Sample],
        generator: torch.Generator | None = None,
        *,
        step: int | None = None,
        config: Config | None = None,
    ) -> list[OutputsT]:
        """Find objects in each sample.

        Args:
            samples: one or more.
            generator: on the CPU; draws all that losses need. Needed in training mode; in evaluation mode outputs can
                be judged by `losses` if it is given.
            step: of a training, counted from 0.
            config: other settings of a network with the same weights, such as the number of proposals; None for the
                network's own.

        Returns:
            The outputs of each sample.
        """
        if generator is not None and self.refinement is not None and self._learns_refinement_alone:
            none_found = samples[0].boxes_cam[:0]
            learned = [self.refinement.learned(sample, none_found, generator) for sample in samples]
            return [cast("OutputsT", Outputs(refinement=outputs)) for outputs in learned]
        return [
            self.judge(sample, features, generator, step=step, config=config)
            for sample, features in zip(samples, self.extract(samples), strict=True)
        ]

    @property
    def _learns_refinement_alone(self) -> bool:
        """Whether nothing before the last stage learns, and that one from copies of true boxes alone."""
        before = (p for name, p in self.named_parameters() if not name.startswith("refinement."))
        return self.training and not self.config.refinement.found_boxes and not any(p.requires_grad for p in before)

    @abstractmethod
    def extract(self, samples: Sequence[Sample]) -> list[FeaturesT]:
        """Make the feature maps of samples."""

    def judge(
        self,
        sample: Sample,
        features: FeaturesT,
        generator: torch.Generator | None = None,
        *,
        step: int | None = None,
        config: Config | None = None,
    ) -> OutputsT:
        """Find objects in the feature maps of a sample; arguments as for `forward`."""
        config = self.config if config is None else config
        outputs = self.find(sample, features, generator, step=step, config=config)
        if self.refinement is None or generator is None:
            return outputs
        with torch.no_grad():
            found_cam = self.decode(outputs, sample, config.detection).boxes_cam[: config.refinement.found_boxes]
        return replace(outputs, refinement=self.refinement.learned(sample, found_cam, generator))

    @abstractmethod
    def find(
        self,
        sample: Sample,
        features: FeaturesT,
        generator: torch.Generator | None,
        *,
        step: int | None,
        config: Config,
    ) -> OutputsT:
        """Find objects in the feature maps of a sample, before the last stage; arguments as for `forward`."""

    @abstractmethod
    def extractors(self) -> tuple[nn.Module, ...]:
        """Return the parts that make feature maps, for compiling them."""

    @abstractmethod
    def own_losses(self, outputs: OutputsT, sample: Sample, generator: torch.Generator) -> dict[str, Tensor]:
        """Compute the weighted losses that `TERMS` names."""

    @abstractmethod
    def decode(self, outputs: OutputsT, sample: Sample, config: DetectionConfig) -> Boxes:
        """Decode boxes and drop the lesser ones."""

    @abstractmethod
    def own_parts(self) -> tuple[Part, ...]:
        """List its parts before the last stage."""

    def parts(self) -> tuple[Part, ...]:
        """List its parts, in evaluation mode."""
        return self.own_parts() if self.refinement is None else (*self.own_parts(), *self.refinement.parts())

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the losses, the total last."""
        return (*self.TERMS, *(() if self.refinement is None else ("refinement",)), "total")

    def losses(self, outputs: OutputsT, sample: Sample, generator: torch.Generator) -> dict[str, Tensor]:
        """Compute the losses of a sample's outputs, which were made with a generator.

        Returns:
            Scalars by name, weights applied, the total last.
        """
        if type(outputs) is Outputs:
            terms = {name: sample.boxes_cam.new_zeros(()) for name in self.TERMS}
        else:
            terms = self.own_losses(outputs, sample, generator)
        if outputs.refinement is not None:
            terms["refinement"] = outputs.refinement.loss() * self.config.refinement.weight
        return terms | {"total": torch.stack(list(terms.values())).sum()}

    def boxes(self, outputs: OutputsT, sample: Sample, config: Config) -> Boxes:
        """Turn outputs into boxes, best first.

        Where the network has that stage, the points in boxes correct them, and a box's score becomes the root of its
        product with how well points fit the box. Its class may follow from its length (`classes_by_length`).
        """
        found = self.decode(outputs, sample, config.detection)
        passes = config.refinement.passes
        if self.refinement is None or passes == 0:
            return found
        # Others would stay below the least score, however well their points fit.
        may_count = found.scores >= config.detection.min_score**2
        scores, classes = found.scores[may_count], found.classes[may_count]
        boxes_cam, qualities = self.refinement(sample, found.boxes_cam[may_count], passes)
        scores = torch.sqrt(scores * qualities)
        if config.detection.classes_by_length:
            classes = classes_by_length(boxes_cam, config.classes)
        # Boxes that were corrected onto one object overlap now.
        kept = kept_boxes(boxes_cam, scores, classes, config.detection)
        return Boxes(boxes_cam[kept], scores[kept], classes[kept])

    def arithmetic(self, values: Tensor) -> contextlib.AbstractContextManager[object]:
        """Compute convolutions and layers with the network's precision meanwhile."""
        if self.precision is None:
            return contextlib.nullcontext()
        return torch.autocast(values.device.type, dtype=self.precision)


AnyNetwork = DetectionNetwork[Any, Any]
"""A network of any kind."""


def stacked(maps: list[Tensor]) -> Tensor:
    """Stack maps (C, H, W) channels last, which convolutions on processors with bf16 and on GPUs like."""
    return torch.stack(maps).contiguous(memory_format=torch.channels_last)
