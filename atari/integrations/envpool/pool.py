"""`EnvPool`: an `AtariVectorEnv` with the interface of EnvPool's Atari environments."""

import inspect
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.base.gymnasium_versions import AutoresetMode, VectorEnv
from atari.base.validation import check_integer
from atari.cores.options import SEED_LIMIT
from atari.env.rendering import Window
from atari.integrations.envpool.spec import EnvPoolSpec, import_dm, make_spec, task_ids
from atari.integrations.jax import xla
from atari.task import Task
from atari.task.task import GameLike
from atari.vector import AtariVectorEnv
from atari.vector.results import pick_rows
from atari.wrappers import resize_image


class EnvPool:
    """Environments of one game with the interface of EnvPool.

    Observations are uint8 (batch, stack_num, img_height, img_width), in RGB with 3 * stack_num; rewards float32
    (batch,). `info` has, (batch,) each: `env_id`, `lives`, `elapsed_step`, int32; `reward`, float32, not clipped;
    `terminated`, int32, whether the game is over, even if a lost life ends an episode; and `TimeLimit.truncated`,
    bool. It also has `players`, a dict with `env_id`; and `ram`, uint8 (batch, 128).

    The step after an end ignores its action and returns the first observation of the next episode. Observations do not
    change while you hold them.

    Attributes may be set, as scripts do with `num_envs` and `single_action_space`; nothing depends on them.

    Args:
        spec: from `make_spec`.
        returns_done: whether `step` returns four values, with `done`, and `reset` only the observations.
        render_mode: "rgb_array" lets `render` return screens, "human" show them in a window.
        render_env_id: the environment that `render` shows.
        render_width, render_height: the size of its images; None means that of the screen.
        render_camera_id: a number for EnvPool's environments with cameras, which Atari's ignore.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> envs = envpool.make("Pong-v5", env_type="gymnasium", num_envs=4, seed=1)
        >>> observations, info = envs.reset()
        >>> observations.shape, info["lives"].shape
        ((4, 4, 84, 84), (4,))
    """

    is_vector_env = True
    closed = True  # until the constructor ends: old releases of Gymnasium close an open one that is deleted
    has_discount = False  # whether results have `zero_discount_on_life_loss`

    def __init__(
        self,
        spec: EnvPoolSpec,
        returns_done: bool = False,
        *,
        render_mode: str | None = None,
        render_env_id: int = 0,
        render_width: int | None = None,
        render_height: int | None = None,
        render_camera_id: int | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array", "human"):
            raise ValueError(f"render_mode must be None, 'rgb_array' or 'human', got {render_mode!r}")
        if spec.config.zero_discount_on_life_loss and not self.has_discount:
            raise ValueError("no discount is returned; leave zero_discount_on_life_loss out, or use make_dm")
        self.render_mode: Any = render_mode
        self._render_env_id = check_integer("render_env_id", render_env_id, 0, spec.config.num_envs - 1)
        self._render_size = tuple(
            None if size is None else check_integer(name, size, 1, 10_000)
            for name, size in (("render_width", render_width), ("render_height", render_height))
        )
        self._window: Any = None
        self.vector: AtariVectorEnv = spec.make_vector()
        self.spec: Any = spec
        self.config: dict[str, Any] = spec.config._asdict()
        self.num_envs = self.vector.num_envs
        self.is_async = self.vector.batch_size < self.vector.num_envs
        self.all_env_ids = np.arange(self.num_envs, dtype=np.int32)
        modes = ["rgb_array", "human"]
        self.metadata: Any = {"render_modes": modes, "render.modes": modes, "autoreset_mode": AutoresetMode.NEXT_STEP}
        self.observation_space: Any = spec.observation_space if returns_done else spec.gymnasium_observation_space
        self.action_space: Any = spec.action_space if returns_done else spec.gymnasium_action_space
        self.single_observation_space: Any = self.observation_space
        self.single_action_space: Any = self.action_space
        self.closed = False
        self.returns_done = returns_done
        self._reset_returns_info = not returns_done or spec.config.gym_reset_return_info
        self._seed: Any = spec.config.env_seed or spec.config.seed

    @property
    def task(self) -> Task:
        """The task."""
        return self.vector.task

    def reset(self, env_id: Any = None, *, seed: Any = None, options: Any = None) -> Any:
        """Reset all environments, or those in `env_id`, and return their first observations and `info`.

        Args:
            env_id: integers (rows,), each once; the results have the rows of these environments, in this order.
            seed: the k-th environment that is reset, from 0 on in the order of their numbers, gets seed + k. If all
                are reset, environment i gets seed + i. None continues the generators, or begins with `make`'s seed.
            options: None, or empty.

        Raises:
            TypeError, ValueError, IndexError: `env_id` or `seed` does not fit.
            gymnasium.error.ResetNeeded: the first reset does not reset all environments.
        """
        if options:
            raise ValueError(f"reset() has no options here, got {options!r}")
        rows = None if env_id is None else self._check_env_id(env_id)
        if rows is not None and self.is_async and len(rows) < self.vector.num_envs:
            raise ValueError("with batch_size < num_envs all environments are reset together; leave env_id out")
        chosen: dict[str, Any] = {"new_game": True}
        if rows is not None and len(rows) < self.vector.num_envs:
            chosen["reset_mask"] = np.isin(self.all_env_ids, rows)
        else:
            seed = self._take_seed(seed)
        observation, info = self.vector.reset(seed=seed, options=chosen)
        none = np.zeros(len(info["env_id"]), np.bool_)
        results = (observation, none.astype(np.float32), none, none.copy(), info)
        return self._results(results if rows is None or self.is_async else pick_rows(results, rows), reset=True)

    def step(self, action: Any, env_id: Any = None) -> Any:
        """Play a step of all environments, or of those in `env_id`; then the results have only their rows.

        Returns:
            Observations, rewards, dones and `info`; for "gymnasium" terminations and truncations instead of dones.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            TypeError, ValueError, IndexError: the actions or `env_id` do not fit; nothing is played.
        """
        self.send(action, env_id)
        return self.recv()

    def send(self, action: Any, env_id: Any = None) -> None:
        """Begin a step; `recv` returns its results. It raises the errors of `step`.

        Raises:
            gymnasium.error.AlreadyPendingCallError: the last step has not been received.
        """
        if isinstance(action, dict):
            action, env_id = action["action"], action.get("env_id", env_id)
        self.vector.send(action, env_id=env_id)

    def recv(self, reset: bool = False, return_info: bool = True) -> Any:
        """Wait for a batch of results, in the form of `step`, or with `reset` in the form of `reset`.

        Raises:
            gymnasium.error.NoAsyncCallError: nothing has been sent.
        """
        return self._results(self.vector.recv(), reset, return_info)

    def async_reset(self) -> None:
        """Begin a reset of all environments; `recv` returns the first results."""
        self.vector.reset_async(seed=self._take_seed(None), options={"new_game": True})

    def seed(self, seed: Any = None) -> None:
        """Seed the next reset of all environments; environment i with seed + i."""
        self._seed = seed

    def render(self, env_ids: Any = None, camera_id: int | None = None) -> npt.NDArray[np.uint8] | None:
        """The screens of environments, (rows, height, width, 3) uint8, or None and a window.

        Args:
            env_ids: an environment, or several; None means `render_env_id`.
            camera_id: see `render_camera_id`.

        Raises:
            RuntimeError: there is no render mode, or environments are being played.
            TypeError, ValueError, IndexError: `env_ids` does not fit.
        """
        if self.render_mode is None:
            raise RuntimeError("render() needs a render mode; make the environments with render_mode='rgb_array'")
        rows = self._check_env_id(np.atleast_1d(self._render_env_id if env_ids is None else env_ids))
        screens = [resized(self.vector.lanes[row].screen_rgb(), *self._render_size) for row in rows]
        if self.render_mode == "rgb_array":
            return np.stack(screens)
        if self._window is None:
            self._window = Window(self.vector.games[0], self.vector.metadata["render_fps"])
        self._window.show(self.vector.lanes[rows[0]].screen_rgb())
        return None

    def xla(self) -> Any:
        """`handle`, `recv`, `send` and `step` for functions compiled by JAX, see `atari.integrations.jax.xla`.

        `recv` and `step` return a handle and the results of the methods of these names.

        Raises:
            gymnasium.error.DependencyNotInstalled: JAX is not installed, or is older than 0.5.0.
        """
        handle, recv, send, step = xla(self.vector)
        as_results = partial(as_envpool, returns_done=self.returns_done)  # compiled functions may keep it

        def converted(function: Callable[..., Any]) -> Callable[..., Any]:
            def call(*arguments: Any, **named: Any) -> tuple[Any, Any]:
                handle, results = function(*arguments, **named)
                return handle, as_results(results)

            return call

        return handle, converted(recv), send, converted(step)

    def _repr_html_(self) -> str | None:
        """The first screens, for a notebook; see `AtariVectorEnv`."""
        return self.vector._repr_html_()

    def close(self, **_: Any) -> None:
        """Join the threads and release the environments."""
        self.closed = True
        if self._window is not None:
            self._window.close()
            self._window = None
        self.vector.close()

    def __len__(self) -> int:
        return self.vector.num_envs

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.config.items())})"

    __str__ = __repr__

    def _take_seed(self, seed: Any) -> Any:
        seed, self._seed = self._seed if seed is None else seed, None
        if isinstance(seed, (int, np.integer)):
            return int(seed) % SEED_LIMIT
        return seed

    def _check_env_id(self, env_id: Any) -> npt.NDArray[np.int64]:
        array = np.asarray(env_id)
        if array.dtype.kind not in "iu" or array.ndim != 1 or not array.size:
            raise TypeError(f"env_id must be integers (rows,), one or more, got {env_id!r}")
        if array.min() < 0 or array.max() >= self.vector.num_envs:
            raise IndexError(f"env_id must be within 0..{self.vector.num_envs - 1}, got {env_id!r}")
        if len(np.unique(array)) < len(array):
            raise ValueError(f"env_id must name each environment once, got {env_id!r}")
        return array.astype(np.int64)

    def _results(self, results: Any, reset: bool, return_info: bool = True) -> Any:
        if reset:
            image, *_, info = as_envpool(results, self.returns_done)
            return (image, info) if self._reset_returns_info and return_info else image
        return as_envpool(results, self.returns_done)


