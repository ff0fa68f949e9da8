"""Every environment ID in the history of these games, as a table of families.

Sources: the registrations of OpenAI Gym 0.1-0.26 (v0 and v4) and of ale-py 0.7-0.12 (v5). An ID is a stem
(`MsPacman`) with a family's prefix, suffix and version; the family has all options.
"""

import difflib
import inspect
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from os import PathLike
from pathlib import Path
from typing import Any

import ale_py  # noqa: F401 - its import registers its IDs, which ours must replace
import gymnasium
from gymnasium.envs.registration import EnvSpec

from atari.cores import NativeCore
from atari.env import AtariEnv
from atari.games.catalog import games
from atari.validation import check_known

LEGACY_GAMES: tuple[str, ...] = tuple(
    """adventure air_raid alien amidar assault asterix asteroids atlantis bank_heist battle_zone beam_rider berzerk
    bowling boxing breakout carnival centipede chopper_command crazy_climber defender demon_attack double_dunk
    elevator_action enduro fishing_derby freeway frostbite gopher gravitar hero ice_hockey jamesbond journey_escape
    kangaroo krull kung_fu_master montezuma_revenge ms_pacman name_this_game phoenix pitfall pong pooyan private_eye
    qbert riverraid road_runner robotank seaquest skiing solaris space_invaders star_gunner tennis time_pilot
    tutankham up_n_down venture video_pinball wizard_of_wor yars_revenge zaxxon""".split()
)
"""The 62 games that have v0 and v4 IDs."""

MAX_FRAMES = 108_000
"""Emulated frames after which every registered environment truncates an episode: half an hour of play."""


_MODULE_PREFIX = "atari:"  # of "atari:ALE/Pong-v5", with which Gymnasium imports this package first
_ENTRY_POINT = "atari.env:AtariEnv"
_VECTOR_ENTRY_POINT = "atari.vector:AtariVectorEnv"
_PRESET_OPTIONS = ("episodic_life", "clip_reward", "reward_clipping")


@dataclass(frozen=True)
class Family:
    """The IDs that differ only in the game: `<prefix><stem><suffix>-v<version>`."""

    prefix: str
    suffix: str
    version: int
    obs_type: str
    frameskip: int | tuple[int, int]
    repeat_action_probability: float

    def id(self, game: str) -> str:
        """The ID of a game in this family."""
        return f"{self.prefix}{stem(game)}{self.suffix}-v{self.version}"

    def games(self) -> tuple[str, ...]:
        """The games this family has."""
        return tuple(game.id for game in games.playable()) if self.version == 5 else LEGACY_GAMES

    @property
    def vector_entry_point(self) -> str | None:
        """What `gymnasium.make_vec` makes. As with ale-py, only the IDs of ALE's v5 with pixels have one.

        Of all others, `make_vec` makes a `SyncVectorEnv` of the environments that `gymnasium.make` makes.
        """
        return _VECTOR_ENTRY_POINT if self.version == 5 and self.obs_type == "rgb" else None

    def options(self, game: str) -> dict[str, Any]:
        """The options of `AtariEnv` for the ID of this game."""
        frameskip = self.frameskip
        if game == "space_invaders" and self.suffix.endswith("Deterministic"):
            frameskip = 3  # with 4, the blinking shots would be invisible
        options = {
            "game": game,
            "obs_type": self.obs_type,
            "repeat_action_probability": self.repeat_action_probability,
            "full_action_space": False,
            "frameskip": frameskip,
            "max_num_frames_per_episode": MAX_FRAMES,
        }
        if self.obs_type == "rgb":
            del options[
                "obs_type"
            ]  # the default; ale-py's specs do not name it, and vectors then show their preprocessing
        return options


def _families() -> Iterator[Family]:
    for ram, obs_type in (("", "rgb"), ("-ram", "ram")):
        for speed, frameskip in (("", (2, 5)), ("Deterministic", 4), ("NoFrameskip", 1)):
            for version, probability in ((0, 0.25), (4, 0.0)):
                yield Family("", ram + speed, version, obs_type, frameskip, probability)
        yield Family("ALE/", ram, 5, obs_type, 4, 0.25)


FAMILIES: tuple[Family, ...] = tuple(_families())


def stem(game: str) -> str:
    """The name of a game inside an ID: `ms_pacman` -> `MsPacman`, `tic_tac_toe_3d` -> `TicTacToe3D`."""
    return game.title().replace("_", "")


@cache
def ids() -> dict[str, tuple[Family, str]]:
    """Every ID, with its family and game."""
    return {family.id(game): (family, game) for family in FAMILIES for game in family.games()}


