"""`EvaluationProtocol`: how games of an evaluation begin, are played and end. `GAME_SETS`: the games of benchmarks."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import SimpleNamespace
from typing import Any, Literal

from atari.base.frozen import FrozenDict
from atari.base.validation import check_frameskip, check_integer, check_name, check_probability
from atari.learning.evaluation.published import Published, check_known_name, read_table
from atari.task import PRESETS, Task
from atari.task.description import summary
from atari.task.fields import DEFAULTS, GROUPS
from atari.task.presets import OTHER_NAMES

MAX_EPISODES = 1_000_000


@dataclass(frozen=True)
class EvaluationProtocol:
    """All numbers on which a score depends besides the policy. Scores of two protocols are not compared.

    Attributes:
        name: the name of the protocol.
        source: the publication or program of the protocol, and the numbers that are added to it.
        repeat_action_probability: the probability of sticky actions, drawn each frame.
        full_action_space: whether all 18 actions are given, not only the game's minimal actions.
        noop_min, noop_max: the range noop_min..noop_max of the number of NOOPs with which a game begins; 0, 0 is none.
        max_frames: the frames after which a game is truncated, NOOPs included. The limit stops games that would not end
            by themselves, as in Breakout if a policy never presses FIRE.
        epsilon: probability of a random action in place of the policy's, drawn each step.
        episodes: whole games of each game, unless the caller of `evaluate` gives another number.
        preset: a name of `atari.PRESETS`, with the images of policies without `task` and `environment`; with
            lives="preset" also how games and lives begin; "" with a `task`.
        lives: the effect of a lost life. "continue": none. "fire": as the wrappers of OpenAI's Baselines, with FIRE and
            the action of index 2 at the start and after each lost life. "preset": as the preset begins games and the
            episodes that follow a lost life. "task": as `task` does.
        frame_skip: frames for each action, or (low, high) for low..high-1.
        task: with `lives="task"`, the task whose whole games are played: its actions, beginnings, lives and limits, and
            its images for policies without `task` and `environment`. `of_task` makes such a protocol.

    Example:
        >>> from dataclasses import replace
        >>> from atari.learning import PROTOCOLS
        >>> protocol = replace(PROTOCOLS["dopamine"], name="mine", epsilon=0.0)
        >>> protocol.name, protocol.epsilon
        ('mine', 0.0)
        >>> protocol.comparable[:3]
        ('dopamine/dqn', 'dopamine/c51', 'dopamine/rainbow')
    """

    name: str
    source: str
    repeat_action_probability: float
    full_action_space: bool
    noop_min: int
    noop_max: int
    max_frames: int
    epsilon: float
    episodes: int
    preset: str
    lives: Literal["continue", "fire", "preset", "task"] = "continue"
    frame_skip: int | tuple[int, int] = 4
    task: Task | None = None

    @classmethod
    def of_task(cls, task: Task, *, name: str, source: str, epsilon: float, episodes: int) -> "EvaluationProtocol":
        """The protocol of the whole games of a task, with scores that are not clipped.

        A task without a limit gets one of 108,000 frames.

        Raises:
            TypeError, ValueError: as the class.
        """
        numbers = {"max_frames": _HALF_AN_HOUR, **_numbers_of(task)}
        return cls(name, source, epsilon=epsilon, episodes=episodes, preset="", lives="task", task=task, **numbers)

    def __post_init__(self) -> None:
        for text in ("name", "source"):
            if not isinstance(getattr(self, text), str):
                raise TypeError(f"{text} of a protocol must be a string, got {getattr(self, text)!r}")
        if not isinstance(self.full_action_space, bool):
            raise TypeError(f"full_action_space must be True or False, got {self.full_action_space!r}")
        check_probability("repeat_action_probability", self.repeat_action_probability)
        check_probability("epsilon", self.epsilon)
        check_integer("noop_min", self.noop_min, 0, check_integer("noop_max", self.noop_max, 0, 1_000_000))
        check_integer("max_frames", self.max_frames, 1, 100_000_000)
        check_integer("episodes", self.episodes, 1, MAX_EPISODES)
        object.__setattr__(self, "frame_skip", check_frameskip(self.frame_skip))
        check_name("lives", self.lives, ("continue", "fire", "preset", "task"))
        self._check_task()
        known = globals().get("PROTOCOLS", {}).get(self.name)  # not defined yet when its own protocols are made
        if known is not None and differences(self, known):
            raise ValueError(f"a protocol with other numbers than {self.name!r} needs another name: give name=...")

    def _check_task(self) -> None:
        if self.task is None:
            if self.lives == "task":
                raise ValueError("lives='task' plays the games of a task; use EvaluationProtocol.of_task(task, ...)")
            check_name("preset", self.preset, PRESETS)
            return
        if not isinstance(self.task, Task):
            raise TypeError(f"task of a protocol must be an atari.Task, got {self.task!r}")
        if self.lives != "task" or self.preset:
            raise ValueError(
                f"a protocol with a task has lives='task' and preset='', got {self.lives!r} and {self.preset!r}"
            )
        for name, value in _numbers_of(self.task).items():
            if getattr(self, name) != value:
                raise ValueError(
                    f"{name} must be {value!r}, as the protocol's task has it, got {getattr(self, name)!r}"
                )

    @property
    def frames(self) -> tuple[int, int]:
        """The range of the frame skip, (low, high): low..high-1."""
        return self.frame_skip if isinstance(self.frame_skip, tuple) else (self.frame_skip, self.frame_skip + 1)

    @property
    def comparable(self) -> tuple[str, ...]:
        """The names of the published agents that were played in this protocol's environments, see `faults`."""
        return tuple(name for name in Published.names() if not self.faults(Published(name)))

    def faults(self, other: Published) -> list[str]:
        """The fields in which the environments of a published agent differ from this protocol, in words.

        A field that the agent's source does not state is a difference, except for the limit of frames and the least
        number of no-ops. One no-op is no random start, and counts as none; so does one FIRE at the start of a game.
        """
        facts = other.protocol
        noops = (0, 0) if facts["noop_max"] == 1 else (facts["noop_min"], facts["noop_max"])
        own_noops = (0, 0) if self.noop_max == 1 else (self.noop_min, self.noop_max)
        pairs = {
            "repeat_action_probability": (facts["repeat_action_probability"], self.repeat_action_probability),
            "full_action_space": (facts["full_action_space"], self.full_action_space),
            "noop_min": (own_noops[0] if noops[0] is None else noops[0], own_noops[0]),
            "noop_max": (noops[1], own_noops[1]),
            "frame_skip": (facts["frame_skip"], self.frame_skip),
            "max_frames": (facts["max_frames"] or self.max_frames, self.max_frames),
            "lives": (facts["lives"], "fire" if self._fires_after_lost_lives else "continue"),
        }
        return [
            f"{name} is {'not stated' if theirs is None else theirs}, and {ours} in {self.name}"
            for name, (theirs, ours) in pairs.items()
            if theirs != ours
        ]

    @property
    def _fires_after_lost_lives(self) -> bool:
        if self.task is not None:
            return self.task.fire != "never" and self.task.episodic_life
        return self.lives == "fire" or (self.lives == "preset" and "fire" in PRESETS[self.preset].fields)

    def to_json(self) -> dict[str, Any]:
        """All fields, as the types of JSON."""
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        return {**own, "task": None if self.task is None else json.loads(self.task.to_json())}

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> "EvaluationProtocol":
        """The protocol from the result of `to_json`.

        Raises:
            TypeError, ValueError: a field is missing, unknown, or wrong.
        """
        task = content.get("task")
        return cls(**{**content, "task": None if task is None else Task.from_json(json.dumps(task))})

    def __str__(self) -> str:
        actions = "all 18 actions" if self.full_action_space else "the game's minimal actions"
        if self.task is not None and not isinstance(self.task.actions, str):
            actions = f"the actions {', '.join(self.task.actions)}"
        noops = f"{self.noop_min}-{self.noop_max} no-ops" if self.noop_max else "no no-ops"
        lives = {
            "continue": "",
            "fire": "; FIRE at the start and after lost lives",
            "preset": f"; games and lives begin as in preset {self.preset}",
            "task": "" if self.task is None else f"; games and lives begin as in its task ({summary(self.task)})",
        }[self.lives]
        return (
            f"{self.name}: sticky actions {self.repeat_action_probability:g}, {actions}, {noops}, "
            f"{in_words(self.frames)} frames an action, epsilon {self.epsilon:g}, "
            f"at most {self.max_frames:,} frames a game{lives}; unclipped scores of whole games"
        )


