"""The doors of this package: each function, class and command that plays a game, as a function that returns its task.

A door is called with GAME and options of a task by their names, and returns the `Task` that it would play or plays.
"""

import contextlib
import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

import gymnasium
import pytest
from field_values import CASES, flags_of, lacking

import atari
from atari.cli import main
from atari.integrations import envpool
from atari.learning import load_policy
from atari.learning.evaluation.played import played_task, resolve_games
from atari.learning.evaluation.protocols import find_protocol
from atari.multiplayer import MultiplayerCore, parallel_env
from atari.task import Task
from atari.task.description import summary
from atari.task.fields import GROUPS, OF_GAME, WRAPPED
from atari.task.resolution import OPTIONS


@dataclass(frozen=True)
class Door:
    """A door.

    Attributes:
        name: its name in a user's code.
        task: returns the task that it plays for GAME and options; it closes the objects that it makes.
        refuses: fields that it cannot honour, each with the reason.
        translates: options that become another field, under ale-py's names.
        outside: fields that something around this package does, each with the reason.
        games: what GAME may be: "any", only "ids", or "several", games of two players.
        takes_options: whether it takes options of a task; otherwise it needs a `Task`.
    """

    name: str
    task: Callable[..., Task]
    refuses: Mapping[str, str] = field(default_factory=dict)
    translates: Mapping[str, str] = field(default_factory=dict)
    outside: Mapping[str, str] = field(default_factory=dict)
    games: Literal["any", "ids", "several"] = "any"
    takes_options: bool = True


def _made(make: Callable[..., Any], *arguments: Any) -> Callable[..., Task]:
    """A door for a function or a class that makes an environment, which this door closes."""

    def task(game: Any, **options: Any) -> Task:
        env = make(game, *arguments, **options)
        found = env.task if hasattr(env, "task") else env.unwrapped.whole_task
        env.close()
        assert isinstance(found, Task)
        return found

    return task


def _gymnasium_vector(game: Any, **options: Any) -> Any:
    if gymnasium.__version__ < "1":
        pytest.skip("Gymnasium before 1.0 makes its own vector of this ID")
    return gymnasium.make_vec(game, num_envs=1, **options).unwrapped


def _stable_baselines(game: Any, **options: Any) -> Any:
    from atari.integrations.sb3 import AtariVecEnv

    return AtariVecEnv(game, 1, **options)


def _evaluation(game: Any) -> Task:
    """The task that `evaluate` plays under the evaluation protocol machado2018."""
    return played_task(*resolve_games(game), find_protocol("machado2018"), load_policy("noop"))


def _command(*words: str) -> Callable[..., Task]:
    """A door for a command, which prints its task; an exit code other than 0 is a ValueError with the error's text."""

    def task(game: str, **options: Any) -> Task:
        line = [
            *words,
            game,
            *(flag for name, value in options.items() for flag in flags_of(name, value)),
        ]
        printed, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(errors):
            try:
                code = main([*line, "--print-task", *([] if "--json" in words else ["--json"])])
            except SystemExit as exit_:
                code = exit_.code
        if code:
            raise ValueError(errors.getvalue())
        return Task.from_json(printed.getvalue())

    return task


def of_fields(names: str | tuple[str, ...], reason: str) -> dict[str, str]:
    """Fields, or the fields of a group, that a door refuses for one reason."""
    chosen = GROUPS[names] if isinstance(names, str) else names
    return dict.fromkeys(chosen, reason)


def all_but(names: tuple[str, ...], reason: str) -> dict[str, str]:
    """The other fields, which a door refuses for one reason."""
    return of_fields(tuple(name for name in OPTIONS if name not in names), reason)


_NO_WRAPPERS = "an AtariEnv has no wrappers; atari.make puts them around"
_ONE_PLAYER = "Gymnasium's environments have one player; atari.multiplayer and vectors have several"
_NO_SOUND = of_fields(lacking("vector"), "a vector's engine has no sound")
_SINGLE = of_fields(lacking("one"), _ONE_PLAYER)
_OF_WRAPPERS = ("max_episode_steps", *(name for name in WRAPPED if name not in lacking("one")))
_OF_LIMITS = {"max_num_frames_per_episode": "max_frames"}
_OF_SEVERAL = of_fields(lacking("several"), "a rule of tasks: it is for one player")
_OF_STEPS = all_but(
    ("players", "mode", "difficulty", "repeat_action_probability", "interventions", "max_num_frames_per_episode"),
    "a core plays frames, and an environment around it makes steps of them",
)
_OF_ENVPOOL = of_fields(("obs_type",), "EnvPool's info has the RAM, and its observations are images")

_BY_FRAME = "it plays single frames with all actions"
_SEEN_BY_A_PERSON = "a person sees the screen and the score"
_COMPARED = ("mode", "difficulty", "repeat_action_probability", "max_num_frames_per_episode")
_FRAMES = (*_COMPARED, "interventions")
_OF_PLAY = of_fields(
    ("continuous", "continuous_action_threshold", *GROUPS["observation"], *GROUPS["reward"]), _SEEN_BY_A_PERSON
)
_NOT_OF_BASELINES = of_fields(("fire_again", "seamless_lives"), "it contradicts preset baselines")
_OF_POLICIES = of_fields(
    (
        *lacking("one", "vector"),
        *("continuous", "continuous_action_threshold", "life_loss_info", "reward", "reward_clipping"),
    ),
    "policies play whole games of one player, with the game's own scores",
)
_NO_CHOICE = of_fields(("continuous", "continuous_action_threshold"), "a policy chooses one of the actions")
_OF_RECORD = {**of_fields(("agent_indicator", "zero_sum"), _SEEN_BY_A_PERSON), **_NO_CHOICE}

