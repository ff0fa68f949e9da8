"""The parts of the page without a built core, for tests of how pages are written."""

import shutil
from pathlib import Path

SOURCES = Path(__file__).parents[2]
CATCH = SOURCES / "examples" / "catch"
CORE = b"a core"


def parts(folder: Path) -> Path:
    """Copy the parts as scripts/web does, with other bytes in place of the core."""
    folder.mkdir()
    for path in (
        *(SOURCES / "web" / "page").iterdir(),
        SOURCES / "web" / "core" / "core.js",
        *(SOURCES / "atari" / "lab" / "inspector" / "static" / f"{name}.js" for name in ("dom", "screen", "touch")),
        *(CATCH / f"catch.{ending}" for ending in ("bin", "toml")),
    ):
        shutil.copy(path, folder)
    (folder / "core.wasm").write_bytes(CORE)
    return folder
