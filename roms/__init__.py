"""ROM files: find, verify, identify and import them, by their content and never by their names.

ale-py's wheel carries the ROM files of every game, so no setup is needed. `find` searches, in this order, a path
that you give, the folders in the environment variable `ATARI_ROMS` (separated as in `PATH`), your own folder
(filled by `import_from` and `install`), and ale-py's wheel. Each file in these folders is a candidate under any name,
such as `Breakout (1978) (Atari).a26`, plain or gzip-compressed.

`atari.roms.locations.folders()` returns these folders, `atari.roms.locations.path()` your own.
"""

from typing import TYPE_CHECKING, Any

from atari.roms.identification import identify
from atari.roms.search import find, installed, verify

if TYPE_CHECKING:
    from atari.roms.autorom import install
    from atari.roms.importing import import_from

__all__ = ["find", "identify", "import_from", "install", "installed", "verify"]


def __getattr__(name: str) -> Any:
    """The functions that open archives: `import atari` finds ROM files and needs no archive."""
    if name == "install":
        from atari.roms.autorom import install

        return install
    if name == "import_from":
        from atari.roms.importing import import_from

        return import_from
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
