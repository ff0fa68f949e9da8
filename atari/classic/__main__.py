"""`python -m atari.classic script.py [arguments]`: run a script of Gym's time; its `import gym` gives this package.

`python -m atari.classic --modern FILE` shows what a script for Gymnasium has in its place.
"""

import importlib
import pkgutil
import sys
from pathlib import Path

import atari.classic
from atari.base.program import run
from atari.base.script import run_script
from atari.classic import old_numpy
from atari.classic.rewrite.files import HINT, is_python_2, modernize, no_option

_HELP = """\
       python -m atari.classic --modern FILE... [--write]

Runs a script of OpenAI Gym's time: `import gym` gives it atari.classic.

  --modern FILE...  show as a diff how scripts or notebooks change for Gymnasium, and run nothing
  --write           change the files, and keep their old text as NAME.orig"""


def main(arguments: list[str]) -> int:
    """Run a script like `python script.py`, or rewrite it, and return the exit code."""
    if arguments[:1] == ["--modern"]:
        return run(lambda: modernize(arguments[1:]))
    if arguments and arguments[0].startswith("-") and arguments[0] not in ("-h", "--help"):
        print(f"atari.classic: {no_option(arguments[0], ['--modern', '--help'])}; see --help", file=sys.stderr)
        return 2
    script = Path(arguments[0]).absolute() if arguments else Path()
    if script.suffix == ".ipynb" and script.is_file():
        print(
            f"atari.classic: {script.name} is a notebook, which Jupyter runs: replace its line `import gym` by "
            "`import atari.classic as gym`, or rewrite it with --modern",
            file=sys.stderr,
        )
        return 2
    code = run_script("atari.classic", _HELP, arguments, prepare)
    if code and script.is_file() and is_python_2(script):
        print(f"atari.classic: {HINT}", file=sys.stderr)
    return code


def prepare() -> None:
    """Make `import gym` import this package, and NumPy what it was."""
    stand_in()
    old_numpy.restore()


def stand_in() -> None:
    """Make `import gym` import this package, and a module of `gym` the module of that name here."""
    name = atari.classic.__name__
    sys.modules["gym"] = atari.classic
    for module in pkgutil.walk_packages(atari.classic.__path__, f"{name}."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    for module_name in [each for each in sys.modules if each.startswith(f"{name}.")]:
        sys.modules["gym" + module_name.removeprefix(name)] = sys.modules[module_name]
    folder = str(Path(__file__).parent / "spawned")
    if folder not in sys.path:
        sys.path.insert(0, folder)  # `multiprocessing` gives the path to its processes


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