def in_words(frames: tuple[int, int]) -> str:
    """A range of frames (low, high) in words."""
    low, high = frames
    return f"{low}" if high == low + 1 else f"{low} to {high - 1}"


def _numbers_of(task: Task) -> dict[str, Any]:
    numbers = {
        "repeat_action_probability": task.repeat_action_probability,
        "full_action_space": task.actions == "full",
        "noop_min": task.noops[0],
        "noop_max": task.noops[1],
        "frame_skip": task.frameskip,
    }
    limit = task.max_num_frames_per_episode or task.max_frames
    return numbers if limit is None else {**numbers, "max_frames": limit}


_WORDS = ("name", "source", "episodes", "preset", "task")
NUMBERS = tuple(field.name for field in fields(EvaluationProtocol) if field.name not in _WORDS)
"""The fields that must be equal to compare scores, except for a task."""


def differences(one: EvaluationProtocol, other: EvaluationProtocol) -> list[str]:
    """The fields of `NUMBERS` in which two protocols differ, in words."""
    names = (*NUMBERS, "preset") if one.lives == "preset" == other.lives else NUMBERS
    pairs = [(name, getattr(one, name), getattr(other, name)) for name in names]
    if one.task is not None and other.task is not None:
        pairs += [
            (f"{name} of the task", *pair)
            for name, pair in one.task.differences(other.task).items()
            if name not in _UNLIKE
        ]
    return [f"{name} {first} and {second}" for name, first, second in pairs if first != second]


