"""The differential test: two cores play the same game, and their states are compared after every frame.

ale-py is the oracle of the native core, and the reference core is the oracle of the fast paths: a difference is a bug
of our emulator. Compared are RAM, framebuffer, sound, reward, lives, end of game, truncation and both frame counters.
A difference can be written to a file, from which `read` and `verify` replay it.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np

from atari.base import durable, json_text
from atari.base.typed_table import check_table
from atari.base.validation import check_name
from atari.cores import CORES, ByteArray, Core
from atari.games.actions import PLAYER_ACTIONS
from atari.games.catalog import games

_ARRAYS = ("ram", "screen", "audio")
_NUMBERS = ("lives", "game_over", "truncated", "frame_number", "episode_frame_number")


@dataclass(frozen=True)
class VerificationRun:
    """One run of the test: a game, how it is played, and the two cores.

    Actions are drawn from `seed`: mostly minimal actions, sometimes any of the 18, each held for up to 11 frames. With
    `pokes`, RAM bytes are overwritten at random, with `strengths` paddles move by fractions.
    """

    game: str
    frames: int = 600
    seed: int = 0
    repeat_action_probability: float = 0.25
    mode: int | None = None
    difficulty: int | None = None
    max_num_frames_per_episode: int = 0
    pokes: bool = False
    strengths: bool = False
    cores: tuple[str, str] = ("native", "ale")

    def make(self, core: str) -> Core:
        """A core of this kind, at the start of a game."""
        made = CORES[core](
            self.game,
            seed=self.seed,
            repeat_action_probability=self.repeat_action_probability,
            mode=self.mode,
            difficulty=self.difficulty,
            max_num_frames_per_episode=self.max_num_frames_per_episode,
            sound=True,
        )
        made.reset()
        return made

    def steps(self) -> Iterator["Step"]:
        """The action of each frame, and the RAM bytes to overwrite."""
        generator = np.random.default_rng(self.seed)
        minimal = [int(action) for action in games.resolve(self.game).minimal_actions]
        action, strength, left = 0, 1.0, 0
        for _ in range(self.frames):
            if not left:
                choices = minimal if generator.random() < 0.9 else range(len(PLAYER_ACTIONS))
                action, left = int(generator.choice(choices)), int(generator.integers(1, 12))
                strength = float(generator.random()) if self.strengths else 1.0
            left -= 1
            poke = None
            if self.pokes and generator.random() < 0.05:
                poke = int(generator.integers(128)), int(generator.integers(256))
            yield Step(action, strength, poke)


@dataclass(frozen=True)
class Step:
    """One frame: an action with its strength; before it, `poke` overwrites a byte of RAM (index, value)."""

    action: int
    strength: float = 1.0
    poke: tuple[int, int] | None = None

    def play(self, core: Core) -> int:
        """Start a new game if the last one has ended, then play the frame; returns the reward."""
        if core.game_over or core.truncated:
            core.reset()
        if self.poke is not None:
            core.set_ram(*self.poke)
        return core.act(self.action, self.strength)


@dataclass(frozen=True)
class Difference:
    """The first difference of two cores: the run, the frame (from 0; -1 is before the first), and the values."""

    run: VerificationRun
    frame: int
    what: tuple[str, ...] = field(default=())

    def __str__(self) -> str:
        first, second = self.run.cores
        return (
            f"{self.run.game}: {first} differs from {second} at frame {self.frame} (seed {self.run.seed}, "
            f"mode {self.run.mode}, difficulty {self.run.difficulty}): {'; '.join(self.what)}"
        )

    def write(self, folder: Path) -> Path:
        """Write a file from which `read` and `verify` replay the difference."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"difference-{self.run.game}-{self.run.seed}-{self.frame}.json"
        durable.write_file(path, (json.dumps(asdict(self), indent=1) + "\n").encode())
        return path


def read(path: Path) -> VerificationRun:
    """The run in a file that `Difference.write` wrote, up to the difference.

    Raises:
        ValueError: the file is no such file.
    """
    try:
        content = check_table(json_text.read(path), "it", {"run": dict, "frame": int, "what": list})
        kinds: dict[str, Any] = {one.name: type(one.default) for one in fields(VerificationRun) if one.name != "game"}
        kinds |= {"mode": int | None, "difficulty": int | None, "cores": list}
        options = check_table(content["run"], "its run", {"game": str}, kinds)
        cores = [check_name("a core", core, CORES) for core in options.get("cores", VerificationRun.cores)]
        return VerificationRun(**{**options, "cores": tuple(cores), "frames": content["frame"] + 1})
    except ValueError as error:
        raise ValueError(f"{path} is not a difference that `atari verify` wrote: {error}") from None


def verify(run: VerificationRun) -> Difference | None:
    """Play a run on both cores; the first difference, or None if there is none.

    Raises:
        ValueError: the game, mode or another option does not exist.
    """
    first, second = (run.make(core) for core in run.cores)
    try:
        what = _differences(first, second, 0, 0)
        if what:
            return Difference(run, -1, what)
        for frame, step in enumerate(run.steps()):
            what = _differences(first, second, step.play(first), step.play(second))
            if what:
                return Difference(run, frame, what)
        return None
    finally:
        first.close()
        second.close()


def _differences(first: Core, second: Core, reward: int, other_reward: int) -> tuple[str, ...]:
    """The values that differ, as text."""
    words = [] if reward == other_reward else [f"reward {reward} and {other_reward}"]
    for name in _NUMBERS:
        ours, theirs = getattr(first, name), getattr(second, name)
        if ours != theirs:
            words.append(f"{name} {ours} and {theirs}")
    for name in _ARRAYS:
        ours, theirs = getattr(first, name)(), getattr(second, name)()
        if not np.array_equal(ours, theirs):
            words.append(f"{name} {_differing_bytes(ours, theirs)}")
    return tuple(words)


def _differing_bytes(ours: ByteArray, theirs: ByteArray) -> str:
    """The number of differing bytes, and the first of them."""
    indices = np.argwhere(ours != theirs)
    first = tuple(int(index) for index in indices[0])
    where = first[0] if len(first) == 1 else first
    return f"in {len(indices)} bytes, first {where}: {ours[first]} and {theirs[first]}"
