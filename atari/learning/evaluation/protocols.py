"""`EvaluationProtocol`: how games of an evaluation begin, are played and end; and the sets of games of benchmarks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from os import PathLike
from types import MappingProxyType
from typing import Any, Literal

from atari.games.catalog import games as catalog
from atari.games.game import Game
from atari.learning.evaluation.tables import check_known_name, read_table
from atari.validation import check_integer, check_name, check_probability
from atari.wrappers import PRESETS
from atari.wrappers.presets import OTHER_NAMES

MAX_EPISODES = 1_000_000


@dataclass(frozen=True)
class EvaluationProtocol:
    """All numbers on which a score depends besides the policy. Scores of two protocols are not compared.

    Attributes:
        name: of the protocol.
        source: the publication or program that it is from, and what is added to it.
        repeat_action_probability: of sticky actions, drawn each frame.
        full_action_space: whether all 18 actions are given, not only those that the game uses.
        noop_min, noop_max: a game begins with so many NOOPs, drawn from noop_min..noop_max; 0, 0 is none.
        max_frames: a game is truncated after so many frames, NOOPs included. It ends games that would not end by
            themselves, as Breakout does if a policy never presses FIRE.
        epsilon: probability of a random action in place of the policy's, drawn each step.
        episodes: whole games of each game, unless the caller of `evaluate` gives another number.
        preset: of `atari.wrappers.PRESETS`, the images that a policy gets if it does not say which it needs, and how
            games and lives begin if `lives` says so.
        lives: "continue": a lost life is not an event, the game goes on. "fire": as the wrappers of OpenAI's Baselines,
            with FIRE and the action of index 2 at the start and after each lost life. "preset": as the preset begins
            games and the episodes that follow a lost life.
        frame_skip: frames for each action.

    Example:
        >>> from dataclasses import replace
        >>> from atari.learning import PROTOCOLS
        >>> protocol = replace(PROTOCOLS["dopamine"], name="mine", epsilon=0.0)
        >>> protocol.name, protocol.epsilon
        ('mine', 0.0)
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
    lives: Literal["continue", "fire", "preset"] = "continue"
    frame_skip: int = 4

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
        check_integer("frame_skip", self.frame_skip, 1, 10_000)
        check_name("lives", self.lives, ("continue", "fire", "preset"))
        check_name("preset", self.preset, PRESETS)
        known = globals().get("PROTOCOLS", {}).get(self.name)  # which has not been made when its own are
        if known is not None and differences(self, known):
            raise ValueError(f"a protocol with other numbers than {self.name!r} needs another name: give name=...")

    def __str__(self) -> str:
        actions = "all 18 actions" if self.full_action_space else "the game's minimal actions"
        noops = f"{self.noop_min}-{self.noop_max} no-ops" if self.noop_max else "no no-ops"
        lives = {
            "continue": "",
            "fire": "; FIRE at the start and after lost lives",
            "preset": f"; games and lives begin as in preset {self.preset}",
        }[self.lives]
        return (
            f"{self.name}: sticky actions {self.repeat_action_probability:g}, {actions}, {noops}, "
            f"{self.frame_skip} frames an action, epsilon {self.epsilon:g}, at most {self.max_frames:,} frames a game"
            f"{lives}; unclipped scores of whole games"
        )


NUMBERS = tuple(
    field.name for field in fields(EvaluationProtocol) if field.name not in ("name", "source", "episodes", "preset")
)
"""The fields that must be equal to compare scores."""


def differences(one: EvaluationProtocol, other: EvaluationProtocol) -> list[str]:
    """In which of `NUMBERS` two protocols differ, in words."""
    names = (*NUMBERS, "preset") if one.lives == "preset" == other.lives else NUMBERS
    pairs = ((name, getattr(one, name), getattr(other, name)) for name in names)
    return [f"{name} {first} and {second}" for name, first, second in pairs if first != second]


_HALF_AN_HOUR = 108_000

