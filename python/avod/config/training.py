"""The numbers of a training: frozen, checked when made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final, Literal

from cadet._util.checks import Limits, check_fields

_MOST_STEPS: Final = 999_999_999
"""Nine digits name a checkpoint's folder."""


@dataclass(frozen=True, kw_only=True)
class TrainingConfig:
    """The optimizer, its schedule, and what is drawn.

    Raises:
        CadetError: a number outside its range.
    """

    steps: Annotated[int, Limits(1, _MOST_STEPS)] = 120_000
    """Steps of the whole training."""
    frames_per_step: Annotated[int, Limits(1, 1024)] = 1
    """Frames whose losses are averaged in a step, on each device."""
    min_objects: Annotated[int, Limits(1)] = 1
    """Frames with fewer objects of the classes are left out."""
    schedule: Literal["steps", "one_cycle"] = "steps"
    """Of the learning rate: it falls in steps, as AVOD's, or rises from a tenth over the first quarter of the steps and
    falls to nothing along a cosine."""
    learning_rate: Annotated[float, Limits(1e-12, 10)] = 1e-4
    """At step 0, or the greatest of the cycle."""
    decay_factor: Annotated[float, Limits(1e-6, 1)] = 0.8
    """Of the schedule in steps: the learning rate is multiplied by this ..."""
    decay_steps: Annotated[int, Limits(1, _MOST_STEPS)] = 30_000
    """... whenever this many steps have passed."""
    max_gradient_norm: Annotated[float, Limits(1e-12)] = 1.0
    """Each parameter's gradient is clipped to this norm on its own."""
    label_smoothing: Annotated[float, Limits(0, 0.5)] = 0.001
    """Taken from the right class and shared among the others."""
    flip: bool = True
    """Mirror half of the samples."""
    pca_jitter: bool = True
    """Shift the colors of half of the samples along their principal axes."""
    average_decay: Annotated[float, Limits(0, 0.999999)] = 0.0
    """Of a moving average of the weights, which checkpoints then hold; 0 keeps the last step's weights, as in AVOD."""
    learns: str = ""
    """Beginning of the names of the parameters that learn, such as "refinement.heading"; the others, and their batch
    normalizations, stay as they are. All learn by default."""
    checkpoint_steps: Annotated[int, Limits(1, _MOST_STEPS)] = 2_000
    """Between two checkpoints."""

    def __post_init__(self) -> None:
        check_fields(self)
