"""Every environment ID in the history of these games, as a table of families.

Sources: the registrations of OpenAI Gym 0.1-0.26 (v0 and v4) and of ale-py 0.7-0.12 (v5). An ID is a stem
(`MsPacman`) with a family's prefix, suffix and version; the family has its options.
"""

import difflib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import gymnasium

from atari.games.catalog import playable_ids

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


MODULE_PREFIX = "atari:"
"""The prefix in "atari:ALE/Pong-v5", which makes Gymnasium import this package first."""


@dataclass(frozen=True)
class Family:
    """The IDs that differ only in the game: `<prefix><stem><suffix>-v<version>`."""

    prefix: str
    suffix: str
    version: int
    ram: bool
    frameskip: int | tuple[int, int]
    repeat_action_probability: float

    def id(self, game: str) -> str:
        """The ID of a game in this family."""
        return f"{self.prefix}{stem(game)}{self.suffix}-v{self.version}"

    def games(self) -> tuple[str, ...]:
        """The games of this family."""
        return playable_ids() if self.version == 5 else LEGACY_GAMES

    def options(self, game: str) -> dict[str, Any]:
        """The options of `AtariEnv` for the ID of this game."""
        frameskip = self.frameskip
        if game == "space_invaders" and self.suffix.endswith("Deterministic"):
            frameskip = 3  # with 4, the blinking shots would be invisible
        return {
            "game": game,
            **({"obs_type": "ram"} if self.ram else {}),  # ale-py's specs omit the default
            "repeat_action_probability": self.repeat_action_probability,
            "full_action_space": False,
            "frameskip": frameskip,
            "max_num_frames_per_episode": MAX_FRAMES,
        }


def _families() -> Iterator[Family]:
    for suffix, ram in (("", False), ("-ram", True)):
        for speed, frameskip in (("", (2, 5)), ("Deterministic", 4), ("NoFrameskip", 1)):
            for version, probability in ((0, 0.25), (4, 0.0)):
                yield Family("", suffix + speed, version, ram, frameskip, probability)
        yield Family("ALE/", suffix, 5, ram, 4, 0.25)


FAMILIES: tuple[Family, ...] = tuple(_families())


def stem(game: str) -> str:
    """The name of a game inside an ID: `ms_pacman` -> `MsPacman`, `tic_tac_toe_3d` -> `TicTacToe3D`."""
    return game.title().replace("_", "")


@cache
def ids() -> dict[str, tuple[Family, str]]:
    """Every ID, with its family and game."""
    return {family.id(game): (family, game) for family in FAMILIES for game in family.games()}


def is_ale_py_vector(env_id: str) -> bool:
    """Whether ale-py has a vector environment for an ID: it has one for ALE's v5 IDs of pixels."""
    family, _ = ids().get(env_id, (None, ""))
    return family is not None and family.version == 5 and not family.ram


def not_found(env_id: str, known: Iterable[str]) -> gymnasium.error.NameNotFound:
    """The error for an ID that is none of `known`; it suggests the right one."""
    return gymnasium.error.NameNotFound(f"there is no environment {env_id!r}; {_suggestion(env_id, known)}")


def _suggestion(env_id: str, known: Iterable[str]) -> str:
    wanted, skeletons = skeleton(env_id), {one: skeleton(one) for one in known}
    if wanted not in skeletons.values():
        near = difflib.get_close_matches(wanted, set(skeletons.values()), n=1, cutoff=0.7)
        if not near:
            return "see `atari info --ids` for all of them"
        wanted = near[0]
    candidates = [one for one, bones in skeletons.items() if bones == wanted]
    version, namespace = env_id.rpartition("-v")[2], env_id.lower().startswith("ale/")
    closest = [c for c in candidates if c.endswith(f"-v{version}") or (namespace and c.startswith("ALE/"))]
    return f"did you mean {' or '.join(map(repr, closest or candidates))}?"


def skeleton(env_id: str) -> str:
    """An ID without module, namespace, version, case and punctuation, to find IDs with similar spelling."""
    name = re.split("[/:]", env_id.lower())[-1]
    name = name.rpartition("-v")[0] if "-v" in name else name
    return "".join(letter for letter in name if letter.isalnum())
