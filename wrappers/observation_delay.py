"""`ObservationDelay`: the agent sees screen, RAM and sound some frames late."""

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from atari.cores import ByteArray
from atari.env.episode_env import EpisodeEnv
from atari.env.restorable import RestorableWrapper, State, layers
from atari.task.fields import CHECKS
from atari.wrappers._checks import Environment, draw, require_atari
from atari.wrappers.dqn_preprocessing import DqnPreprocessing

_CHECK: Any = CHECKS["observation_delay"]

FrameArrays = dict[str, ByteArray]
"""Arrays of a core after a frame, by the name of the method."""


class ObservationDelay(RestorableWrapper):
    """Observations are made of the screen, or of RAM and sound, of `delay` frames ago.

    Frames are the emulator's, also inside a frame skip. The wrappers inside apply their rules to the frames that have
    arrived: the maximum of two frames, stacks, and what is shown at the end of an episode. Until the first frame after
    a reset has arrived, the frame that the reset shows is held. Only if an inner `DqnPreprocessing` with
    `seamless_lives` continues its stack after a lost life, the frames on their way are kept, and the frames of such a
    reset are never shown. Rewards, ends and `info` are not delayed. Put this wrapper outside of all others that play
    frames or make observations.

    (`gymnasium.wrappers.DelayObservation` delays the observations themselves, by steps, and begins with zeros.)
    `atari.make` has the option `observation_delay`, which the engine plays.

    Args:
        env: an `AtariEnv`, possibly wrapped.
        delay: frames, 0..60; or (low, high), both included, for a number drawn at each reset from the generator of the
            no-ops, after them, and after the number of an inner `ActionDelay`.

    Raises:
        TypeError, ValueError: `delay` is of the wrong kind or out of range; the environment is no `AtariEnv`, has an
            `ObservationDelay` already, or is the one object of a preset, which has the option `observation_delay`.

    Example:
        >>> import atari
        >>> from atari.wrappers import ObservationDelay
        >>> env = ObservationDelay(atari.AtariEnv("pong", obs_type="ram", frameskip=4), 4)
        >>> first, info = env.reset(seed=0)
        >>> second, reward, terminated, truncated, info = env.step(2)
        >>> bool((first == second).all()), second.shape
        (True, (128,))
    """

    def __init__(self, env: Environment, delay: int | tuple[int, int]) -> None:
        delay = _CHECK("delay", delay)
        self._atari = require_atari(env, "ObservationDelay")
        for layer in layers(env):
            if isinstance(layer, EpisodeEnv):
                raise ValueError(
                    "ObservationDelay has no effect around the one object of a preset; make the environment with "
                    f"observation_delay={delay}"
                )
            if isinstance(layer, ObservationDelay):
                raise ValueError("the environment has an ObservationDelay already; use one with the sum of both delays")
        super().__init__(env, delay=list(delay) if isinstance(delay, tuple) else delay)
        self._range: tuple[int, int] = delay if isinstance(delay, tuple) else (delay, delay)
        self._skip = next((layer for layer in layers(env) if isinstance(layer, DqnPreprocessing)), None)
        shown = "screen" if self._skip is not None else self._atari.task.kind.method
        self._names = tuple(dict.fromkeys((shown, "ram", *(["audio"] if self._atari.sound_obs else []))))
        self._line: deque[FrameArrays] = deque()
        self._resets = self._began = self._played = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset; the frames that have not arrived are dropped."""
        self._resets, self._began, self._played = True, False, False
        try:
            result: tuple[Any, dict[str, Any]] = self._watched(lambda: self.env.reset(seed=seed, options=options))
        finally:
            self._resets = False
        if self._began or not self._keeps_stack:
            low, high = self._range
            delay = low if low == high else draw(self.env, low, high + 1)
            first = self._read() if self._began or self._played else self._line[0]
            self._line = deque([first] * (delay + 1), maxlen=delay + 1)
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step; the observation is made of the frames that have arrived."""
        self._warn_if_restored()
        return self._watched(lambda: self.env.step(action))

    def game_begun(self) -> None:
        """Note that the emulator was reset."""
        self._began = True

    def frame_played(self, action: int, reward: int) -> None:
        """Add the present frame."""
        self._played = True
        if not self._resets:
            self._line.append(self._read())

    def arrived(self, name: str) -> ByteArray:
        """The array of a core's method after the frame that has arrived.

        In a reset that is the present frame, unless the reset goes on with the stack or plays no frame.
        """
        goes_on = not self._began and (self._keeps_stack or not self._played)
        shown = name in self._names  # otherwise `DqnPreprocessing` inside drops the observation
        present = not shown or (self._resets and not goes_on)
        return getattr(self._atari.core, name)() if present else self._line[0][name].copy()

    @property
    def _keeps_stack(self) -> bool:
        return self._skip is not None and self._skip.keeps_stack

    def _watched(self, call: Callable[[], Any]) -> Any:
        """Make a call in which this object receives each frame, and observations are made of what has arrived."""
        driver = self._atari.driver
        driver.observers.append(self)
        driver.delayed = _Arrived(self)
        try:
            return call()
        finally:
            driver.observers.remove(self)
            driver.delayed = None

    def _read(self) -> FrameArrays:
        return {name: getattr(self._atari.core, name)() for name in self._names}

    def _save_state(self) -> State:
        frames = [*self._line, *[self._read()] * (self._range[1] + 1 - len(self._line))]
        return {"delay": len(self._line) - 1, **{name: np.array([one[name] for one in frames]) for name in self._names}}

    def _load_state(self, state: State) -> dict[str, Any]:
        delay = state["delay"]
        if not -1 <= delay <= self._range[1]:
            raise ValueError(f"the snapshot is damaged: a delay of {delay} is not within 0..{self._range[1]}")
        frames = ({name: state[name][entry].copy() for name in self._names} for entry in range(delay + 1))
        return {"_line": deque(frames, maxlen=max(delay + 1, 0) or None)}


class _Arrived:
    """The methods of a core that make observations, for the frame that has arrived."""

    def __init__(self, delay: ObservationDelay) -> None:
        self._delay = delay

    def screen(self) -> ByteArray:
        return self._delay.arrived("screen")

    def screen_rgb(self) -> ByteArray:
        return self._delay.arrived("screen_rgb")

    def screen_grayscale(self) -> ByteArray:
        return self._delay.arrived("screen_grayscale")

    def ram(self) -> ByteArray:
        return self._delay.arrived("ram")

    def audio(self) -> ByteArray:
        return self._delay.arrived("audio")
