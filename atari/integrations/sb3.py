"""`AtariVecEnv`: the vector environment for Stable-Baselines3.

Its `VecEnv` came before Gymnasium's and differs: an episode's end and the next one's start are one step, images have
their channels first, and `infos` has a dict for each environment. `AtariVectorEnv` with SAME_STEP does most of this.
`AtariVecEnv` adds the rest, and the episode statistics of Stable-Baselines3's `Monitor`.
"""

import inspect
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from os import PathLike
from types import FrameType
from typing import Any

import gymnasium
import numpy as np
from gymnasium import logger, spaces

from atari.base.extras import install_extra
from atari.base.gymnasium_versions import AutoresetMode
from atari.cores.options import SEED_LIMIT
from atari.env.env import check_reset_options
from atari.recording.replay.record_replay import RecordVectorReplay
from atari.recording.video.record_vector_video import RecordVectorVideo
from atari.task import Task
from atari.task.task import GameLike
from atari.vector.env import AtariVectorEnv
from atari.vector.results import indexed

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecFrameStack
except ImportError:
    raise gymnasium.error.DependencyNotInstalled(f"atari.sb3 needs Stable-Baselines3: {install_extra('sb3')}") from None

Indices = int | Sequence[int] | None


class AtariVecEnv(VecEnv):  # type: ignore[misc]
    """Many Atari games for Stable-Baselines3, played in C++.

    With `preset="baselines"` and equal seeds, its results equal those of `make_atari_env` with `VecFrameStack(..., 4)`
    to the byte, except that `reset` in the middle of a game begins a new one. Observations are uint8: (num_envs,
    stack_num, img_height, img_width), in RGB with 3 * stack_num channels in place of stack_num, RAM (num_envs, 128), or
    a dict of both; rewards are float32.

    The `info` of each environment has `lives`, `frame_number`, `episode_frame_number`, `TimeLimit.truncated`, and when
    its episode ends `terminal_observation`. When a whole game ends, with all its lives, it also has `episode`: `r`, the
    sum of its rewards without clipping; `l`, its length in frames; `t`, the seconds since the
    environments were made. So a `VecMonitor` is not needed, and would record clipped rewards of single lives. As with
    `Monitor`, `r` includes the rewards during the no-ops and the FIRE of a reset, which no step returns.

    With `channels_last=True` images are contiguous, (num_envs, img_height, img_width, stack_num), and
    Stable-Baselines3 transposes them like the images of its own environments. PPO and DQN then end with the same
    weights, to the bit. With channels first, convolutions add in another order, and weights differ by rounding.

    `vector` is the `AtariVectorEnv`; `get_attr`, `set_attr` and `env_method` apply to its `lanes`. `RecordVideo` and
    `RecordReplay` record it. A wrapper that does not change observations, rewards and actions can replace it.

    Args:
        game, num_envs: see `AtariVectorEnv`.
        options: options of `AtariVectorEnv`, except `autoreset_mode` and `batch_size`. Unless given, `render_mode` is
            "rgb_array", as in `make_atari_env`, for `VecVideoRecorder`.

    Raises:
        TypeError, ValueError, FileNotFoundError: see `AtariVectorEnv`.

    Example:
        >>> from atari.sb3 import AtariVecEnv
        >>> envs = AtariVecEnv("breakout", 4, preset="baselines")
        >>> envs.seed(0)
        [0, 1, 2, 3]
        >>> envs.reset().shape
        (4, 4, 84, 84)
        >>> observations, rewards, dones, infos = envs.step([1, 1, 1, 1])
        >>> envs.close()
    """

    def __init__(
        self,
        game: GameLike | Sequence[GameLike],
        num_envs: int | None = None,
        **options: Any,
    ) -> None:
        for name in {"autoreset_mode", "batch_size"} & set(options):
            raise TypeError(f"Stable-Baselines3 decides about {name}; leave it out")
        options.setdefault("render_mode", "rgb_array")
        self._atari = AtariVectorEnv(game, num_envs, **options, autoreset_mode=AutoresetMode.SAME_STEP)
        self.vector: gymnasium.vector.VectorEnv[Any, Any, Any] = self._atari
        super().__init__(
            self._atari.num_envs, _channels_first(self._atari.single_observation_space), self._atari.single_action_space
        )
        self.metadata: dict[str, Any] = {
            "render_modes": ["human", "rgb_array"] if self._atari.render_mode else [],
            "render_fps": self._atari.metadata["render_fps"],
        }
        self._actions: Any = None
        self._made_at = time.time()

    @property
    def task(self) -> Task:
        """The task of the first environment."""
        return self._atari.task

    def reset(self) -> Any:
        """Begin new games, with the seeds of `seed` if it was called. Warn if a `VecFrameStack` calls it."""
        space = self.observation_space
        shape = (space["image"] if isinstance(space, spaces.Dict) else space).shape or ()
        is_stacked = len(shape) == 3 and shape[0] not in (1, 3)  # more than the channels of one image
        if is_stacked and _called_by(VecFrameStack, sys._getframe(1)):
            logger.warn(
                "VecFrameStack stacks the observations of AtariVecEnv, which are stacks already; "
                "leave VecFrameStack out, or make AtariVecEnv with stack_num=1"
            )
        options = self._options[0]
        observation, info = self.vector.reset(seed=self._seeds[0], options=options or None)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = _split(info)
        return _as_sb3(observation)

    def step_async(self, actions: Any) -> None:
        """Begin a step; it raises the errors of `AtariVectorEnv.send`.

        A wrapper around `vector` plays the step in `step_wait`, which then raises the errors.
        """
        self._actions = actions
        if self.vector is self._atari:
            self._atari.send(actions)

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Wait for the step's observations, rewards, ends of episodes, and infos."""
        played = self._atari.recv() if self.vector is self._atari else self.vector.step(self._actions)
        observation, rewards, terminations, truncations, info = played
        dones = terminations | truncations
        shown, infos = _as_sb3(observation), _split(info)
        for one, truncated in zip(infos, (truncations & ~terminations).tolist(), strict=True):
            one["TimeLimit.truncated"] = truncated
        if dones.any():
            self._note_ends(dones, info, shown, infos)
        return shown, np.float32(rewards), dones, infos

    def _note_ends(self, dones: Any, info: dict[str, Any], shown: Any, infos: list[dict[str, Any]]) -> None:
        final = _as_sb3(info["final_obs"])
        for index in np.flatnonzero(dones).tolist():
            # With `life_loss_info` an episode continues after a termination.
            source = final if info["_final_obs"][index] else shown
            infos[index]["terminal_observation"] = indexed(source, index)
        seconds = round(time.time() - self._made_at, 6)
        for games in (info, info["final_info"]):  # The step's game replaces one that ended inside the reset after it.
            for index in np.flatnonzero(games.get("_episode", ())).tolist():
                score, frames = (games["episode"][key][index] for key in "rl")
                infos[index]["episode"] = {"r": float(score), "l": int(frames), "t": seconds}

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed environment i with seed + i, at the next reset; None draws a seed.

        Raises:
            ValueError: the seed is not within 0..2**32-1.
        """
        if seed is None:
            seed = int(np.random.randint(2**31 - self.num_envs))
        if not 0 <= seed < SEED_LIMIT:
            raise ValueError(f"seed must be within 0..2**32-1, got {seed}")
        return super().seed(seed)

    def set_options(self, options: Sequence[Mapping[str, Any]] | Mapping[str, Any] | None = None) -> None:
        """Set the options of the next reset, {"new_game": True}: a dict, or a list with an equal dict for each lane.

        Raises:
            TypeError: there is no such option, as in `AtariEnv.reset`.
            ValueError: the list has another length, or its dicts differ: a vector begins all games alike.
        """
        each = [options or {}] * self.num_envs if options is None or isinstance(options, Mapping) else list(options)
        for one in each:
            check_reset_options(one)
        if len(each) != self.num_envs or any(one != each[0] for one in each):
            raise ValueError(f"set_options takes a dict, or {self.num_envs} equal dicts for the lanes, got {options!r}")
        super().set_options([{"new_game": bool(one["new_game"])} if "new_game" in one else {} for one in each])

    def _repr_html_(self) -> str | None:
        """The first screens, for a notebook; see `AtariVectorEnv`."""
        return self._atari._repr_html_()

    def close(self) -> None:
        """Join the threads and release the environments."""
        self.vector.close()

    def get_images(self) -> Sequence[Any]:
        """The screens, (height, 160, 3) uint8 each."""
        return self.env_method("screen_rgb")

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """An attribute of each lane, or else of the vector, repeated. Spaces are a single environment's."""
        chosen = [self._atari.lanes[index] for index in self._get_indices(indices)]
        if attr_name in ("action_space", "observation_space"):
            return [getattr(self, attr_name)] * len(chosen)
        return [getattr(lane if hasattr(lane, attr_name) else self._atari, attr_name) for lane in chosen]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set `mode` or `difficulty`; it raises the errors of `AtariVectorEnv.set_attr`."""
        chosen = set(self._get_indices(indices))
        now = self.get_attr(attr_name)
        self._atari.set_attr(attr_name, [value if index in chosen else old for index, old in enumerate(now)])

    def env_method(self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any) -> list[Any]:
        """Call a method of each environment, and return the results."""
        lanes = self._atari.lanes
        return [getattr(lanes[index], method_name)(*args, **kwargs) for index in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:
        """True for `Monitor`, because `infos` have its statistics; `evaluate_policy` then counts whole games."""
        return [issubclass(wrapper_class, Monitor) for _ in self._get_indices(indices)]


def _called_by(kind: type[Any], frame: FrameType | None) -> bool:
    while frame is not None:
        if isinstance(frame.f_locals.get("self"), kind):
            return True
        frame = frame.f_back
    return False


def _split(info: dict[str, Any]) -> list[dict[str, Any]]:
    names = [name for name in ("lives", "frame_number", "episode_frame_number", "action_mask") if name in info]
    columns = [list(info[name]) if name == "action_mask" else info[name].tolist() for name in names]
    return [dict(zip(names, values, strict=True)) for values in zip(*columns, strict=True)]


def _channels_first(space: spaces.Space[Any]) -> spaces.Space[Any]:
    if isinstance(space, spaces.Dict):
        return spaces.Dict({name: _channels_first(part) for name, part in space.spaces.items()})
    shape = space.shape or ()
    if len(shape) != 4:
        return space
    stack, height, width, colours = shape
    return spaces.Box(0, 255, (stack * colours, height, width), np.uint8)


def _as_sb3(observation: Any) -> Any:
    """Observations in Stable-Baselines3's form: RGB copied, with stack and channels in one first axis."""
    if isinstance(observation, dict):
        return {name: _as_sb3(part) for name, part in observation.items()}
    if observation.ndim != 5:
        # With channels last, the networks then compute in the same order as with Stable-Baselines3's own environments.
        return np.ascontiguousarray(observation)
    count, stack, height, width, colours = observation.shape
    return observation.transpose(0, 1, 4, 2, 3).reshape(count, stack * colours, height, width)


