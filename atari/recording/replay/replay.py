"""`Replay`: a recorded game that can be played again, verified, searched and rendered to a video.

The file has the calls of the core and hashes, so half an hour takes tens of kilobytes. Playing a replay emulates the
game again: screens, RAM, sound and rewards are the same on each core. A test plays a replay of every game on the native
core and on ale-py's.
"""

import json
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import chain, takewhile
from os import PathLike
from pathlib import Path
from typing import Any, Literal

import numpy as np

from atari.base import json_text
from atari.base.notebook import picture
from atari.base.png import animation, pooled
from atari.base.validation import check_integer, check_name
from atari.cores import CORES, Core, snapshot
from atari.cores.writes import switched_on
from atari.env import AtariEnv
from atari.games.game import Game
from atari.games.interventions import load, resolve
from atari.recording.replay import file_format
from atari.recording.replay.events import Event, Kind, unpack
from atari.recording.replay.file_format import FRAMES_PER_FULL_HASH, Corrupt
from atari.recording.replay.header import emulator_task, game_of_header
from atari.recording.replay.observations import Observed, ObservedReplay, Walk
from atari.recording.replay.players import PlayersRunner, make_core
from atari.recording.replay.results import Divergence, EpisodeSummary, Frame, Verification, difference, frames_of
from atari.recording.replay.runner import Call, Checkpoint, ReplayRunner
from atari.recording.replay.shown import ShownVideo, in_notebook
from atari.recording.replay.side_by_side import labels, write_film
from atari.recording.video.facts import PACKAGE
from atari.recording.video.formats import has_sound, is_picture
from atari.recording.video.overlay import Overlay
from atari.recording.video.writer import frame_rate, video_rate
from atari.task import Task

_CHUNKS_PER_CHECKPOINT = 4
_SECONDS_SHOWN = 20  # in a notebook


