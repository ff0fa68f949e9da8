"""`AtariTorchRLEnv`: a vector environment as TorchRL's `EnvBase`, with its specs and partial resets."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from atari.base.extras import pip_install
from atari.base.gymnasium_versions import AutoresetMode
from atari.integrations.torch import TorchEnvs
from atari.vector.env import vector_of

try:
    import torch
    from tensordict import TensorDict
    from torchrl.data import Bounded, Categorical, Composite, UnboundedContinuous, UnboundedDiscrete
    from torchrl.envs import EnvBase
except ImportError:
    raise gymnasium.error.DependencyNotInstalled(
        f"atari.integrations.torchrl needs TorchRL: {pip_install('torchrl')}"
    ) from None


class AtariTorchRLEnv(EnvBase):
    """A vector environment for TorchRL: `rollout`, collectors and losses.

    A batch of tensordicts is (num_envs,). Keys: "observation", uint8, or with obs_type="dict" "image" and "ram";
    "action", int64 (num_envs,), an index, or with `continuous` float32 (num_envs, 3); "reward", float32; "done",
    "terminated", "truncated", bool, (num_envs, 1) each; "lives", int32 (num_envs,).

    TorchRL resets the environments that are done, so `autoreset_mode` must be DISABLED. "next" then has the last
    observation of an episode, not the first observation of the next episode.

    Args:
        envs: an `AtariVectorEnv` with autoreset_mode="Disabled" and batches of all environments; or a game for
            `AtariVectorEnv`: an ID, a name, a game file, a `Game`, an `atari.Task`, or a list of them.
        device: the device of the tensors; None means the CPU. `TorchEnvs` makes the copies to a CUDA device.
        num_envs, options: arguments of `AtariVectorEnv`, for a game.

    Attributes:
        task: the task of the first environment.

    Raises:
        TypeError, ValueError, FileNotFoundError: see `AtariVectorEnv`; or the vector environment resets by itself, or
            has batches of fewer than all environments, or several players.

    Example:
        >>> envs = AtariTorchRLEnv("pong", num_envs=8)
        >>> data = envs.rollout(100, break_when_any_done=False)
        >>> data["next", "observation"].shape
        torch.Size([8, 100, 4, 84, 84])
    """

    def __init__(self, envs: Any, device: Any = None, num_envs: int | None = None, **options: Any) -> None:
        envs = vector_of(envs, num_envs, options, autoreset_mode=AutoresetMode.DISABLED)
        mode = envs.metadata["autoreset_mode"]
        if mode != AutoresetMode.DISABLED:
            raise ValueError(
                f"TorchRL resets environments itself: make them with autoreset_mode='Disabled', not {mode}"
            )
        if envs.batch_size != envs.num_envs:
            raise ValueError("TorchRL needs batches of all environments: leave batch_size out")
        if isinstance(envs.single_action_space, spaces.MultiDiscrete):
            raise ValueError("TorchRL's specs here are for one player: leave players out")
        super().__init__(device=torch.device("cpu" if device is None else device), batch_size=[envs.num_envs])
        self._view = TorchEnvs(envs, device)
        self.task = self._view.task
        self._seed_of_reset: int | None = None
        self._make_specs(envs)

    def _make_specs(self, envs: Any) -> None:
        rows, device = (envs.num_envs,), self.device
        space = envs.single_observation_space
        parts = space.spaces if isinstance(space, spaces.Dict) else {"observation": space}
        observations = {name: _spec(part, rows, device) for name, part in parts.items()}
        lives = UnboundedDiscrete(rows, device=device, dtype=torch.int32)
        self.observation_spec = Composite({**observations, "lives": lives}, shape=rows)
        self.action_spec = _spec(envs.single_action_space, rows, device)
        self.reward_spec = UnboundedContinuous((*rows, 1), device=device)
        flag = Categorical(2, shape=(*rows, 1), device=device, dtype=torch.bool)
        flags = {name: flag.clone() for name in ("done", "terminated", "truncated")}
        self.done_spec = Composite(flags, shape=rows)

    def _reset(self, tensordict: Any = None, **_: Any) -> Any:
        mask = None if tensordict is None else tensordict.get("_reset", None)
        options = None if mask is None else {"reset_mask": mask.reshape(self.batch_size)}
        if mask is not None and bool(mask.all()):
            options = None
        seed, self._seed_of_reset = (self._seed_of_reset, None) if options is None else (None, self._seed_of_reset)
        observation, info = self._view.reset(seed=seed, options=options)
        return TensorDict(self._entries(observation, info), self.batch_size, self.device)

    def _step(self, tensordict: Any) -> Any:
        observation, reward, terminated, truncated, info = self._view.step(tensordict["action"])
        values = self._entries(observation, info)
        values["reward"] = reward.to(torch.float32).unsqueeze(-1)
        values["terminated"], values["truncated"] = terminated.unsqueeze(-1), truncated.unsqueeze(-1)
        values["done"] = values["terminated"] | values["truncated"]
        return TensorDict(values, self.batch_size, self.device)

    def _set_seed(self, seed: int | None) -> None:
        """Seed the next reset of all environments; environment i with seed + i."""
        self._seed_of_reset = seed

    def close(self, **arguments: Any) -> None:
        """Close the vector environment too."""
        self._view.close()
        super().close(**arguments)

    def _entries(self, observation: Any, info: dict[str, Any]) -> dict[str, Any]:
        parts = observation if isinstance(observation, dict) else {"observation": observation}
        return {**parts, "lives": info["lives"].to(self.device)}


def _spec(space: spaces.Space[Any], rows: tuple[int, ...], device: Any) -> Any:
    if isinstance(space, spaces.Discrete):
        return Categorical(int(space.n), shape=rows, device=device)
    assert isinstance(space, spaces.Box)
    low, high = (
        torch.from_numpy(np.array(np.broadcast_to(limit, (*rows, *space.shape)))) for limit in (space.low, space.high)
    )
    return Bounded(low, high, (*rows, *space.shape), device=device, dtype=low.dtype)
