"""What AVOD's network finds in a frame."""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor

from avod.model.avod.targets import ProposalTargets
from avod.model.network import Outputs
from cadet._util.summary import summary


@dataclass(frozen=True, eq=False)
class FrameOutputs(Outputs):
    """The network's outputs for one frame, N anchors and P proposals.

    Attributes:
        anchor_logits: (N, 2) of background and object.
        anchor_offsets: (N, 6).
        proposals: (P, 6) anchors as the first stage regresses them, best first; with targets those that were sampled.
        class_logits: (P, K + 1), background first.
        box_offsets: (P, 10) from the proposals' corners and heights, meters.
        vectors: (P, 2) of headings.
        targets: what the proposals should become; None where nothing is drawn.
    """

    anchor_logits: Tensor
    anchor_offsets: Tensor
    proposals: Tensor
    class_logits: Tensor
    box_offsets: Tensor
    vectors: Tensor
    targets: ProposalTargets | None = None

    def __repr__(self) -> str:
        return summary(
            self, **{f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("targets", "refinement")}
        )

    @property
    def is_finite(self) -> bool:
        """Whether all that boxes are made of are numbers."""
        return bool(torch.isfinite(self.class_logits).all() & torch.isfinite(self.box_offsets).all())