def register_all() -> None:
    """Put every ID into Gymnasium's registry; an ID that ale-py has too is replaced.

    With the environment variable `ATARI_REGISTER=own`, an ID that is registered already keeps its environment.

    Raises:
        ValueError: `ATARI_REGISTER` has another value.
    """
    choice = os.environ.get("ATARI_REGISTER", "all") or "all"
    if choice not in ("all", "own"):
        raise ValueError(
            "the environment variable ATARI_REGISTER must be 'all' (replace ale-py's IDs) or 'own' (keep them), "
            f"got {choice!r}"
        )
    for env_id in ids():
        if choice == "all" or env_id not in gymnasium.registry:
            gymnasium.registry[env_id] = _spec(env_id)  # not gymnasium.register(), which warns when it replaces an ID


def _spec(env_id: str) -> EnvSpec:
    family, game = ids()[env_id]
    return EnvSpec(
        id=env_id,
        entry_point=_ENTRY_POINT,
        kwargs=family.options(game),
        vector_entry_point=family.vector_entry_point,
    )


def known_ids() -> tuple[str, ...]:
    """Every ID that `make` accepts: those of `ids`, of the algorithmic tasks, and of registered games."""
    others = (env_id for env_id, spec in gymnasium.registry.items() if str(spec.entry_point).startswith("atari."))
    return tuple(dict.fromkeys([*ids(), *others]))


def resolve(env_id: str) -> tuple[Family, str]:
    """The family and game of an ID.

    Raises:
        gymnasium.error.NameNotFound: there is no such ID, or it is of no family; the message suggests the right one.
    """
    known = env_id.removeprefix(_MODULE_PREFIX)
    if known in ids():
        return ids()[known]
    if known in known_ids():
        raise gymnasium.error.NameNotFound(
            f"only IDs of ALE's games are explained, {known!r} is none; gymnasium.spec({known!r}) shows what it is"
        )
    raise _not_found(env_id)


def make(game_or_id: str, *, preset: str | None = None, **options: Any) -> gymnasium.Env[Any, Any]:
    """Make an environment of a game or a registered ID, as `gymnasium.make` would.

    Args:
        game_or_id: a game ("breakout", which means "ALE/Breakout-v5") or an ID of this package ("Breakout-ram-v4").
        preset: name of a preprocessing, such as "dqn2015" (see `atari.wrappers.preset`); the options of the
            environment that it prescribes are set, unless given.
        **options: those of `AtariEnv`, and those of `gymnasium.make`, such as `max_episode_steps`. With a preset also
            `episodic_life` and `clip_reward`, of which `reward_clipping` is another name.

    Raises:
        gymnasium.error.NameNotFound: no such ID; the message suggests the right one.
        ValueError: no such game; the message suggests the nearest. Or a preset for an ID that is not an Atari game.
        TypeError: there is no such option, the message suggests the nearest; or it needs a preset.

    Example:
        >>> import atari
        >>> env = atari.make("breakout", preset="dqn2015")
        >>> observation, info = env.reset(seed=0)
        >>> observation.shape
        (4, 84, 84)
        >>> atari.make("Breakout-ram-v4").observation_space.shape
        (128,)
    """
    if not isinstance(game_or_id, str):
        raise TypeError(f"make() takes a game ('breakout') or an ID ('ALE/Breakout-v5'), got {game_or_id!r}")
    if "-v" not in game_or_id and "/" not in game_or_id:
        env_id = f"ALE/{stem(games.find(game_or_id).id)}-v5"
    else:
        env_id = game_or_id.removeprefix(_MODULE_PREFIX)
        if env_id not in known_ids():
            raise _not_found(game_or_id)
    ours = getattr(gymnasium.registry.get(env_id), "entry_point", None) == _ENTRY_POINT
    # With ATARI_REGISTER=own, the registered environment may be ale-py's.
    target = _spec(env_id) if env_id in ids() and not ours else env_id
    if ours or target != env_id:
        known = _make_options()
        check_known("atari.make", [name for name in options if name not in known], known)
    chosen = {name: options.pop(name) for name in _PRESET_OPTIONS if name in options}
    if preset is None and chosen:
        raise TypeError(
            f"{next(iter(chosen))!r} is an option of presets; "
            f"give one: atari.make({game_or_id!r}, preset='dqn2015', ...)"
        )
    if preset is None:
        return gymnasium.make(target, **options)
    if target == env_id and not ours:
        raise ValueError(f"a preset is for Atari games, and {env_id!r} is none; make it without preset={preset!r}")
    from atari import wrappers  # imported here because it imports OpenCV

    env = gymnasium.make(target, **{**wrappers.preset_options(preset), **options})
    return wrappers.preset(env, preset, **chosen)


