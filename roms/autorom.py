"""Downloading the ROM files with AutoROM, the Farama Foundation's installer, which requires a licence first.

It is rarely needed, because ale-py's wheel has the files. AutoROM downloads to a temporary folder, from which only
files with the right content are imported.
"""

import contextlib
import io
import sys
import tarfile
import tempfile
import zlib
from pathlib import Path
from typing import TextIO

from gymnasium.error import DependencyNotInstalled

from atari.base.extras import install_extra
from atari.roms.importing import ImportReport, import_from


def install(accept_license: bool = False) -> ImportReport:
    """Download the ROM files with AutoROM and import them into your own folder, like `import_from`.

    Args:
        accept_license: you own a licence to the ROM files; without it, AutoROM requests confirmation on the terminal.

    Raises:
        gymnasium.error.DependencyNotInstalled: AutoROM, the extra `roms`, is missing.
        PermissionError: the licence was declined.
        ConnectionError: the download failed, for example because the machine is offline.
    """
    try:
        from AutoROM import AutoROM
    except ImportError as error:
        raise DependencyNotInstalled(
            f"AutoROM is needed to download ROM files; install it with `{install_extra('roms')}`"
        ) from error
    with tempfile.TemporaryDirectory() as folder:
        heard = _Listener(sys.stdout)
        try:
            with contextlib.redirect_stdout(heard):
                AutoROM.main(accept_license, None, folder, True)
        except RuntimeError as error:  # click's Abort: Ctrl-C, or no terminal to answer on
            raise _declined() from error
        except (OSError, ValueError, EOFError, zlib.error, tarfile.TarError) as error:
            raise _failed(repr(error)) from error
        if not any(Path(folder).iterdir()):
            # AutoROM returns silently if the licence is declined, and after a message if the download fails.
            raise _declined() if heard.text.rstrip().endswith(":") else _failed(heard.last_words())
        return import_from(folder)


def _declined() -> PermissionError:
    return PermissionError("the licence of the ROM files was not accepted, so nothing was installed")


def _failed(reason: str) -> ConnectionError:
    return ConnectionError(
        f"AutoROM could not download the ROM files, which needs the internet (it says: {reason}); "
        "offline, use the files in ale-py's wheel, or `atari roms import` on files you have"
    )


class _Listener(io.TextIOBase):
    """A stream that forwards its text to another stream, and keeps it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.text = ""

    def write(self, text: str) -> int:
        self.text += text
        return self._stream.write(text)

    def flush(self) -> None:
        self._stream.flush()

    def last_words(self) -> str:
        """The last line without a prompt, because a user types the end of a prompt's line."""
        return self.text.strip().rpartition("\n")[2].rpartition("]: ")[2]
