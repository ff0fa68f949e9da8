"""`ObservedReplay`: the observations that an agent of a task sees in a recorded game.

`_emulator.Episode` plays the rules of the task, as it does in environments. Its core is a `Tape`, which plays the
recorded frames whatever actions it gets. The numbers that an environment drew (no-ops and frame skips) are read from
the recording, so the observations of a recorded environment's own task are that environment's, to the bit.
"""

from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from typing import Any, NamedTuple

import numpy as np

from atari.cores import Core
from atari.env.settings import make_episode
from atari.games.actions import Action
from atari.recording.replay.events import Event, Kind
from atari.recording.replay.runner import Call
from atari.task import Task

Walk = Generator[tuple[Event, Iterator[Call]], None, None]
"""The events of a replay, each with an iterator that makes its calls; see `Replay.walk`."""

JUMPS = (Kind.RESET, Kind.SEED, Kind.RESTORE, Kind.LOAD)
"""The events after which another game, or another part of one, is played."""

_OF_STEPS = (
    "frameskip", "action_delay", "noops", "fire", "fire_counts", "third_action", "fire_unit", "fire_again",
    "episodic_life", "lives_unit", "on_reset", "last_life", "seamless_lives", "max_frames", "max_episode_steps",
)  # fmt: skip
"""The fields that decide in which frames steps and episodes begin."""


class Observed(NamedTuple):
    """A step of a recorded game, as an agent of a task sees it.

    Attributes:
        observation: the observation before the step, as `atari.make` of the task returns it.
        begins: whether the stack of the observation begins here: in a new game, or in an episode after a lost life.
        action: the ALE action number of the step's last frame; in a continuous game (radius, angle, fire), float32.
        reward: the game's own reward since the last step.
        terminated, truncated: whether the game is over after the step, or has reached the emulator's limit of frames.
        episode: the number of the game in the recording.
        frame: the frames of the recording before the step.
    """

    observation: Any
    begins: bool
    action: Any
    reward: float
    terminated: bool
    truncated: bool
    episode: int
    frame: int


@dataclass(frozen=True)
class State:
    """A state between two steps of a recorded game.

    Attributes:
        observation, begins, episode, frame: see `Observed`.
        action: the action of the step that has led here, see `Observed`; None in the first state of a game.
        reward, terminated, truncated: the results of that step.
    """

    observation: Any
    begins: bool
    episode: int
    frame: int
    action: Any = None
    reward: float = 0.0
    terminated: bool = False
    truncated: bool = False


