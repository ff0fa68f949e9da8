"""Vector environments inside functions that JAX compiles: `xla`.

`functions.py` has the functions, `results.py` their results, `callback.py` the callbacks in Python for GPUs. JAX is
imported when `xla` is called.
"""

from typing import Any

from atari._renamed import missing
from atari.integrations.jax.functions import xla

__all__ = ["xla"]


def __getattr__(name: str) -> Any:
    raise missing("atari.integrations.jax", name)
