"""Placeholder."""
from pathlib import Path
from ale_py import roms as _r
def find(game: str, path=None) -> Path:
    """Find."""
    return Path(_r.get_rom_path(game))
