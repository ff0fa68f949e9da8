"""`Replay`: a recorded game that can be played again, checked, searched and filmed.

The file has the calls of the emulator and a few hashes, so a replay of half an hour has tens of kilobytes. Playing it
is emulating it: screens, RAM, sound and rewards come out as they were, on each core and on any machine.
"""

import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import Any

from atari import snapshot
from atari.catalog import games
from atari.cores import CORES, ByteArray, Core
from atari.cores.options import check_integer, check_name
from atari.env import AtariEnv
from atari.game import Game
from atari.recording import replay_file
from atari.recording.formats import has_sound
from atari.recording.recorder import rom_md5
from atari.recording.replay_events import Event, Kind, unpack
from atari.recording.replay_file import FRAMES_PER_CHECK, Corrupt
from atari.recording.replay_player import Call, Player, Position
from atari.recording.video import VideoWriter, frame_rate

_CHUNKS_PER_POSITION = 4


@dataclass(frozen=True)
class Frame:
    """One emulated frame of a replay.

    `index` counts from 0 over all episodes, `episode` from 0. `action` is ALE's number 0..17 and `strength` the
    paddle's; with sticky actions the console may have repeated the one before. `ends_step` tells the last frame of a
    step of the environment. `ram` is (128,) and `screen` (height, 160, 3), uint8; `audio` (512,) uint8 samples, all
    zero unless asked for.
    """

    index: int
    episode: int
    action: int
    strength: float
    ends_step: bool
    reward: int
    lives: int
    terminated: bool
    truncated: bool
    ram: ByteArray
    screen: ByteArray
    audio: ByteArray


@dataclass(frozen=True)
class Episode:
    """Frames and score of an episode, and how it ended: "game over", "truncated", or "open" if it did not."""

    frames: int
    score: int
    end: str


@dataclass(frozen=True)
class Divergence:
    """Where a replay parts from the recorded game.

    `frame` is the first one that was seen to differ, counted from 0; nothing before `since` differs. They are the same
    in most cases: what differs in RAM shows at once with a probability of 3/4.
    """

    frame: int
    since: int
    what: str

    def __str__(self) -> str:
        first = f"; it may have begun at frame {self.since}" if self.since < self.frame else ""
        return f"frame {self.frame} differs in {self.what}{first}"


@dataclass(frozen=True)
class Verification:
    """What `Replay.verify` found: the core, how many frames were compared, and the divergence, if there is one."""

    core: str
    frames: int
    divergence: Divergence | None

    def __bool__(self) -> bool:
        return self.divergence is None