def resized(screen: npt.NDArray[np.uint8], width: int | None, height: int | None) -> npt.NDArray[np.uint8]:
    """A screen in another size, by areas like EnvPool's; None keeps it."""
    size = (height or screen.shape[0], width or screen.shape[1])
    if size == screen.shape[:2]:
        return screen
    return resize_image(screen, size)


def as_envpool(results: Any, returns_done: bool) -> tuple[Any, ...]:
    """Results of the vector environment in the form of EnvPool's `step`, as arrays of NumPy or of JAX.

    Args:
        results: the results of `AtariVectorEnv.step`.
        returns_done: whether there is one array of ends, not two.
    """
    observation, reward, terminated, truncated, theirs = results
    image = observation["image"]
    if image.ndim == 5:
        count, stack, height, width, colours = image.shape
        image = image.transpose(0, 1, 4, 2, 3).reshape(count, stack * colours, height, width)
    env_id = theirs["env_id"].copy()
    info = {
        "env_id": env_id,
        "players": {"env_id": env_id.copy()},
        "lives": theirs["lives"],
        "reward": theirs["reward"].astype(np.float32),
        "terminated": theirs["terminated"].astype(np.int32),
        "ram": observation["ram"],
        "elapsed_step": theirs["elapsed_step"],
        "TimeLimit.truncated": truncated & ~terminated,
    }
    ends = (terminated | truncated,) if returns_done else (terminated, truncated)
    return (image, reward.astype(np.float32), *ends, info)


