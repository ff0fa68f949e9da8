"""`Inspection`: all actions of a user of the inspector, without a page."""

import copy
import logging
from dataclasses import dataclass
from typing import Any, Protocol

import gymnasium
import numpy as np

from atari.base.json_text import escaped
from atari.base.validation import check_action, check_integer, check_name
from atari.cores import ByteArray, Core
from atari.cores.writes import make_writes
from atari.env import AtariEnv
from atari.games.actions import Action, nearest_action
from atari.games.interventions import load
from atari.lab.inspector.readings import Readings, ahead, causes_of, changed_pixels
from atari.lab.inspector.timeline import NEW_GAME, Timeline
from atari.lab.search import Search

_log = logging.getLogger(__name__)

FRAMES_PER_SECOND = 60
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 16.0)
HISTORY = 240
"""Frames of a byte's history that the page shows: four seconds."""
_ROUNDING = 1e-6
_MOST_LAG = 0.25  # seconds; after a longer delay the lost time is dropped
_GAME_OVER = "the game is over; begin a new one (R), or go back in time"
_PAUSED = "the game is paused; Play (P) goes on"


FILTERS = {
    "changed": 0, "unchanged": 0, "increased": 0, "decreased": 0, "equals": 1, "between": 2, "bcd": 1, "correlates": 0
}  # fmt: skip
"""The filters of the search, methods of `atari.lab.Search`, and the number of arguments of each."""


class Agent(Protocol):
    """A player of an inspection, instead of a person."""

    name: str

    def begin(self, core: Core) -> None:
        """A game begins, or goes on from another state."""

    def act(self, core: Core) -> int:
        """The ALE action number of the next frame."""


@dataclass
class Change:
    """A change of RAM by the user: a poke, or a byte that is frozen (`new`) or released (`new` is None)."""

    frame: int
    index: int
    old: int | None
    new: int | None
    kind: str
    game_frame: int = 0
    """Frames since the game began."""


@dataclass
class Switch:
    """An intervention that the user has switched on or off."""

    frame: int
    name: str
    on: bool
    kind: str = "intervention"


class _ActiveCore:
    """The core that is shown, the main one or the fork's, for `Search`."""

    def __init__(self, inspection: "Inspection") -> None:
        self._inspection = inspection
        self.game = inspection.game

    def ram(self) -> ByteArray:
        return self._inspection.ram()

    def set_ram(self, index: int, value: int) -> None:
        self._inspection.poke(index, value)


