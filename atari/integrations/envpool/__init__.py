"""The interface of EnvPool: `import atari.integrations.envpool as envpool`.

`python -m atari.integrations.envpool script.py` runs a script in which `import envpool` means this package.
"""

from typing import Any

from atari.integrations.envpool import atari
from atari.integrations.envpool.pool import (
    EnvPool,
    GymnasiumEnvPool,
    list_all_envs,
    make,
    make_dm,
    make_gym,
    make_gymnasium,
)
from atari.integrations.envpool.spec import ArraySpec, EnvPoolSpec, import_dm, make_spec, register

__version__ = "1.2.5"
"""The version of EnvPool with this interface, for scripts that check it."""

EnvSpec = EnvPoolSpec
"""EnvPool's name of `EnvPoolSpec`."""

__all__ = [
    "ArraySpec",
    "EnvPool",
    "EnvPoolSpec",
    "EnvSpec",
    "GymnasiumEnvPool",
    "atari",
    "list_all_envs",
    "make",
    "make_dm",
    "make_gym",
    "make_gymnasium",
    "make_spec",
    "register",
]


def __getattr__(name: str) -> Any:
    if name == "DMEnvPool":  # needs dm_env
        return import_dm().DMEnvPool
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
