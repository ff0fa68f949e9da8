"""Replays of several players: `RecordMatch` records a `MultiplayerCore`, and `PlayersRunner` plays a replay on one."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

from atari.base.version import VERSION
from atari.games.game import Game
from atari.multiplayer.core import MultiplayerCore
from atari.recording.replay.events import Event, Kind
from atari.recording.replay.file_format import FORMAT_OF_PLAYERS, Corrupt, Scores
from atari.recording.replay.recorded_core import RecordedCore, ReplayRecorder, json_value
from atari.recording.replay.runner import ReplayRunner

_ACTIONS = 18


class RecordMatch(RecordedCore):
    """A `MultiplayerCore` whose calls are recorded in a replay: `RecordReplay(core, path)` makes it.

    A recording that begins in the middle of a game contains a snapshot, which only releases with the same version of
    the emulator's state restore.

    Raises:
        ValueError: the name of the file does not end in ".a26r", or the core has a frame skip.
        OSError: the file cannot be written. During the game, the error is raised by the next call of `act_players`,
            `reset` or `close`, before it does anything; the game can continue without a recording.
    """

    def __init__(self, core: MultiplayerCore, path: str | PathLike[str]) -> None:
        if core.frame_skip != 1:
            raise ValueError(f"a replay needs each frame: make the core with frameskip=1, got {core.frame_skip}")
        header = {
            "format": FORMAT_OF_PLAYERS,
            "game": core.game.id,
            "rom": core.rom_md5,
            "core": core.name,
            "source": type(core).__name__,
            "players": core.players,
            "options": json_value(core.options),
            "package": VERSION,
        }
        recorder = ReplayRecorder(path, header, core)
        super().__init__(core, recorder)
        self.path = recorder.path
        self.record_writes()
        if core.save() != MultiplayerCore(core.game, rom=core.rom, **core.options).save():
            recorder.record_restore(core.snapshot())

    def reset(self) -> None:
        """Begin a new game."""
        self._recorder.raise_deferred_error()
        super().reset()
        self._recorder.flush_if_full()

    def act_players(self, actions: Sequence[int]) -> list[int]:
        """Play a frame with an action of each player, as `MultiplayerCore.act_players`, and record it."""
        self._recorder.raise_deferred_error()
        core = self.inner
        before = core.frame_number
        rewards: list[int] = core.act_players(actions)
        word = sum(int(action) * _ACTIONS**player for player, action in enumerate(actions))
        self._recorder.record_act(word, 1.0, rewards, core.frame_number != before)
        self._recorder.flush_if_full()
        return rewards

    def act(self, action: int, strength: float = 1.0) -> int:
        """Raise RuntimeError, because several players act."""
        raise RuntimeError("this is a game of several players; call act_players")

    def set_mode(self, mode: int) -> None:
        """Raise RuntimeError, because the file has the mode of the core."""
        raise RuntimeError("the mode is part of the replay; make the core with the mode, then record it")

    def set_difficulty(self, difficulty: int) -> None:
        """Raise RuntimeError, because the file has the difficulty of the core."""
        raise RuntimeError("the difficulty is part of the replay; make the core with the difficulty, then record it")

    def close(self) -> None:
        """Complete the file. A second call does nothing."""
        self._recorder.close()

    def __enter__(self) -> "RecordMatch":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class PlayersRunner(ReplayRunner):
    """Feeds the events of a replay of several players to a `MultiplayerCore`."""

    core: MultiplayerCore
    _plays = Kind.ACTIONS

    def _play_frame(self, event: Event) -> Scores:
        return Scores(self.core.act_players(actions_of(event.numbers[0], self.core.players)))

    def _do(self, kind: Kind, first: int = 0, second: int = 0) -> None:
        if kind in (Kind.MODE, Kind.DIFFICULTY, Kind.CONTINUOUS_ACTION):
            raise ValueError("replays of several players have no such event")
        super()._do(kind, first, second)


def actions_of(word: int, players: int) -> list[int]:
    """The action of each player.

    Raises:
        ValueError: the word has more digits.
    """
    actions = []
    for _ in range(players):
        word, action = divmod(word, _ACTIONS)
        actions.append(action)
    if word:
        raise ValueError(f"the replay has actions of more than {players} players")
    return actions


def make_core(
    header: Mapping[str, Any], game: Game, rom: str | PathLike[str] | None, sound: bool = False
) -> MultiplayerCore:
    """The core that a header describes.

    Raises:
        Corrupt: an option is wrong, or not one of `MultiplayerCore`'s.
    """
    try:
        odd = header["options"].keys() ^ MultiplayerCore.OPTIONS
        if odd:
            raise ValueError(f"the option {min(odd)!r} is missing, or none")
        core = MultiplayerCore(game, rom=rom, sound=sound, **header["options"])
        if core.players != header["players"]:
            raise ValueError(f"the game is for {core.players} players, and not for {header['players']!r}")
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise Corrupt(f"the replay is damaged: its header is wrong ({error})") from None
    return core
