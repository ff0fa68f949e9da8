"""The fields of a `Task`, one row each: name, type, default, group, sentence, and what the type does not say.

The dataclass, the checks, the typed options, flags and their help, JSON, the printed task and the tables of
`docs/tasks.md` follow from the rows. The rules between fields are in `atari/task/rules.py`.
"""

import dataclasses
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypedDict, TypeVar, get_args

from atari.base.frozen import FrozenDict
from atari.base.validation import MOST_FRAMES_SKIPPED
from atari.games.actions import Action
from atari.games.interventions import Intervention
from atari.task.checks import (
    NO_LIMIT,
    Check,
    FrameSkip,
    Limit,
    OneOf,
    OrNone,
    Probability,
    Span,
    Whole,
    as_is,
    check_actions,
    check_bool,
    check_probabilities,
    check_reward,
    check_text,
    check_threshold,
)
from atari.task.observation_kinds import IN_WORDS, ObsType

Fire = Literal["never", "before_noops", "after_noops"]
OnReset = Literal["noop", "continue", "new_game"]
Unit = Literal["frame", "skip"]
Seeding = Literal["gymnasium", "ale"]
Padding = Literal["zero", "reset"]
EndFrames = Literal["last", "gymnasium", "baselines", "envpool"]
Interventions = Sequence[str | Mapping[str, Any] | Intervention] | None
Group = Literal["game", "play", "begin", "lives", "limits", "observation", "reward"]
_T = TypeVar("_T")


class _Unset:
    """The type of `UNSET`."""

    def __repr__(self) -> str:
        return "as the game says"


UNSET: Any = _Unset()
"""The default of an option that a user may leave out."""


@dataclass(frozen=True)
class Row:
    """A field, without its name, type and default.

    Attributes:
        group: the part of a task to which the field belongs.
        says: its meaning, for the documentation and the help of commands.
        check: checks a value; None for a bool or a Literal, whose type is the check.
        tuned: whether users tune it. Otherwise it only says how another program resets.
        wrapped: whether wrappers play it, so that an `AtariEnv` alone accepts its default only; None if its group says.
        of_game: whether it changes the game that an agent meets; the game of an evaluation decides it, not its
            protocol.
        accepts: the type of the option, if it takes more than the field holds. None then counts as not given.
        flags: its flags, if they are not made from its name.
        metavar: its value in the help of commands; "" for the choices of a Literal, and otherwise N.
        words: its words in the printed task where its value is not the default; {} is the value. "" if
            `atari/task/description.py` writes it together with other fields.
    """

    group: Group
    says: str
    check: Check | None = None
    tuned: bool = True
    wrapped: bool | None = None
    of_game: bool = False
    accepts: str | None = None
    flags: tuple[str, ...] = ()
    metavar: str = ""
    words: str = ""


def row(default: _T, group: Group, says: str, *, compare: bool = True, **more: Any) -> _T:
    """A field with a default; see `Row`. `compare` is whether `==` compares it."""
    return dataclasses.field(default=default, compare=compare, metadata={"row": Row(group, says, **more)})


