"""`DMEnvPool`: an `EnvPool` with the interface of dm_env."""

from collections import namedtuple
from typing import Any

import dm_env
import numpy as np
from dm_env import specs

from atari.integrations.envpool.pool import EnvPool
from atari.integrations.envpool.spec import ArraySpec, EnvPoolSpec

players = namedtuple("players", ["env_id"])
_ARRAYS = ("obs", "lives", "reward", "terminated", "ram")
State = namedtuple("State", ["env_id", "players", "obs", "lives", "reward", "terminated", "ram"])


class DMEnvPool(EnvPool, dm_env.Environment):  # type: ignore[misc]
    """Environments whose `reset`, `step` and `recv` return a `dm_env.TimeStep` of arrays with a row for each.

    `observation` is a named tuple: `obs`, and the arrays `env_id`, `players`, `lives`, `reward`, `terminated` and `ram`
    that `EnvPool` has in `info`. `step_type` is int32, 0 at the begin of an episode and 2 at its end; `reward` and
    `discount` are float32. `discount` is 0 at an end, also by the limit of steps, and with
    `zero_discount_on_life_loss` in steps that lose a life.

    Args:
        spec, options: see `EnvPool`.

    Example:
        >>> import numpy as np
        >>> import atari.integrations.envpool as envpool
        >>> envs = envpool.make_dm("Pong-v5", num_envs=2)
        >>> step = envs.reset()
        >>> step.step_type, step.observation.obs.shape
        (array([0, 0], dtype=int32), (2, 4, 84, 84))
    """

    has_discount = True

    def __init__(self, spec: EnvPoolSpec, **options: Any) -> None:
        super().__init__(spec, returns_done=False, **options)
        self._lives = np.zeros(self.num_envs, np.int32)
        self._ended = np.ones(self.num_envs, np.bool_)

    def reset(self, env_id: Any = None) -> Any:  # type: ignore[override]
        """Reset all environments, or those in `env_id`; the errors are those of `EnvPool.reset`."""
        return super().reset(env_id)

    def observation_spec(self) -> Any:
        """The `State` of the specs of one environment's arrays."""
        return self.spec.observation_spec()

    def action_spec(self) -> Any:
        """The spec of one environment's action."""
        return self.spec.action_spec()

    def _results(self, results: Any, reset: bool, return_info: bool = True) -> Any:
        image, reward, terminated, truncated, info = super()._results(results, reset=False)
        rows, last = info["env_id"], terminated | truncated
        first = self._ended[rows] | (info["elapsed_step"] == 0)
        lost = (info["lives"] < self._lives[rows]) & self.config["zero_discount_on_life_loss"]
        self._lives[rows], self._ended[rows] = info["lives"], last
        step_type = np.where(last, 2, np.where(first, 0, 1)).astype(np.int32)
        discount = np.where(last | (lost & ~first), 0, 1).astype(np.float32)
        seen = {name: info[name] for name in ("lives", "reward", "terminated", "ram")}
        state = State(env_id=rows, players=players(info["players"]["env_id"]), obs=image, **seen)
        return dm_env.TimeStep(step_type, reward, discount, state)


def observation_spec(arrays: dict[str, ArraySpec]) -> State:
    """The specs of dm_env of the arrays of an observation."""
    named = {name: as_dm(name, arrays.get(f"info:{name}", arrays["obs"])) for name in _ARRAYS}
    env_ids = [as_dm("env_id", arrays[f"info:{name}"]) for name in ("env_id", "players.env_id")]
    return State(env_ids[0], players(env_ids[1]), **named)


def as_dm(name: str, array: ArraySpec) -> Any:
    """The spec of dm_env of one environment's row of an array."""
    if array.minimum == 0 and array.dtype == np.int32:
        return specs.DiscreteArray(array.maximum + 1, array.dtype, name)
    shape = [size for size in array.shape if size != -1]
    return specs.BoundedArray(shape, array.dtype, array.minimum, array.maximum, name)