class Inspection:
    """A game that is played, looked into and changed.

    Frames are played one at a time, without a frame skip. While a fork is open, each frame is played in both timelines,
    and changes go to the fork.

    Args:
        env: an `AtariEnv` in any wrappers. The inspection plays its core directly; the wrappers do not see it.
        agent: plays instead of a person.
        seed: seed of the first game, if the environment was not reset before.

    Raises:
        TypeError: `env` is no `AtariEnv`.
        ValueError: its core is ale-py's.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], *, agent: Agent | None = None, seed: int | None = None) -> None:
        atari = env.unwrapped
        if not isinstance(atari, AtariEnv):
            raise TypeError(f"the inspector shows an atari.AtariEnv, got {type(atari).__name__}")
        if atari.core.name == "ale":
            raise ValueError("the inspector goes back in time, which ale-py's core cannot exactly; use core='native'")
        if atari.driver.phase == "new":
            atari.reset(seed=seed)
        self.env = atari
        self.game = atari.game
        self.agent = agent
        self.main = Timeline(atari.core)
        self.fork: Timeline | None = None
        self.playing = False
        self.by_agent = agent is not None
        self.speed = 1.0
        self.action = Action.NOOP
        self.watched: list[int] = []
        self.selected: int | None = None
        self.names: dict[int, str] = {}
        """Names that the user has given to bytes."""
        own = {one.name for one in atari.interventions}
        known = {} if atari.game.file else load(atari.game)
        self.interventions = {name: one for name, one in known.items() if name not in own}
        """The package's interventions for the game that the task does not have; they can be switched on."""
        self.changes: list[Change | Switch] = []
        """The changes that can be undone."""
        self.new_search()
        self.readings = Readings(self.game)
        self.version = 0
        """The number of frames that were played and commands that `protocol.run` has run."""
        self.notice = self.error = ""
        """Texts that the page has not shown yet."""
        self._debt = 0.0
        self._agent_is_new = True
        self._changes_of_main = 0
        """While there is a fork, the number of changes before it."""

    @property
    def active(self) -> Timeline:
        """The timeline that changes go to: the fork, or the main one."""
        return self.fork or self.main

    @property
    def frozen(self) -> dict[int, int]:
        """The bytes that are held in the shown timeline, and their values."""
        return self.active.frozen

    @property
    def at(self) -> int:
        """The present frame."""
        return self.main.at

    @property
    def over(self) -> bool:
        """Whether the game has ended."""
        return self.main.core.game_over or self.main.core.truncated

    def ram(self) -> ByteArray:
        """The RAM that is shown, (128,) uint8."""
        return self.active.core.ram()

    def screen(self, timeline: Timeline) -> tuple[ByteArray, bool]:
        """The screen, (height, 160) palette indices, and whether it is a preview.

        If RAM was changed after the newest frame, the screen is the next frame's, without input.
        """
        if timeline.pending and timeline.at == timeline.end:
            return ahead(timeline.core), True
        return timeline.core.screen(), False

    # --- playing

    def tick(self, seconds: float) -> None:
        """Play the frames of some seconds, at the speed of the inspection. An error pauses it; see `fail`."""
        if not self.playing:
            self._debt = 0.0
            return
        self._debt += min(seconds, _MOST_LAG) * FRAMES_PER_SECOND * self.speed
        while self._debt >= 1 - _ROUNDING and self.playing:
            self._debt -= 1
            try:
                self._play_frame()
            except Exception as error:  # also an agent's, which is the user's code
                self.fail(error)

    def fail(self, error: Exception) -> None:
        """Pause, show an error on the page, and log it."""
        self.pause()
        self._debt = 0.0
        expected = isinstance(error, (OSError, RuntimeError, TypeError, ValueError))
        self.error = f"frame {self.at}: {error if expected else repr(error)}"
        _log.error("atari lab, %s", escaped(self.error).replace("\n", " "))

    def play(self) -> None:
        """Play on: the recorded frames after the present one, then new frames."""
        if self.over and self.at == self.main.end and not self.by_agent:
            raise ValueError(_GAME_OVER)
        self.playing = True

    def pause(self) -> None:
        """Pause."""
        self.playing = False
        self.action = Action.NOOP

    def step(self, frames: int = 1) -> None:
        """Pause, and play frames, or go back if negative."""
        frames = check_integer("frames", frames, -3600, 3600)
        self.pause()
        if frames < 0:
            self.seek(self.at + frames)
        for _ in range(frames):
            self._play_frame(single=True)

    def seek(self, frame: int) -> None:
        """Return to a frame, or to the nearest one that is kept."""
        frame = check_integer("frame", frame, 0, 2**31 - 1)
        self.main.seek(frame)
        if self.fork is not None:
            self.fork.seek(max(frame, self.fork.first))
            self.main.seek(self.fork.at)
        self._moved()

    def take_over(self) -> None:
        """Drop the recorded frames after the present one."""
        for timeline in self._timelines():
            timeline.cut()
        self._moved()

    def new_game(self) -> None:
        """Begin a new game."""
        for timeline in self._timelines():
            timeline.play_new(NEW_GAME)
        self._moved()

    def set_speed(self, speed: float) -> None:
        """Set the speed, as a multiple of the console's.

        Raises:
            ValueError: `speed` is not one of `SPEEDS`.
        """
        if isinstance(speed, bool) or speed not in SPEEDS:
            raise ValueError(f"speed is one of {', '.join(map(str, SPEEDS))}, got {speed!r}")
        self.speed = float(speed)

    def hold(self, vertical: int, horizontal: int, fire: bool) -> None:
        """Set the position of the stick: 1 is up and right. An illegal position becomes the nearest legal one.

        The first press drops the recorded frames after the present one. A press plays no frame of a paused game; the
        page says so.
        """
        vertical = check_integer("vertical", vertical, -1, 1)
        horizontal = check_integer("horizontal", horizontal, -1, 1)
        self.action = nearest_action(vertical, horizontal, bool(fire), self.game.legal_actions) or Action.NOOP
        if self.action != Action.NOOP:
            dropped = self.main.end - self.main.at
            if dropped:
                self.take_over()
            self.by_agent = False
            if not self.playing:
                self.notice = _GAME_OVER if self.over else _PAUSED
                self.notice += f"; the {dropped} frames recorded after this one were dropped" if dropped else ""

    def let_agent_play(self, on: bool) -> None:
        """Let the agent play, or the keyboard.

        Raises:
            ValueError: there is no agent.
        """
        if on and self.agent is None:
            raise ValueError("there is no agent; start with `atari lab GAME --agent MODULE:NAME`")
        self.by_agent = bool(on)
        self._agent_is_new = True

    # --- changing RAM

    def poke(self, index: int, value: int) -> None:
        """Write a byte now."""
        index, value = self._byte(index), check_integer("value", value, 0, 255)
        timeline = self.active
        old, since = int(timeline.core.ram()[index]), timeline.frames_of_game()
        if index in timeline.frozen:
            timeline.freeze({**timeline.frozen, index: value})
        self.changes.append(Change(timeline.at, index, old, value, "poke", since))
        timeline.write(index, value)

    def freeze(self, index: int, value: int | None = None) -> None:
        """Hold a byte at a value, by default its present one, at every emulated frame.

        Raises:
            ValueError, RuntimeError: the byte cannot be held; see `atari.lab.Freeze`.
        """
        index = self._byte(index)
        timeline = self.active
        value = int(timeline.core.ram()[index]) if value is None else check_integer("value", value, 0, 255)
        held = timeline.frozen.get(index)
        timeline.freeze({**timeline.frozen, index: value})
        self.changes.append(Change(timeline.at, index, held, value, "freeze"))
        timeline.write(index, value)

    def release(self, index: int) -> None:
        """Hold a byte no longer."""
        index = self._byte(index)
        timeline = self.active
        if index in timeline.frozen:
            timeline.cut()
            self.changes.append(Change(self.at, index, timeline.frozen[index], None, "freeze"))
            timeline.freeze({other: held for other, held in timeline.frozen.items() if other != index})

    def intervene(self, name: str, on: bool = True) -> None:
        """Switch one of `interventions` on or off, from the present frame on.

        Raises:
            ValueError: the game has no such intervention, or the core has no room for its writes.
        """
        check_name("intervention", name, self.interventions)
        if on != (name in self.active.added):
            self._switch(name, on)
            self.changes.append(Switch(self.active.at, name, on))

    def _switch(self, name: str, on: bool) -> None:
        added = {other: writes for other, writes in self.active.added.items() if other != name}
        if on:
            added[name] = tuple(make_writes(self.game, [self.interventions[name]]))
        self.active.intervene(added)

    def undo(self) -> None:
        """Undo the last change: a poke is taken back, or its old value is written if frames were played since."""
        if not self.changes:
            raise ValueError("there is no change of RAM to undo")
        change, timeline = self.changes.pop(), self.active
        if isinstance(change, Switch):
            self._switch(change.name, not change.on)
            return
        if change.kind == "freeze":
            held = {**timeline.frozen, change.index: change.old}
            timeline.freeze({index: value for index, value in held.items() if value is not None})
        if timeline.at == timeline.end == change.frame and change.index in timeline.pending:
            timeline.forget_write(change.index)
            if change.kind == "poke" and int(timeline.core.ram()[change.index]) != change.old:
                timeline.write(change.index, change.old or 0)
            self.notice = f"byte {change.index} is as it was"
        elif change.kind == "poke":
            timeline.write(change.index, change.old or 0)
            self.notice = f"frames were played since; {change.old} was written back into byte {change.index}"

    def name(self, index: int, name: str) -> None:
        """Name a byte; an empty name removes it.

        Raises:
            ValueError: `name` is no valid name of a label, or another byte has it.
        """
        index = self._byte(index)
        if not isinstance(name, str) or len(name) > 40 or (name and not name.isidentifier()) or not name.isascii():
            raise ValueError("a name has letters, digits and underscores, begins with no digit, and at most 40 of them")
        taken = {label: at for at, labels in self.readings.names.items() for label in labels}
        taken |= {given: at for at, given in self.names.items()}
        if name and taken.get(name, index) != index:
            raise ValueError(f"{name} is the name of byte {taken[name]}")
        self.names.pop(index, None)
        if name:
            self.names[index] = name

    def copied_env(self) -> AtariEnv:
        """A copy of the environment, without the held bytes and added interventions, which each `FrameInput` has."""
        env = copy.deepcopy(self.env)
        if hasattr(env.core, "writes"):
            env.core.writes = self.main.own_slots
        return env

    # --- forks

    def open_fork(self) -> None:
        """Fork the present state: from here, each frame is played twice, and changes go to the fork."""
        if self.fork is not None:
            raise ValueError("there is a fork already; close it first")
        twin = self.copied_env()
        twin.core.restore_state(self.main.core.clone_state(include_rng=True))
        self.main.cut()
        self.fork = Timeline(twin.core, self.main.at, self.main.score)
        self.fork.intervene(self.main.added)
        self.fork.freeze(self.main.frozen)
        self._changes_of_main = len(self.changes)

    def close_fork(self, keep: bool = False) -> None:
        """Close the fork, and go on with it (`keep`) or with the main timeline."""
        fork, self.fork = self.fork, None
        if fork is None:
            return
        if keep:
            self.main.seek(fork.first)
            self.main.cut()
            for frame in fork.frames(fork.first, fork.at):
                self.main.play(frame)
            self.main.intervene(fork.added)
            self.main.freeze(fork.frozen)
            for index, value in fork.pending.items():
                self.main.write(index, value)
        else:
            del self.changes[self._changes_of_main :]
        fork.core.close()
        self._moved()

    # --- looking

    def select(self, index: int | None) -> None:
        """Choose the byte whose history is shown."""
        self.selected = None if index is None else self._byte(index)

    def watch(self, index: int, on: bool = True) -> None:
        """Put a byte on the watch list, or take it off."""
        index = self._byte(index)
        if on and index not in self.watched:
            if len(self.watched) == 16:
                raise ValueError("the watch list has 16 bytes; take one off first")
            self.watched.append(index)
        elif not on and index in self.watched:
            self.watched.remove(index)

    def new_search(self) -> None:
        """Begin a search over all bytes."""
        self.search = Search(_ActiveCore(self))
        self.search_scores = [self.active.score]
        """The score at the start of the search and at each filter."""
        self.searched = self.ram()
        """The RAM at the last filter."""

    def filter(self, name: str, low: int = 0, high: int = 0) -> None:
        """Narrow the search down by a method of `atari.lab.Search`; `low` and `high` are its numbers.

        Raises:
            ValueError: there is no such filter, or a number is out of range.
        """
        count = FILTERS[check_name("filter", name, FILTERS)]
        numbers = (check_integer("the number", low, 0, 99_999_999), check_integer("the second number", high, 0, 255))
        if name == "correlates":  # this RAM and score are part of the history that is compared
            scores = [*self.search_scores, self.active.score]
            if len(set(scores)) < 2:
                raise ValueError("the score has not changed since the search began; play on until it has")
            self.search.keep().correlates(scores)
            self.search_scores = scores
        else:
            getattr(self.search, name)(*numbers[:count])
        self.search_scores.append(self.active.score)
        self.searched = self.ram()

    def undo_filter(self) -> None:
        """Take the last filter back.

        Raises:
            ValueError: there is no filter.
        """
        self.search.undo()
        del self.search_scores[len(self.search.history) :]

    def pixels_of(self, index: int) -> tuple[np.ndarray[Any, Any], str]:
        """The pixels that a byte causes, (height, 160) bool, and their source.

        The source is "state", the present state; or "map", the causal map, if the byte causes no pixels in this state.
        """
        index = self._byte(index)
        pixels = changed_pixels(self.active.core, index)
        if pixels.any() or self.readings.causes is None:
            return pixels, "state"
        return self.readings.causes.bytes[index].pixels, "map"

    def bytes_of(self, x: int, y: int) -> tuple[list[int], list[int]]:
        """The bytes that cause a pixel of the present state, and further bytes for other states, by the causal map."""
        height, width = self.game.screen.shape
        x, y = check_integer("x", x, 0, width - 1), check_integer("y", y, 0, height - 1)
        found = causes_of(self.active.core, x, y)
        known = [] if self.readings.causes is None else self.readings.causes.pixel(x, y)
        return found, [index for index in known if index not in found]

    # ---

    def _timelines(self) -> tuple[Timeline, ...]:
        return (self.main,) if self.fork is None else (self.main, self.fork)

    def _play_frame(self, single: bool = False) -> None:
        """Play the next frame in all timelines, or pause at the end of the game."""
        self.version += 1
        if self.main.at < self.main.end:
            for timeline in self._timelines():
                timeline.play_again()
            self._agent_is_new = True
            return
        if self.over:
            if self.by_agent and not single:
                self.new_game()
                return
            self.pause()
            self.notice = _GAME_OVER
            return
        action = self._ask_agent(self.agent) if self.by_agent and self.agent is not None else int(self.action)
        for timeline in self._timelines():
            timeline.play_new(action)

    def _ask_agent(self, agent: Agent) -> int:
        try:
            if self._agent_is_new:
                agent.begin(self.main.core)
                self._agent_is_new = False
            return check_action(agent.act(self.main.core))
        except Exception as error:
            raise RuntimeError(f"the agent {agent.name} has failed: {error!r}") from error

    def _moved(self) -> None:
        self._agent_is_new = True
        self._debt = 0.0

    def _byte(self, index: int) -> int:
        """The index of a place in RAM: an index 0..127, or an address 0x80..0xFF."""
        return check_integer("a byte", index, 0, 255) & 127
