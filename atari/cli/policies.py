"""Policies that play games to a replay, for `record`, `collect`, `watch` and `evaluate`."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from atari.cores.options import SEED_LIMIT
from atari.learning import load_policy
from atari.learning.evaluation.evaluate import EvaluatedPolicy
from atari.learning.evaluation.played import EvaluatedGame, has_no_needs, played_task, resolve_games, usual_protocol
from atari.learning.evaluation.protocols import find_protocol
from atari.learning.options import NOT_FOR_AGENTS
from atari.policy import LoadedPolicy
from atari.recording import RecordReplay, Replay
from atari.task import Task
from atari.task.arguments import given_options, read_game, task_of
from atari.task.fields import OF_GAME
from atari.task.resolution import is_id
from atari.task.task import look_up

NOT_RECORDED = (*NOT_FOR_AGENTS, "life_loss_info", "reward", "reward_clipping")
"""Fields that recorded games of policies do not honour: their scores are the game's own."""

UNCLIPPED = {"reward_clipping": False}
"""The field that presets have and that does not matter for recorded games: what is recorded is never clipped."""


class PolicySession:
    """A policy in an environment, step by step, for one player; `MultiplayerSession` serves several players.

    Args:
        env: the environment.
        task: the task of the environment.
        policy: the policy, which gets batches of one observation.
        seed: the seed of the first game and of the policy in it. Each further game has the next seed.
    """

    def __init__(self, env: RecordReplay, task: Task, policy: LoadedPolicy, seed: int) -> None:
        self.game = task.definition
        self.over = True
        self._env, self._task, self._policy, self._seed = env, task, policy, seed
        self._lane = np.zeros(1, np.int64)
        self._seen: Any = None
        self._ended = True

    @property
    def frames(self) -> int:
        """Frames played."""
        return self._env.recorder.frames

    def new_game(self) -> None:
        """Begin the next game."""
        seed = self._seed % SEED_LIMIT
        self._seed += 1
        names = [action.name for action in self._task.action_set]
        self._policy.begin(self._task.game, names, self._lane, np.array([seed]))
        self._seen, _ = self._env.reset(seed=seed)
        self._ended = False

    def play(self) -> None:
        """Play a step; if an episode has ended and its game continues, reset first."""
        if self._ended:
            self._seen, _ = self._env.reset()
            if self._task.new_stack_after_life:
                self._policy.begin_episodes(self._lane)
        seen = self._seen
        batch = {key: value[None] for key, value in seen.items()} if isinstance(seen, dict) else seen[None]
        (action,) = self._policy(batch, self._lane)
        self._seen, _, terminated, truncated, _ = self._env.step(int(action))
        self._ended = terminated and not self._task.life_loss_info
        inner: Any = self._env.unwrapped
        self.over = inner.core.game_over or truncated or (self._ended and self._task.new_game_after_life)

    def close(self) -> None:
        """Close the environment, and with it the replay."""
        self._env.close()


def find_played(args: argparse.Namespace, names: Sequence[str], policy: Any = None) -> tuple[EvaluatedGame, ...]:
    """The games of a command line with `add_task`, or without names the game of the policy's training.

    Args:
        args: the parsed arguments.
        names: games, IDs, sets of games, or files.
        policy: its `task` or `environment`, if present, decides how games are played.

    Raises:
        gymnasium.error.NameNotFound, ValueError, FileNotFoundError: there is no such game, or none is named; or a
            flag contradicts the policy.
    """
    given, trained = given_options(args), getattr(policy, "task", None)
    of_game = {name: value for name, value in given.items() if name in OF_GAME}
    alone = getattr(policy, "game", None) if trained is None else EvaluatedGame.of_policy(trained, of_game)
    games: list[Any] = [read_game(name) for name in names] or [alone]
    if games == [None]:
        raise ValueError(f"{args.source} does not say which game it plays; name it, such as pong")
    others = [name for name in given if name not in OF_GAME] + ["preset"] * (getattr(args, "preset", None) is not None)
    try:
        if not others:
            return resolve_games(games, given)
        if not has_no_needs(policy):
            raise ValueError(f"the policy says how games are played; leave --{others[0].replace('_', '-')} out")
        if args.preset is None and not any(is_id(name) or name.endswith(".json") for name in names):
            args.preset = "baselines"  # as without fields, see `usual_protocol`
        found = resolve_games([task_of(args, name) for name in names])
        args.without = {}  # of `UNCLIPPED`; the task shows it
        return found
    except TypeError as error:
        raise ValueError(str(error)) from None


def games_of(policy: Any, game: EvaluatedGame, protocol: str | None = None) -> tuple[Task, EvaluatedPolicy]:
    """The task that a policy plays in a game, and the policy in its environments, which `record` games.

    A note on stderr, or the error, says if the policy was trained on other games.

    Args:
        policy, game: see `record_games`.
        protocol: name of a protocol; None means the policy's usual one.

    Raises:
        TypeError, ValueError: see `record_games`.
    """
    found = find_protocol(protocol) if protocol else usual_protocol(policy, game)
    trained = getattr(policy, "games", None) or (game.id,)
    other = game.id not in trained
    said = f"{policy.name} was trained on {', '.join(trained)}"
    try:
        task = played_task(game, found, policy)
        player = EvaluatedPolicy(policy, task, found.epsilon)  # raises its errors before a game is played
    except ValueError as error:
        raise ValueError(f"{said}, and {game.id} is another game: {error}" if other else str(error)) from error
    if other:
        print(f"note: {said}, and plays {game.id}", file=sys.stderr)
    return task, player


@dataclass(frozen=True)
class PolicyGame:
    """A policy that plays a game where a command takes replays, too.

    Attributes:
        source: the policy, as the user named it.
        task: the task that it plays.
        player: the policy in the environments of the task.
    """

    source: str
    task: Task
    player: EvaluatedPolicy

    @classmethod
    def load(cls, source: str, game: str | None = None) -> "PolicyGame":
        """Load a policy, which plays the game of its training, or `game` if it does not say one.

        Raises:
            FileNotFoundError, ValueError: there is no such policy, or neither says which game it plays.
        """
        policy = load_policy(source)
        if getattr(policy, "task", None) is None and getattr(policy, "game", None) is None:
            if game is None:
                raise ValueError(
                    f"{source} does not say which game it plays; let it play one to a replay, and name that: "
                    f"atari record GAME --policy {source} -o game.a26r"
                )
            names = [game]
        else:
            names = []
        (found,) = find_played(argparse.Namespace(source=source), names, policy)
        return cls(source, *games_of(policy, found))

    def play(self, path: Path, seed: int = 0) -> Replay:
        """Play a game to a replay."""
        self.player.record([seed], path)
        replay = Replay.load(path, game=self.task.definition)
        replay.name = self.source
        return replay


def replay_of(args: argparse.Namespace, path: str) -> Replay:
    """The replay of a command line's game.

    Raises:
        ValueError: it belongs to another game, or the command line sets other fields, which the replay decides.
    """
    found = look_up(read_game(args.game))
    game = found.definition
    replay = Replay.load(path, game=game if game.file else None, rom=getattr(args, "rom", None))
    if replay.game != game:
        raise ValueError(f"{path} is a replay of {replay.game.id}, not of {game.id}")
    if not found.bare:
        raise ValueError(f"what was played is in the replay {path}; name the game alone, {game.id!r}")
    options = [*given_options(args), *(["preset"] if args.preset is not None else [])]
    if options:
        raise ValueError(f"what was played is in the replay {path}; leave {', '.join(options)} out")
    return replay
