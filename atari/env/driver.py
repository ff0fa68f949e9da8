"""`Driver`: plays the frames of an `AtariEnv`, for the environment itself and for wrappers around it.

A wrapper that plays frames uses `env.unwrapped.driver`: `step` would make an observation each time.
"""

import operator
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, Literal, Protocol

import gymnasium
import numpy as np
from gymnasium import logger

import atari._emulator as _emulator
from atari.base.validation import check_action_index
from atari.cores import CORES, ByteArray, Core, NativeCore
from atari.cores.ale_game import AleGame
from atari.cores.ale_interface import AleSettings
from atari.cores.ale_random import AleRandom
from atari.games.actions import Action, in_continuous_space, joystick_action
from atari.task import Task

Phase = Literal["new", "playing", "over", "warned"]
"""Before the first reset; in an episode; after its end; after a step with the warning about that end."""


_INDICES = frozenset((int, np.int64))


class FrameObserver(Protocol):
    """Receives every emulated frame, those inside a frame skip too; see `Driver.observers`."""

    def game_begun(self) -> None:
        """The emulator was reset."""

    def frame_played(self, action: int, reward: int) -> None:
        """The core has played a frame with this ALE action. Must not raise."""


@dataclass(slots=True)
class Played:
    """The score and the counters of a game since the emulator's reset."""

    score: float = 0.0
    steps: int = 0  # counted by wrappers that play several frames a step
    first_frame: int = 0  # the episode frame number after the reset
    began: float = field(default_factory=time.perf_counter)
    rewards: int = 0  # the number of rewards other than zero; a restored snapshot starts it again

    def statistics(self, core: Core) -> dict[str, Any]:
        """The sum of the rewards, the frames and the seconds of the game, as `RecordEpisodeStatistics` names them."""
        seconds = round(time.perf_counter() - self.began, 6)
        return {"r": self.score, "l": core.episode_frame_number - self.first_frame, "t": seconds}


