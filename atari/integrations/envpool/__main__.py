"""`python -m atari.integrations.envpool script.py [arguments]`: run a script whose `import envpool` gives this package.

If Gym is not installed, `import gym` imports `atari.classic`.
"""

import sys
from importlib.util import find_spec
from types import ModuleType

from atari.base.script import run_script
from atari.classic.__main__ import stand_in as stand_in_for_gym
from atari.integrations import envpool
from atari.integrations.envpool import registration

_HELP = "Runs a script written for EnvPool: `import envpool` gives it atari.integrations.envpool."


def main(arguments: list[str]) -> int:
    """Run a script like `python script.py`, and return its exit code."""
    return run_script("atari.integrations.envpool", _HELP, arguments, stand_in)


def stand_in() -> None:
    """Make `import envpool` import this package; `envpool.python.protocol` has the type `EnvPool` for annotations."""
    if find_spec("gym") is None:
        stand_in_for_gym()
    sys.modules["envpool"] = envpool
    sys.modules["envpool.atari"], sys.modules["envpool.registration"] = envpool.atari, registration
    for name in ("envpool.python", "envpool.python.protocol"):
        sys.modules[name] = ModuleType(name)
    for name in ("ArraySpec", "EnvPool", "EnvSpec", "GymnasiumEnvPool"):
        vars(sys.modules["envpool.python.protocol"])[name] = getattr(envpool, name)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
