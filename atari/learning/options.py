"""The options that all agents have: the task, the length of the training, the network, and the machine's resources."""

import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, ClassVar, Literal, TypeVar, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from atari.base.typed_table import check_type, fits, from_text, in_words, members
from atari.base.validation import check_integer, check_known
from atari.cores.options import SEED_LIMIT
from atari.learning.programs import is_program, module_of, named_in, program, program_in_module
from atari.policy.needs import in_game
from atari.task import Task
from atari.task.resolution import ALIASES, OPTIONS
from atari.task.task import GameLike, look_up

NETWORKS = ("nature", "small", "mlp", "bits")
"""The names of the networks of this package."""

PROGRAMS = ("network", "intrinsic_reward", "logger")
"""The options that can be a class or function of the user's, of which a run folder keeps the file."""

WINDOW = 100
"""The number of whole games whose mean is the score in the log."""

MOST_WORKERS = 1024
"""The largest number of threads that play and learn."""

FAST_RAM: Mapping[str, Any] = {
    "obs_type": "ram",
    "img_height": None,
    "img_width": None,
    "network": "bits",
    "stack_num": 2,
    "padding": "reset",
}
"""Options for RAM, which replace the options for pixels."""

_Options = TypeVar("_Options", bound="TrainingOptions")


@dataclass(frozen=True, kw_only=True)
class TrainingOptions:
    """The options that all agents have. `of` makes them from a game and options by name.

    Attributes:
        task: the task that the agent plays.
        seed: the seed of environments, weights and actions, 0..2**32-1; equal seeds give equal weights, to the bit, on
            one machine. Weights and actions are drawn from the seed itself. Environment i has the seed
            seed * num_envs + i, with DQN seed + i; if one of these is 2**32 or more, environments have words of NumPy's
            SeedSequence.
        total_steps: agent steps of all environments together.
        stop_score: stop when the mean score of the last 100 whole games reaches this; none is never.
        more_games: other games of the training, with commas between. Environment i plays the game i modulo their
            number, the task's game first; the score is the mean of the games' scores. They are played as the task says,
            and must have the same actions, as with actions "full".
        num_envs: environments that are played together.
        network: nature (Mnih et al. 2015), small (two convolutions, 256 units), or, for RAM, mlp (two layers of 256
            units) or bits (the same on the bits of RAM); or FILE.py:NAME, a class or function of your own that makes a
            torch.nn.Module from the observation space. The module gets normalised observations, float32, and returns
            features (n, width), from which the agent computes its values.
        normalize: subtract the mean of each pixel or byte and divide by its standard deviation, over all observations
            so far, instead of dividing by 255.
        bfloat16: compute convolutions and wide layers in bfloat16; parameters stay float32. auto does so where the
            processor has instructions for it; without them it takes ten times as long as float32.
        learning_rate: step size of the optimiser.
        gamma: discount of a reward for each step before it.
        device: the device of the network: cpu, cuda, cuda:N, or auto, a GPU if PyTorch can use one.
        workers: threads that play and compute gradients, each in its own environments; on cpu, one for each core is
            best. Another number gives other weights. With a GPU they only play, and the weights do not depend on it.
        checkpoint_minutes: minutes between checkpoints.
        intrinsic_reward: FILE.py:NAME or MODULE:NAME, a class or function of your own that makes, from the vector
            environment and the seed, an object that is called with the observations, actions and info of each step. It
            returns rewards (n,), which the learner gets beside the game's, not clipped; the score is without them. Its
            methods state() and restore(state) are for checkpoints. On cpu, each of the workers has its own object.
        logger: FILE.py:NAME or MODULE:NAME, a class or function of your own that makes, from the run folder, an object
            that is called with each row of the log, with the columns step and frames; close() is called at the end.

    Raises:
        TypeError, ValueError: an option is wrong, or the agent cannot play the task.

    Example:
        >>> from atari.learning.options import TrainingOptions
        >>> options = TrainingOptions.of("breakout", preset="dqn2015", img_height=42, img_width=42, num_envs=4)
        >>> options.num_envs, options.task.img_height, options.task.noops
        (4, 42, (1, 30))
    """

    default_preset: ClassVar[str] = "baselines"
    """The preset of a game or an ID, unless the user names another one."""
    ram_padding: ClassVar[str] = "reset"
    """The padding of stacks of RAM, unless the user gives another one."""

    task: Task
    seed: int = 0
    total_steps: int = 10_000_000
    stop_score: float | None = None
    more_games: str | None = None
    num_envs: int = 8
    network: str | Callable[[Any], Any] = "nature"
    normalize: bool = False
    bfloat16: Literal["auto", True, False] = False
    learning_rate: float = 2.5e-4
    gamma: float = 0.99
    device: str = "cpu"
    workers: int = 1
    checkpoint_minutes: float = 5.0
    intrinsic_reward: Callable[..., Any] | None = None
    logger: Callable[..., Any] | None = None

    @classmethod
    def of(cls: type[_Options], game: GameLike, *, preset: str | None = None, **options: Any) -> _Options:
        """The options of a training in a game.

        Unless `options` say otherwise, the task has `reward_clipping=True`, `seamless_lives=False` (a lost life that
        ends an episode clears the stack) and, for RAM, `stack_num=4`. A given `Task` is not changed.

        Args:
            game: a game's name, the path of a game file or a `Game`; an environment ID, which decides sticky actions,
                the actions, and RAM or pixels; or a `Task`.
            preset: a name of `atari.PRESETS`; None is `default_preset`, except for a `Task`.
            **options: fields of this class and of `atari.Task`.

        Raises:
            gymnasium.error.NameNotFound: the ID is not known.
            TypeError, ValueError: an option is not known (the nearest is suggested), or see the class.
        """
        own = {field.name for field in dataclasses.fields(cls)} - {"task"}
        known = (*own, *OPTIONS, *ALIASES)
        check_known(cls.__name__, [name for name in options if name not in known], known)
        given = {name: value for name, value in options.items() if name not in own}
        if not (isinstance(game, Task) and preset is None):
            given.setdefault("seamless_lives", False)  # the stack begins anew where the learner's episode does
            if "clip_reward" not in given:
                given.setdefault("reward_clipping", True)
        resolve = partial(look_up(game).task_for_agent, preset, default=cls.default_preset, owner=cls.__name__)
        rest = {name: value for name, value in options.items() if name in own}
        unstacked = {name: value for name, value in given.items() if name not in ("stack_num", "padding")}
        if not resolve(unstacked).kind.image:
            rest.setdefault("network", "mlp")
            if not (isinstance(game, Task) and preset is None):
                given.setdefault("stack_num", 4)
                if given["stack_num"] is not None:
                    given.setdefault("padding", cls.ram_padding)
        return cls(task=resolve(given), **rest)

    def __post_init__(self) -> None:
        if not isinstance(self.task, Task):
            raise TypeError(f"task must be an atari.Task, got {self.task!r}; {type(self).__name__}.of(GAME) makes one")
        check_task(self.task)
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        for name, most in (("total_steps", 10**15), ("num_envs", 2**16), ("workers", MOST_WORKERS)):
            check_integer(name, getattr(self, name), 1, most)
        kinds = get_type_hints(type(self))
        for field in dataclasses.fields(self):
            if field.name not in ("task", *PROGRAMS):
                _check_option(field.name, getattr(self, field.name), kinds[field.name])
        if self.num_envs % self.workers:
            raise ValueError(f"num_envs must be a multiple of workers, got {self.num_envs} and {self.workers}")
        self._check_network()
        self._check_programs()
        self._check_games()
        if not re.fullmatch(r"cpu|auto|cuda(:\d{1,4})?", self.device):
            raise ValueError(f"device must be cpu, cuda, cuda:N or auto, got {self.device!r}")
        if not 0 < self.gamma <= 1:
            raise ValueError(f"gamma must be above 0 and at most 1, got {self.gamma}")

    def _check_programs(self) -> None:
        for name in ("intrinsic_reward", "logger"):
            if (given := getattr(self, name)) is not None and not callable(given):
                raise TypeError(
                    f"{name} must be a class or a function, and in a command FILE.py:NAME, got {given!r:.60}"
                )

    def _check_network(self) -> None:
        if not isinstance(self.network, str):
            if not callable(self.network):
                raise TypeError(f"network must be a name, a class or a function, got {self.network!r:.60}")
            return
        if ":" in self.network:
            raise ValueError(
                "a network of your own is a class or a function, network=Net, and in a command FILE.py:NAME, such as "
                f"my_net.py:Net; got {self.network!r}"
            )
        if self.network not in NETWORKS:
            raise ValueError(f"network must be one of {', '.join(NETWORKS)}, got {self.network!r}")
        if self.from_ram != (self.network in ("mlp", "bits")):
            raise ValueError(
                f"network {self.network!r} is not for obs_type {self.task.obs_type!r}: images need nature or small, "
                "ram mlp or bits"
            )

    def _check_games(self) -> None:
        names = [task.game for task in self.tasks]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"{twice[0]} is named twice in more_games={self.more_games!r} and the task; leave one out")
        for task in self.tasks[1:]:
            if task.action_set != self.task.action_set:
                raise ValueError(
                    f"{task.game} has other actions than {self.task.game}, and one network rates the actions of all "
                    "games; add actions='full'"
                )
        if self.num_envs % (self.workers * len(names)):
            given = f"{self.num_envs}, {self.workers} and {len(names)}"
            raise ValueError(f"num_envs must be a multiple of workers times games, got {given}")

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """The task of each game: `task`, and the same in `more_games`."""
        others = [] if self.more_games is None else self.more_games.split(",")
        return (self.task, *(in_game(self.task, Task.of(name.strip())) for name in others))

    @property
    def torch_device(self) -> str:
        """The device of the network; with "auto", cuda if PyTorch can use a GPU, and otherwise cpu.

        Raises:
            ValueError: PyTorch has no such GPU.
        """
        import torch  # the options of a run are read without it

        count = torch.cuda.device_count() if torch.cuda.is_available() else 0
        if self.device == "auto":
            return "cuda" if count else "cpu"
        if self.device != "cpu" and int(self.device.partition(":")[2] or 0) >= count:
            raise ValueError(
                f"device is {self.device!r}, and PyTorch can use {count} GPUs; use device='cpu', or 'auto', which "
                "takes a GPU if there is one"
            )
        return self.device

    @property
    def computes_bfloat16(self) -> bool:
        """Whether the network computes in bfloat16; with "auto", on a GPU, and on processors with AVX512-BF16 or AMX.

        PyTorch computes bfloat16 on other processors by float32, in ten times the time of float32 alone.
        """
        import torch

        if self.bfloat16 != "auto":
            return self.bfloat16
        if self.torch_device != "cpu":
            return True
        capabilities: Callable[[], Mapping[str, object]] = getattr(torch.cpu, "get_capabilities", dict)
        return any(capabilities().get(name) is True for name in ("avx512_bf16", "amx_bf16"))

    @property
    def replicas(self) -> int:
        """Networks that compute gradients, each in a thread: `workers`, or one on a GPU."""
        return self.workers if self.torch_device == "cpu" else 1

    @property
    def from_ram(self) -> bool:
        """Whether the network sees RAM, not images."""
        return not self.task.kind.image

    def environment_seeds(self, first: int, count: int) -> npt.NDArray[np.int64]:
        """The seeds of `count` environments: `first`, `first + 1`, ..., if all are below 2**32.

        Otherwise they are words of `numpy.random.SeedSequence(first)`.
        """
        if first + count <= SEED_LIMIT:
            return np.arange(first, first + count)
        return np.random.SeedSequence(first).generate_state(count).astype(np.int64)


