"""EnvPool's module `envpool.registration`."""

from atari.integrations.envpool.pool import list_all_envs, make, make_dm, make_gym, make_gymnasium
from atari.integrations.envpool.spec import make_spec, register

__all__ = ["list_all_envs", "make", "make_dm", "make_gym", "make_gymnasium", "make_spec", "register"]
