"""Vector environments inside functions that JAX compiles: `xla`.

`functions.py` has the functions, `results.py` their results, `callback.py` the callbacks in Python for GPUs. JAX is
imported when `xla` is called.
"""

from atari.integrations.jax.functions import xla

__all__ = ["xla"]
