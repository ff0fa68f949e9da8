"""`ResultParts`: the results of `step` and `recv` inside compiled functions: the same arrays in every step."""

from typing import Any

from gymnasium import spaces

import atari._emulator as _emulator
from atari.base.gymnasium_versions import AutoresetMode
from atari.vector.results import COUNTERS, GAME_INFO


class ResultParts:
    """The arrays of a batch, and their conversion to the results of a step.

    Args:
        options: the options of the vector environment.
        port: the port of its engine for XLA.

    Attributes:
        declared: name, shape and dtype of each array that a compiled function gets, in order.
        as_written: whether an observation is one array, in the engine's form.
    """

    def __init__(self, options: Any, port: _emulator.XlaPort) -> None:
        space = options.observation_space()
        self._named = isinstance(space, spaces.Dict)
        parts: dict[str, Any] = dict(space.spaces) if isinstance(space, spaces.Dict) else {"": space}
        written = zip(("pixels", "ram"), options.part_names(), strict=True)
        self._parts = {array: part for array, part in written if part in parts}
        shown = {array: parts[part].shape for array, part in self._parts.items()}
        self.declared: list[tuple[str, tuple[int, ...], str]] = []
        for name, dtype, shape in port.results():
            part = name.removeprefix("final_")
            self.declared.append((name, (shape[0], *shown[part]) if part in shown else shape, dtype))
        self._players = options.players
        self._same_step = options.autoreset_mode == AutoresetMode.SAME_STEP
        self._layout, self._game_info, self._masks = options.layout, options.game_info, options.action_masks()
        self.as_written = self._layout.is_engines and not self._named

    def assemble(self, arrays: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Observations, rewards, terminations, truncations and info, from JAX arrays in the order of `declared`."""
        parts = dict(zip((name for name, *_ in self.declared), arrays, strict=True))
        info = {name: parts[name] for name in ("env_id", *COUNTERS)}
        if self._game_info:
            info |= {key: parts[name] for key, name in GAME_INFO.items()}
        if self._masks is not None:
            import jax.numpy

            info["action_mask"] = jax.numpy.asarray(self._masks)[parts["env_id"]]
        if self._same_step:
            info["final_obs"] = self._observation(parts, "final_")
            info["final_info"] = {name: parts["final_" + name] for name in COUNTERS}
            info["_final_obs"] = info["_final_info"] = parts["ended"]
        reward = parts["reward"] if self._players == 1 else parts["reward"].astype(float)
        reward = parts.get("own_reward_float", reward)
        return self._observation(parts), reward, parts["terminated"], parts["truncated"], info

    def _observation(self, arrays: dict[str, Any], prefix: str = "") -> Any:
        parts = {part: arrays[prefix + name] for name, part in self._parts.items()}
        observation = parts if self._named else parts[""]
        return observation if self._layout.is_engines else self._layout.apply(observation)
