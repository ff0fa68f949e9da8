"""The options that all agents have: game, observations, length of the training."""

import dataclasses
import re
import types
import typing
from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True, kw_only=True)
class TrainingOptions:
    """The options that all agents have.

    Attributes:
        game: id of the game, such as pong.
        obs: what the network sees, pixels or ram.
        seed: of environments, weights and actions; equal seeds give equal weights, to the bit, on one machine.
        total_steps: agent steps of all environments together; a step is 4 frames.
        stop_score: stop when the mean score of the last 100 whole games reaches this; none is never.
        num_envs: environments that are played together.
        protocol: how games begin and end, the name of a preset; its sticky actions, too, unless `sticky` is given.
        sticky: probability that an action is repeated instead of the next one; none is the protocol's.
        episodic_life: whether a lost life is the end of an episode for the learner; none is the protocol's.
        actions: names of the actions that the agent has, such as NOOP,RIGHT,LEFT; none is all that the game uses.
        image_size: rows and columns of an image.
        stack: successive images, or RAM vectors, that the network sees together.
        network: nature (Mnih et al. 2015), small (two convolutions, 256 units), or, for RAM, mlp (two layers of 256
            units) or bits (the same on the bits of RAM).
        normalize: subtract the mean of each pixel or byte and divide by its standard deviation, both of all
            observations so far, instead of dividing by 255.
        bfloat16: compute convolutions and wide layers in bfloat16; parameters stay float32.
        learning_rate: step size of the optimiser.
        gamma: discount of a reward for each step until it comes.
        device: where the network is computed, cpu or cuda.
        workers: threads, each with environments of its own, that play and compute gradients; on cpu, one for each
            core. Another number gives other weights.
        checkpoint_minutes: minutes between checkpoints.
    """

    game: str = "pong"
    obs: Literal["pixels", "ram"] = "pixels"
    seed: int = 0
    total_steps: int = 10_000_000
    stop_score: float | None = None
    num_envs: int = 8
    protocol: str = "baselines"
    sticky: float | None = None
    episodic_life: bool | None = None
    actions: tuple[str, ...] | None = None
    image_size: int = 84
    stack: int = 4
    network: Literal["nature", "small", "mlp", "bits"] = "nature"
    normalize: bool = False
    bfloat16: bool = False
    learning_rate: float = 2.5e-4
    gamma: float = 0.99
    device: str = "cpu"
    workers: int = 1
    checkpoint_minutes: float = 5.0

    def __post_init__(self) -> None:
        for name in ("total_steps", "num_envs", "stack", "workers"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be 1 or more, got {getattr(self, name)}")
        if self.num_envs % self.workers:
            raise ValueError(f"num_envs must be a multiple of workers, got {self.num_envs} and {self.workers}")
        if (self.obs == "ram") != (self.network in ("mlp", "bits")):
            raise ValueError(
                f"network {self.network!r} is not for obs {self.obs!r}: pixels need nature or small, ram mlp or bits"
            )
        if self.device.split(":")[0] not in ("cpu", "cuda"):
            raise ValueError(f"device must be cpu, cuda or cuda:N, got {self.device!r}")
        if not 0 < self.gamma <= 1:
            raise ValueError(f"gamma must be above 0 and at most 1, got {self.gamma}")
        for field in dataclasses.fields(self):
            choices = typing.get_args(hints(type(self))[field.name])
            if isinstance(getattr(self, field.name), str) and choices and str not in choices:
                check_choice(field.name, getattr(self, field.name), choices)


def check_choice(name: str, value: Any, choices: tuple[Any, ...]) -> None:
    """Check an option.

    Raises:
        ValueError: it is none of the choices.
    """
    if value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(map(str, choices))}, got {value!r}")


def hints(options: type) -> dict[str, Any]:
    """The types of the options of a class, by name."""
    return typing.get_type_hints(options)


def descriptions(options: type) -> dict[str, str]:
    """What the docstrings of a class of options and of its bases say about each option, by name."""
    found: dict[str, str] = {}
    for base in reversed(options.__mro__):
        section = (base.__doc__ or "").partition("Attributes:\n")[2]
        for name, text in re.findall(r"^ {8}(\w+): (.*(?:\n {12}.*)*)", section, re.MULTILINE):
            found[name] = re.sub(r"\s+", " ", text).rstrip(".")
    return found


def parse(options: type, name: str, text: str) -> Any:
    """The value of an option from its text on a command line.

    Raises:
        ValueError: the text is none.
    """
    kind = hints(options)[name]
    members = typing.get_args(kind) if isinstance(kind, types.UnionType) else (kind,)
    if type(None) in members and text == "none":
        return None
    kind = members[0]
    if kind == tuple[str, ...]:
        return tuple(text.split(","))
    if kind is bool:
        check_choice(name, text, ("true", "false"))
        return text == "true"
    if kind is int:
        value = float(text)  # 1e6 is a whole number, too
        if not value.is_integer():
            raise ValueError(f"{name} must be a whole number, got {text}")
        return int(value)
    if kind is float:
        return float(text)
    return text
