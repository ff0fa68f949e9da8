"""`make`, and the functions that Gymnasium calls to make an environment of a registered ID."""

import inspect
from collections.abc import Mapping
from os import PathLike
from typing import Any

import gymnasium
from gymnasium.envs.registration import EnvSpec
from typing_extensions import Unpack

from atari.base.validation import check_known
from atari.env import AtariEnv
from atari.games.catalog import games
from atari.task import Task, env_ids
from atari.task.fields import MakeOptions
from atari.task.resolution import ALIASES, ENTRY_POINT, OPTIONS, fields_of_id, is_id, is_ours, known_ids
from atari.task.task import FoundGame, GameLike, look_up
from atari.vector import AtariVectorEnv
from atari.vector.options import OF_TASKS

_OF_GYMNASIUM = (name for name in inspect.signature(gymnasium.make).parameters if name not in ("id", "kwargs"))
_OTHER_OPTIONS = ("render_mode", "core", "rom", *_OF_GYMNASIUM)
"""Options that do not change the task: an environment's own, and the options of `gymnasium.make`."""

Env = gymnasium.Env[Any, Any]


def make(game_or_id: GameLike, *, preset: str | None = None, **options: Unpack[MakeOptions]) -> Env:
    """Make an environment of a game, an ID or a task, as `gymnasium.make` would.

    Args:
        game_or_id: a game's name ("breakout", which means "ALE/Breakout-v5"), an ID of this package
            ("Breakout-ram-v4"), the path of a game file, a `Game`, or an `atari.Task`.
        preset: name of a preprocessing, one of `atari.PRESETS`.
        **options: fields of `atari.Task`; `render_mode`, `core` and `rom` of `atari.AtariEnv`; and options of
            `gymnasium.make`.

    Raises:
        gymnasium.error.NameNotFound: no such ID; the message suggests the right one.
        ValueError: no such game; the message suggests the nearest. Or a preset for an ID that is not an Atari game.
        TypeError: there is no such option; the message suggests the nearest.

    Example:
        >>> import atari
        >>> env = atari.make("breakout", preset="dqn2015")
        >>> observation, info = env.reset(seed=0)
        >>> observation.shape
        (4, 84, 84)
        >>> atari.make("Breakout-ram-v4").observation_space.shape
        (128,)
    """
    if isinstance(game_or_id, str) and is_id(game_or_id):
        env_id = game_or_id.removeprefix(env_ids.MODULE_PREFIX)
        if env_id not in known_ids():
            raise env_ids.not_found(game_or_id, known_ids())
        if env_id not in env_ids.ids() and not is_ours(gymnasium.registry[env_id].entry_point):
            if preset is not None:
                raise ValueError(f"a preset is for Atari games, and {env_id!r} is none; make it without {preset=}")
            return gymnasium.make(env_id, **options)
    known = ("preset", *OPTIONS, *ALIASES, *_OTHER_OPTIONS)
    check_known("atari.make", [name for name in options if name not in known], known)
    fields = {name: value for name, value in options.items() if name in OPTIONS or name in ALIASES}
    others = {name: value for name, value in options.items() if name not in fields}
    found = look_up(game_or_id)
    return make_found(found, found.task(preset, fields, owner="atari.make"), others)


def make_found(found: FoundGame, task: Task, options: dict[str, Any]) -> Env:
    """An environment of a task as `make` makes it: by the ID that GAME is, or by the game's ID.

    `options` are those of `gymnasium.make`, and others that do not change the task.
    """
    env_id = None if found.env_id is None else found.env_id.removeprefix(env_ids.MODULE_PREFIX)
    if found.bare and task.definition.file is None:
        env_id = f"ALE/{env_ids.stem(task.game)}-v5"
    inner = task.emulator_task() if task.preprocessed else task
    return _with_wrappers(_make_unwrapped(inner, env_id, options), task)


def _make_unwrapped(task: Task, env_id: str | None, options: dict[str, Any]) -> Env:
    """An environment without wrappers of this package, made by Gymnasium, by its ID if it has one."""
    limit = task.max_episode_steps
    limited: dict[str, Any] = {} if limit is None else {"max_episode_steps": limit}
    if env_id is None:
        return gymnasium.make(spec_of(task.replace(max_episode_steps=None)), **limited, **options)
    base = FoundGame(task.definition, env_id, fields_of_id(env_id)[1]).task(None, {})
    changed = {name: getattr(task, name) for name in base.differences(task) if name != "max_episode_steps"}
    spec = env_id if is_ours(gymnasium.registry[env_id].entry_point) else spec_of_id(env_id)
    return gymnasium.make(spec, **{**changed, **limited, **options})


def spec_of_id(env_id: str) -> EnvSpec:
    """The spec with which an ID of `ids` is registered."""
    family, game = env_ids.ids()[env_id]
    return EnvSpec(
        id=env_id,
        entry_point=ENTRY_POINT,
        kwargs={**family.options(game), "base": env_id},
        vector_entry_point=VECTOR_ENTRY_POINT,
    )


