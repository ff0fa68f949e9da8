"""NumPy arrays as arrays of PyTorch and JAX, without a copy (DLPack). Each library is imported at the first call."""

from typing import Any

import numpy as np

from atari.base.extras import import_extra, pip_install


def to_torch(arrays: Any, device: Any = None, pin_memory: bool = False) -> Any:
    """An array, or a dict, list or tuple of them, as PyTorch tensors.

    On the CPU, tensors share the memory of the arrays, which environments do not overwrite while a tensor exists. On
    another device they are copies.

    Args:
        arrays: the arrays.
        device: PyTorch's name of a device, such as "cuda"; None means the CPU.
        pin_memory: copy to page-locked memory first, from which a GPU copies asynchronously. Without CUDA it has no
            effect.

    Raises:
        gymnasium.error.DependencyNotInstalled: PyTorch is not installed.
        TypeError: something else is given, or PyTorch has no such dtype.

    Example:
        >>> import atari
        >>> envs = atari.AtariVectorEnv("pong", 8)
        >>> observations, info = envs.reset(seed=0)
        >>> atari.to_torch(observations).shape  # the memory of the array, without a copy
        torch.Size([8, 4, 84, 84])
    """
    torch = import_extra("torch", f"atari.to_torch needs PyTorch: {pip_install('torch')}")
    pins = pin_memory and torch.cuda.is_available()

    def convert(array: Any) -> Any:
        tensor = torch.from_dlpack(array) if array.flags.writeable else torch.tensor(array)
        tensor = tensor.pin_memory() if pins else tensor
        return tensor if device is None else tensor.to(device, non_blocking=pins)

    return _mapped(convert, arrays)


def to_jax(arrays: Any) -> Any:
    """An array, or a dict, list or tuple of them, as JAX arrays.

    They may share the memory of the NumPy arrays, which environments do not overwrite while a JAX array exists.

    Raises:
        gymnasium.error.DependencyNotInstalled: JAX is not installed.
        TypeError: something else is given, or JAX has no such dtype.
    """
    jax = import_extra("jax", f"atari.to_jax needs JAX: {pip_install('jax')}")
    return _mapped(jax.numpy.from_dlpack, arrays)


def _mapped(convert: Any, arrays: Any) -> Any:
    if isinstance(arrays, dict):
        return {name: _mapped(convert, array) for name, array in arrays.items()}
    if isinstance(arrays, (list, tuple)):
        return type(arrays)(_mapped(convert, array) for array in arrays)
    if not hasattr(arrays, "__dlpack__") and not isinstance(arrays, np.generic):
        raise TypeError(f"arrays must be NumPy arrays, or dicts, lists and tuples of them, got {arrays!r:.80}")
    try:
        return convert(arrays)
    except BufferError as error:  # of a dtype that DLPack does not have, or not in this machine's order of bytes
        raise TypeError(f"an array of dtype {getattr(arrays, 'dtype', None)} cannot be converted: {error}") from None