class ObservedReplay:
    """A replay that is played on a core, and observed by the rules of a task.

    If the recorded environment has the task's rules, the steps are the recorded steps. Otherwise an agent of the task
    watches the game: its first observation is the first frame, and a step is played in each frame skip; no-ops and FIRE
    are not pressed.

    Args:
        task: the task that decides the observations.
        recorded: the task of the recorded environment.
        core: a new core, on which the replay is played.
        walk: `Replay.walk` on this core.
        has_steps: whether the recording has the ends of steps.

    Raises:
        ValueError: the task has observations that a recording does not determine.
    """

    def __init__(self, task: Task, recorded: Task, core: Core, walk: Walk, has_steps: bool) -> None:
        self.own = has_steps and all(getattr(task, name) == getattr(recorded, name) for name in _OF_STEPS)
        """Whether the steps are the recorded steps."""
        check_observable(task, own=self.own)
        self.tape = Tape(core, walk)
        self._task = task
        self._draws = np.random.default_rng(0)
        self._episode = make_episode(task.replace(reward=None), stacked=task.stack_num is not None, draw=self._draw)
        self._number = -1

    def steps(self) -> Iterator[Observed]:
        """Yield the steps of all games."""
        for before, after in pairwise(self.states()):
            if before.episode == after.episode:
                done = after.reward, after.terminated, after.truncated
                yield Observed(before.observation, before.begins, after.action, *done, before.episode, before.frame)

    def states(self) -> Iterator[State]:
        """Yield the n + 1 states of each game of n steps; the core is in the state that was yielded.

        Where the game goes on after a lost life, the state is that after the reset.

        Raises:
            ValueError: an environment of the task would have played other frames than the recorded ones.
        """
        state, shown = None, True
        while self.tape.fetch(steps=self.own):
            if self.tape.jumps:
                if state is not None and not shown:
                    yield state
                state, shown = self._begin(), True
            while state is not None and self.tape.acts and not (state.terminated or state.truncated):
                try:
                    state = self._go_on(state)
                    yield state
                    shown = True
                    state, shown = self._step(), False
                except Cut:
                    if self.own:
                        raise self._other_frames() from None
                    break  # the recorded game ends within a step
                if self.own and self.tape.acts and not (state.terminated or state.truncated):
                    raise self._other_frames()
            self.tape.run_out()
        if state is not None and not shown:
            yield state

    def _begin(self) -> State:
        """Begin a game, or go on from a restored state, where the stack begins anew."""
        self._number += 1
        from_reset = self.tape.jump() == Kind.RESET
        beginning: dict[str, Any] = {} if self.own and from_reset else {"noops": 0, "fire": False}
        self._allot_reset()
        try:
            observation, _ = self._episode.reset(self.tape, lambda: self.tape, new_game=True, **beginning)
        except Cut:
            raise self._other_frames() from None
        return self._state(observation)

    def _go_on(self, state: State) -> State:
        """The state before the next step: after a lost life that of a reset in which the game goes on."""
        if not self._episode.ended:
            return state
        self._allot_reset()
        options: dict[str, Any] = {} if self.own else {"noops": 0, "fire": False}
        observation, _ = self._episode.reset(self.tape, self._same_game, **options)
        return replace(state, observation=observation, begins=True, frame=self.tape.frame)

    def _same_game(self) -> "Tape":
        if self.own:  # the recording has no new game here
            raise Cut
        return self.tape

    def _step(self) -> State:
        self.tape.allotted = None
        observation = self._episode.step(self.tape, 0)[0]
        over = self.tape.game_over, self.tape.truncated
        return self._state(observation, self.tape.action, self.tape.take_reward(), *over)

    def _state(self, observation: Any, *step: Any) -> State:
        return State(observation, not step, self._number, self.tape.frame, *step)

    def _allot_reset(self) -> None:
        """Leave the frames of the recorded step to the step that follows a reset."""
        if self.own:
            skip, step = self._task.frameskip, self.tape.acts_of_last_event
            if self._task.action_delay and isinstance(skip, int):  # the step may have two events
                step = min(self.tape.acts, skip)
            self.tape.allotted = self.tape.acts - step

    def _draw(self, low: int, high: int) -> int:
        """A number within low..high-1, which the recorded environment has drawn from its generators."""
        if not self.own:
            return int(self._draws.integers(low, high))
        task, tape = self._task, self.tape
        skips, noops = (low, high) == task.frameskip, (low, high - 1) == task.noops
        if tape.allotted is None:  # in a step
            number = tape.acts
        elif noops and not (skips and tape.presses):
            number = tape.noops + (task.fire_counts and Action.FIRE in task.begin_actions)
        else:
            number = tape.acts_of_event if skips else low
        return min(max(number, low), high - 1)

    def _other_frames(self) -> ValueError:
        return ValueError(
            f"{self._task!r} plays other frames than those recorded before frame {self.tape.frame}: was this "
            "environment stepped after the end of an episode without a reset, in wrappers of its own, or its state set "
            'from outside? Observe the replay with another task, or write its screens (observations="screen")'
        )


def check_observable(task: Task, *, own: bool) -> None:
    """Refuse a task whose observations no recorded frames determine.

    Raises:
        ValueError: the task has sound, several players, or a delay of observations that the environment drew.
    """
    if task.sound_obs:
        raise ValueError("sound_obs=True adds sound to observations, and a replay gives images and RAM; leave it out")
    if task.players > 1:
        raise ValueError(f"a replay is observed by one player, and the task has players={task.players}")
    if own and isinstance(task.observation_delay, tuple) and len({*task.observation_delay}) > 1:
        raise ValueError(
            f"observation_delay={task.observation_delay} was drawn in each game, and the replay does not have the "
            'number; give one number, or write the screens (observations="screen")'
        )


class Cut(Exception):
    """A step or a reset needs a frame that the recording does not have there."""


