"""`MultiplayerSession`: a game of two to four players, by hand or by policies, without its window."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from atari.actions import PLAYER_ACTIONS, Action
from atari.cores import ByteArray
from atari.cores.options import SEED_LIMIT
from atari.multiplayer import MultiplayerCore
from atari.play.base import BaseSession
from atari.recording import RecordMatch
from atari.task.resolution import GameLike
from atari.validation import check_name

Policy = Callable[[ByteArray, dict[str, Any]], Any]
"""A player that is a function: of the observation and the info of a frame, to an action's number (0 .. 17) or name."""

Observation = Literal["rgb", "grayscale", "ram", "screen"]
OBSERVATIONS: tuple[Observation, ...] = get_args(Observation)
_FRAMES_PER_RANDOM_ACTION = 4


class MultiplayerSession(BaseSession):
    """A game of two to four players, played frame by frame whatever the frame skip of a task. All 18 actions are legal.

    Args:
        game: as of `MultiplayerCore`, a name ("combat"), an ID, a game file, a `Game` or a `Task`.
        players: 2, 3 or 4; None is that of `mode`, else the fewest that the game has.
        mode: in Multi-Agent-ALE's numbering; None is PettingZoo's for `players`, else the first.
        difficulty: None is 0.
        seed: of the game; None is a random one.
        policies: by player (0 is the first), the players that are policies; human players are the others. In each frame
            a policy is called with the observation and an info, and returns an action's number (0 .. 17) or name
            ("UPFIRE"). The info has `player` (0 is the first), `players`, `mode`, `frame` (since the game began),
            `scores`, `rewards` (of the last frame) and `lives`; the last three are lists, a number of each player.
        obs_type: of the policies' observations, all uint8: "rgb" (height, 160, 3), "grayscale" (height, 160), "screen"
            (height, 160) palette indices, or "ram" (128,). A policy with an attribute `obs_type` gets these instead.
            All players see the same game.
        state: the file of the saved state.
        replay: the replay file, with the suffix ".a26"; None writes no replay.
        videos: the folder of the videos.
        scale: a pixel becomes `2 * scale` x `scale` pixels of a video.

    Raises:
        TypeError, ValueError: see `MultiplayerCore`; or a policy is of a player that the game does not have.

    Example:
        >>> from atari.play import MultiplayerSession
        >>> session = MultiplayerSession("combat")
        >>> session.over, len(session.legal_actions)
        (False, 18)
    """

    _saved_as: ClassVar[str] = "play of several players"
    _blob: ClassVar[str] = "core"

    def __init__(
        self,
        game: GameLike,
        *,
        rom: Path | None = None,
        players: int | None = None,
        mode: int | None = None,
        difficulty: int | None = None,
        seed: int | None = None,
        policies: Mapping[int, Policy] | None = None,
        obs_type: Observation = "rgb",
        state: Path = Path("game.state"),
        replay: Path | None = None,
        videos: Path = Path("videos"),
        scale: int = 2,
    ) -> None:
        check_name("obs_type", obs_type, OBSERVATIONS)
        if seed is None:
            seed = int(np.random.default_rng().integers(SEED_LIMIT))
        self.core = MultiplayerCore(
            game, rom=rom, players=players, mode=mode, difficulty=difficulty, seed=seed, sound=True, frameskip=1
        )
        self.policies = dict(policies or {})
        self._obs_types: dict[int, Observation] = {}
        for player, policy in self.policies.items():
            kind: Observation = getattr(policy, "obs_type", obs_type)
            check_name("obs_type", kind, OBSERVATIONS)
            self._obs_types[player] = kind
            if player not in range(self.core.players):
                raise ValueError(f"there is no player {player + 1} in a game of {self.core.players} players")
        self._recorded: Any = self.core if replay is None else RecordMatch(self.core, replay)
        super().__init__(self.core.game, self.core.players, state, videos, scale)
        self.humans = tuple(player for player in range(self.core.players) if player not in self.policies)
        """The players that are no policies; 0 is the first."""
        self._reset()

    @property
    def legal_actions(self) -> tuple[Action, ...]:
        """All 18."""
        return PLAYER_ACTIONS

    @property
    def over(self) -> bool:
        """Whether the game has ended."""
        return self.core.game_over or self.core.truncated

    @property
    def screen(self) -> ByteArray:
        """The current screen, (height, 160, 3) uint8."""
        return self.core.screen_rgb()

    @property
    def samples(self) -> ByteArray:
        """The sound of the last frame, (512,) uint8 around 128."""
        return self.core.audio()

    @property
    def title(self) -> str:
        """The game and the score of each player, for the window's title."""
        return "   ".join(
            [self.game.title, *(f"player {player}: {score:,}" for player, score in enumerate(self.scores, 1))]
        )

    def close(self) -> None:
        """Complete the replay and the video.

        Raises:
            OSError: a file cannot be written.
        """
        try:
            super().close()
        finally:
            self._recorded.close()

    def _step(self, actions: tuple[Action, ...]) -> list[int]:
        chosen = dict(zip(self.humans, map(int, actions), strict=True))
        seen = {kind: self._observe(kind) for kind in set(self._obs_types.values())}
        chosen |= {player: self._decide(player, seen[kind]) for player, kind in self._obs_types.items()}
        rewards: list[int] = self._recorded.act_players([chosen[player] for player in range(self.core.players)])
        self._rewards = rewards
        return rewards

    def _observe(self, kind: Observation) -> ByteArray:
        core = self.core
        read = {"rgb": core.screen_rgb, "grayscale": core.screen_grayscale, "ram": core.ram, "screen": core.screen}
        return read[kind]()

    def _decide(self, player: int, observation: ByteArray) -> int:
        """The action of a policy.

        Raises:
            RuntimeError: the policy fails, or returns no action. Not ValueError, after which a window plays on.
        """
        info = {
            "player": player,
            "players": self.core.players,
            "mode": self.core.mode,
            "frame": self.core.episode_frame_number - self._first_frame,
            "scores": list(self.scores),
            "rewards": list(self._rewards),
            "lives": self.core.player_lives,
        }
        try:
            action = self.policies[player](observation.copy(), info)
        except Exception as error:
            raise RuntimeError(f"the policy of player {player + 1} failed: {type(error).__name__}: {error}") from error
        number = _NUMBERS.get(action) if isinstance(action, (str, int, np.integer)) else None
        if number is None or isinstance(action, bool):
            raise RuntimeError(
                f"the policy of player {player + 1} returned {action!r}; an action is a number 0 .. 17, or a name "
                "such as 'UPFIRE'"
            )
        return number

    def _snapshot(self) -> bytes:
        data: bytes = self._recorded.snapshot()
        return data

    def _restore(self, data: bytes) -> None:
        self._recorded.restore(data)
        self._rewards = [0] * self.core.players

    def _reset(self) -> None:
        self._recorded.reset()
        self._first_frame = self.core.episode_frame_number  # after the starting actions
        self._rewards = [0] * self.core.players


_NUMBERS: Mapping[Any, int] = {key: int(action) for action in PLAYER_ACTIONS for key in (int(action), action.name)}


def random_policy(actions: tuple[Action, ...], seed: int) -> Policy:
    """A policy that draws one of `actions` every four frames."""
    random = np.random.default_rng(seed)
    action = Action.NOOP

    def policy(observation: ByteArray, info: dict[str, Any]) -> int:
        nonlocal action
        if info["frame"] % _FRAMES_PER_RANDOM_ACTION == 0:
            action = actions[random.integers(len(actions))]
        return int(action)

    return policy


def no_op_policy(observation: ByteArray, info: dict[str, Any]) -> int:
    """A policy that never acts."""
    return int(Action.NOOP)