class Driver(AleGame):
    """The core of an `AtariEnv`, its generators, and the record of the game since the reset.

    Attributes:
        phase: the state of the episode.
        played: the score and the counters of the game.
        ended: the statistics of a game that has ended, until a wrapper takes them and sets None.
        restored: whether a state was restored since the last reset; wrappers with a state of their own warn then.
        replacement: an ALE action that `ale_action` returns in place of every action; None has no effect.
        np_random: the generator of episodes. If `ale_random` is set, it replaces this one.
        convert: a function of the ALE action and the strength of a frame, which returns those that the console gets in
            their place; None has no effect. A wrapper sets it for the time of its `step`.
        delayed: what observations are made of in place of `core`, with methods of the same names; None has no effect.
            A wrapper sets it for the time of its `step`.
        observers: the receivers of every frame, such as recorders. An observer may read the core, but not change it.
            Copies of the environment have no observers.

    Example:
        >>> import atari
        >>> env = atari.make("pong", obs_type="ram")
        >>> observation, info = env.reset(seed=0)
        >>> driver = env.unwrapped.driver
        >>> driver.play_frames(*driver.ale_action(2), frames=60)
        0.0
        >>> driver.info()["episode_frame_number"]
        60
    """

    def __init__(self, task: Task, core: str, rom: str | PathLike[str] | None) -> None:
        settings = AleSettings(
            repeat_action_probability=task.repeat_action_probability,
            max_num_frames_per_episode=task.max_num_frames_per_episode or 0,
            sound_obs=task.sound_obs,
        )
        self.ale_random: AleRandom | None = None
        self.ale_settings = settings
        self.seed_game()
        super().__init__(
            CORES[core],
            task.definition,
            settings,
            mode=task.set_mode,
            difficulty=task.set_difficulty,
            rom=rom,
            interventions=task.interventions,
        )
        self._task = task
        self.actions = task.action_set
        self._threshold = np.float32(task.continuous_action_threshold)
        self.phase: Phase = "new"
        self.played = Played()
        self.ended: dict[str, Any] | None = None
        self.restored = False
        self.replacement: Action | None = None
        self.convert: Callable[[int, float], tuple[int, float]] | None = None
        self.delayed: Any = None
        self.observers: list[FrameObserver] = []

    @property
    def actions(self) -> tuple[Action, ...]:
        """The actions of the environment's action space, by index."""
        return self._actions

    @actions.setter
    def actions(self, actions: tuple[Action, ...]) -> None:
        self._actions = actions
        self._numbers = tuple(map(int, actions))

    @property
    def observed(self) -> Core:
        """The object that observations read: the core, or one with its methods for screen, RAM and sound."""
        return self.core if self.delayed is None else self.delayed

    @property
    def plays_several(self) -> bool:
        """Whether several frames may be played by one call of the core."""
        return not self.observers and self.convert is None and self.delayed is None

    def seed_game(self, seed: int | None = None) -> tuple[np.uint32, np.uint32]:
        """Seed the generators, and the core from the next `load_game` on; None draws a new seed.

        Returns:
            The two words drawn from the seed: for `np_random`, and for the emulator.

        Raises:
            TypeError, ValueError: the seed is no integer of 0 or more.
        """
        words = np.random.SeedSequence(seed).generate_state(2)
        if self.ale_random is not None:
            words[1] = self.ale_random.seed(seed)
        self.np_random = np.random.Generator(np.random.PCG64(np.random.SeedSequence(int(words[0]))))
        self.ale_settings.set_seed(int(words[1]))
        return words[0], words[1]

    def draw(self, low: int, high: int) -> int:
        """A number within low..high-1 from the generator of episodes, which draws no-ops and frame skips."""
        low, high = operator.index(low), operator.index(high)
        if self.ale_random is None:
            return int(self.np_random.integers(low, high))
        return low + self.ale_random.below(high - low)

    def reset(self) -> None:
        """Begin a new game."""
        self.core.reset()
        self.game_was_reset()
        self.restored = False
        for observer in self.observers:
            observer.game_begun()

    def game_was_reset(self) -> None:
        """Begin the record of a new game: the emulator was reset, by `reset` or by `reset_game` of `ale`."""
        self.phase = "playing"
        self.played = Played(first_frame=self.emulated.episode_frame_number)

    def play_frames(self, action: int, strength: float = 1.0, *, frames: int) -> float:
        """Play frames with an ALE action number and return the reward.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            TypeError, ValueError: no ALE action (0..17), or a strength that is not finite.
        """
        if self.phase != "playing":
            self.check_phase()
        act = self.core.act if self.plays_several else self._act_frame
        reward = 0.0
        for _ in range(frames):
            reward += act(action, strength)
        self._count(reward)
        return reward

    def play_step(
        self, action: int, strength: float, pixels: _emulator.PixelFormat, *, frames: int
    ) -> tuple[ByteArray, float, bool, bool, dict[str, Any]]:
        """Play frames by one call of a native core, and return the results of `AtariEnv.step`.

        The caller makes sure that the core is an `Emulator`, and that `plays_several` is true.

        Raises:
            gymnasium.error.ResetNeeded, TypeError, ValueError: see `play_frames`.
        """
        if self.phase != "playing":
            self.check_phase()
        core: Any = self.core
        results: tuple[ByteArray, float, bool, bool, dict[str, Any]] = core.step(action, frames, strength, pixels)
        if results[1] or results[2] or results[3]:
            self._count(results[1])
        return results

    def play_until(self, action: int, strength: float = 1.0, *, frames: int) -> tuple[float, int]:
        """Play up to `frames` frames, and return the reward and the number of frames.

        The last one ends the game, changes the number of lives, or is the last of `frames`. Where `plays_several` is
        false, and with cores that play only single frames, the method plays one frame. Wrappers that read only some of
        the frames (`atari.wrappers.DqnPreprocessing`) call this method.

        Raises:
            gymnasium.error.ResetNeeded, TypeError, ValueError: see `play_frames`.
        """
        if self.phase != "playing":
            self.check_phase()
        core = self.core
        if not self.plays_several or not isinstance(core, NativeCore):
            return self.play_frames(action, strength, frames=1), 1
        reward, played = core.act_until(action, frames, strength)
        self._count(reward)
        return float(reward), played

    def ale_action(self, action: Any) -> tuple[int, float]:
        """The ALE action number and the strength of an action of the environment's action space.

        Raises:
            TypeError, ValueError: the action is not in the action space.
        """
        if self.replacement is not None:
            return int(self.replacement), 1.0
        if self._task.continuous:
            return self._continuous_action(action)
        if type(action) not in _INDICES or not 0 <= action < len(self._numbers):  # the check takes longer than this
            action = check_action_index(action, len(self._numbers), self.game.id)
        return self._numbers[action], 1.0

    def info(self) -> dict[str, int]:
        """The counters that `step` and `reset` return."""
        core = self.core
        return {
            "lives": core.lives,
            "episode_frame_number": core.episode_frame_number,
            "frame_number": core.frame_number,
        }

    def restore_state(self, state: Any) -> None:
        """Continue from a state of `core.clone_state`.

        Raises:
            TypeError, ValueError: it is no such state, or belongs to another game or kind of core.
        """
        self.core.restore_state(state)
        self.phase = "playing"
        self.restored = True

    def _count(self, reward: float) -> None:
        if reward:
            self.played.score += reward
            self.played.rewards += 1
        if (self.core.game_over or self.core.truncated) and self.phase == "playing":
            self.phase = "over"
            self.ended = self.played.statistics(self.core)

    def _act_frame(self, action: int, strength: float) -> int:
        if self.convert is not None:
            action, strength = self.convert(action, strength)
        before = self.core.frame_number
        reward = self.core.act(action, strength)
        if self.core.frame_number != before:  # after the end of a game, `act` plays no frame
            for observer in self.observers:
                observer.frame_played(action, reward)
        return reward

    def check_phase(self) -> bool:
        """Refuse a step before the first reset, and warn once about a step after the end; whether the game is over."""
        if self.phase == "new":
            raise gymnasium.error.ResetNeeded("call env.reset() before the first env.step()")
        if not (self.core.game_over or self.core.truncated):
            self.phase = "playing"  # the game was reset through `core`
        elif self.phase == "over":
            self.phase = "warned"
            logger.warn("env.step() was called after the episode had ended; nothing happens until env.reset()")
        return self.phase != "playing"

    def _continuous_action(self, action: Any) -> tuple[int, float]:
        """The ALE action and the strength of (radius, angle, fire), computed in float32 as in CALE."""
        try:
            with np.errstate(over="ignore"):
                motion = np.asarray(action, dtype=np.float32)
        except (TypeError, ValueError):
            motion = None
        if motion is None or motion.shape != (3,):
            raise TypeError(f"a continuous action is three floats (radius, angle, fire), got {action!r}")
        radius, angle, fire = motion
        if not in_continuous_space(radius, angle, fire):
            raise ValueError(
                f"a continuous action is radius 0..1, angle -pi..pi, fire 0..1, got ({radius}, {angle}, {fire})"
            )
        return int(joystick_action(radius, angle, fire, self._threshold)), float(radius)
