"""NumPy arrays as PyTorch's and JAX's, without a copy (DLPack). Neither is imported unless it is asked for."""

from typing import Any

import gymnasium


def to_torch(arrays: Any, device: Any = None, pin_memory: bool = False) -> Any:
    """An array, or a dict, list or tuple of them, as PyTorch tensors.

    On the CPU they are the same memory, which environments leave alone while the tensor lives. On another device they
    are copies.

    Args:
        arrays: to be shown.
        device: as PyTorch names it, such as "cuda"; None is the CPU.
        pin_memory: copy to page-locked memory first, from which a GPU fetches while the program goes on. Where there is
            no CUDA nothing is pinned.

    Raises:
        gymnasium.error.DependencyNotInstalled: PyTorch is not installed.
    """
    try:
        import torch
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled("atari.to_torch needs PyTorch: pip install torch") from None

    pins = pin_memory and torch.cuda.is_available()

    def convert(array: Any) -> Any:
        tensor = torch.from_dlpack(array) if array.flags.writeable else torch.tensor(array)
        tensor = tensor.pin_memory() if pins else tensor
        return tensor if device is None else tensor.to(device, non_blocking=pins)

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
