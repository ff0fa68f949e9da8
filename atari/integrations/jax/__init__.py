"""Vector environments inside functions that JAX compiles: `xla`.

`functions.py` has the functions; `results.py`, what they return; `callback.py`, the way through Python for GPUs. JAX is
imported when `xla` is called.
"""

from atari.integrations.jax.functions import XlaFunctions, xla

__all__ = ["XlaFunctions", "xla"]