_UNLIKE = frozenset((*GROUPS["game"], "interventions", *GROUPS["observation"], *GROUPS["reward"]))
"""Fields of a protocol's task that the game, the policy, or the policy's training decides."""


_HALF_AN_HOUR = 108_000


def _of_preset(name: str, source: str, preset: str = "", **others: Any) -> EvaluationProtocol:
    """The protocol of a preset, by default that of its name: 100 games of at most half an hour, or as `others` say."""
    preset = preset or name
    task: Any = SimpleNamespace(**{**DEFAULTS, **PRESETS[preset].fields})
    numbers = {**_numbers_of(task), "max_frames": _HALF_AN_HOUR, "epsilon": 0.0, "episodes": 100, **others}
    return EvaluationProtocol(name, source, preset=preset, **numbers)


_ALL = (
    _of_preset(
        "dqn2015",
        "Mnih et al. 2015: 30 games of at most five minutes, no-op starts, epsilon 0.05",
        max_frames=18_000,
        epsilon=0.05,
        episodes=30,
    ),
    _of_preset(
        "noop_starts",
        "the no-op starts of Double DQN and Rainbow (van Hasselt et al. 2016, Hessel et al. 2018), as in PFRL: half an "
        "hour, epsilon 0.001",
        preset="dqn2015",
        epsilon=0.001,
    ),
    _of_preset(
        "machado2018",
        "Machado et al. 2018, with the 4 frames an action and 108,000 frames that later users of it take. The paper "
        "reports the last 100 games of the training; this plays 100 games after it",
    ),
    _of_preset(
        "dreamerv3",
        "DreamerV3's 57 games (Hafner et al. 2023): as machado2018, after 0 to 30 no-ops. It reports training games",
        preset="machado2018",
        noop_max=30,
    ),
    _of_preset(
        "atari100k",
        "the Atari 100k benchmark as in Dopamine's data-efficient Rainbow: 100 games, epsilon 0.001",
        epsilon=0.001,
    ),
    _of_preset(
        "atari100k_noops",
        "the Atari 100k benchmark as in DreamerV3 (Hafner et al. 2023): 0 to 30 no-ops. It reports training games",
        preset="atari100k",
        noop_max=30,
    ),
    _of_preset(
        "dopamine",
        "Dopamine's evaluation, epsilon 0.001, with 100 games in place of 125,000 steps, which favour short games",
        epsilon=0.001,
    ),
    _of_preset(
        "dopamine_nets",
        "as dopamine, with the 100,000 frames a game of Dopamine's newer runs (Nature CNN and Impala networks)",
        preset="dopamine",
        max_frames=100_000,
        epsilon=0.001,
    ),
    _of_preset(
        "baselines",
        "the wrappers of OpenAI's Baselines, Stable-Baselines3 and CleanRL, with scores as their Monitor records them "
        "around the game",
        lives="fire",
    ),
)
PROTOCOLS: Mapping[str, EvaluationProtocol] = FrozenDict({protocol.name: protocol for protocol in _ALL})
"""Every protocol by name."""

GAME_SETS: Mapping[str, tuple[str, ...]] = FrozenDict(
    {name: tuple(games) for name, games in read_table("sets").items()}
)
"""Sets of games by name: "atari57" (and "atari55", "atari60", "atari49" of 2015), "atari26" (Atari 100k), "atari5"."""


def find_protocol(protocol: Any) -> EvaluationProtocol:
    """The protocol of an argument: a name of `PROTOCOLS`, or an `EvaluationProtocol`.

    Raises:
        TypeError: the argument is neither.
        ValueError: no protocol has this name; the nearest is suggested, if one is near.
    """
    if isinstance(protocol, EvaluationProtocol):
        return protocol
    return PROTOCOLS[check_known_name("protocol", protocol, PROTOCOLS, others=OTHER_NAMES)]


def refusal(protocol: EvaluationProtocol, other: Published) -> str:
    """The fields in which a published agent is not comparable, and the protocol that would do; "" if there are none.

    If no protocol would do, the text names the one with the fewest differences.
    """
    faults = protocol.faults(other)
    if not faults:
        return ""
    nearest = min(PROTOCOLS.values(), key=lambda one: len(one.faults(other)))
    left = nearest.faults(other)
    if not left:
        advice = f"protocol {nearest.name!r} has its environments"
    elif None in (other.protocol["repeat_action_probability"], other.protocol["lives"]):
        advice = "its source does not state its environments, so no protocol has them"
    else:
        advice = f"no protocol has its environments; the nearest is {nearest.name!r}, where {', '.join(left)}"
    return f"{', '.join(faults)}; {advice}"