class Replay:
    """A recorded game. `Replay.load` reads one from a file.

    Attributes:
        path: of the file.
        header: what the file says of itself: game, ROM, core, options, release.
        game: the game.
        seeds: those that the emulator was given, in order.
        complete: whether the recording was closed. If not, it was cut, and the replay is what is left of it.
        frames_total: emulated frames.
    """

    def __init__(
        self, path: Path, content: replay_file.Content, game: Game, rom: str | PathLike[str] | None = None
    ) -> None:
        self.path = path
        self.header: Mapping[str, Any] = content.header
        self.game = game
        self.complete = content.end is not None
        self.frames_total = content.frames
        self._content = content
        self.rom = rom
        self._uses: Counter[int] = Counter()  # how often each snapshot is gone back to
        seeds = []
        for event in chain.from_iterable(map(self._events, range(len(content.plays)))):  # a wrong one shows at once
            if event.kind == Kind.RESTORE:
                self._uses[event.numbers[0]] += 1
            elif event.kind == Kind.SEED:
                seeds.append(event.numbers[0])
        self.seeds = tuple(seeds)
        self._index: dict[tuple[str, bool], list[Position]] = {}

    @classmethod
    def load(
        cls,
        path: str | PathLike[str],
        *,
        game: "str | PathLike[str] | Game | None" = None,
        rom: str | PathLike[str] | None = None,
    ) -> "Replay":
        """Read a file that `RecordReplay` wrote. A file that was cut gives what is whole, with a warning.

        Args:
            path: of the file.
            game: the game file, for a game of your own; None is the game that the replay names.
            rom: path of the ROM file; None searches (see `atari.roms`).

        Raises:
            ValueError: it is no replay, of another version, damaged (the text has the offset), or of another ROM.
            FileNotFoundError: there is no such file, or no ROM of the game.
        """
        path = Path(path)
        content = replay_file.read(path)
        header = content.header
        if not isinstance(header.get("game"), str) or not isinstance(header.get("options"), dict):
            raise Corrupt("the replay is damaged: its header has no game, or no options")
        found = games.find(header["game"] if game is None else game)
        md5 = rom_md5(found, rom)
        if md5 != header.get("rom"):
            raise ValueError(
                f"the replay was recorded with a ROM of MD5 {header.get('rom')}, but the one of {found.id} here has "
                f"{md5}; pass the right one as rom="
            )
        if content.end is None:
            warnings.warn(
                f"{path} was cut while it was recorded; its first {content.frames:,} frames are whole", stacklevel=2
            )
        return cls(path, content, found, rom)

    @property
    def options(self) -> dict[str, Any]:
        """The options of the environment that was recorded, as `AtariEnv` takes them."""
        skip = self.header["options"].get("frameskip")
        return {**self.header["options"], **({"frameskip": tuple(skip)} if isinstance(skip, list) else {})}

    @property
    def episodes(self) -> tuple[Episode, ...]:
        """The episodes. If the recording was cut, this plays it to find them out.

        Raises:
            Corrupt: the file does not say.
        """
        end = self._content.end
        try:
            return tuple(Episode(**episode) for episode in (end["episodes"] if end else self._play_for_episodes()))
        except (KeyError, TypeError):
            raise Corrupt(f"the replay is damaged: the end of {self.path} has no episodes") from None

    def __repr__(self) -> str:
        cut = "" if self.complete else ", cut"
        return f"Replay({str(self.path)!r}, {self.game.id}, {self.frames_total} frames{cut})"

    def frames(
        self, start: int = 0, stop: int | None = None, *, core: str = "native", sound: bool = False
    ) -> Iterator[Frame]:
        """Play and show each frame.

        The first time, frames before `start` are played too; then they are skipped, from snapshots made on the way.

        Args:
            start: the first frame to show, 0 or more.
            stop: the one behind the last; None is the end.
            core: on which to play.
            sound: whether `audio` is filled.

        Raises:
            TypeError, ValueError: there is no such frame or core, or the replay cannot be played on it.
        """
        start = check_integer("start", start, 0, max(self.frames_total, 0))
        stop = self.frames_total if stop is None else min(check_integer("stop", stop, 0, 2**62), self.frames_total)
        for player, call in self._calls(core, sound=sound, start=start):
            if player.frame > stop or start >= stop:
                break
            if call.played and player.frame > start:
                yield _frame(player, call)

    def seek(self, frame: int, *, core: str = "native", sound: bool = False) -> Core:
        """A core of your own in the state behind the first `frame` frames, to look at or to play on.

        Behind 0 frames, not even the first reset has happened.

        Raises:
            TypeError, ValueError: as of `frames`.
        """
        frame = check_integer("frame", frame, 0, self.frames_total)
        player, calls = self._player(core, sound=sound, start=frame)
        while player.frame < frame:
            next(calls)
        return player.core  # type: ignore[no-any-return]

    def verify(self, core: str = "native", *, progress: Callable[[int], object] | None = None) -> Verification:
        """Play the replay and compare it with the hashes in the file.

        Args:
            core: on which to play, "native", "plain" or "ale".
            progress: is called with a number of frames, now and then, when they have been compared.

        Raises:
            ValueError: there is no such core, or the replay cannot be played on it.
        """
        since = 0
        player = self._new_player(core, sound=False)
        try:
            for number, play in enumerate(self._content.plays):
                for call in chain.from_iterable(map(player.play, self._events(number))):
                    if not call.played:
                        continue
                    what = _difference(player, play)
                    if what:
                        return Verification(core, player.frame, Divergence(player.frame - 1, since, what))
                    if player.frame % FRAMES_PER_CHECK == 0:
                        since = player.frame
                if player.frame < play.first + len(play.marks):
                    return Verification(core, player.frame, Divergence(player.frame, since, "that the game is over"))
                if progress is not None:
                    progress(len(play.marks))
            player.end_episode()
            end = self._content.end
            check = replay_file.check(player.core, player.score)
            if end is not None and end != {"episodes": player.episodes, "check": check}:
                last = max(player.frame - 1, 0)
                return Verification(core, player.frame, Divergence(last, min(since, last), "how it ends"))
            return Verification(core, player.frame, None)
        finally:
            player.core.close()

    def render(
        self,
        path: str | PathLike[str],
        *,
        scale: int = 2,
        sound: bool = True,
        start: int = 0,
        stop: int | None = None,
        core: str = "native",
        progress: Callable[[int], object] | None = None,
    ) -> Path:
        """Write a video of it, or of a part, with each emulated frame, at the console's speed.

        Args:
            path: of the video; see `VideoWriter` for its formats.
            scale: a pixel becomes `2 * scale` columns and `scale` rows.
            sound: with the game's sound, if the format has any.
            start, stop, core: as of `frames`.
            progress: is called with 1 behind each frame.

        Raises:
            TypeError, ValueError: as of `frames`, and of `VideoWriter`.
            OSError: the file cannot be written.
            gymnasium.error.DependencyNotInstalled: PyAV is not installed.
        """
        audible = sound and has_sound(path)
        with VideoWriter(path, self.game.screen.shape, frame_rate(self.game), scale=scale, sound=audible) as video:
            for frame in self.frames(start, stop, core=core, sound=video.sound):
                video.write(frame.screen, frame.audio)
                if progress is not None:
                    progress(1)
        return video.path

    def make_env(self, *, core: str = "native", **options: Any) -> AtariEnv:
        """An environment made with the options of the recorded one; `options` take the place of some.

        Raises:
            TypeError, ValueError: as of `AtariEnv`.
        """
        check_name("core", core, CORES)
        return AtariEnv(self.game, **{**self.options, **options}, core=core, rom=self.rom)

    def walk(self, core: Core) -> Iterator[tuple[Event, Iterator[Call]]]:
        """Do to a core what was done to the recorded one: each event, and its calls, to be asked for before the next.

        Raises:
            ValueError: an event is not possible on this core.
        """
        player = Player(core, self._content.snapshots, self._uses)
        for number in range(len(self._content.plays)):
            for event in self._events(number):
                yield event, player.play(event)

    def _events(self, number: int) -> list[Event]:
        play = self._content.plays[number]
        try:
            return unpack(play.events)
        except ValueError as error:
            raise Corrupt(f"the replay is damaged at offset {play.offset}: {error}") from None

    def _new_player(self, core: str, *, sound: bool) -> Player:
        check_name("core", core, CORES)
        options = self.options
        if core == "ale" and self._content.snapshots:  # they fit only a core that makes sound if they were, or not
            sound = bool(snapshot.unpack(self._content.snapshots[0])[0].get("sound"))
        names = ("repeat_action_probability", "mode", "difficulty")
        made = CORES[core](
            self.game,
            max_num_frames_per_episode=options.get("max_num_frames_per_episode") or 0,
            sound=sound,
            rom=self.rom,
            **{name: options[name] for name in names if name in options},
        )
        return Player(made, self._content.snapshots, self._uses)

    def _player(self, core: str, *, sound: bool, start: int) -> tuple[Player, Iterator[Call]]:
        player = self._new_player(core, sound=sound)
        positions = self._index.setdefault((core, sound), [])
        known = [position for position in positions if position.frame <= start]
        if known:
            player.go_to(known[-1])
        return player, self._play_on(player, positions)

    def _play_on(self, player: Player, positions: list[Position]) -> Iterator[Call]:
        for number in range(player.chunk, len(self._content.plays)):
            known = positions[-1].chunk if positions else 0
            # ale-py's snapshots are played again from the start, and gain nothing.
            if number % _CHUNKS_PER_POSITION == 0 and number > known and player.core.name != "ale":
                positions.append(player.position())
            for event in self._events(number):
                yield from player.play(event)
            player.chunk += 1

    def _calls(self, core: str, *, sound: bool, start: int = 0) -> Iterator[tuple[Player, Call]]:
        player, calls = self._player(core, sound=sound, start=start)
        try:
            for call in calls:
                yield player, call
        finally:
            player.core.close()

    def _play_for_episodes(self) -> list[dict[str, Any]]:
        player, calls = self._player("native", sound=False, start=0)
        for _ in calls:
            pass
        player.end_episode()
        return player.episodes


def _frame(player: Player, call: Call) -> Frame:
    core, (_, numbers, floats, ends_step) = player.core, call.event
    return Frame(
        index=player.frame - 1,
        episode=player.episode,
        action=numbers[0],
        strength=floats[0] if floats else 1.0,
        ends_step=ends_step,
        reward=call.reward,
        lives=core.lives,
        terminated=core.game_over,
        truncated=core.truncated,
        ram=core.ram(),
        screen=core.screen_rgb(),
        audio=core.audio(),
    )


def _difference(player: Player, play: replay_file.Play) -> str:
    """In what the frame just played differs from what the file says of it, or ""."""
    place = player.frame - play.first - 1
    if place >= len(play.marks):
        return "that the game goes on"
    if replay_file.mark(player.core) != play.marks[place]:
        return "RAM"
    if player.frame % FRAMES_PER_CHECK == 0:
        number = player.frame // FRAMES_PER_CHECK - play.first // FRAMES_PER_CHECK - 1
        if replay_file.check(player.core, player.score) != play.checks[number]:
            return "RAM, screen, reward, lives or end"
    return ""
