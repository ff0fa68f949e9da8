"""`Program`: a Python file of the user's, and the class or function in it that a training runs.

A run folder keeps copies of such files. To load the run executes the copies, which the user must trust. A program that
the user has trained with is trusted. Others are asked for once in a terminal, or entered by `RunFolder.trust`. The
SHA-256 of each trusted program is kept in the user's data folder.
"""

import ast
import hashlib
import inspect
import sys
import warnings
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from importlib.util import find_spec, module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

from platformdirs import user_data_path

from atari.base import durable
from atari.base.validation import check_file


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


def program_in_module(text: str) -> Program:
    """The program that a word MODULE:NAME names; modules of the current folder are found, too.

    Raises:
        ValueError: there is no such module, or it is no Python file.
    """
    module, _, name = text.rpartition(":")
    sys.path.insert(0, "")  # modules of this folder, as with `python -m`
    try:
        spec = find_spec(module)
    except (ImportError, ValueError) as error:
        raise ValueError(f"the module of {text} cannot be found: {error}") from error
    finally:
        sys.path.remove("")
    if spec is None or spec.origin is None or not spec.origin.endswith(".py"):
        raise ValueError(f"there is no module {module} in a Python file; give FILE.py:NAME, or MODULE:NAME, got {text}")
    return Program(Path(spec.origin), name)


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


def sha256(program: bytes) -> str:
    """The SHA-256 of a program, in hexadecimal digits."""
    return hashlib.sha256(program).hexdigest()


def trusted_file() -> Path:
    """The file with the SHA-256 of each trusted program, a line each; it need not exist yet."""
    return (user_data_path("atari-envs", appauthor=False) / "trusted_programs").absolute()


def is_trusted(digest: str) -> bool:
    """Whether the user trusts the program with a SHA-256."""
    file = trusted_file()
    return file.is_file() and digest in file.read_text(errors="replace").split()


def trust(digest: str) -> None:
    """Remember that the user trusts the program with a SHA-256. A warning says if that is not possible."""
    if is_trusted(digest):
        return
    try:
        trusted_file().parent.mkdir(parents=True, exist_ok=True)
        durable.append(trusted_file(), f"{digest}\n".encode())
    except OSError as error:
        warnings.warn(f"the trust in a program is not remembered: {error}", RuntimeWarning, stacklevel=4)


def check_trusted(file: Path, digest: str, what: str) -> None:
    """Check that the user trusts a program, or ask.

    Args:
        file: the path of the program in a run folder.
        digest: its SHA-256.
        what: its origin, for the question.

    Raises:
        PermissionError: the user does not trust it, or there is no terminal for the question.
    """
    if is_trusted(digest):
        return
    if sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty():
        print(
            f"{file} is a program of this run ({what}). Loading the run executes it.\n"
            "Trust it, now and later? [y/N] ",
            end="", file=sys.stderr, flush=True,
        )  # fmt: skip
        if sys.stdin.readline().strip().lower() in ("y", "yes"):
            trust(digest)
            return
    raise PermissionError(
        f"{file} is a program ({what}), and loading the run executes it; if you trust its author, say so once: "
        f"atari.learning.RunFolder.open({str(file.parent)!r}).trust(), or answer the question in a terminal"
    )
