"""`Session`: a one-player game, played by hand, without its window: the environment and the replay."""

from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

from atari.cores import ByteArray
from atari.cores.writes import definitions, make_writes, slots, switched_on
from atari.games.actions import Action
from atari.games.interventions import load
from atari.play.base import BaseSession
from atari.play.multiplayer_session import MultiplayerSession
from atari.recording import RecordReplay
from atari.recording.video.facts import facts_of
from atari.registry.making import make_env
from atari.task import Task
from atari.task.arguments import SCREEN
from atari.task.task import BY_FRAME, GameLike, look_up


class Session(BaseSession):
    """A game that a person plays under a task, and that is shown frame by frame.

    The action of the first frame of a step is held for the whole step. Frames at the start of an episode, such as
    no-ops, are also shown. After a lost life that ends an episode, the game continues if the task says so.

    With `players`, with `policies`, or with a task for several players, `Session` makes a `MultiplayerSession`, for
    people and policies. It has the arguments `rom`, `players`, `mode`, `difficulty`, `seed`, `policies`, `obs_type`,
    `state`, `replay`, `videos` and `scale`.

    Args:
        game: an ID, a game or a task, see `atari.Task.of`; a name or a file is played frame by frame, with all legal
            actions, without sticky actions and without a limit.
        rom: path of the ROM file; None searches (see `atari.roms`).
        replay: the replay file, with the suffix ".a26r"; None writes no replay.
        state: the file of the saved state.
        videos: the folder of the videos.
        seed: the game's seed; None means a random one.
        scale: a pixel becomes `2 * scale` x `scale` pixels of a video.
        **options: `preset`, and fields of `atari.Task`, except observations.

    Raises:
        TypeError, ValueError, OSError: see `atari.Task.of`, `AtariEnv` and `RecordReplay`.

    Example:
        >>> import atari
        >>> from atari.play import Session
        >>> session = Session("pong")
        >>> session.score, session.over, session.screen.shape
        (0, False, (210, 160, 3))
        >>> session.close()
        >>> match = Session("combat", players=2, policies={1: "random"})
        >>> match.scores, match.humans
        ([0, 0], (0,))
        >>> match.close()
    """

    def __new__(cls, game: Any = None, **options: Any) -> Any:
        """A `MultiplayerSession` for several players."""
        players = options.get("players", game.players if isinstance(game, Task) else 1)
        several = players != 1 or options.get("policies") is not None
        return MultiplayerSession(game, **options) if several else super().__new__(cls)

    _saved_as: ClassVar[str] = "play"  # `AtariEnv.restore` also reads these files
    _blob: ClassVar[str] = "env"

    def __init__(
        self,
        game: GameLike,
        *,
        rom: Path | None = None,
        replay: Path | None = None,
        state: Path = Path("game.state"),
        videos: Path = Path("videos"),
        seed: int | None = None,
        scale: int = 2,
        **options: Any,
    ) -> None:
        self.task = _task(game, options)
        inner: Any = make_env(self.task, rom=rom)
        inner.unwrapped.driver.make_sound()
        self._inner, self._atari = inner, inner.unwrapped
        own = {one.name for one in self.task.interventions}
        known = {} if self.task.definition.file else load(self.task.definition)
        self._changes = {name: one for name, one in known.items() if name not in own}
        played = inner if replay is None else RecordReplay(inner, replay)
        found, files = self._atari.game, {"state": state, "videos": videos}
        super().__init__(found, played, self.task.action_set, found.minimal_actions, players=1, scale=scale, **files)
        self._unseen: deque[tuple[ByteArray, ByteArray, int]] = deque()  # frames not yet shown
        self._ended = self._truncated = False  # the episode; the game may continue
        self._atari.driver.observers.append(self)
        self._final_scores: list[int] = []  # of the games before this one
        self._begun_at = 0  # the frame at which this game began
        self._played.reset(seed=seed)

    @property
    def score(self) -> int:
        """The score of the current game."""
        return self.scores[0]

    @property
    def best(self) -> int:
        """The best score of the games that were played, as they ended or stand; 0 before the first frame."""
        return max([*self._final_scores, *self._current_score()], default=0)

    def _current_score(self) -> list[int]:
        """The score of the current game, if a frame of it was played."""
        return [self.score] if self.frames > self._begun_at else []

    @property
    def over(self) -> bool:
        """Whether the game has ended, and its last frame has been shown."""
        core = self._atari.core
        ended = self._ended and (self._truncated or self.task.new_game_after_life)
        return not self._unseen and (core.game_over or core.truncated or ended)

    @property
    def screen(self) -> ByteArray:
        """The screen that is shown, (height, 160, 3) uint8."""
        return self._screen

    @property
    def samples(self) -> ByteArray:
        """The sound of the frame that is shown, (512,) uint8 around 128."""
        return self._samples

    @property
    def interventions(self) -> Mapping[str, bool]:
        """The package's interventions for the game that the task does not have, by name, and whether each is on."""
        on = switched_on(self._changes, definitions(slots(self._atari.core)))
        return {name: name in on for name in self._changes}

    def _writes(self, name: str) -> Sequence[Any]:
        """The writes of one of `interventions`. A session can be copied, and writes cannot."""
        return make_writes(self.task.definition, [self._changes[name]])

    def toggle_intervention(self, name: str) -> None:
        """Switch one of `interventions` on or off, from the next frame on; the replay has it.

        Raises:
            ValueError: there is no such intervention, or the core has no room for its writes.
        """
        super().toggle_intervention(name)
        core: Any = self._atari.core
        writes = self._writes(name)
        if self.interventions[name]:
            self._remove_writes(writes)
            return
        for number, write in enumerate(writes):
            try:
                core.add_write(write, True)
            except (RuntimeError, ValueError):
                self._remove_writes(writes[:number])
                raise

    def _remove_writes(self, writes: Sequence[Any]) -> None:
        core: Any = self._atari.core
        for write in writes:  # after going back the core has others of the same definition
            core.remove_write(next(one for one in slots(core) if one and one.definition == write.definition))

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Show the frames of the copied environment, which has no observers."""
        self.__dict__.update(state)
        self._atari.driver.observers.append(self)

    def game_begun(self) -> None:
        """Show the first screen of a game; the environment calls it."""
        self._unseen.clear()
        self._show()

    def frame_played(self, action: int, reward: int) -> None:
        """Keep a frame until it is shown; the environment calls it."""
        core = self._atari.core
        self._unseen.append((core.screen_rgb(), core.audio(), reward))

    @property
    def _facts(self) -> dict[str, Any]:
        on = [name for name, is_on in self.interventions.items() if is_on]
        return {**facts_of(self.task), **({"switched_on": on} if on else {})}

    @property
    def _between_steps(self) -> bool:
        return not self._unseen and not self._ended

    def _step(self, actions: tuple[Action, ...]) -> list[int]:
        (action,) = actions
        if self._ended and not self._unseen:
            self._go_on()
        if not self._unseen:
            _, _, terminated, self._truncated, _ = self._played.step(self.legal_actions.index(action))
            self._ended = self._truncated or (terminated and not self.task.life_loss_info)
        self._screen, self._samples, reward = self._unseen.popleft()
        return [reward]

    def _show(self) -> None:
        self._screen, self._samples = self._atari.core.screen_rgb(), self._atari.core.audio()

    def _snapshot(self) -> bytes:
        """The state after the present step, without its remaining frames."""
        while self._unseen:
            self._screen, self._samples, reward = self._unseen.popleft()
            self.scores = [self.score + reward]
        if self._ended and not self.over:
            self._go_on()
        return self._inner.snapshot()

    def _restore(self, data: bytes) -> None:
        self._inner.restore(data)
        self._unseen.clear()
        self._ended = self._truncated = False
        self._show()

    def _reset(self) -> None:
        self._go_on({"new_game": True})
        self._final_scores += self._current_score()
        self._begun_at = self.frames

    def _go_on(self, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; after a lost life, in the same game, unless `options` begin a new one."""
        self._ended = self._truncated = False
        self._played.reset(options=options)


def _task(game: GameLike, options: dict[str, Any]) -> Task:
    """The task of the session, without the fields of an agent's observations."""
    preset = options.pop("preset", None)
    if unseen := [name for name in SCREEN if name in options]:
        raise TypeError(f"Session has no option {unseen[0]!r}: it shows the screen and the score of the game")
    task = look_up(game).task(preset, options, BY_FRAME, owner="Session")
    if task.continuous:
        raise ValueError("one person plays with a stick, got continuous=True; leave it out")
    if task.players > 1:
        raise ValueError(f"{game!r} is a game of {task.players} players; give players={task.players}")
    return task.replace(**SCREEN)