class GymnasiumEnvPool(EnvPool, VectorEnv, gymnasium.Env[Any, Any]):  # type: ignore[misc]
    """An `EnvPool` for Gymnasium's wrappers of single and of vector environments, like EnvPool's own.

    Example:
        >>> from gymnasium.wrappers.vector import RecordEpisodeStatistics
        >>> import atari.integrations.envpool as envpool
        >>> envs = RecordEpisodeStatistics(envpool.make("Pong-v5", env_type="gymnasium", num_envs=2))
        >>> envs.reset()[0].shape
        (2, 4, 84, 84)
    """


def make(task_id: GameLike, env_type: str, **options: Any) -> EnvPool:
    """Make environments of a task, like `envpool.make`.

    Args:
        task_id: a name of `list_all_envs`, such as "Breakout-v5", or another argument of `make_spec`: a game's name, a
            game file, an environment ID, or an `atari.Task`.
        env_type: "gym": `step` returns four values and `reset` one, as in EnvPool with Gym before 0.26;
            "gymnasium"; or "dm", see `make_dm`.
        options: EnvPool's options: num_envs, batch_size, num_threads, thread_affinity_offset, seed, max_episode_steps,
            stack_num, frame_skip, noop_max, episodic_life, reward_clip, use_fire_reset, img_height, img_width, mode,
            difficulty, full_action_space, repeat_action_probability, gray_scale, gym_reset_return_info, env_seed (a
            seed for each environment); and render_mode, render_env_id, render_width, render_height, render_camera_id.

    Raises:
        TypeError, ValueError: an option does not exist, is of the wrong kind or out of range, or is not supported.
        FileNotFoundError: there is no ROM of the game.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> envs = envpool.make("Pong-v5", env_type="gymnasium", num_envs=2)
        >>> observations, info = envs.reset()
        >>> observations.shape
        (2, 4, 84, 84)
    """
    makers = {"gym": make_gym, "gymnasium": make_gymnasium, "dm": make_dm}
    if env_type not in makers:
        raise ValueError(f"env_type must be 'gym', 'gymnasium' or 'dm', got {env_type!r}")
    return makers[env_type](task_id, **options)


