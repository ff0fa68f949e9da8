"""The interface of EnvPool: `import atari.integrations.envpool as envpool`.

`python -m atari.integrations.envpool script.py` runs a script in which `import envpool` means this package.
"""

from atari.integrations.envpool.pool import EnvPool, list_all_envs, make, make_gym, make_gymnasium
from atari.integrations.envpool.spec import EnvPoolSpec, make_spec

__version__ = "1.2.5"
"""The version of EnvPool with this interface, for scripts that check it."""

__all__ = ["EnvPool", "EnvPoolSpec", "list_all_envs", "make", "make_gym", "make_gymnasium", "make_spec"]
