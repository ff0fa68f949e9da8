"""Run a user's script like `python script.py`, for programs that first replace modules."""

import os
import sys
from collections.abc import Callable
from types import ModuleType, TracebackType

from atari.base.program import end_imports, run


def run_script(program: str, help_text: str, arguments: list[str], prepare: Callable[[], None]) -> int:
    """Run a script and return its exit code.

    Args:
        program: the module's name, such as "atari.classic".
        help_text: the text below the usage in `--help`.
        arguments: the script's path, and its own arguments.
        prepare: a function to call before the script runs.
    """
    usage = f"usage: python -m {program} script.py [arguments of the script]"

    def explain() -> int:
        if not arguments or arguments[0] in ("-h", "--help"):
            print(f"{usage}\n\n{help_text}")
            return 0 if arguments else 2
        print(f"{program}: there is no script {arguments[0]!r}; {usage}", file=sys.stderr)
        return 2

    if not arguments or not os.path.isfile(script := arguments[0]):
        return run(explain)
    prepare()
    end_imports()
    sys.argv = arguments
    sys.path.insert(0, os.path.dirname(os.path.abspath(script)))  # modules in the script's folder can be imported
    try:
        _run(script)
    except (Exception, KeyboardInterrupt) as error:
        trace = _from_script(error.__traceback__, script)
        sys.excepthook(type(error), error.with_traceback(trace), trace)
        return 130 if isinstance(error, KeyboardInterrupt) else 1
    return 0


def _run(script: str) -> None:
    # Not runpy.run_path: the interpreter clears `__main__` at its end, so that the script's environments are closed.
    module = sys.modules["__main__"] = ModuleType("__main__")
    module.__file__ = script
    with open(script, "rb") as file:
        code = compile(file.read(), script, "exec")
    exec(code, vars(module))


def _from_script(trace: TracebackType | None, script: str) -> TracebackType | None:
    """The part of a traceback inside the script; empty for a syntax error of the script."""
    while trace is not None and trace.tb_frame.f_code.co_filename != script:
        trace = trace.tb_next
    return trace