@cache
def _make_options() -> tuple[str, ...]:
    """The names of all options of `make` for Atari games."""
    names = [name for maker in (AtariEnv, gymnasium.make) for name in inspect.signature(maker).parameters]
    return tuple(name for name in (*names, *_PRESET_OPTIONS) if name not in ("game", "id", "wrong", "kwargs"))


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
    registered = []
    for suffix, observation in (("", {}), ("-ram", {"obs_type": "ram"})):
        env_id = f"{stem(game.id)}{suffix}-v5"
        if env_id in gymnasium.registry:
            raise ValueError(f"the ID {env_id!r} is taken; rename the game file")
        options = {
            "game": str(Path(file).absolute()),
            "rom": str(Path(rom).absolute()),
            **observation,
            "max_num_frames_per_episode": MAX_FRAMES,
        }
        gymnasium.registry[env_id] = EnvSpec(id=env_id, entry_point=_ENTRY_POINT, kwargs=options)
        registered.append(env_id)
    return registered[0], registered[1]


def explain(env_id: str) -> str:
    """A text that explains the options of an ID, and how related IDs of the same game differ from it.

    Raises:
        gymnasium.error.NameNotFound: as of `resolve`.

    Example:
        >>> import atari
        >>> print(atari.explain("ALE/Pong-v5").splitlines()[0])
        ALE/Pong-v5: Pong
    """
    family, game_id = resolve(env_id)
    game = games[game_id]
    options = family.options(game_id)
    siblings = [other for other in FAMILIES if other != family and game_id in other.games()]
    width = max(len(other.id(game_id)) for other in (*siblings, family))
    lines = [
        f"{env_id}: {game.title}",
        f"  observation   {_obs_text(family, game_id)}",
        f"  frame skip    {_skip_text(options['frameskip'])}",
        f"  sticky        {_sticky_text(family.repeat_action_probability)}",
        f"  actions       {len(game.minimal_actions)}, those the game uses: "
        + " ".join(action.name for action in game.minimal_actions),
        f"  limit         truncated after {MAX_FRAMES} frames of the emulator, half an hour of play",
        f"  mode          {game.default_mode} of {', '.join(map(str, game.modes))}; "
        f"difficulty 0 of {', '.join(map(str, game.difficulties))}",
        "  siblings",
        *(f"    {other.id(game_id):{width}}  {_difference(family, other, game_id)}" for other in siblings),
    ]
    return "\n".join(lines)


def _obs_text(family: Family, game: str) -> str:
    rows = games[game].screen.height
    return "the 128 bytes of RAM, uint8" if family.obs_type == "ram" else f"RGB screen ({rows}, 160, 3), uint8"


def _skip_text(frameskip: int | tuple[int, int]) -> str:
    if isinstance(frameskip, tuple):
        low, high = frameskip
        return f"random, {low} to {high - 1} frames a step"
    return "none, 1 frame a step" if frameskip == 1 else f"{frameskip} frames a step"


def _sticky_text(probability: float) -> str:
    return f"the previous action repeats with probability {probability} each frame" if probability else "no"


def _difference(family: Family, other: Family, game: str) -> str:
    """The options in which `other` differs, as text."""
    words = []
    if other.obs_type != family.obs_type:
        words.append("RAM" if other.obs_type == "ram" else "RGB screen")
    skip = other.options(game)["frameskip"]
    if skip != family.options(game)["frameskip"]:
        words.append(f"frame skip: {_skip_text(skip)}")
    if other.repeat_action_probability != family.repeat_action_probability:
        words.append("sticky actions" if other.repeat_action_probability else "no sticky actions")
    return "; ".join(words) or "the same"


def _not_found(env_id: str) -> gymnasium.error.NameNotFound:
    return gymnasium.error.NameNotFound(f"there is no environment {env_id!r}; {_suggestion(env_id)}")


def _suggestion(env_id: str) -> str:
    """What to do about an unknown ID: its prefix, version, case or spelling may be wrong."""
    wanted, skeletons = skeleton(env_id), {known: skeleton(known) for known in known_ids()}
    if wanted not in skeletons.values():
        near = difflib.get_close_matches(wanted, set(skeletons.values()), n=1, cutoff=0.7)
        if not near:
            return "see `atari list --ids` for all of them"
        wanted = near[0]
    candidates = [known for known, bones in skeletons.items() if bones == wanted]
    version, namespace = env_id.rpartition("-v")[2], env_id.lower().startswith("ale/")
    closest = [c for c in candidates if c.endswith(f"-v{version}") or (namespace and c.startswith("ALE/"))]
    return f"did you mean {' or '.join(map(repr, closest or candidates))}?"


def skeleton(env_id: str) -> str:
    """An ID without module, namespace, version, case and punctuation, to find IDs that are spelt alike."""
    name = re.split("[/:]", env_id.lower())[-1]
    name = name.rpartition("-v")[0] if "-v" in name else name
    return "".join(letter for letter in name if letter.isalnum())