class _Recorder(VecEnvWrapper):  # type: ignore[misc]
    """An `AtariVecEnv` with a recorder around its `vector`."""

    def __init__(self, venv: AtariVecEnv, record: Callable[[Any], Any]) -> None:
        if not isinstance(venv, AtariVecEnv):
            raise TypeError(f"an atari.sb3.AtariVecEnv is recorded, before other wrappers; got {type(venv).__name__}")
        venv.vector = record(venv.vector)
        super().__init__(venv)

    def __getstate__(self) -> dict[str, Any]:
        """Leave out Stable-Baselines3's table of the class, which cannot be pickled."""
        return {name: value for name, value in vars(self).items() if name != "class_attributes"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.class_attributes = dict(inspect.getmembers(type(self)))

    def reset(self) -> Any:
        return self.venv.reset()

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Play a step and record its frames; the results are those of `AtariVecEnv.step_wait`."""
        return self.venv.step_wait()


def _of_recorder(name: str) -> Any:
    path = f"venv.vector.{name}"

    def put(self: Any, value: Any) -> None:
        setattr(self.venv.vector, name, value)

    return property(attrgetter(path), put, doc=f"`{name}` of `atari.recording.RecordVideo`.")


class RecordVideo(_Recorder):
    """Record videos of an `AtariVecEnv`, like `atari.recording.RecordVideo` for a vector.

    It takes the place of Stable-Baselines3's `VecVideoRecorder`, and records every emulated frame, with its sound.

    Args:
        venv: an `AtariVecEnv`, in no other wrapper.
        record_video_trigger: Stable-Baselines3's name of `step_trigger`; videos then have 200 steps by default.
        video_folder, video_length, name_prefix, options: see `atari.recording.RecordVideo`.

    Raises:
        TypeError, ValueError, OSError: see `atari.recording.RecordVideo`; or `venv` is no `AtariVecEnv`.

    Example:
        >>> from atari.sb3 import AtariVecEnv, RecordVideo
        >>> envs = AtariVecEnv("breakout", 4, preset="baselines")
        >>> envs = RecordVideo(envs, "videos", step_trigger=lambda step: step % 10_000 == 0, video_length=500)
        >>> envs.reset().shape
        (4, 4, 84, 84)
        >>> envs.close()
    """

    def __init__(
        self,
        venv: AtariVecEnv,
        video_folder: str | PathLike[str],
        record_video_trigger: Callable[[int], bool] | None = None,
        video_length: int | None = None,
        name_prefix: str = "rl-video",
        **options: Any,
    ) -> None:
        if record_video_trigger is not None:
            if "step_trigger" in options:
                raise TypeError("record_video_trigger and step_trigger are two names of one argument; give one of them")
            options["step_trigger"] = record_video_trigger
        if video_length is None:
            video_length = 0 if record_video_trigger is None else 200
        options.update(video_length=video_length, name_prefix=name_prefix)
        super().__init__(venv, lambda vector: RecordVectorVideo(vector, video_folder, **options))

    env = property(attrgetter("venv"), doc="The recorded environments.")
    record_video_trigger = _of_recorder("step_trigger")


_NAMES = "frames_per_sec name_prefix recorded_frames recording step_id video_folder video_length video_name video_path"
for _name in _NAMES.split():
    setattr(RecordVideo, _name, _of_recorder(_name))


class RecordReplay(_Recorder):
    """Record one environment of an `AtariVecEnv` in a replay, like `atari.recording.RecordReplay`.

    Args:
        venv: an `AtariVecEnv`, in no other wrapper.
        path, index: see `atari.recording.RecordReplay`.

    Raises:
        TypeError, ValueError, OSError: see `atari.recording.RecordReplay`; or `venv` is no `AtariVecEnv`.

    Example:
        >>> from atari.sb3 import AtariVecEnv, RecordReplay
        >>> envs = RecordReplay(AtariVecEnv("breakout", 4), "third.a26r", index=2)
        >>> observations = envs.reset()
        >>> envs.close()
    """

    def __init__(self, venv: AtariVecEnv, path: str | PathLike[str], index: int = 0) -> None:
        super().__init__(venv, lambda vector: RecordVectorReplay(vector, path, index))