class Tape:
    """A core that plays the frames of a replay, whatever actions it gets.

    It has fetched the events of a step, or of a game, and plays them one frame at a call of `act`.

    Args:
        core: the core that plays.
        walk: the events, see `Replay.walk`.

    Attributes:
        allotted: the number of frames that may be played before `Cut` is raised; None is all that were fetched.
        acts: the fetched frames that are left.
        frame: the frames played so far.
        action: the last ALE action number, or the last continuous action.
    """

    def __init__(self, core: Core, walk: Walk) -> None:
        self.core = core
        self.allotted: int | None = None
        self.acts = 0
        self.frame = 0
        self.action: Any = None
        self._walk = walk
        self._ahead: tuple[Event, Iterator[Call]] | None = None
        self._fetched: deque[list[Any]] = deque()  # an event, its calls, and its frames that are left
        self._continuous: Any = None
        self._reward = 0.0

    def fetch(self, *, steps: bool) -> bool:
        """Fetch the events up to the end of a step, or those of a game. Returns whether any frame is among them."""
        self.run_out()
        while True:
            pair = self._ahead or next(self._walk, None)
            self._ahead = None
            if pair is None:
                return bool(self.acts) and not steps
            event, calls = pair
            if not steps and event.kind in JUMPS and self.acts:
                self._ahead = pair
                return True
            frames = event.numbers[1] if event.kind == Kind.ACT else 0
            self._fetched.append([event, calls, frames])
            self.acts += frames
            if steps and (event.ends_step or event.kind == Kind.STEP):
                return True

    @property
    def jumps(self) -> bool:
        """Whether a fetched event begins another game, or another part of one."""
        return any(event.kind in JUMPS for event, *_ in self._fetched)

    def jump(self) -> Kind:
        """Play up to the last such event, which `Kind` is returned of, without observing the frames before it."""
        kind = Kind.SEED
        while self.jumps:
            kind = self._fetched[0][0].kind
            self._run(None)
        self._reward = 0.0
        return kind

    @property
    def acts_of_event(self) -> int:
        """The frames of the next event with frames."""
        return next((left for *_, left in self._fetched if left), 0)

    @property
    def acts_of_last_event(self) -> int:
        """The frames of the last event with frames."""
        return next((left for *_, left in reversed(self._fetched) if left), 0)

    @property
    def presses(self) -> bool:
        """Whether the next frame that may be played has an action other than NOOP."""
        return bool(self.allotted) and next(event.numbers[0] for event, _, left in self._fetched if left) != Action.NOOP

    @property
    def noops(self) -> int:
        """The frames of NOOP among those that may be played."""
        left, found = self.allotted or 0, 0
        for event, _, frames in self._fetched:
            played = min(frames, left)
            left -= played
            found += played if played and event.numbers[0] == Action.NOOP else 0
        return found

    def run_out(self) -> None:
        """Play what is left of the fetched events."""
        while self._fetched:
            self._run(None)

    def take_reward(self) -> float:
        """The sum of the rewards since the last call or jump."""
        reward, self._reward = self._reward, 0.0
        return reward

    def act(self, action: int, strength: float) -> int:
        """Play the next frame, and return its reward.

        Raises:
            Cut: there is none.
        """
        if self.allotted == 0 or not self.acts:
            raise Cut
        if self.allotted is not None:
            self.allotted -= 1
        while not self._fetched[0][2]:
            self._run(None)
        return self._run(1)

    def _run(self, frames: int | None) -> int:
        """Play some frames of the first fetched event, or all of it."""
        entry = self._fetched[0]
        event, calls, left = entry
        reward = 0
        for call in islice(calls, frames):
            self.frame += call.played
            reward += call.reward
        if event.kind == Kind.CONTINUOUS_ACTION:
            self._continuous = np.array(event.floats, np.float32)
        elif event.kind == Kind.ACT:
            self.action = event.numbers[0] if self._continuous is None else self._continuous
        entry[2] = 0 if frames is None else left - frames
        self.acts -= left - entry[2]
        if not entry[2]:
            self._fetched.popleft()
        self._reward += reward
        return reward

    def close(self) -> None:
        """End the replay, and close the core."""
        self._walk.close()
        self.core.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.core, name)