NOT_FOR_AGENTS = ("players", "continuous", "continuous_action_threshold", "sound_obs", "agent_indicator", "zero_sum")
"""Options of a task that no agent of this package plays."""


def check_task(task: Task) -> None:
    """Refuse a task that the agents cannot play.

    Raises:
        ValueError: a field of the task is not supported.
    """
    if task.kind.colours or task.kind.is_dict:
        raise ValueError(
            f"an agent learns from obs_type='grayscale' or 'ram', and the task has {task.obs_type!r}; "
            "add obs_type='grayscale', or a preset such as preset='baselines'"
        )
    if task.stack_num is None:
        raise ValueError(
            "an agent sees stacks of images or RAM, and the task has stack_num=None; add stack_num=4, or 1"
        )
    if task.continuous:
        raise ValueError("an agent chooses one of the actions, and the task has continuous=True; leave it out")
    if task.players > 1:
        raise ValueError(f"an agent plays alone, and the task has players={task.players}; use players=1")
    if task.sound_obs:
        raise ValueError("an agent has no place for sound, and the task has sound_obs=True; leave it out")


_FROM_ZERO = ("seed", "learning_starts")
"""Options that are whole numbers and can be 0."""


def _check_option(name: str, value: Any, kind: Any) -> None:
    """Check that the value of an option is of its type; numbers must be finite and not negative."""
    if not fits(value, kind):
        error = ValueError if get_origin(kind) is Literal else TypeError
        raise error(f"{name} must be {in_words(kind)}, got {value!r:.60}")
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        real = float in members(kind)
        least = -math.inf if name == "stop_score" else 0 if real or name in _FROM_ZERO else 1
        if not math.isfinite(value) or not least <= value < 2**63:
            wanted = "finite" if least < 0 else "finite and not negative" if real else f"within {least}..2**63-1"
            raise ValueError(f"{name} must be {wanted}, got {value!r:.60}")


def option_from_text(options: type, name: str, text: str) -> Any:
    """The value of an option from its text on a command line.

    Raises:
        ValueError: the text is no value of the option.
        FileNotFoundError: there is no such file of a program.
    """
    if name in PROGRAMS and (":" in text or is_program(text)):
        named = program(text) if is_program(text) else program_in_module(text)
        return named_in(module_of(named.file), named)
    if name in ("intrinsic_reward", "logger") and text != "none":
        raise ValueError(f"{name} must be FILE.py:NAME, MODULE:NAME or none, got {text!r:.60}")
    kind = get_type_hints(options)[name]
    return check_type(from_text(text, kind), name, kind)