DOORS: tuple[Door, ...] = (
    Door("Task.of", Task.of),
    Door("atari.make", _made(atari.make), _SINGLE),
    Door(
        "gymnasium.make",
        _made(gymnasium.make),
        _SINGLE,
        outside={"max_episode_steps": "Gymnasium puts its TimeLimit around"},
        games="ids",
    ),
    Door("gymnasium.make_vec", _made(_gymnasium_vector), _NO_SOUND, _OF_LIMITS, games="ids"),
    Door("atari.AtariEnv", _made(atari.AtariEnv), {**_SINGLE, **of_fields(_OF_WRAPPERS, _NO_WRAPPERS)}),
    Door("atari.AtariVectorEnv", _made(atari.AtariVectorEnv, 1), _NO_SOUND, _OF_LIMITS),
    Door(
        "envpool.make",
        _made(partial(envpool.make, env_type="gymnasium", num_envs=1)),
        {**_SINGLE, **_NO_SOUND, **_OF_ENVPOOL},
        takes_options=False,
    ),
    Door("MultiplayerCore", _made(MultiplayerCore), {**_OF_STEPS, **_OF_SEVERAL}, games="several"),
    Door(
        "parallel_env",
        _made(lambda game, **options: parallel_env(game, **options).unwrapped),
        _OF_SEVERAL,
        games="several",
    ),
    Door(
        "evaluate",
        _evaluation,
        all_but((*OF_GAME, "reward", "reward_clipping", "actions", "obs_type", "maxpool"), "the protocol says it"),
        outside=of_fields(("reward", "reward_clipping"), "scores are the game's own"),
        takes_options=False,
    ),
    Door("atari info", _command("info")),
    Door("atari play", _command("play"), _OF_PLAY),
    Door("atari record", _command("record"), _OF_RECORD),
    Door("atari record --policy random", _command("record", "--policy", "random"), _OF_RECORD),
    Door("atari lab", _command("lab"), all_but(_FRAMES, _BY_FRAME)),
    Door("atari causes", _command("causes"), all_but(("mode", "difficulty"), _BY_FRAME)),
    Door("atari verify", _command("verify"), all_but(_COMPARED, _BY_FRAME)),
    Door("atari collect", _command("collect", "-o", "games.h5"), {**_OF_POLICIES, **_NOT_OF_BASELINES}),
    Door("atari evaluate", _command("evaluate", "random"), all_but(OF_GAME, "the protocol says it")),
    Door("atari watch", _command("watch", "random"), {**_OF_POLICIES, **_NOT_OF_BASELINES}),
)

TRAIN = Door(
    "atari train",
    _command("train", "--json", "ppo"),
    {
        **of_fields(
            (*lacking("one", "vector"), "continuous", "continuous_action_threshold"),
            "agents see images or RAM of one player, and choose one of the actions",
        ),
        **_NOT_OF_BASELINES,
        **of_fields(("life_loss_info",), "it contradicts preset baselines"),
    },
)
"""The door that needs PyTorch."""

STABLE_BASELINES = Door("atari.sb3.AtariVecEnv", _made(_stable_baselines), _NO_SOUND, _OF_LIMITS)
"""The door that needs Stable-Baselines3."""

GAMES = ("pong", "ALE/Pong-v5", "PongNoFrameskip-v4", "Pong-ram-v4")


def row(door: Door) -> str:
    """The row of a door in the table of docs/tasks.md: its task for each of `GAMES`."""
    return f"| {door.name} | {' | '.join(_words(door, game) for game in GAMES)} |"


def _words(door: Door, game: str) -> str:
    if door.games == "ids" and game == "pong":
        return "-"
    try:
        played = door.task(game)
    except ValueError:
        return "refused"
    words = summary(played).removeprefix("pong: Pong, ").removeprefix("as ")
    return "as it says" if words == game else f"`{words}`"


def cell_options(door: Door, field: str) -> dict[str, Any]:
    """Options, GAME among them, in which a field differs from its default."""
    case = CASES[field]
    if door.games != "several":
        return {"game": "breakout", **case.needs, field: case.value}
    case = case.several or case
    return {"players": 2, **case.needs, "game": "pong", field: case.value}


def call(door: Door, options: dict[str, Any]) -> Task:
    """The task of a door."""
    options = dict(options)
    game = options.pop("game")
    if not door.takes_options:
        return door.task(Task.of(game, **options))
    return door.task(f"ALE/{game.title()}-v5" if door.games == "ids" else game, **options)


def check_cell(door: Door, field: str) -> None:
    """Check that a door takes a field, so that its task has the value, or refuses it with a sentence that names it."""
    options = cell_options(door, field)
    if field in door.outside:
        assert getattr(call(door, options), field) == getattr(Task("pong"), field), door.outside[field]
        return
    if field in door.refuses:
        with pytest.raises((TypeError, ValueError)) as error:
            call(door, options)
        text = str(error.value).replace("-", "_")  # flags have hyphens
        assert any(name in text for name in {*options} - {"game"}), door.refuses[field]
        return
    played = call(door, options)
    assert getattr(played, door.translates.get(field, field)) == getattr(Task(**options), field)
