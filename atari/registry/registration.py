"""Gymnasium's registry: every environment ID in the history of these games, and games of a user's own."""

from collections.abc import Iterable
from contextlib import suppress
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

import gymnasium
from gymnasium.envs.registration import EnvSpec

from atari.base.variables import value
from atari.cores import NativeCore
from atari.games.catalog import games
from atari.registry import after_ale_py
from atari.registry.making import VECTOR_ENTRY_POINT, spec_of_id
from atari.roms.search import remember
from atari.task import Task
from atari.task.description import skip_text
from atari.task.env_ids import FAMILIES, MAX_FRAMES, MODULE_PREFIX, Family, ids, not_found, stem
from atari.task.resolution import ENTRY_POINT, known_ids

ALGORITHMIC: dict[str, tuple[str, dict[str, Any], float]] = {
    "Copy-v0": ("CopyEnv", {}, 25.0),
    "DuplicatedInput-v0": ("DuplicatedInputEnv", {}, 9.0),
    "RepeatCopy-v0": ("RepeatCopyEnv", {}, 75.0),
    "Reverse-v0": ("ReverseEnv", {}, 25.0),
    "ReversedAddition-v0": ("ReversedAdditionEnv", {"rows": 2}, 25.0),
    "ReversedAddition3-v0": ("ReversedAdditionEnv", {"rows": 3}, 25.0),
}
"""By ID, as OpenAI Gym published it: the class, its options, the mean return over 100 episodes that solves the task."""


def register_all() -> None:
    """Put every ID into Gymnasium's registry; an ID that ale-py has too is replaced, also if it is imported later.

    With the environment variable `ATARI_REGISTER=own`, ale-py's IDs, and others that are registered already, keep their
    environments.

    Raises:
        ValueError: `ATARI_REGISTER` has another value.
    """
    if value("ATARI_REGISTER") == "own":
        with suppress(ImportError):
            import_module("ale_py")  # which registers its IDs
        register_ids(env_id for env_id in ids() if env_id not in gymnasium.registry)
    else:
        register_ids(ids())
        after_ale_py.keep(ids())


def register_ids(env_ids: Iterable[str]) -> None:
    """Put these IDs of `ids` into Gymnasium's registry; an ID that is registered already is replaced."""
    for env_id in env_ids:
        gymnasium.registry[env_id] = spec_of_id(env_id)  # gymnasium.register() warns when it replaces an ID


def register_algorithmic() -> None:
    """Put the IDs of the algorithmic tasks into Gymnasium's registry.

    Example:
        >>> import gymnasium
        >>> import atari  # which calls it
        >>> gymnasium.make("Copy-v0").observation_space
        Discrete(6)
    """
    for env_id, (name, options, threshold) in ALGORITHMIC.items():
        gymnasium.registry[env_id] = EnvSpec(
            id=env_id,
            entry_point=f"atari.classic.algorithmic:{name}",
            kwargs=options,
            reward_threshold=threshold,
            max_episode_steps=200,
        )


def resolve(env_id: str) -> tuple[Family, str]:
    """The family and game of an ID.

    Raises:
        gymnasium.error.NameNotFound: the ID does not exist or belongs to no family; the message suggests the right one.
    """
    known = env_id.removeprefix(MODULE_PREFIX)
    if known in ids():
        return ids()[known]
    if known in known_ids():
        raise gymnasium.error.NameNotFound(
            f"only IDs of ALE's games are explained, {known!r} is none; gymnasium.spec({known!r}) shows what it is"
        )
    raise not_found(env_id, known_ids())


def register_game(file: str | PathLike[str], rom: str | PathLike[str]) -> tuple[str, str]:
    """Register a game of your own: a ROM of any supported cartridge type, with rules from a game file.

    Args:
        file: the game file (`atari/games/SCHEMA.md` documents it); its name without `.toml` names the game.
        rom: the ROM file.

    Returns:
        The two IDs, for pixels and for RAM, with the options of ALE's v5: `my_game.toml` gives "MyGame-v5" and
        "MyGame-ram-v5".

    Raises:
        ValueError: the file is not a game, the ROM is of no supported type, or an environment has the ID already.
        FileNotFoundError: one of the files does not exist.

    Example:
        >>> import atari, gymnasium
        >>> atari.register_game("my_game.toml", "my_game.bin")  # doctest: +SKIP
        ('MyGame-v5', 'MyGame-ram-v5')
        >>> env = gymnasium.make("MyGame-v5")  # doctest: +SKIP
    """
    game = games.find(Path(file))
    NativeCore(game, rom=rom).close()  # raises the errors of both files before anything is registered
    remember(game, rom)
    observations = {f"{stem(game.id)}-v5": {}, f"{stem(game.id)}-ram-v5": {"obs_type": "ram"}}
    for env_id in observations:
        if env_id in gymnasium.registry:
            raise ValueError(f"the ID {env_id!r} is taken; rename the game file")
    for env_id, observation in observations.items():
        options = {
            "game": str(Path(file).absolute()),
            "rom": str(Path(rom).absolute()),
            **observation,
            "max_num_frames_per_episode": MAX_FRAMES,
            "base": env_id,
        }
        gymnasium.registry[env_id] = EnvSpec(
            id=env_id, entry_point=ENTRY_POINT, kwargs=options, vector_entry_point=VECTOR_ENTRY_POINT
        )
    pixels, ram = observations
    return pixels, ram


def explain(env_id: str) -> str:
    """A text that explains what an ID plays, and how related IDs of the same game differ from it.

    Raises:
        gymnasium.error.NameNotFound: there is no such ID.

    Example:
        >>> import atari
        >>> print(atari.explain("ALE/Pong-v5").splitlines()[0])
        ALE/Pong-v5: Pong
    """
    family, game_id = resolve(env_id)
    siblings = [other for other in FAMILIES if other != family and game_id in other.games()]
    width = max(len(other.id(game_id)) for other in (*siblings, family))
    _, *table = str(Task.of(family.id(game_id))).splitlines()
    lines = [
        f"{env_id}: {games[game_id].title}",
        *table,
        "  siblings",
        *(f"    {other.id(game_id):{width}}  {_difference(family, other, game_id)}" for other in siblings),
    ]
    return "\n".join(lines)


def _difference(family: Family, other: Family, game: str) -> str:
    words = []
    if other.ram != family.ram:
        words.append("RAM" if other.ram else "RGB screen")
    skip = other.options(game)["frameskip"]
    if skip != family.options(game)["frameskip"]:
        words.append(f"frame skip: {skip_text(skip)}")
    if other.repeat_action_probability != family.repeat_action_probability:
        words.append("sticky actions" if other.repeat_action_probability else "no sticky actions")
    return "; ".join(words) or "the same"