# The formatter would give each argument of a row a line of its own.
# fmt: off
@dataclass(frozen=True, repr=False)
class TaskFields:
    """The rows. Their order is the order of the fields in `repr`, in the documentation and in the help of commands."""

    game: str = dataclasses.field(metadata={"row": Row(
        "game", 'id of the game ("breakout"). The constructor also takes a game file of your own, or a `Game`', as_is)})
    _: dataclasses.KW_ONLY
    rules: str = row(
        "", "game", 'fingerprint of the game definition; "" in the constructor means the installed one\'s',
        check=check_text)
    rom_md5: str | None = row(
        None, "game", "MD5 of the ROM, None if it is not known; it is not compared by `==`", check=check_text,
        compare=False)
    mode: int | None = row(
        None, "game",
        "game mode, None in the constructor means the default. With several players, Multi-Agent-ALE numbers the modes",
        check=as_is, of_game=True)
    difficulty: int | None = row(
        None, "game", "None in the constructor means ALE's default, 0", check=as_is, of_game=True)
    players: int = row(1, "game", "number of players of one game, 1 to 4", check=Whole(1, 4), accepts="int | None")
    actions: str | tuple[str, ...] = row(
        "minimal", "play", "minimal (those that the game uses), full (all legal ones), or names of actions",
        check=check_actions, accepts="str | Sequence[str | Action] | None", metavar="full|NAMES")
    continuous: bool = row(
        False, "play", 'actions are (radius, angle, fire), three float32 (Farebrother and Castro 2024, "CALE")')
    continuous_action_threshold: float = row(
        0.5, "play", "least movement of the stick, or pressure on fire, that counts, 0..1",
        check=Probability(check_threshold), metavar="P")
    repeat_action_probability: float | tuple[float, ...] = row(
        0.25, "play", "probability of repeating the previous action, drawn in each frame (sticky actions); each of "
        "several players can have its own", check=Probability(check_probabilities),
        accepts="float | tuple[float, ...] | None", flags=("--repeat-action-probability", "--sticky"), metavar="P")
    frameskip: int | tuple[int, int] = row(
        4, "play", "frames for each action, or (low, high) for a number within low..high-1 drawn at each step",
        check=FrameSkip(Whole(1, MOST_FRAMES_SKIPPED)), metavar="N|LOW,HIGH")
    action_delay: int | tuple[int, int] = row(
        0, "play", "frames between the agent's action and the console, or (low, high), both included, for a number "
        "drawn at each episode; see docs/tasks.md", check=Span(Whole(0, 60), or_number=True), wrapped=True,
        of_game=True, metavar="N|LOW,HIGH", words="they arrive {} frames later")
    interventions: tuple[Intervention, ...] = row(
        (), "play", 'changes of the game through its RAM; names, paths as "file.toml#name", or definitions',
        check=as_is, of_game=True, accepts="Interventions", flags=("--intervention",), metavar="NAME")
    noops: tuple[int, int] = row(
        (0, 0), "begin",
        "(low, high), both included: an episode begins with a number of NOOP frames drawn from this range",
        check=Span(Whole(0, 1_000_000)), metavar="LOW,HIGH")
    fire: Fire = row(
        "never", "begin", "an episode begins with FIRE before or after the no-ops, or never, in games that have it")
    fire_counts: bool = row(False, "begin", "FIRE is one of the no-ops", tuned=False)
    third_action: bool = row(
        False, "begin", "the action with index 2 follows FIRE, as in OpenAI's Baselines", tuned=False)
    fire_unit: Unit = row(
        "frame", "begin", "FIRE is played for a frame, or for a skip: a whole step, after the no-ops", tuned=False)
    fire_again: bool = row(
        True, "begin", "FIRE is pressed again when a game ends in the no-ops that follow it", tuned=False,
        words="FIRE is not pressed again if the game ends in them")
    seeding: Seeding = row(
        "gymnasium", "begin", "generators that a seed starts: gymnasium (NumPy's PCG64 for no-ops and skips, the "
        "emulator's from the second word of the seed) or ale (a Mersenne Twister, and the seed itself for the "
        "emulator)", tuned=False)
    episodic_life: bool = row(False, "lives", "a lost life ends the episode", accepts="bool | None")
    lives_unit: Unit = row(
        "frame", "lives",
        "lives are compared after each frame, so that a lost life cuts a skip short, or after a whole skip",
        tuned=False, words="whole steps are played")
    on_reset: OnReset = row(
        "new_game", "lives", "a reset after a lost life plays a step of NOOP, nothing (continue), or a new game")
    last_life: bool = row(
        False, "lives", "losing the last life counts in games that continue after it", words="the last life counts too")
    seamless_lives: bool = row(
        False, "lives", "a lost life neither cuts a skip short nor clears the stack", tuned=False,
        words="skip and stack go on")
    life_loss_info: bool = row(False, "lives", "a lost life is reported as a termination, and the episode continues")
    max_num_frames_per_episode: int | None = row(
        108_000, "limits", "limit on all frames of a game, no-ops included; None means no limit",
        check=Limit(Whole(0, NO_LIMIT)), words="{:,} frames of the emulator")
    max_frames: int | None = row(
        None, "limits", "limit on the frames of a game after its beginning; None means no limit",
        check=OrNone(Whole(1, NO_LIMIT)), wrapped=True, words="{:,} frames after the beginning")
    max_episode_steps: int | None = row(
        None, "limits", "limit on the agent's steps of an episode; None means no limit",
        check=OrNone(Whole(1, NO_LIMIT)), words="{:,} steps")
    obs_type: ObsType = row("rgb", "observation", IN_WORDS, wrapped=False, accepts="ObsType | None")
    img_height: int | None = row(
        None, "observation", "rows of the image, None means the screen's rows", check=OrNone(Whole(1, 256)))
    img_width: int | None = row(
        None, "observation", "columns of the image, None means the screen's columns", check=OrNone(Whole(1, 160)))
    stack_num: int | None = row(
        None, "observation", "images or RAM vectors in an observation, the oldest first; None means one, without an "
        "axis for it. In dicts of both, images are stacked, RAM is not. The stacks of presets contain images",
        check=OrNone(Whole(1, 256)))  # 26 MB of RGB images
    maxpool: bool = row(False, "observation", "the image is the maximum of the last two frames of a skip")
    pool_rgb: bool = row(
        False, "observation",
        "colours are pooled and then made gray, as in OpenAI's Baselines, instead of ALE's gray values")
    padding: Padding = row(
        "zero", "observation",
        "filling of the stack at the start of an episode: zero, or reset, the first image or RAM")
    end_frames: EndFrames = row(
        "last", "observation",
        "frames that are observed when an episode ends inside a skip; see `atari.wrappers.DqnPreprocessing`")
    observation_delay: int | tuple[int, int] = row(
        0, "observation", "frames between the screen, or RAM, and the agent, or (low, high), both included, for a "
        "number drawn at each episode; see docs/tasks.md", check=Span(Whole(0, 60), or_number=True), of_game=True,
        metavar="N|LOW,HIGH", words="{} frames late")
    sound_obs: bool = row(
        False, "observation", "observations are image and sound: 512 samples of the step's last frame",
        wrapped=False, words="and 512 samples of sound")
    agent_indicator: bool = row(
        False, "observation", "each of several players sees more channels, which say which player it is",
        words="with the number of the player")
    reward: str | None = row(
        None, "reward", 'an expression over the game\'s own reward, lives and RAM, such as "reward - 5 * lives_lost", '
        "see docs/rewards.md; None is the game's own. `info` has the game's rewards and scores all the same",
        check=check_reward, metavar="EXPRESSION", words="the expression {}")
    reward_clipping: bool = row(
        False, "reward", "rewards are clipped to -1..1", accepts="bool | None", words="clipped to -1..1")
    zero_sum: bool = row(
        False, "reward", "each of several players gets its reward minus the mean of the others'",
        words="minus the mean of the other players'")
