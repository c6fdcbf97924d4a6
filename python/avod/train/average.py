"""A moving average of a network's weights: steadier than the last step's."""

from __future__ import annotations

import copy

from avod.model.network import AvodNetwork


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

    def __init__(self, network: AvodNetwork, decay: float) -> None:
        self.network = copy.deepcopy(network).eval().requires_grad_(False)
        self._decay = decay

    def update(self, network: AvodNetwork, step: int) -> None:
        """Take in the weights after a step, counted from 0."""
        decay = min(self._decay, (1.0 + step) / (10.0 + step))
        averages, values = self.network.state_dict(), network.state_dict()
        for name, average in averages.items():
            average.lerp_(values[name], 1.0 - decay)
