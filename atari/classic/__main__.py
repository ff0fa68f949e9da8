"""`python -m atari.classic script.py [arguments]`: run a script of Gym's time; its `import gym` gives this package."""

import importlib
import os
import pkgutil
import runpy
import sys
from types import TracebackType

import atari.classic
from atari.classic import old_numpy

_USAGE = "usage: python -m atari.classic script.py [arguments of the script]"


def main(arguments: list[str]) -> int:
    """Run a script as `python script.py` would, and return its exit code."""
    if not arguments or arguments[0] in ("-h", "--help"):
        print(f"{_USAGE}\n\nRuns a script of OpenAI Gym's time: `import gym` gives it atari.classic.")
        return 0 if arguments else 2
    script = arguments[0]
    if not os.path.isfile(script):
        print(f"atari.classic: there is no script {script!r}; {_USAGE}", file=sys.stderr)
        return 2
    stand_in()
    old_numpy.restore()
    sys.argv = arguments
    sys.path.insert(0, os.path.dirname(os.path.abspath(script)))  # modules in the script's folder can be imported
    try:
        runpy.run_path(script, run_name="__main__")
    except (Exception, KeyboardInterrupt) as error:
        trace = _from_script(error.__traceback__, script)
        sys.excepthook(type(error), error.with_traceback(trace), trace)
        return 130 if isinstance(error, KeyboardInterrupt) else 1
    return 0


def stand_in() -> None:
    """Let `import gym` give this package, and the import of a module of `gym` the module of that name here."""
    name = atari.classic.__name__
    sys.modules["gym"] = atari.classic
    for module in pkgutil.walk_packages(atari.classic.__path__, f"{name}."):
        if not module.name.endswith("__main__"):
            sys.modules["gym" + module.name.removeprefix(name)] = importlib.import_module(module.name)
    sys.modules["gym.error"] = atari.classic.error


def _from_script(trace: TracebackType | None, script: str) -> TracebackType | None:
    """The part of a traceback inside the script; empty for a syntax error of the script."""
    while trace is not None and trace.tb_frame.f_code.co_filename != script:
        trace = trace.tb_next
    return trace


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
