"""The numbers of a training: frozen, checked when made."""

from __future__ import annotations

from dataclasses import dataclass

from cadet._util.checks import check_number


@dataclass(frozen=True, kw_only=True)
class TrainingConfig:
    """The optimizer, its schedule, and what is drawn.

    Raises:
        CadetError: a number outside its range.
    """

    steps: int = 120_000
    """Steps of the whole training."""
    frames_per_step: int = 1
    """Frames whose losses are averaged in a step, on each device."""
    min_objects: int = 1
    """Frames with fewer objects of the classes are left out."""
    learning_rate: float = 1e-4
    """At step 0."""
    decay_factor: float = 0.8
    """The learning rate is multiplied by this ..."""
    decay_steps: int = 30_000
    """... whenever this many steps have passed."""
    max_gradient_norm: float = 1.0
    """Each parameter's gradient is clipped to this norm on its own."""
    label_smoothing: float = 0.001
    """Taken from the right class and shared among the others."""
    flip: bool = True
    """Mirror half of the samples."""
    pca_jitter: bool = True
    """Shift the colors of half of the samples along their principal axes."""
    average_decay: float = 0.0
    """Of a moving average of the weights, which checkpoints then hold; 0 keeps the last step's weights, as in AVOD."""
    checkpoint_steps: int = 2_000
    """Between two checkpoints."""

    def __post_init__(self) -> None:
        # Nine digits name a checkpoint's folder.
        for name in ("steps", "decay_steps", "checkpoint_steps"):
            check_number("TrainingConfig", name, getattr(self, name), 1, 999_999_999, whole=True)
        check_number("TrainingConfig", "frames_per_step", self.frames_per_step, 1, 1024, whole=True)
        check_number("TrainingConfig", "min_objects", self.min_objects, 1, whole=True)
        check_number("TrainingConfig", "learning_rate", self.learning_rate, 1e-12, 10)
        check_number("TrainingConfig", "decay_factor", self.decay_factor, 1e-6, 1)
        check_number("TrainingConfig", "max_gradient_norm", self.max_gradient_norm, 1e-12)
        check_number("TrainingConfig", "average_decay", self.average_decay, 0, 0.999999)
        check_number("TrainingConfig", "label_smoothing", self.label_smoothing, 0, 0.5)