class Replay:
    """A recorded game. `Replay.load` reads one from a file.

    Attributes:
        path: the file.
        name: its name in a video beside others: the path without its ending. It can be set.
        header: the file's header: game, ROM, core, options, release.
        game: the game.
        seeds: the seeds of the core, in order.
        complete: whether the recording was closed. If not, the replay has the chunks that were written.
        frames_total: emulated frames.
        steps: steps of the environment; 0 if a core was recorded.
        players: the number of players; replays of several run on core "native".

    Example:
        >>> import atari
        >>> from atari.recording import RecordReplay, Replay
        >>> with RecordReplay(atari.make("pong"), "game.a26r") as env:
        ...     observation, info = env.reset(seed=0)
        ...     observation = env.step(2)[0]
        >>> replay = Replay.load("game.a26r")
        >>> [frame.action for frame in replay.frames()]
        [3, 3, 3, 3]
        >>> bool(replay.verify())
        True
    """

    def __init__(
        self, path: Path, content: file_format.ReplayContent, game: Game, rom: str | PathLike[str] | None = None
    ) -> None:
        self.path = path
        self.name = str(path.with_suffix("") if path.suffix.lower() == file_format.SUFFIX else path)
        self.header: Mapping[str, Any] = content.header
        self.game = game
        self.complete = content.end is not None
        self.frames_total = content.frames
        self.players = int(self.header.get("players", 1))
        self._content = content
        self.rom = rom
        self.steps = 0
        self._uses: Counter[int] = Counter()  # by snapshot: the number of times that it is restored
        seeds = [self.header["options"]["seed"]] if self.players > 1 else []
        for event in chain.from_iterable(map(self._events, range(len(content.plays)))):  # raises now if one is damaged
            if event.kind == Kind.RESTORE:
                self._uses[event.numbers[0]] += 1
            elif event.kind == Kind.SEED:
                seeds.append(event.numbers[0])
            self.steps += event.ends_step or event.kind == Kind.STEP
        self.seeds = tuple(seeds)
        self._checkpoints: dict[tuple[str, bool], list[Checkpoint]] = {}

    @classmethod
    def load(
        cls,
        path: str | PathLike[str],
        *,
        game: "str | PathLike[str] | Game | None" = None,
        rom: str | PathLike[str] | None = None,
    ) -> "Replay":
        """Read a file of `RecordReplay`. If the file was cut, return its complete chunks and warn.

        Args:
            path: the file.
            game: the game file, for a game of your own; None is the game that the replay names.
            rom: path of the ROM file; None searches (see `atari.roms`).

        Raises:
            ValueError: the file is not a replay, of another version, damaged (the message has the offset), or of
                another ROM.
            FileNotFoundError: there is no such file, or no ROM of the game.
        """
        path = Path(path)
        content = file_format.read(path)
        found = game_of_header(content.header, game, rom)
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

    @cached_property
    def episodes(self) -> tuple[EpisodeSummary, ...]:
        """The episodes. If the recording was cut, the replay is played to count them.

        An episode has the number of its `frames`, its `score`, and its `end`: "game over", "truncated" by the
        emulator's limit of frames, or "open" if the emulator did not end it, as with a wrapper's limit of steps. With
        several players, `scores` has the score of each, `score` is the first player's, and `frames` counts the
        frames of the reset, too.

        Raises:
            Corrupt: the end chunk of the file has no episodes.
        """
        end = self._content.end
        try:
            found = end["episodes"] if end else self._play_for_episodes()
            episodes = tuple(EpisodeSummary(**episode) for episode in found)
            if all(self._is_episode(episode) for episode in episodes):
                return episodes
            raise TypeError
        except (KeyError, TypeError):
            raise Corrupt(f"the replay is damaged: the end of {self.path} has no episodes") from None

    @property
    def frames_rewound(self) -> int:
        """The frames that were played and then taken back by restoring a snapshot of the recording."""
        return max(self.frames_total - sum(episode.frames for episode in self.episodes), 0) if self._uses else 0

    @property
    def best_episode(self) -> int:
        """The number of the episode with the highest score of the first player; of equal scores, the first.

        Raises:
            ValueError: the replay has no episodes.
        """
        scores = [episode.score for episode in self.episodes]
        if not scores:
            raise ValueError(f"{self.path} has no episodes")
        return scores.index(max(scores))

    def _is_episode(self, episode: EpisodeSummary) -> bool:
        if (type(episode.frames), type(episode.score), type(episode.end)) != (int, int, str):
            return False
        if self.players == 1:
            return episode.scores is None
        scores = episode.scores
        return isinstance(scores, list) and [type(score) for score in scores] == [int] * self.players

    def __repr__(self) -> str:
        cut = "" if self.complete else ", cut"
        return f"Replay({str(self.path)!r}, {self.game.id}, {self.frames_total} frames{cut})"

    def _repr_html_(self) -> str | None:
        """The first seconds in a page with sound, for a notebook, or as an animation if the page is not built.

        None without the ROM or without frames.
        """
        with suppress(OSError, ValueError):
            return in_notebook(self, _SECONDS_SHOWN)
        try:
            screens = (frame.screen for frame in self.frames(0, _SECONDS_SHOWN * 60))
            data, shown = animation(pooled(screens, 2), round(frame_rate(self.game) / 2))
        except (OSError, ValueError):  # without frames, too
            return None
        caption = f"{self.game.title}: {self.frames_total:,} frames"
        if self.complete:
            caption += f", score {', '.join(str(episode.score) for episode in self.episodes[:5])}"
        if 2 * shown < self.frames_total:
            caption += f"; the first {2 * shown // frame_rate(self.game)} seconds"
        return picture(data, caption, self.game.screen.shape)

    def frames(
        self,
        start: int = 0,
        stop: int | None = None,
        *,
        episode: int | Literal["best"] | None = None,
        core: str = "native",
        sound: bool = False,
    ) -> Iterator[Frame]:
        """Play the replay and yield each frame.

        The first call plays the frames before `start` too and keeps checkpoints. Later calls resume from a checkpoint.

        A frame's `index` counts from 0 over all episodes, its `episode` from 0. `action` is ALE's number 0..17 and
        `strength` the paddle's; with sticky actions the core may have repeated the previous action. `reward`, `lives`,
        `terminated` and `truncated` are results of the frame, and `score` is the sum of the episode's rewards up to
        it. `ends_step` is True for the last frame of a step of the environment. `ram` is (128,) and `screen`
        (height, 160, 3), uint8. `audio` is (512,) uint8 samples, all zero without sound=True. `actions`, `rewards`,
        `scores` and `all_lives` have a number for each player; `action`, `reward`, `score` and `lives` are the first
        player's. A recording that begins in the middle of a game counts `score` from there.

        Args:
            start: the first frame, 0 or more.
            stop: the frame after the last; None is the end.
            episode: the number of the only episode that is played, or "best", which is `best_episode`; without
                `start` and `stop`.
            core: the core to play on.
            sound: whether `audio` is filled.

        Raises:
            TypeError, ValueError: there is no such frame, episode or core, or the replay cannot be played on this core.
        """
        if episode is None:
            start, stop = self._part(start, stop)
            calls = self._calls(core, sound=sound, start=start) if start < stop else iter(())
            part = ((runner, call) for runner, call in calls if runner.frame > start)
            return frames_of(takewhile(lambda pair: pair[0].frame <= stop, part))
        if start or stop is not None:
            raise ValueError(f"episode={episode!r} is a whole episode; leave start and stop out")
        number = self.best_episode if episode == "best" else episode
        number = check_integer('an episode other than "best"', number, 0, len(self.episodes) - 1)
        calls = takewhile(lambda pair: len(pair[0].episodes) <= number, self._calls(core, sound=sound))
        return frames_of((runner, call) for runner, call in calls if len(runner.episodes) == number)

    def _part(self, start: int, stop: int | None) -> tuple[int, int]:
        total = self.frames_total
        start = check_integer("start", start, 0, total)
        return start, total if stop is None else min(check_integer("stop", stop, 0, 2**62), total)

    def best_frame(
        self, start: int = 0, stop: int | None = None, *, episode: int | Literal["best"] | None = None
    ) -> int:
        """Return the index of the first frame with the greatest reward, in all frames, a part, or an episode.

        Raises:
            TypeError, ValueError: see `render`; there is no frame.
        """
        best = max(self.frames(start, stop, episode=episode), key=lambda frame: frame.reward, default=None)
        if best is None:
            raise ValueError(f"there is no frame for a picture: the replay has {self.frames_total:,} frames")
        return best.index

    def best_start(self, frames: int, *, episode: int | Literal["best"] | None = None) -> int:
        """Return the first of `frames` frames in a row in which the first player makes the most points.

        Where several parts have as many points, it is the middle one of them. The replay is played once.

        Args:
            frames: the number of frames, at most as many as the replay or the episode has.
            episode: the only episode that is searched, see `render`; None searches all.

        Raises:
            TypeError, ValueError: there is no such episode, or `frames` is out of range.

        Example:
            >>> import atari
            >>> from atari.recording import RecordReplay, Replay
            >>> with RecordReplay(atari.make("pong"), "game.a26r") as env:
            ...     observation, info = env.reset(seed=0)
            ...     for _ in range(100):
            ...         observation = env.step(0)[0]
            >>> replay = Replay.load("game.a26r")
            >>> start = replay.best_start(200)
            >>> sum(frame.reward for frame in replay.frames(start, start + 200))
            -1
        """
        pairs = [(frame.index, frame.reward) for frame in self.frames(episode=episode)]
        frames = check_integer("frames", frames, 1, len(pairs))
        points = np.cumsum([0, *(reward for _, reward in pairs)])
        sums = points[frames:] - points[:-frames]
        best = np.flatnonzero(sums == sums.max())
        return pairs[0][0] + int(best[len(best) // 2])

    def seek(self, frame: int, *, core: str = "native", sound: bool = False) -> Core:
        """Return a new core in the state after the first `frame` frames, for inspection or for playing on.

        After 0 frames the first reset has not happened yet.

        Raises:
            TypeError, ValueError: see `frames`.
        """
        frame = check_integer("frame", frame, 0, self.frames_total)
        runner, calls = self._runner_at(core, sound=sound, start=frame)
        while runner.frame < frame:
            next(calls)
        return runner.core

    def verify(self, core: str = "native", *, progress: Callable[[int], object] | None = None) -> Verification:
        """Play the replay and compare it with the hashes in the file.

        Args:
            core: the core to play on, "native", "plain" or "ale".
            progress: called after each chunk with the number of its frames.

        Returns:
            An object that is true if all is equal: the `core`, the number of compared `frames`, and the `divergence`,
            or None. The hashes of frame `divergence.frame`, counted from 0, are the first that differ, in
            `divergence.what`; the frames before `divergence.since` are equal.

        Raises:
            ValueError: there is no such core, or the replay cannot be played on it.
        """
        since = 0
        runner = self._new_runner(core, sound=False)
        try:
            for number, play in enumerate(self._content.plays):
                for call in chain.from_iterable(map(runner.run, self._events(number))):
                    if not call.played:
                        continue
                    what = difference(runner, play)
                    if what:
                        return Verification(core, runner.frame, Divergence(runner.frame - 1, since, what))
                    if runner.frame % FRAMES_PER_FULL_HASH == 0:
                        since = runner.frame
                if runner.frame < play.first + len(play.short_hashes):
                    return Verification(core, runner.frame, Divergence(runner.frame, since, "that the game is over"))
                if progress is not None:
                    progress(len(play.short_hashes))
            runner.end_episode()
            end = self._content.end
            check = file_format.full_hash(runner.core, runner.score)
            if end is not None and end != {"episodes": runner.episodes, "check": check}:
                last = max(runner.frame - 1, 0)
                return Verification(core, runner.frame, Divergence(last, min(since, last), "how it ends"))
            return Verification(core, runner.frame, None)
        finally:
            runner.core.close()

    def render(
        self,
        path: str | PathLike[str],
        *,
        speed: float = 1,
        scale: int = 2,
        sound: bool = True,
        start: int = 0,
        stop: int | None = None,
        episode: int | Literal["best"] | None = None,
        frame: int | Literal["best"] | None = None,
        overlay: tuple[str, ...] | None = None,
        beside: "Sequence[Replay]" = (),
        core: str = "native",
        progress: Callable[[int], object] | None = None,
    ) -> Path:
        """Write a video of the replay or of a part, with each emulated frame; or a picture of one frame.

        With `beside`, the video shows several replays, each with its `name`. It lasts as long as the longest, and the
        others keep their last frame. It has the sound and the frame rate of this replay.

        Args:
            path: the video, see `VideoWriter` for the formats; a picture ends in ".png" and has no "%" in its name.
            speed: 1 is the console's speed, 0.25 is slow motion, and 4 is fast; see `VideoWriter`.
            scale: a pixel becomes `2 * scale` columns and `scale` rows.
            sound: write the game's sound, if the format has sound.
            start, stop, episode, core: see `frames`.
            frame: the frame of a picture: its number, without `start`, `stop` and `episode`, or "best", the first with
                the greatest reward. None is the last frame.
            overlay: parts of the text below the frame: some of "score", "lives", "action", "ram" and "curve", the score
                of the episode up to each frame. None means no part, or beside others ("score", "lives").
            beside: other replays, also of other games. `start`, `stop`, `episode`, `frame` and `overlay` apply to each.
            progress: called with 1 after each frame.

        Raises:
            TypeError, ValueError: see `frames` and `VideoWriter`; there is no such episode or frame, or no frame.
            OSError: the file cannot be written.
            gymnasium.error.DependencyNotInstalled: PyAV is not installed.

        Example:
            >>> import atari
            >>> from atari.recording import RecordReplay, Replay
            >>> for seed in (0, 1):
            ...     with RecordReplay(atari.make("pong"), f"seed{seed}.a26r") as env:
            ...         observation, info = env.reset(seed=seed)
            ...         observation = env.step(2)[0]
            >>> first, second = Replay.load("seed0.a26r"), Replay.load("seed1.a26r")
            >>> first.render("both.png", beside=[second]).name
            'both.png'
        """
        others: list[Any] = list(beside) if isinstance(beside, (list, tuple)) else [beside]
        if wrong := [one for one in others if not isinstance(one, Replay)]:
            raise TypeError(f"beside is a list of replays, such as [Replay.load('b.a26r')], got {wrong[0]!r} in it")
        replays: list[Replay] = [self, *others]
        audible = sound and has_sound(path)
        if len(replays) > 1 and overlay is None:
            overlay = ("score", "lives")
        overlays = [Overlay(overlay, replay.game) for replay in replays]
        part: dict[str, Any] = {"start": start, "stop": stop, "episode": episode, "frame": frame}
        last = is_picture(path) and "curve" not in overlays[0].parts  # a curve has the frames before, too
        names, facts = [""], self.facts
        if others:
            names = labels([replay.name for replay in replays], self.game.screen.width)
            first, *rest = ({**replay.facts, "name": name} for replay, name in zip(replays, names, strict=True))
            facts = {**first, "beside": rest}
        return write_film(
            path,
            [replay._rendered(path, last, **part, core=core, sound=audible) for replay in replays],
            overlays,
            [replay.game.screen.shape for replay in replays],
            names,
            video_rate(self.game, Path(path).suffix, speed=speed),
            scale=scale,
            sound=audible,
            comment=json.dumps(facts),
            progress=progress,
        )

    def video(self, **options: Any) -> ShownVideo:
        """Return a video with sound that a cell of a notebook shows.

        The notebook contains the video, and the HTML that nbconvert writes of it does, too.

        Args:
            **options: options of `render` for a video, but `progress`.

        Returns:
            An object whose `data` has the bytes of an MP4 file.

        Raises:
            TypeError, ValueError: see `render`; or the video has more than 20 MB, which is too much for a notebook.
            gymnasium.error.DependencyNotInstalled: PyAV is not installed.

        Example:
            >>> import atari
            >>> from atari.recording import RecordReplay, Replay
            >>> with RecordReplay(atari.make("pong"), "game.a26r") as env:
            ...     observation, info = env.reset(seed=0)
            ...     for _ in range(100):
            ...         observation = env.step(0)[0]
            >>> Replay.load("game.a26r").video(stop=120)
            ShownVideo(caption='Pong: 120 frames, 0.0 MB')
        """
        return ShownVideo.of(self.game, lambda path, progress: self.render(path, progress=progress, **options))

    def _rendered(
        self, path: Any, last: bool, start: int, stop: int | None, episode: Any, frame: Any, **options: Any
    ) -> Iterator[Frame]:
        """The frames that `render` shows, or only the last of them, unless they are an episode."""
        if frame is not None:
            start, stop = self._part_of_frame(path, frame, start, stop, episode)
            episode = None
        if episode is None:
            start, stop = self._part(start, stop)
            if start >= stop:
                raise ValueError(f"there are no frames to render: the replay has {self.frames_total:,} frames")
            start, stop = (stop - 1 if last else start), stop
        return self.frames(start, stop, episode=episode, **options)

    def _part_of_frame(
        self, path: Any, frame: Any, start: int, stop: int | None, episode: Any
    ) -> tuple[int, int | None]:
        """The part of the replay that ends with the frame of a picture."""
        if not is_picture(path):
            raise ValueError(
                f"frame={frame!r} chooses the frame of a picture, such as 'pong.png', got {str(path)!r}; leave it out"
            )
        if frame == "best":
            return 0, 1 + self.best_frame(start, stop, episode=episode)
        if episode is not None or start or stop is not None:
            raise ValueError(f"frame={frame!r} is a frame of the whole replay; leave episode, start and stop out")
        return 0, 1 + check_integer('a frame other than "best"', frame, 0, self.frames_total - 1)

    def make_env(self, *, core: str = "native", **options: Any) -> AtariEnv:
        """Return an environment with the options of the recorded environment; `options` override them.

        Raises:
            TypeError, ValueError: see `AtariEnv`.
        """
        check_name("core", core, CORES)
        self._require_one_player("AtariEnv")
        played = emulator_task(self.options, self.game)
        return AtariEnv(played, **options, core=core, rom=self.rom)

    def observations(self, task: Task | None = None, *, core: str = "native") -> Iterator[Observed]:
        """Play the replay, and yield what an agent of a task sees at each step.

        If the recorded environment has the task's frame skip, beginnings, lives and limits, the steps are the recorded
        steps, and observations are that environment's, to the bit, if the task is its own. Otherwise an agent of the
        task watches the game, such as a person's: its first observation is the first frame, a step is a frame skip of
        the task, and lost lives begin the stack anew as the task says. After a restored snapshot the stack begins anew.

        Args:
            task: the task, of the recorded game; None is the recorded task.
            core: the core to play the replay on.

        Raises:
            ValueError: the task is of another game, or has observations that a replay does not determine (sound, a
                delay that was drawn); or the environment was in wrappers that the recorded task does not have.

        Example:
            >>> import atari
            >>> from atari.recording import RecordReplay, Replay
            >>> with RecordReplay(atari.make("pong", preset="dqn2015"), "game.a26r") as env:
            ...     first, info = env.reset(seed=0)
            ...     second = env.step(2)[0]
            ...     third = env.step(2)[0]
            >>> steps = list(Replay.load("game.a26r").observations())
            >>> [bool((step.observation == seen).all()) for step, seen in zip(steps, [first, second])]
            [True, True]
            >>> task = atari.Task.of("pong", obs_type="ram")
            >>> next(Replay.load("game.a26r").observations(task)).observation.shape
            (128,)
        """
        return self.observed(task, core).steps()

    def observed(self, task: Task | None = None, core: str = "native") -> ObservedReplay:
        """The replay on a new core, with the observations of a task; see `observations`."""
        recorded = self.task
        task = recorded if task is None else task
        if task.definition != self.game:
            raise ValueError(f"{self.path} is a replay of {self.game.id}, and the task is one of {task.game}")
        played = self.seek(0, core=core)
        return ObservedReplay(task, recorded, played, self.walk(played), self.steps > 0)

    @property
    def task(self) -> Task:
        """The task that was played, with the wrappers that `atari.make` has put around the recorded environment.

        Raises:
            ValueError: several players played.
        """
        if self.players > 1:
            raise ValueError(f"{self.path} has {self.players} players, and no task; `options` has what was played")
        return Task.from_json(self.header["task"], self.game)

    @property
    def switched_on(self) -> tuple[str, ...]:
        """The package's interventions that were switched on during the recording, without the task's own."""
        return switched_on({} if self.game.file else load(self.game), self._content.writes)

    @property
    def facts(self) -> dict[str, Any]:
        """The facts that videos and data sets made of the replay carry; see `video_facts`."""
        if self.players > 1:
            played = {"game": self.game.id, "players": self.players, "options": dict(self.header["options"])}
        else:
            played = {"task": json_text.parse(self.header["task"], f"the task of {self.path}")}
        changed = {"switched_on": list(self.switched_on)} if self.switched_on else {}
        return {**played, **changed, "core_seeds": list(self.seeds), "package": PACKAGE}

    def walk(self, core: Core) -> Walk:
        """Yield each event with an iterator that makes its calls on `core`; exhaust it before the next event.

        Raises:
            ValueError: an event is not possible on this core.
        """
        self._require_one_player("this core")
        runner = ReplayRunner(core, self._content, self._uses)
        try:
            for number in range(len(self._content.plays)):
                for event in self._events(number):
                    yield event, runner.run(event)
        finally:
            runner.release()

    def _require_one_player(self, what: str) -> None:
        if self.players > 1:
            raise ValueError(f"{self.path} has {self.players} players, and {what} is for one; use frames() or seek()")

    def _events(self, number: int) -> list[Event]:
        play = self._content.plays[number]
        try:
            return unpack(play.events)
        except ValueError as error:
            raise Corrupt(f"the replay is damaged at offset {play.offset}: {error}") from None

    def _new_runner(self, core: str, *, sound: bool) -> ReplayRunner:
        check_name("core", core, CORES)
        if self.players > 1:
            if core != "native":
                raise ValueError(f"a replay of several players runs on core 'native' only, got {core!r}")
            return PlayersRunner(make_core(self.header, self.game, self.rom, sound), self._content, self._uses)
        options = self.options
        if core == "ale" and self._content.snapshots:  # they need the sound setting of the recorded core
            sound = bool(snapshot.unpack(self._content.snapshots[0])[0].get("sound"))
        names = ("repeat_action_probability", "mode", "difficulty")
        made = CORES[core](
            self.game,
            max_num_frames_per_episode=options.get("max_num_frames_per_episode") or 0,
            sound=sound,
            rom=self.rom,
            interventions=resolve(self.game, options.get("interventions")),
            **{name: options[name] for name in names if name in options},
        )
        return ReplayRunner(made, self._content, self._uses)

    def _runner_at(self, core: str, *, sound: bool, start: int) -> tuple[ReplayRunner, Iterator[Call]]:
        runner = self._new_runner(core, sound=sound)
        checkpoints = self._checkpoints.setdefault((core, sound), [])
        known = [checkpoint for checkpoint in checkpoints if checkpoint.frame <= start]
        if known:
            runner.resume(known[-1])
        return runner, self._run_chunks(runner, checkpoints)

    def _run_chunks(self, runner: ReplayRunner, checkpoints: list[Checkpoint]) -> Iterator[Call]:
        for number in range(runner.chunk, len(self._content.plays)):
            known = checkpoints[-1].chunk if checkpoints else 0
            # Restoring ale-py's snapshot plays the game again from its start, so a checkpoint saves no time.
            if number % _CHUNKS_PER_CHECKPOINT == 0 and number > known and runner.core.name != "ale":
                checkpoints.append(runner.checkpoint())
            for event in self._events(number):
                yield from runner.run(event)
            runner.chunk += 1

    def _calls(self, core: str, *, sound: bool, start: int = 0) -> Iterator[tuple[ReplayRunner, Call]]:
        runner, calls = self._runner_at(core, sound=sound, start=start)
        try:
            for call in calls:
                yield runner, call
        finally:
            runner.core.close()

    def _play_for_episodes(self) -> list[dict[str, Any]]:
        runner, calls = self._runner_at("native", sound=False, start=0)
        deque(calls, maxlen=0)
        runner.end_episode()
        return runner.episodes
