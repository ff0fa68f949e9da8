"""`Program`: a Python file of the user's, and the class or function in it that a training runs.

A run folder keeps copies of such files. To load the run executes the copies, which the user must trust.
"""

import ast
import inspect
import sys
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

from atari.base.validation import check_file
from atari.learning.trust import sha256, trust


@dataclass(frozen=True)
class Program:
    """A file, and the name of a class or function at its top; "" is none."""

    file: Path
    name: str

    def __str__(self) -> str:
        return f"{self.file}:{self.name}" if self.name else str(self.file)


def is_program(text: str) -> bool:
    """Whether a word of a command line names a program: FILE.py or FILE.py:NAME."""
    return text.endswith(".py") or text.rpartition(":")[0].endswith(".py")


def program(text: str) -> Program:
    """The program that a word names."""
    file, colon, name = text.rpartition(":")
    return Program(Path(file), name) if colon and file.endswith(".py") else Program(Path(text), "")


def program_of(value: Any) -> Program:
    """The program of a class or function, which the user has executed already.

    Raises:
        ValueError: it stands in no file, not at the top of its file, or in a script that trains when it is loaded.
    """
    try:
        file = Path(inspect.getfile(value))
        source = file.read_bytes()
    except (TypeError, OSError):
        raise ValueError(
            f"{value.__name__} stands in no file, and a run keeps a copy of its file; write it into a file"
        ) from None
    if value.__qualname__ != value.__name__:
        raise ValueError(f"{value.__qualname__} stands inside of something else in {file}; move it to the file's top")
    if value.__module__ == "__main__" and not _has_guard(source):
        raise ValueError(
            f"a run loads {value.__name__} from a copy of {file}, which would begin the same training again; put what "
            f"the script does below `if __name__ == '__main__':`, or {value.__name__} into a file of its own"
        )
    trust(sha256(source))
    return Program(file.absolute(), value.__name__)


def _has_guard(source: bytes) -> bool:
    """Whether a script asks at its top if it is the program that runs."""
    return any(
        isinstance(node, ast.If) and any(getattr(part, "id", "") == "__name__" for part in ast.walk(node.test))
        for node in ast.parse(source).body
    )


def module_of(file: Path) -> ModuleType:
    """The module of a file, see `executed`. The user is then taken to trust it.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it cannot be executed.
    """
    source = check_file(file).read_bytes()
    module = executed(file, source)
    trust(sha256(source))
    return module


def named_in(module: ModuleType, named: Program) -> Any:
    """The class or function that a program names.

    Raises:
        ValueError: the program names none, or its file has none of this name.
    """
    if not named.name:
        raise ValueError(f"name the class or function in {named.file}, as in {named.file}:Net")
    if not callable(found := getattr(module, named.name, None)):
        raise ValueError(f"{named.file} has no class or function {named.name}")
    return found


def executed(file: Path, source: bytes) -> ModuleType:
    """The module of a source, which is executed once in a process.

    Raises:
        ValueError: it cannot be executed.
    """
    name = f"atari_program_{sha256(source)[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    module = module_from_spec(spec_from_loader(name, SourceFileLoader(name, str(file))))  # type: ignore[arg-type]
    sys.modules[name] = module  # dataclasses look for it there
    try:
        exec(compile(source, str(file), "exec"), module.__dict__)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        ours = isinstance(error, ImportError) and (error.name or "").startswith("atari")
        hint = "; it may be for another release of atari-envs" if ours else ""
        raise ValueError(f"{file} cannot be loaded{hint}: {type(error).__name__}: {error}") from error
    return module
