"""`MultiplayerSession`: a game of two to four players, by hand or by policies, without its window."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, get_args

import numpy as np

from atari.base.validation import check_name
from atari.cores import ByteArray, Core
from atari.cores.options import SEED_LIMIT
from atari.env.env import ObsType
from atari.games.actions import PLAYER_ACTIONS, Action
from atari.games.game import Game
from atari.learning.frame_agent import FrameAgent
from atari.multiplayer import MultiplayerCore
from atari.play.base import BaseSession
from atari.policy.needs import Needs
from atari.recording.replay.players import RecordMatch
from atari.task import Task
from atari.task.task import GameLike


class PlayerAgent(FrameAgent):
    """A policy that plays as one of several players, with the observations that it needs.

    It presses no button at the start of a game or after a lost life, because the players share the game. A policy
    without a task gets `Task.of(game, players=...)`: four frames an action, the game's minimal actions. In a game
    that shows player 2 as a mirror image of player 1, a one-player policy sees mirrored images as player 2.

    Args:
        policy: a policy, see `load_policy`.
        player: the player, 0 is the first. It is the policy's lane.
        core: the core of the game.
        obs_type: the observations of a policy without a task.

    Raises:
        TypeError, ValueError, FileNotFoundError, gymnasium.error.DependencyNotInstalled: see `FrameAgent`, `task_in`.
    """

    def __init__(self, policy: Any, player: int, core: MultiplayerCore, obs_type: ObsType) -> None:
        super().__init__(policy)
        self._lanes = np.array([player], np.int64)
        self._players, self._obs_type = core.players, obs_type
        plays_first = self.task_in(core.game).players == 1
        self._mirrored = plays_first and player == 1 and core.mode in core.rules.mirrored_modes

    def _task_of(self, needs: Needs, game: Game) -> Task:
        if needs.task is not None and needs.task.definition != game:
            raise ValueError(f"{self.name} is a policy for {needs.task.game}, not for {game.id}")
        task = super()._task_of(needs, game)
        if task.agent_indicator:
            raise ValueError(f"{self.name} has agent_indicator=True, which sessions do not draw; leave it out")
        return task.replace(fire="never", noops=(0, 0), episodic_life=False, life_loss_info=False)

    def _unsaid(self, game: Game) -> Task:
        return Task.of(game, players=self._players, obs_type=self._obs_type)

    def _screen(self, core: Core) -> ByteArray:
        screen = core.screen()
        return np.ascontiguousarray(screen[:, ::-1]) if self._mirrored else screen


class MultiplayerSession(BaseSession):
    """A game of two to four players, played frame by frame despite a task's frame skip. All 18 actions are legal.

    Args:
        game: a name ("combat"), an ID, a game file, a `Game` or a `Task`, see `MultiplayerCore`.
        players: 2, 3 or 4; None means the number of `mode`, or the game's fewest.
        mode: the mode in Multi-Agent-ALE's numbering; None means PettingZoo's for `players`, or the first.
        difficulty: the difficulty; None means 0.
        seed: the game's seed; None means a random one.
        policies: the policies by player (0 is the first), see `atari.learning.load_policy`; people play the others.
            The policy's lane is the player. Its task or environment defines its observations and the length of its
            steps; see `PlayerAgent`.
        obs_type: the observations of a policy without a task, uint8: "rgb" (height, 160, 3), "grayscale" (height, 160)
            or "ram" (128,).
        state: the file of the saved state.
        replay: the replay file, with the suffix ".a26r"; None writes no replay.
        videos: the folder of the videos.
        scale: a pixel becomes `2 * scale` x `scale` pixels of a video.

    Raises:
        TypeError, ValueError: see `MultiplayerCore`; or the game does not have the player of a policy.

    Example:
        >>> from atari.play import Session
        >>> session = Session("combat", players=2)
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
        policies: Mapping[int, Any] | None = None,
        obs_type: ObsType = "rgb",
        state: Path = Path("game.state"),
        replay: Path | None = None,
        videos: Path = Path("videos"),
        scale: int = 2,
    ) -> None:
        check_name("obs_type", obs_type, get_args(ObsType))
        if seed is None:
            seed = int(np.random.default_rng().integers(SEED_LIMIT))
        self.core = MultiplayerCore(
            game, rom=rom, players=players, mode=mode, difficulty=difficulty, seed=seed, sound=True, frameskip=1
        )
        self._agents: dict[int, PlayerAgent] = {}
        for player, policy in (policies or {}).items():
            if player not in range(self.core.players):
                raise ValueError(f"policies has players 0 to {self.core.players - 1} of this game, got {player!r}")
            self._agents[player] = PlayerAgent(policy, player, self.core, obs_type)
        self._seed, self._games = seed, -1
        played = self.core if replay is None else RecordMatch(self.core, replay)
        minimal, players, files = self.core.rules.minimal_actions, self.core.players, {"state": state, "videos": videos}
        super().__init__(self.core.game, played, PLAYER_ACTIONS, minimal, players=players, scale=scale, **files)
        self.humans = tuple(player for player in range(self.core.players) if player not in self._agents)
        """The human players; 0 is the first."""
        self._reset()

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

    def _step(self, actions: tuple[Action, ...]) -> list[int]:
        chosen = dict(zip(self.humans, map(int, actions), strict=True))
        chosen |= {player: self._decide(player, agent) for player, agent in self._agents.items()}
        self._agents_are_new = False
        return self._played.act_players([chosen[player] for player in range(self.core.players)])

    def _decide(self, player: int, agent: PlayerAgent) -> int:
        core: Any = self.core
        try:
            if self._agents_are_new:
                agent.begin(core, (self._seed + player + self._games * core.players) % SEED_LIMIT)
            return agent.act(core)
        except Exception as error:  # a window would show a ValueError and continue
            raise RuntimeError(f"the policy of player {player + 1} failed: {type(error).__name__}: {error}") from error

    def _snapshot(self) -> bytes:
        return self._played.snapshot()

    def _restore(self, data: bytes) -> None:
        self._played.restore(data)
        self._agents_are_new = True

    def _reset(self) -> None:
        self._played.reset()
        self._agents_are_new = True
        self._games += 1
