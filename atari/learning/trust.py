"""The programs of runs that a user trusts: loading a run with a program of its own executes it.

A program that the user has trained with is trusted. Others are asked for once in a terminal, or entered by
`RunFolder.trust`. The SHA-256 of each trusted program is kept in the user's data folder.
"""

import hashlib
import sys
import warnings
from pathlib import Path

from platformdirs import user_data_path

from atari.base import durable


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