def spec_of(task: Task) -> EnvSpec:
    """A spec that contains a task, as JSON unless its game was made in memory."""
    in_memory = task.definition.file is None and games.get(task.game) != task.definition
    env_id = f"atari/{env_ids.stem(task.game)}-v0"
    return EnvSpec(id=env_id, entry_point=ENTRY_POINT, kwargs={"task": task if in_memory else task.to_json()})


def make_env(task: Task, render_mode: Any = None, core: str = "native", rom: str | PathLike[str] | None = None) -> Env:
    """An environment of a task: an `AtariEnv`, with wrappers around it where the task needs them."""
    inner = task.emulator_task() if task.preprocessed else task.replace(max_episode_steps=None)
    env: Env = AtariEnv(inner, render_mode=render_mode, core=core, rom=rom)
    if not task.preprocessed and task.max_episode_steps is not None:
        from atari.wrappers.layers import StepLimit  # here: most environments have no wrapper

        env = StepLimit(env, task.max_episode_steps)
    return _with_wrappers(env, task)


def _with_wrappers(env: Env, task: Task) -> Env:
    if task.preprocessed:
        from atari.wrappers.layers import wrap  # here: most environments have no wrapper

        env = wrap(env, task)
    env.unwrapped.whole_task = task  # type: ignore[attr-defined]
    return env


def make_AtariEnv(  # other programs recognise Atari games by this name
    base: str | None = None,
    *,
    preset: str | None = None,
    task: "str | Task | None" = None,
    render_mode: Any = None,
    core: str = "native",
    rom: str | PathLike[str] | None = None,
    **options: Any,
) -> Env:
    """The environment of a registered ID, or of a spec that contains a task; `gymnasium.make` calls this function.

    Args:
        base: the ID. Options equal to its own have no effect.
        preset: name of a preprocessing, one of `atari.PRESETS`.
        task: a task, or its JSON, instead of an ID.
        render_mode, core, rom: see `AtariEnv`.
        **options: fields of `atari.Task`.

    Raises:
        TypeError, ValueError, FileNotFoundError: see `atari.Task.of` and `AtariEnv`.
    """
    if task is not None:
        chosen = Task.from_json(task) if isinstance(task, str) else task
        found = FoundGame(chosen).task(preset, options, owner=f"{chosen.game}'s spec")
    else:
        if not options.get("continuous", False):  # Dopamine gives a threshold to every environment, as ale-py allows
            options.pop("continuous_action_threshold", None)
        found = look_up(base or options.pop("game")).task(preset, given_beside(base, options), owner="AtariEnv")
    return make_env(found, render_mode, core, rom)


make_AtariEnv.metadata = AtariEnv.metadata  # type: ignore[attr-defined]  # which `gymnasium.make` reads


def make_AtariVectorEnv(base: str, num_envs: int, *, preset: str | None = None, **options: Any) -> AtariVectorEnv:
    """The vector environment of a registered ID; `gymnasium.make_vec` calls this function.

    ALE's v5 IDs of pixels have ale-py's preprocessing without a preset, as in ale-py; all others play the ID's task.

    Raises:
        TypeError, ValueError, FileNotFoundError: see `AtariVectorEnv`.
    """
    running = {name: options.pop(name) for name in list(options) if name not in OF_TASKS and name != "game"}
    given = given_beside(base, options)
    if preset is None and env_ids.is_ale_py_vector(base):
        family, game = env_ids.ids()[base]
        of_id = family.options(game)
        kept = {name: value for name, value in of_id.items() if _OTHER_NAMES.get(name) not in given}
        return AtariVectorEnv(kept.pop("game"), num_envs, **running, **{**kept, **given})
    return AtariVectorEnv(base, num_envs, preset=preset, **running, **given)


_OTHER_NAMES = {"full_action_space": "actions", "max_num_frames_per_episode": "max_frames"}
"""The name that a user may give for an option of an ID, as ale-py's vector has it."""

VECTOR_ENTRY_POINT = "atari.registry.making:make_AtariVectorEnv"


def given_beside(env_id: str | None, options: Mapping[str, Any]) -> dict[str, Any]:
    """The user's options without the ID's own.

    Raises:
        ValueError: the user gave another game than the ID's.
    """
    if env_id is None:
        return dict(options)
    own = spec_of_id(env_id).kwargs if env_id in env_ids.ids() else gymnasium.registry[env_id].kwargs
    given = {name: value for name, value in options.items() if name not in own or not _same(own[name], value)}
    if "game" in given:
        raise ValueError(f"{env_id} is of the game {own['game']!r}, got game={given['game']!r}; make that game's ID")
    return given


def _same(own: Any, value: Any) -> bool:
    """Whether a value is an ID's own. 4.0 and True equal integers, and are checked as the values that they are."""
    return bool(own == value) and (type(own) is type(value) or not isinstance(own, int))
