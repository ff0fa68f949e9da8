"""EnvPool's module `envpool.registration`."""

from collections.abc import Sequence
from typing import Any

from atari.integrations.envpool.pool import (
    GymnasiumEnvPool as GymnasiumEnvPool,
)
from atari.integrations.envpool.pool import (
    list_all_envs,
    make,
    make_dm,
    make_gym,
    make_gymnasium,
)
from atari.integrations.envpool.spec import EnvPoolSpec, import_dm, make_spec, register, task_ids

__all__ = ["list_all_envs", "make", "make_dm", "make_gym", "make_gymnasium", "make_spec", "register", "registry"]

EnvSpec = EnvPoolSpec
base_path = ""
"""The value of the option `base_path`: ROM files are searched for by `atari.roms`."""


class EnvRegistry:
    """The tasks by name, and the functions of the module as methods."""

    register, make_spec = staticmethod(register), staticmethod(make_spec)
    make, make_dm, make_gymnasium = staticmethod(make), staticmethod(make_dm), staticmethod(make_gymnasium)
    list_all_envs = staticmethod(list_all_envs)

    @property
    def specs(self) -> dict[str, tuple[str, str, dict[str, Any]]]:
        """The module and the class of each task's spec, and its options."""
        return {name: ("envpool.atari", "AtariEnvSpec", {"task": game}) for name, game in task_ids().items()}

    @property
    def envpools(self) -> dict[str, dict[str, Sequence[str]]]:
        """The module and the class of each task's environments, by the type of environments."""
        kinds = {"dm": ("envpool.atari", "AtariDMEnvPool"), "gymnasium": ("envpool.atari", "AtariGymnasiumEnvPool")}
        return {name: dict(kinds) for name in task_ids()}


registry = EnvRegistry()


def __getattr__(name: str) -> Any:
    if name == "DMEnvPool":  # needs dm_env
        return import_dm().DMEnvPool
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
