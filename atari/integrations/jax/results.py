"""`ResultParts`: the results of `step` and `recv` inside compiled functions: the same arrays in every step."""

from typing import Any

import numpy as np
from gymnasium import spaces

from atari._gymnasium import AutoresetMode


class ResultParts:
    """The arrays of a batch, and how they become the results of a step.

    Args:
        options: the options of the vector environment.

    Attributes:
        pixels, ram: whether an observation has this part.
        as_written: whether an observation is one array, as the engine writes it.
    """

    def __init__(self, options: Any) -> None:
        space, rows, players = options.observation_space(), options.batch_size, options.players
        names: dict[str, Any] = dict(space.spaces) if isinstance(space, spaces.Dict) else {"": space}
        self._named = isinstance(space, spaces.Dict)
        self._names = [name for name in options.part_names() if name in names]
        self.pixels, self.ram = (name in names for name in options.part_names())
        self._rows, self._players = rows, players
        self._observation = [(f"obs.{name}", (rows, *names[name].shape), np.uint8) for name in self._names]
        self._same_step = options.autoreset_mode == AutoresetMode.SAME_STEP
        self._layout, self._game_info, self._masks = options.layout, options.game_info, options.action_masks()
        self.as_written = self._layout.is_engines and not self._named

    def declared(self) -> list[tuple[str, tuple[int, ...], Any]]:
        """Name, shape and dtype of each array that a compiled function gets, in the order of `Port::for_parts`.

        The order is in atari/emulator/python/binding_xla.cpp.
        """
        one = (self._rows,)
        each = one if self._players == 1 else (self._rows, self._players)
        integers, flags = np.int32, np.bool_
        parts: list[tuple[str, tuple[int, ...], Any]] = [
            *self._observation,
            ("reward", each, integers),
            ("terminated", each, flags),
            ("truncated", each, flags),
            ("env_id", one, integers),
            ("lives", each, integers),
            ("frame_number", one, integers),
            ("episode_frame_number", one, integers),
            ("game_reward", each, integers),
            ("elapsed_step", one, integers),
            ("game_over", one, flags),
        ]
        if self._same_step:
            parts += [(f"final.{name}", shape, dtype) for name, shape, dtype in self._observation]
            parts += [("ended", one, flags), ("final.lives", each, integers)]
            parts += [("final.frame_number", one, integers), ("final.episode_frame_number", one, integers)]
        return parts

    def assemble(self, arrays: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Observations, rewards, terminations, truncations and info, from JAX arrays in the order of `declared`."""
        parts = dict(zip((name for name, *_ in self.declared()), arrays, strict=True))
        info = {name: parts[name] for name in ("env_id", "lives", "frame_number", "episode_frame_number")}
        if self._game_info:
            info |= {
                "reward": parts["game_reward"],
                "elapsed_step": parts["elapsed_step"],
                "terminated": parts["game_over"],
            }
        if self._masks is not None:
            import jax.numpy

            info["action_mask"] = jax.numpy.asarray(self._masks)[parts["env_id"]]
        if self._same_step:
            names = ("lives", "frame_number", "episode_frame_number")
            info["final_obs"] = self._shown({name: parts[f"final.obs.{name}"] for name in self._names})
            info["final_info"] = {name: parts[f"final.{name}"] for name in names}
            info["_final_obs"] = info["_final_info"] = parts["ended"]
        reward = parts["reward"] if self._players == 1 else parts["reward"].astype(float)
        observation = self._shown({name: parts[f"obs.{name}"] for name in self._names})
        return observation, reward, parts["terminated"], parts["truncated"], info

    def _shown(self, parts: dict[str, Any]) -> Any:
        observation = parts if self._named else parts[""]
        return observation if self._layout.is_engines else self._layout.apply(observation)
