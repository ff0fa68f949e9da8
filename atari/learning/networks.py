"""The networks of the agents: from observations of bytes to a number for each action."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
import torch
from torch import Tensor, nn

from atari.learning.options import TrainingOptions


def device_of(options: TrainingOptions) -> str:
    """The device of a training's network; with "auto", cuda if PyTorch can use a GPU, and otherwise cpu.

    Raises:
        ValueError: PyTorch has no such GPU.
    """
    count = torch.cuda.device_count() if torch.cuda.is_available() else 0
    if options.device == "auto":
        return "cuda" if count else "cpu"
    if options.device != "cpu" and int(options.device.partition(":")[2] or 0) >= count:
        raise ValueError(
            f"device is {options.device!r}, and PyTorch can use {count} GPUs; use device='cpu', or 'auto', which "
            "takes a GPU if there is one"
        )
    return options.device


def uses_bfloat16(options: TrainingOptions) -> bool:
    """Whether a training computes in bfloat16: with "auto", on a GPU, and on a processor with AVX512-BF16 or AMX.

    PyTorch computes bfloat16 on other processors by float32, in ten times the time of float32 alone.
    """
    if options.bfloat16 != "auto":
        return options.bfloat16
    if device_of(options) != "cpu":
        return True
    capabilities: Callable[[], Mapping[str, object]] = getattr(torch.cpu, "get_capabilities", dict)
    return any(capabilities().get(name) is True for name in ("avx512_bf16", "amx_bf16"))


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
    """From observations to features, (batch, `width`) float32.

    Args:
        shape: the shape of an observation.
        kind: "nature", "small" or "mlp", see `TrainingOptions.network`.
        normalize: see `TrainingOptions.normalize`.
        layer_norm: normalise the layers, as PQN needs it; a network of the user's does so itself.
        bfloat16: see `TrainingOptions.bfloat16`.

    Raises:
        TypeError, ValueError: the user's network is no `torch.nn.Module`, or returns no features.
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
        if isinstance(kind, str):
            self.layers, self.width = _layers(shape, kind, layer_norm)
        else:
            self.layers, self.width = _own_layers(shape, kind)

    def forward(self, observations: Tensor) -> Tensor:
        """Features of observations, (batch, ...) uint8."""
        with torch.autocast(observations.device.type, torch.bfloat16, enabled=self.bfloat16):
            features: Tensor = self.layers(self.normalize(self.unpack(observations)))
        return features.float()

    def observe(self, observations: Tensor) -> None:
        """Add observations to the statistics of `normalize`."""
        self.normalize.update(self.unpack(observations))

    def unpack(self, observations: Tensor) -> Tensor:
        """The bits of observations, (..., 8) of 0 and 255 from the lowest, if the network sees bits."""
        if not self.bits:
            return observations
        masks = 2 ** torch.arange(8, dtype=torch.uint8, device=observations.device)
        return (observations.unsqueeze(-1) & masks).ne(0) * torch.tensor(255, dtype=torch.uint8)


class ActorCritic(nn.Module):
    """A policy and a value function on common features."""

    def __init__(self, encoder: Encoder, actions: int) -> None:
        super().__init__()
        self.encoder = encoder
        self.policy = orthogonal(nn.Linear(encoder.width, actions), gain=0.01)
        self.value = orthogonal(nn.Linear(encoder.width, 1), gain=1.0)

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Logits of the actions, (batch, actions), and values, (batch,)."""
        features = self.encoder(observations)
        return self.policy(features), self.value(features)[:, 0]

    def scores(self, observations: Tensor) -> Tensor:
        """The logits alone."""
        return self.policy(self.encoder(observations))


class QNetwork(nn.Module):
    """Action values; with `dueling`, the sum of a state's value and the actions' advantages (Wang et al. 2016)."""

    def __init__(self, encoder: Encoder, actions: int, dueling: bool = False) -> None:
        super().__init__()
        self.encoder = encoder
        self.advantage = nn.Linear(encoder.width, actions)
        self.value = nn.Linear(encoder.width, 1) if dueling else None

    def forward(self, observations: Tensor) -> Tensor:
        """Values of the actions, (batch, actions)."""
        features = self.encoder(observations)
        advantage: Tensor = self.advantage(features)
        if self.value is None:
            return advantage
        return self.value(features) + advantage - advantage.mean(1, keepdim=True)

    scores = forward


def _layers(shape: Sequence[int], kind: str, layer_norm: bool) -> tuple[nn.Module, int]:
    """The layers of a network of this package, and the number of their features."""
    if kind in ("mlp", "bits"):
        size, layers = torch.Size(shape).numel(), [nn.Flatten()]
        widths = [256, 256]
    else:
        layers = _convolutions(shape[0], _CONVOLUTIONS[kind], layer_norm)
        with torch.no_grad():
            size = nn.Sequential(*layers)(torch.zeros(1, *shape)).shape[1]
        widths = [512 if kind == "nature" else 256]
    for width in widths:
        layers += [orthogonal(nn.Linear(size, width)), *([nn.LayerNorm(width)] if layer_norm else []), nn.ReLU()]
        size = width
    return nn.Sequential(*layers), size


def _own_layers(shape: Sequence[int], make: Callable[[Any], Any]) -> tuple[nn.Module, int]:
    """The module that a class or function of the user's makes, and the number of its features.

    Raises:
        TypeError: it makes no module.
        ValueError: the module returns no features.
    """
    name = getattr(make, "__name__", repr(make))
    layers = make(gymnasium.spaces.Box(0, 255, tuple(shape), np.uint8))
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
        layers += [nn.GroupNorm(1, out), nn.ReLU()] if layer_norm else [nn.ReLU()]
        channels = out
    return [*layers, nn.Flatten()]


def orthogonal(layer: nn.Linear | nn.Conv2d, gain: float = 2**0.5) -> nn.Module:
    """Give a layer orthogonal weights (Saxe et al. 2014) and biases of zero, and return it."""
    nn.init.orthogonal_(layer.weight, gain)
    if layer.bias is not None:
        nn.init.zeros_(layer.bias)
    return layer
