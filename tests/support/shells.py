"""Interactive shells on their own terminals, in which a test presses Tab."""

import os
import re
import select
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

LIMIT = 60.0
"""Seconds after which a shell counts as hung."""


class Session:
    """A shell on a pseudo-terminal, with pipes to its keyboard and from its screen."""

    def __init__(self, command: list[str], folder: Path, **environment: str) -> None:
        spawn = [sys.executable, "-c", "import pty, sys; pty.spawn(sys.argv[1:])", *command]
        pipe: Any = subprocess.PIPE
        self._process = subprocess.Popen(
            spawn, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, cwd=folder, env={**os.environ, **environment}
        )

    def press(self, keys: str) -> None:
        assert self._process.stdin
        self._process.stdin.write(keys.encode())
        self._process.stdin.flush()

    def wait_for(self, pattern: str) -> re.Match[str]:
        """The first match in the shell's output from now on."""
        assert self._process.stdout
        written = ""
        end = time.monotonic() + LIMIT
        while not (match := re.search(pattern, written)):
            readable, _, _ = select.select([self._process.stdout], [], [], max(0.0, end - time.monotonic()))
            if not readable:
                raise AssertionError(f"the shell wrote {written!r}, and not {pattern!r}")
            written += os.read(self._process.stdout.fileno(), 65536).decode(errors="replace")
        return match

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()  # the terminal is closed, which ends the shell
        self._process.communicate()


class ZshSession(Session):
    """zsh, which prints the words that its completion adds instead of completing the line."""

    SETUP = """
fpath=({folder} $fpath)
unsetopt auto_list auto_menu
LISTMAX=100000
autoload -Uz compinit && compinit -D -u
compadd() {{
  if [[ ${{@[1,(i)(-|--)]}} == *-(O|A|D)\\ * ]]; then builtin compadd "$@"; return $?; fi
  typeset -a hits
  builtin compadd -O hits "$@"
  print -rl -- $hits >>{folder}/words
  builtin compadd "$@"
}}
capture() {{ : >{folder}/words; zle complete-word; BUFFER=; print; print -r -- "WORDS:${{(j: :)${{(f)\"$(<{folder}/words)\"}}}}:" }}
zle -N capture
bindkey '^I' capture
print REA''DY
"""

    def __init__(self, functions: Path, folder: Path) -> None:
        super().__init__(["zsh", "-f", "-i"], folder, TERM="dumb")
        setup = functions / "setup.zsh"
        setup.write_text(self.SETUP.format(folder=functions))
        self.press(f"source {setup}\r")
        self.wait_for("READY")

    def complete(self, line: str) -> set[str]:
        """The words that Tab adds or suggests at the end of a line."""
        self.press(f"{line}\t")
        return set(self.wait_for(r"WORDS:(.*?):")[1].split())


class TcshSession(Session):
    """tcsh, which runs a completed line, so that it prints itself."""

    def __init__(self, script: Path, folder: Path) -> None:
        super().__init__(["tcsh", "-f"], folder, TERM="vt100")
        self.press(f"source {script}; alias atari 'echo RUN:'; set prompt='READY>'\r")
        self.wait_for(r"\nREADY>")

    def complete(self, program: str, line: str) -> str:
        """The arguments of a program after Tab."""
        self.press(f"{program} {line}\t\r")
        return self.wait_for(r"RUN: ([^\r\n]*?) *[\r\n]+READY>")[1]  # keys before the prompt are not edited
