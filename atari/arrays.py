"""NumPy arrays as PyTorch's and JAX's, without a copy (DLPack). Neither is imported unless it is asked for."""

from typing import Any

import gymnasium


def to_torch(arrays: Any, device: Any = None) -> Any:
    """An array, or a dict, list or tuple of them, as PyTorch tensors.

    On the CPU they are the same memory, which environments leave alone while the tensor lives. On another device they
    are copies.

    Raises:
        gymnasium.error.DependencyNotInstalled: PyTorch is not installed.
    """
    try:
        import torch
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled("atari.to_torch needs PyTorch: pip install torch") from None

    def convert(array: Any) -> Any:
        tensor = torch.from_dlpack(array) if array.flags.writeable else torch.tensor(array)
        return tensor if device is None else tensor.to(device)

    return _mapped(convert, arrays)


def to_jax(arrays: Any) -> Any:
    """An array, or a dict, list or tuple of them, as JAX arrays.

    They may be the same memory, which JAX takes for constant, and which environments leave alone while the array lives.

    Raises:
        gymnasium.error.DependencyNotInstalled: JAX is not installed.
    """
    try:
        import jax.numpy
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled("atari.to_jax needs JAX: pip install jax") from None
    return _mapped(jax.numpy.from_dlpack, arrays)


def _mapped(convert: Any, arrays: Any) -> Any:
    if isinstance(arrays, dict):
        return {name: _mapped(convert, array) for name, array in arrays.items()}
    if isinstance(arrays, (list, tuple)):
        return type(arrays)(_mapped(convert, array) for array in arrays)
    return convert(arrays)