def make_dm(task_id: GameLike, **options: Any) -> EnvPool:
    """`make` with env_type="dm": `reset` and `step` return a `dm_env.TimeStep`, see `DMEnvPool`.

    Raises:
        gymnasium.error.DependencyNotInstalled: dm-env is not installed.
        TypeError, ValueError, FileNotFoundError: see `make`.

    Example:
        >>> import numpy as np
        >>> import atari.integrations.envpool as envpool
        >>> envs = envpool.make_dm("Pong-v5", num_envs=2)
        >>> step = envs.reset()
        >>> envs.step(np.zeros(2, int)).discount
        array([1., 1.], dtype=float32)
    """
    return _made(import_dm().DMEnvPool, task_id, options)


def _made(kind: type[EnvPool], task_id: GameLike, options: dict[str, Any], **form: Any) -> EnvPool:
    render = {name: options.pop(name) for name in _RENDER_OPTIONS if name in options}
    return kind(make_spec(task_id, **options), **render, **form)


_RENDER_OPTIONS = tuple(name for name in inspect.signature(EnvPool).parameters if name.startswith("render"))


def make_gym(task_id: GameLike, **options: Any) -> EnvPool:
    """`make` with env_type="gym". If `gym` is imported, the result is one of its `Env` and has its spaces.

    Example:
        >>> import numpy as np
        >>> import atari.integrations.envpool as envpool
        >>> envs = envpool.make_gym("Pong-v5", num_envs=2)
        >>> observations = envs.reset()
        >>> observations, rewards, dones, info = envs.step(np.zeros(2, int))
        >>> rewards.shape, dones.dtype
        ((2,), dtype('bool'))
    """
    return _made(_gym_class(), task_id, options, returns_done=True)


def _gym_class() -> type[EnvPool]:
    """The class of `make_gym`. If `gym` is imported, it is made here, and `pickle` finds it by no name."""
    gym = sys.modules.get("gym")
    if gym is None:
        return GymnasiumEnvPool
    names = {"__doc__": EnvPool.__doc__, "__reduce__": lambda envs: (_allocated, (), vars(envs))}
    return type("GymEnvPool", (EnvPool, gym.Env), names)


def _allocated() -> EnvPool:
    kind = _gym_class()
    return kind.__new__(kind)


def make_gymnasium(task_id: GameLike, **options: Any) -> EnvPool:
    """`make` with env_type="gymnasium".

    Example:
        >>> import numpy as np
        >>> import atari.integrations.envpool as envpool
        >>> envs = envpool.make_gymnasium("Pong-v5", num_envs=2)
        >>> observations, info = envs.reset()
        >>> observations, rewards, terminations, truncations, info = envs.step(np.zeros(2, int))
        >>> rewards.shape
        (2,)
    """
    return _made(GymnasiumEnvPool, task_id, options)


def list_all_envs() -> list[str]:
    """The names of all tasks.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> "Breakout-v5" in envpool.list_all_envs()
        True
    """
    return list(task_ids())
