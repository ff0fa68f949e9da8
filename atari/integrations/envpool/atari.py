"""EnvPool's module `envpool.atari`: the classes of its Atari environments."""

from typing import Any

from atari.integrations.envpool.pool import GymnasiumEnvPool as AtariGymnasiumEnvPool
from atari.integrations.envpool.spec import EnvPoolSpec as AtariEnvSpec
from atari.integrations.envpool.spec import import_dm

__all__ = ["AtariDMEnvPool", "AtariEnvSpec", "AtariGymnasiumEnvPool"]  # noqa: F822 - the first by __getattr__


def __getattr__(name: str) -> Any:
    if name == "AtariDMEnvPool":  # needs dm_env
        return import_dm().DMEnvPool
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
