"""ROM files: found, checked, named and imported. The content decides what a file is, never its name.

ale-py's wheel carries the ROM files of every game, so nothing has to be set up. `find` looks, in this order, at a path
you give, the folders in the environment variable `ATARI_ROMS` (separated like those of `PATH`), your own folder
(`path`, filled by `import_from` and `install`), and ale-py's wheel. Each file in these folders is a candidate whatever
it is called, `Breakout (1978) (Atari).a26` too, plain or gzip-compressed.
"""

from atari.roms.autorom import install
from atari.roms.identification import Identification, identify
from atari.roms.importing import ImportReport, import_from
from atari.roms.places import folders, path
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
