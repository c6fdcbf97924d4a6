"""One step of training: losses, gradients, the update of the parameters and of their moving average."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any, Final, cast

import torch
from torch import Tensor, nn

from avod.config import Config, TrainingConfig
from avod.data.order import seeded, stream_seed, torch_generator
from avod.data.sample import Sample
from avod.model.making import abstract_network, make_network
from avod.model.network import AnyNetwork
from cadet.errors import CadetError

MAX_WEIGHTS: Final = 10**9
"""The most weights of a network that is trained: with gradients and Adam's averages four numbers each, 16 gigabytes."""


class NonFiniteLossError(CadetError, FloatingPointError):
    """A loss or gradient that is not a number: training cannot go on."""


def learning_rate(step: int, config: TrainingConfig) -> float:
    """Return the learning rate of a step, counted from 0.

    Reference: Smith and Topin, "Super-Convergence" (2018), for "one_cycle".
    """
    if config.schedule == "one_cycle":
        rise = max(config.steps // 4, 1)
        if step < rise:
            return config.learning_rate * (0.1 + 0.9 * step / rise)
        return config.learning_rate * (1.0 + math.cos(math.pi * (step - rise) / (config.steps - rise))) / 2.0
    return config.learning_rate * config.decay_factor ** (step // config.decay_steps)


def make_optimizer(network: nn.Module, config: TrainingConfig) -> torch.optim.Adam:
    """Make AVOD's optimizer: Adam without weight decay, which is configured there but never reaches the loss."""
    return torch.optim.Adam(network.parameters(), lr=config.learning_rate, betas=(0.9, 0.999), eps=1e-8)


def training_step(
    network: nn.Module,
    optimizer: torch.optim.Optimizer,
    samples: Sequence[Sample],
    config: Config,
    *,
    step: int,
    seed: int,
    rank: int = 0,
) -> dict[str, Tensor]:
    """Train on the samples of one step.

    All that is drawn, dropout too, comes from (seed, step, rank), so a step can be repeated alone; PyTorch's own
    generators are left as they were.

    Args:
        network: in training mode, perhaps wrapped for several processes.
        optimizer: of its parameters.
        samples: on the network's device.
        config: the detector and its training.
        step: counted from 0.
        seed: of the training.
        rank: of this process.

    Returns:
        The losses by name, averaged over the samples.

    Raises:
        NonFiniteLossError: a loss or gradient is NaN or infinite; step, frames and term are named.
    """
    generator = torch_generator(seed, "step", step, rank)
    for group in optimizer.param_groups:
        group["lr"] = learning_rate(step, config.training)
    optimizer.zero_grad(set_to_none=True)
    with seeded(samples[0].bev.device, stream_seed(seed, "dropout", step, rank)):
        outputs: list[Any] = network(samples, generator, step=step)
    terms: dict[str, Tensor] = {}
    unwrapped = cast("AnyNetwork", getattr(network, "module", network))
    for sample, output in zip(samples, outputs, strict=True):
        losses = unwrapped.losses(output, sample, generator)
        check_losses(losses, step, sample.frame_id)
        terms = {name: terms.get(name, 0.0) + value / len(samples) for name, value in losses.items()}
    terms["total"].backward()  # type: ignore[no-untyped-call]
    clip_gradients(network, config.training.max_gradient_norm, step, [sample.frame_id for sample in samples])
    optimizer.step()
    return {name: value.detach() for name, value in terms.items()}


def check_losses(losses: dict[str, Tensor], step: int, frame_id: str) -> None:
    """Refuse losses that are no numbers.

    Raises:
        NonFiniteLossError: naming step, frame and term.
    """
    if not bool(torch.isfinite(losses["total"])):
        term, value = next((name, value) for name, value in losses.items() if not bool(torch.isfinite(value)))
        raise NonFiniteLossError(f"step {step}: the {term} loss of frame {frame_id} is {value.item()}")


def clip_gradients(network: nn.Module, max_norm: float, step: int, frame_ids: Sequence[str]) -> None:
    """Clip each parameter's gradient to a norm of its own, not all to a common one.

    Raises:
        NonFiniteLossError: a gradient is NaN or infinite; step, frames and parameter are named.
    """
    named = [(name, p.grad) for name, p in network.named_parameters() if p.grad is not None]
    norms = torch.stack([gradient.norm() for _, gradient in named])
    if not bool(torch.isfinite(norms).all()):
        name = next(name for (name, _), norm in zip(named, norms, strict=True) if not bool(torch.isfinite(norm)))
        name = name.removeprefix("module.")  # of the wrapper for several processes
        raise NonFiniteLossError(f"step {step}: the gradient of {name} is not finite on frame {', '.join(frame_ids)}")
    scales = max_norm / norms.clamp(min=max_norm)
    for (_, gradient), scale in zip(named, scales, strict=True):
        gradient.mul_(scale)


def new_network(config: Config, seed: int) -> AnyNetwork:
    """Make a network whose weights follow from the seed.

    Raises:
        CadetError: the configuration asks for more than `MAX_WEIGHTS` weights.
    """
    count = sum(parameter.numel() for parameter in abstract_network(config).parameters())
    if count > MAX_WEIGHTS:
        raise CadetError(f"the configuration's network has {count:,} weights, expected at most {MAX_WEIGHTS:,}")
    with seeded(torch.device("cpu"), stream_seed(seed, "weights")):
        return make_network(config)


def train_mode(network: AnyNetwork, config: TrainingConfig) -> None:
    """Set a network to training, but for what does not learn.

    Raises:
        CadetError: no parameter is called as `config.learns` says.
    """
    network.train()
    if not config.learns:
        return
    for name, parameter in network.named_parameters():
        parameter.requires_grad_(name.startswith(config.learns))
    if not any(parameter.requires_grad for parameter in network.parameters()):
        raise CadetError(f"Config.training.learns: no parameter's name begins with {config.learns!r}")
    for module in network.modules():
        parameters = list(module.parameters())
        if parameters and not any(parameter.requires_grad for parameter in parameters):
            module.eval()


class WeightAverage:
    """The average of the weights, and of the normalizations' statistics, over the last steps.

    Args:
        network: whose weights it begins with.
        decay: of the average in a step, once training has gone on for long; before, it is (1 + step) / (10 + step), so
            that the first weights are forgotten.

    Attributes:
        network: has the averages, for evaluation.

    Reference: `num_updates` of TensorFlow's ExponentialMovingAverage.
    """

    def __init__(self, network: AnyNetwork, decay: float) -> None:
        self.network = copy.deepcopy(network).eval().requires_grad_(False)
        self._decay = decay

    def update(self, network: AnyNetwork, step: int) -> None:
        """Take in the weights after a step, counted from 0."""
        decay = min(self._decay, (1.0 + step) / (10.0 + step))
        averages, values = self.network.state_dict(), network.state_dict()
        for name, average in averages.items():
            average.lerp_(values[name], 1.0 - decay)