PROTOCOLS: Mapping[str, EvaluationProtocol] = MappingProxyType(
    {
        protocol.name: protocol
        for protocol in (
            EvaluationProtocol(
                name="dqn2015",
                source="Mnih et al. 2015: 30 games of at most five minutes, no-op starts, epsilon 0.05",
                repeat_action_probability=0.0,
                full_action_space=False,
                noop_min=1,
                noop_max=30,
                max_frames=18_000,
                epsilon=0.05,
                episodes=30,
                preset="dqn2015",
            ),
            EvaluationProtocol(
                name="machado2018",
                source="Machado et al. 2018, with the 4 frames an action and 108,000 frames that later users of it "
                "take. The paper reports the last 100 games of the training; this plays 100 games after it",
                repeat_action_probability=0.25,
                full_action_space=True,
                noop_min=0,
                noop_max=0,
                max_frames=_HALF_AN_HOUR,
                epsilon=0.0,
                episodes=100,
                preset="machado2018",
            ),
            EvaluationProtocol(
                name="atari100k",
                source="the Atari 100k benchmark as in Dopamine's data-efficient Rainbow: 100 games, epsilon 0.001",
                repeat_action_probability=0.0,
                full_action_space=False,
                noop_min=0,
                noop_max=0,
                max_frames=_HALF_AN_HOUR,
                epsilon=0.001,
                episodes=100,
                preset="atari100k",
            ),
            EvaluationProtocol(
                name="dopamine",
                source="Dopamine's evaluation, epsilon 0.001, with 100 games in place of 125,000 steps, which favour "
                "short games",
                repeat_action_probability=0.25,
                full_action_space=False,
                noop_min=0,
                noop_max=0,
                max_frames=_HALF_AN_HOUR,
                epsilon=0.001,
                episodes=100,
                preset="dopamine",
            ),
            EvaluationProtocol(
                name="baselines",
                source="the wrappers of OpenAI's Baselines, Stable-Baselines3 and CleanRL, with scores as their "
                "Monitor records them around the game",
                repeat_action_probability=0.0,
                full_action_space=False,
                noop_min=1,
                noop_max=30,
                max_frames=_HALF_AN_HOUR,
                epsilon=0.0,
                episodes=100,
                preset="baselines",
                lives="fire",
            ),
        )
    }
)
"""Every protocol by name."""

GAME_SETS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {name: tuple(games) for name, games in read_table("sets").items()}
)
"""Sets of games by name: "atari57" (and "atari55", "atari60", "atari49" of 2015), "atari26" (Atari 100k), "atari5"."""


def find_protocol(protocol: Any) -> EvaluationProtocol:
    """The protocol of an argument: a name of `PROTOCOLS`, or an `EvaluationProtocol`.

    Raises:
        TypeError: it is neither.
        ValueError: there is no such protocol; the nearest is suggested, if one is near.
    """
    if isinstance(protocol, EvaluationProtocol):
        return protocol
    return PROTOCOLS[check_known_name("protocol", protocol, PROTOCOLS, others=OTHER_NAMES)]


def find_games(games: "str | PathLike[str] | Game | Sequence[str | PathLike[str] | Game]") -> tuple[Game, ...]:
    """The games of an argument: one game, a name of `GAME_SETS`, or a sequence of these; each once, in their order.

    Raises:
        TypeError, ValueError: there is no such game (the nearest is suggested), or none at all.
        FileNotFoundError: there is no such file of a game of your own.
    """
    if isinstance(games, (str, PathLike, Game)):
        games = [games]
    if not isinstance(games, Sequence) or not games:
        raise TypeError(f"games must be a game, a set such as 'atari26', or a sequence of these, got {games!r}")
    found: dict[str, Game] = {}
    for entry in games:
        for one in GAME_SETS.get(entry, (entry,)) if isinstance(entry, str) else (entry,):
            game = catalog.find(one)
            found[game.id] = game
    return tuple(found.values())
