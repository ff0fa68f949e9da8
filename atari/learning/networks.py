"""`Encoder`: the layers that the networks of the agents have in common, from observations of bytes to features."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import torch
from torch import Tensor, nn


class Normalize(nn.Module):
    """Observations, (batch, ...) uint8, as float32: divided by 255, or normalised.

    A normalised pixel or byte has a mean of 0 and a variance of 1 over all observations that `update` has seen, and is
    clipped to -5..5. Moving objects then stand out from the background.
    """

    def __init__(self, shape: Sequence[int], running: bool) -> None:
        super().__init__()
        self.running = running
        self.register_buffer("mean", torch.zeros(*shape))
        self.register_buffer("scale", torch.full(tuple(shape), 1 / 255))
        self.register_buffer("count", torch.zeros((), dtype=torch.float64))
        self.register_buffer("total", torch.zeros(*shape, dtype=torch.float64))
        self.register_buffer("total_of_squares", torch.zeros(*shape, dtype=torch.float64))

    @torch.no_grad()
    def update(self, observations: Tensor) -> None:
        """Add observations to the statistics."""
        if not self.running:
            return
        self.count += len(observations)
        for part in observations.split(512):  # float64 takes eight times the memory
            values = part.double()
            self.total += values.sum(0)
            self.total_of_squares += values.square_().sum(0)
        mean = self.total / self.count
        variance = self.total_of_squares / self.count - mean.square()
        self.mean.copy_(mean)
        self.scale.copy_((variance.clamp_min(0) + 1).rsqrt())  # + 1, so that pixels that hardly change are no noise

    def forward(self, observations: Tensor) -> Tensor:
        """Normalised observations, float32, of the same shape."""
        values = (observations.float() - self.mean).mul_(self.scale)
        return values.clamp_(-5, 5) if self.running else values


class Encoder(nn.Module):
    """From observations to features, (batch, `width`) float32. Each agent adds the layers of its values or its policy.

    Args:
        shape: the shape of an observation.
        kind: "nature", "small", "mlp", "bits" or a network of your own, see `TrainingOptions.network`.
        normalize: see `TrainingOptions.normalize`.
        layer_norm: normalise the layers, as PQN needs it; a network of your own does so itself.
        bfloat16: compute the layers in bfloat16.

    Attributes:
        width: the number of features.
        layers: the layers; their input is as `prepare` returns it, but for images, which are (batch, stack, rows,
            columns).

    Raises:
        TypeError, ValueError: the user's network is no `torch.nn.Module`, or returns no features.

    Example:
        >>> import torch
        >>> from atari.learning import Encoder
        >>> encoder = Encoder((4, 84, 84), "nature")
        >>> encoder(torch.zeros(2, 4, 84, 84, dtype=torch.uint8)).shape
        torch.Size([2, 512])
    """

    layers: nn.Module

    def __init__(
        self,
        shape: Sequence[int],
        kind: str | Callable[[Any], Any],
        normalize: bool = False,
        layer_norm: bool = False,
        bfloat16: bool = False,
    ) -> None:
        super().__init__()
        self.bits = kind == "bits"
        shape = (*shape, 8) if self.bits else shape
        self.normalize = Normalize(shape, normalize)
        self.bfloat16 = bfloat16
        self.own, self.images = not isinstance(kind, str), kind in _CONVOLUTIONS
        if isinstance(kind, str):
            self.layers, self.width = _layers(shape, kind, layer_norm)
        else:
            self.layers, self.width = _own_layers(shape, kind)

    def forward(self, observations: Tensor) -> Tensor:
        """Features of observations, (batch, ...) uint8, or of what `prepare` has returned for them."""
        prepared = self.prepare(observations) if observations.dtype == torch.uint8 else observations
        if self.images:
            prepared = prepared.permute(0, 3, 1, 2)
        with torch.autocast(prepared.device.type, torch.bfloat16, enabled=self.bfloat16):
            features: Tensor = self.layers(prepared)
        return features.float()

    def prepare(self, observations: Tensor) -> Tensor:
        """Normalise observations, (batch, ...) uint8, and arrange them as the layers compute fastest.

        A training that learns from an observation several times prepares it once.

        Returns:
            (batch, ...) float32, or bfloat16 with `bfloat16`; images are (batch, rows, columns, stack). A network of
            your own gets float32 in the shape of the observations.
        """
        values = self.normalize(self.unpack(observations))
        if self.own:
            return values
        dtype = torch.bfloat16 if self.bfloat16 else torch.float32
        if not self.images:
            return values.to(dtype)
        # First the type, then the order: both at once take twice as long.
        return values.to(dtype).contiguous(memory_format=torch.channels_last).permute(0, 2, 3, 1)

    def observe(self, observations: Tensor) -> None:
        """Add observations to the statistics of `normalize`."""
        self.normalize.update(self.unpack(observations))

    def unpack(self, observations: Tensor) -> Tensor:
        """The bits of observations, (..., 8) of 0 and 255 from the lowest, if the network sees bits."""
        if not self.bits:
            return observations
        masks = 2 ** torch.arange(8, dtype=torch.uint8, device=observations.device)
        return (observations.unsqueeze(-1) & masks).ne(0) * torch.tensor(255, dtype=torch.uint8)


def _layers(shape: Sequence[int], kind: str, layer_norm: bool) -> tuple[nn.Module, int]:
    if kind in ("mlp", "bits"):
        size, layers = torch.Size(shape).numel(), [nn.Flatten()]
        widths = [256, 256]
    else:
        layers = _convolutions(shape[0], _CONVOLUTIONS[kind], layer_norm)
        with torch.no_grad():
            size = nn.Sequential(*layers)(torch.zeros(1, *shape)).shape[1]
        widths = [512 if kind == "nature" else 256]
    for width in widths:
        norm = [nn.LayerNorm(width)] if layer_norm else []
        layers += [orthogonal(nn.Linear(size, width)), *norm, nn.ReLU(inplace=True)]
        size = width
    return nn.Sequential(*layers), size


def _own_layers(shape: Sequence[int], make: Callable[[Any], Any]) -> tuple[nn.Module, int]:
    name = getattr(make, "__name__", repr(make))
    try:
        layers = make(gymnasium.spaces.Box(0, 255, tuple(shape), np.uint8))
    except TypeError as error:
        raise TypeError(
            f"network {name} is called with the observation space alone, and makes features; the agent adds the layer "
            f"for the actions: {error}"
        ) from error
    if not isinstance(layers, nn.Module):
        raise TypeError(f"network {name} must make a torch.nn.Module from the observation space, got {layers!r:.60}")
    two = torch.zeros(2, *shape)
    try:
        with torch.no_grad():
            features = layers(two)
    except (RuntimeError, ValueError, TypeError) as error:
        raise ValueError(f"network {name} fails with observations of shape {tuple(two.shape)}: {error}") from error
    if not isinstance(features, Tensor) or not features.is_floating_point() or features.ndim != 2 or len(features) != 2:
        got = f"{features.dtype} {tuple(features.shape)}" if isinstance(features, Tensor) else f"{features!r:.60}"
        raise ValueError(
            f"network {name} must return features, floats (n, width), from which the agent computes a value for each "
            f"action; for observations of shape {tuple(two.shape)} it returned {got}"
        )
    return layers, features.shape[1]


_CONVOLUTIONS = {
    "nature": ((32, 8, 4), (64, 4, 2), (64, 3, 1)),
    "small": ((16, 6, 3), (32, 4, 2)),
}
"""Channels, kernel size and stride of each layer."""


def _convolutions(channels: int, table: Sequence[tuple[int, int, int]], layer_norm: bool) -> list[nn.Module]:
    layers: list[nn.Module] = []
    for out, kernel, stride in table:
        layers.append(orthogonal(nn.Conv2d(channels, out, kernel, stride)))
        layers += [nn.GroupNorm(1, out), nn.ReLU(inplace=True)] if layer_norm else [nn.ReLU(inplace=True)]
        channels = out
    return [*layers, _Flatten()]


class _Flatten(nn.Flatten):
    """Flattens images, and gives the gradient back in the order of the images in memory, with the channels last.

    The backward pass of the ReLU before it takes 25 times as long from one order to the other.
    """

    def forward(self, images: Tensor) -> Tensor:
        if images.requires_grad:
            images.register_hook(partial(Tensor.contiguous, memory_format=torch.channels_last))
        return super().forward(images)


def orthogonal(layer: nn.Linear | nn.Conv2d, gain: float = 2**0.5) -> nn.Module:
    """Give a layer orthogonal weights (Saxe et al. 2014) and biases of zero, and return it."""
    nn.init.orthogonal_(layer.weight, gain)
    if layer.bias is not None:
        nn.init.zeros_(layer.bias)
    return layer
