"""ROM files: find, verify, identify and import them, by their content and never by their names.

ale-py's wheel carries the ROM files of every game, so nothing has to be set up. `find` searches, in this order, a path
that you give, the folders in the environment variable `ATARI_ROMS` (separated like those of `PATH`), your own folder
(`path`, filled by `import_from` and `install`), and ale-py's wheel. Each file in these folders is a candidate under
any name, such as `Breakout (1978) (Atari).a26`, plain or gzip-compressed.
"""

from atari.roms.autorom import install
from atari.roms.identification import Identification, identify
from atari.roms.importing import ImportReport, import_from
from atari.roms.locations import folders, path
from atari.roms.search import Check, find, installed, verify

__all__ = [
    "Check",
    "Identification",
    "ImportReport",
    "find",
    "folders",
    "identify",
    "import_from",
    "install",
    "installed",
    "path",
    "verify",
]
