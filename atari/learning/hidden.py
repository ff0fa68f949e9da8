"""`last_hidden`: the last hidden layer of any network, as features of observations."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from torch import Tensor, nn


def last_hidden(network: nn.Module, compute: Callable[[Any], Any]) -> Callable[[Any], npt.NDArray[np.float32]] | None:
    """A function of observations that returns the input of the linear layer that a network computes last.

    Args:
        network: the network. It is not changed.
        compute: computes the network on observations (n, ...).

    Returns:
        The function, whose result is (n, width) float32; None for a network without linear layers that PyTorch can
        watch, such as TorchScript.

    Example:
        >>> import torch
        >>> from atari.learning.hidden import last_hidden
        >>> layers = torch.nn.Sequential(torch.nn.Linear(128, 5), torch.nn.ReLU(), torch.nn.Linear(5, 3))
        >>> features = last_hidden(layers, layers)
        >>> features(torch.zeros(2, 128)).shape
        (2, 5)
    """
    layers = [part for part in network.modules() if isinstance(part, nn.Linear)]
    if not layers:
        return None

    def features(observations: Any) -> npt.NDArray[np.float32]:
        inputs: list[Tensor] = []

        def keep(_: nn.Module, given: tuple[Tensor, ...]) -> None:
            inputs.extend(given[:1])

        handles = [layer.register_forward_pre_hook(keep) for layer in layers]
        try:
            compute(observations)
        finally:
            for handle in handles:
                handle.remove()
        if not inputs:
            raise ValueError(f"{type(network).__name__} has linear layers, but computes none of them on observations")
        result: npt.NDArray[np.float32] = inputs[-1].detach().float().cpu().flatten(1).numpy()
        return result

    return features