# fmt: on


ROWS: Mapping[str, Row] = {one.name: one.metadata["row"] for one in dataclasses.fields(TaskFields)}
"""The row of each field."""

FIELDS: tuple[str, ...] = tuple(ROWS)
"""The names of the fields of a `Task`."""

TYPES: Mapping[str, Any] = {name: kind for name, kind in typing.get_type_hints(TaskFields).items() if name in ROWS}
"""The type of each field."""

DEFAULTS: Mapping[str, Any] = {one.name: one.default for one in dataclasses.fields(TaskFields)}
"""The default of each field; that of `game` is MISSING."""

GROUPS: Mapping[str, tuple[str, ...]] = FrozenDict(
    {group: tuple(name for name in ROWS if ROWS[name].group == group) for group in get_args(Group)}
)
"""The fields of a `Task` by group."""

WRAPPED: tuple[str, ...] = tuple(
    name
    for name, row in ROWS.items()
    if (row.group in ("begin", "lives", "observation", "reward") if row.wrapped is None else row.wrapped)
)
"""The fields that wrappers play. An `AtariEnv` alone plays their defaults; of `obs_type` it lacks the dicts."""

OF_GAME: tuple[str, ...] = tuple(name for name, row in ROWS.items() if row.of_game)
"""The fields that the game of an evaluation decides."""

CHECKS: Mapping[str, Check] = {
    name: row.check or (check_bool if TYPES[name] is bool else OneOf(get_args(TYPES[name])))
    for name, row in ROWS.items()
}
"""The check of each field. Its attributes are the range that the field accepts; the tests draw from them."""


def check_field(name: str, value: Any) -> Any:
    """The value of a field in the form that a `Task` stores.

    Raises:
        TypeError, ValueError: it is of the wrong kind or out of range.
    """
    return CHECKS[name](name, value)


# Begin of what scripts/generate/options.py writes.
class AddedOptions(TypedDict, total=False):
    """The options that `AtariEnv` does not name."""

    players: int | None
    actions: str | Sequence[str | Action] | None
    action_delay: int | tuple[int, int]
    noops: tuple[int, int]
    fire: Fire
    fire_counts: bool
    third_action: bool
    fire_unit: Unit
    fire_again: bool
    seeding: Seeding
    episodic_life: bool | None
    lives_unit: Unit
    on_reset: OnReset
    last_life: bool
    seamless_lives: bool
    life_loss_info: bool
    max_frames: int | None
    max_episode_steps: int | None
    img_height: int | None
    img_width: int | None
    stack_num: int | None
    maxpool: bool
    pool_rgb: bool
    padding: Padding
    end_frames: EndFrames
    observation_delay: int | tuple[int, int]
    agent_indicator: bool
    reward: str | None
    reward_clipping: bool | None
    zero_sum: bool
    clip_reward: bool | None


class SharedOptions(AddedOptions, total=False):
    """The options that have one type in all functions."""

    continuous: bool
    continuous_action_threshold: float
    repeat_action_probability: float | tuple[float, ...] | None
    frameskip: int | tuple[int, int]
    interventions: Interventions
    max_num_frames_per_episode: int | None
    obs_type: ObsType | None
    sound_obs: bool
    full_action_space: bool | None


# End of what scripts/generate/options.py writes.


class TaskOptions(SharedOptions, total=False):
    """The options of `Task.of`."""

    mode: int | None
    difficulty: int | None


class VectorTaskOptions(SharedOptions, total=False):
    """The options of a task by `AtariVectorEnv`: modes and difficulties may be lists, and ale-py's names are added."""

    mode: int | Sequence[int | None] | None
    difficulty: int | Sequence[int | None] | None
    noop_max: int | None
    use_fire_reset: bool | None
    grayscale: bool | None


class MakeOptions(TaskOptions, total=False):
    """The options of `atari.make`: the options of a task, of an environment and of `gymnasium.make`."""

    render_mode: str | None
    core: str
    rom: Any
    disable_env_checker: bool | None
