"""How large the experiments are: configurations, lengths of trainings, and how checkpoints are chosen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from avod.config import Config

CLASSES: Final[Mapping[str, str]] = {"Car": "car", "Pedestrian": "ped"}
"""The paper's classes, and what their configurations are called."""

MAPS: Final = ("default", "max3_density3", "max_min_density")
"""The paper's configurations of the bird's-eye-view maps."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """How weights that know simulated frames are tuned on real ones.

    Attributes:
        steps: of the tuning.
        learning_rate: at its first step.
        decay_factor: the learning rate is multiplied by this ...
        decay_steps: ... whenever this many steps have passed.
        branch_step: where it goes on from the training on simulated frames, with optimizer and schedule; None begins
            at step 0 with that training's last weights.
    """

    steps: int
    learning_rate: float
    decay_factor: float
    decay_steps: int
    branch_step: int | None = None


@dataclass(frozen=True, kw_only=True)
class Scale:
    """A size of the experiments.

    Attributes:
        name: of the scale.
        configs: name or file of the configuration, by class and maps.
        tuning: on real frames.
        few_steps: of each tuning on a few frames.
        last: how many last checkpoints the best is chosen from; with 1 nothing is chosen.
        has_one_map: its detector is none of AVOD's, with no maps to compare.
    """

    name: str
    configs: Mapping[tuple[str, str], str]
    tuning: Tuning
    few_steps: int
    last: int = 1
    has_one_map: bool = False

    def config(self, class_name: str, maps: str) -> Config:
        """Load the configuration of a class and maps."""
        return Config.named(self.configs[class_name, maps])


def _names(prefix: str, default: str) -> dict[tuple[str, str], str]:
    return {
        (class_name, maps): f"{prefix}{short}{default if maps == 'default' else f'_{maps}'}"
        for class_name, short in CLASSES.items()
        for maps in MAPS
    }


SCALES: Final[Mapping[str, Scale]] = {
    # The tuning of `tiny_car_tune`; 1,000 steps are a third of a whole training.
    "tiny": Scale(
        name="tiny",
        configs=_names("tiny_", ""),
        tuning=Tuning(steps=350, learning_rate=5e-4, decay_factor=0.5, decay_steps=250),
        few_steps=1_000,
    ),
    # The paper's: 120,000 steps, from step 90,000 on to 150,000 on real frames, the best of the last 20 checkpoints.
    # The rate is what the schedule has come to at step 90,000.
    "full": Scale(
        name="full",
        configs=_names("", "_default"),
        tuning=Tuning(steps=60_000, learning_rate=5.12e-5, decay_factor=0.8, decay_steps=30_000, branch_step=90_000),
        few_steps=60_000,
        last=20,
    ),
    # The packaged `center_all`, which finds all classes; tuned as `avod adapt` does.
    "center": Scale(
        name="center",
        configs={(class_name, MAPS[0]): "center_all" for class_name in CLASSES},
        tuning=Tuning(steps=400, learning_rate=1e-3, decay_factor=1.0, decay_steps=400),
        few_steps=400,
        has_one_map=True,
    ),
}
"""The scales by name."""


def with_length(config: Config, steps: int) -> Config:
    """Return a configuration that trains shorter or longer, its schedule stretched in proportion.

    Args:
        config: of the detector and its training.
        steps: of the whole training.
    """
    training, second = config.training, config.second_stage
    share = steps / training.steps

    def scaled(count: int) -> int:
        return max(1, round(count * share))

    return replace(
        config,
        training=replace(
            training,
            steps=steps,
            decay_steps=scaled(training.decay_steps),
            checkpoint_steps=scaled(training.checkpoint_steps),
        ),
        second_stage=replace(second, truth_steps=round(second.truth_steps * share)),
    )


def tuned_config(config: Config, tuning: Tuning) -> Config:
    """Return the configuration of a tuning that begins at step 0 with trained weights."""
    training = replace(
        config.training,
        steps=tuning.steps,
        learning_rate=tuning.learning_rate,
        decay_factor=tuning.decay_factor,
        decay_steps=tuning.decay_steps,
        checkpoint_steps=min(config.training.checkpoint_steps, tuning.steps),
    )
    return replace(config, training=training)
