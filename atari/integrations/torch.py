"""`TorchEnvs`: a vector environment whose `step` takes and returns PyTorch tensors, on the CPU or on a GPU."""

from contextlib import nullcontext
from typing import Any

import gymnasium
import numpy as np

from atari.base.extras import pip_install
from atari.integrations.arrays import to_torch
from atari.vector.env import vector_of

try:
    import torch
except ImportError:
    raise gymnasium.error.DependencyNotInstalled(f"TorchEnvs needs PyTorch: {pip_install('torch')}") from None


class TorchEnvs:
    """A vector environment with tensors.

    On the CPU, tensors share the memory of the arrays, without a copy. On another device, observations, rewards,
    terminations, truncations and `final_obs` are copied to the device; the rest of `info` stays on the CPU. The
    environments write to two page-locked buffers in turn: the copy to a CUDA device runs on its own stream, while
    the environments may already play the next step. The current stream waits for the copy, Python does not.

    Args:
        envs: the vector environment, which can still be used directly; or a game for `AtariVectorEnv`.
        device: PyTorch's name of a device; None means the CPU.
        num_envs, options: arguments of `AtariVectorEnv`, for a game.

    Attributes:
        envs: the vector environment.
        task: the task of the first environment.
        device: a `torch.device`.

    Raises:
        TypeError, ValueError, FileNotFoundError: see `AtariVectorEnv`; or an option is given for an existing vector
            environment.
    """

    def __init__(self, envs: Any, device: Any = None, num_envs: int | None = None, **options: Any) -> None:
        self.envs = envs = vector_of(envs, num_envs, options)
        self.task = envs.task
        self._takes_out: bool = envs.options.layout.is_engines
        self.device: Any = torch.device("cpu" if device is None else device)
        self._copies = _Copies(self.device) if self.device.type != "cpu" else None
        self._actions: Any = None  # page-locked memory for actions from a CUDA device
        self.num_envs: int = envs.num_envs
        self.single_observation_space = envs.single_observation_space
        self.single_action_space = envs.single_action_space
        self.observation_space, self.action_space = envs.observation_space, envs.action_space
        self.metadata = envs.metadata

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset like `AtariVectorEnv.reset`. A `reset_mask` may be a tensor on any device."""
        if options and isinstance(options.get("reset_mask"), torch.Tensor):
            options = {**options, "reset_mask": options["reset_mask"].cpu().numpy()}
        observation, info = self.envs.reset(seed=seed, options=options)
        return self._as_tensors(observation), self._info_as_tensors(info)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step.

        Args:
            actions: integers (batch,), a tensor on any device, or another argument of `AtariVectorEnv.step`.

        Returns:
            The results of `AtariVectorEnv.step`, as tensors of the same dtypes.

        Raises:
            The errors of `AtariVectorEnv.step`.
        """
        self.send(actions)
        return self.recv()

    def send(self, actions: Any) -> None:
        """Begin a step; `recv` returns its results. `step` documents arguments and errors."""
        self.envs.send(self._on_host(actions), out=self._out())

    def recv(self) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Wait for a batch of results, in the form of `step`."""
        *parts, info = self.envs.recv()
        observation, reward, terminated, truncated = map(self._as_tensors, parts)
        return observation, reward, terminated, truncated, self._info_as_tensors(info)

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has a copy of the vector environment, and memory of its own."""
        return TorchEnvs, (self.envs, self.device)

    def close(self) -> None:
        """Close the vector environment."""
        self.envs.close()

    def _on_host(self, actions: Any) -> Any:
        if not isinstance(actions, torch.Tensor):
            return actions
        actions = actions.detach()
        if actions.device.type != "cuda":
            return actions.cpu().numpy()
        if self._actions is None or (self._actions.shape, self._actions.dtype) != (actions.shape, actions.dtype):
            self._actions = torch.empty(actions.shape, dtype=actions.dtype, pin_memory=True)
        self._actions.copy_(actions, non_blocking=True)
        torch.cuda.current_stream(actions.device).synchronize()
        return self._actions.numpy()

    def _out(self) -> Any:
        """Page-locked memory for the next observations; None if the engine cannot write into it."""
        if self._copies is None or not self._takes_out:
            return None
        parts = getattr(self.envs.single_observation_space, "spaces", {"": self.envs.single_observation_space})
        arrays = {
            name: self._copies.array((self.envs.batch_size, *space.shape), np.uint8) for name, space in parts.items()
        }
        return arrays.get("", arrays)

    def _as_tensors(self, arrays: Any) -> Any:
        return to_torch(arrays) if self._copies is None else self._copies.of(arrays)

    def _info_as_tensors(self, info: dict[str, Any]) -> dict[str, Any]:
        final = {"final_obs": self._as_tensors(info["final_obs"])} if "final_obs" in info else {}
        return {**to_torch({name: part for name, part in info.items() if name not in final}), **final}


class _Copies:
    """Copies of arrays on a device, through page-locked memory for a CUDA device."""

    def __init__(self, device: Any) -> None:
        self._device = device
        self._stream = torch.cuda.Stream(device) if device.type == "cuda" else None
        self._buffers: dict[Any, list[_Buffer]] = {}  # two for each shape and dtype, the older copy's first

    def array(self, shape: tuple[int, ...], dtype: Any) -> Any:
        """An array in page-locked memory that no copy reads. The next call of `of` copies it."""
        return self._next(shape, np.dtype(dtype)).array

    def of(self, arrays: Any) -> Any:
        """Copies of an array, or of a dict of arrays."""
        if isinstance(arrays, dict):
            return {name: self.of(array) for name, array in arrays.items()}
        buffer = self._next(arrays.shape, arrays.dtype)
        if buffer.array is not arrays:
            np.copyto(buffer.array, arrays)
        self._buffers[arrays.shape, arrays.dtype].reverse()
        return self._copied(buffer)

    def _next(self, shape: tuple[int, ...], dtype: Any) -> "_Buffer":
        if (shape, dtype) not in self._buffers:
            self._buffers[shape, dtype] = [_Buffer(shape, dtype, self._stream is not None) for _ in range(2)]
        buffer = self._buffers[shape, dtype][0]
        if buffer.copied is not None:
            buffer.copied.synchronize()
        return buffer

    def _copied(self, buffer: "_Buffer") -> Any:
        with nullcontext() if self._stream is None else torch.cuda.stream(self._stream):
            tensor = buffer.tensor.to(self._device, non_blocking=self._stream is not None, copy=True)
        if self._stream is not None:
            buffer.copied = self._stream.record_event()
            current = torch.cuda.current_stream(self._device)
            current.wait_event(buffer.copied)
            tensor.record_stream(current)
        return tensor


class _Buffer:
    """Memory from which a device copies: a tensor, and the same memory as an array; page-locked if `pinned`."""

    def __init__(self, shape: tuple[int, ...], dtype: Any, pinned: bool) -> None:
        like = torch.from_numpy(np.zeros(0, dtype))
        self.tensor = torch.empty(shape, dtype=like.dtype, pin_memory=pinned)
        self.array = self.tensor.numpy()
        self.copied: Any = None  # the event of the last copy's end
