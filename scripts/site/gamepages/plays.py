"""The plays of docs/games/replays: the replay of a game, and its facts in index.toml."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from atari.games.toml_file import tomllib

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "docs" / "games" / "replays"


@dataclass(frozen=True)
class Play:
    """A recorded play: its policy, its score, the mean score of random play of as many frames, and how it was made."""

    path: Path
    policy: str
    score: float
    random_score: float
    frames: int
    how: str
    mode: int
    difficulty: int


@cache
def _index() -> dict[str, dict[str, Any]]:
    path = FOLDER / "index.toml"
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def play_of(game: str) -> Play | None:
    """The play of a game, or None."""
    facts, path = _index().get(game), FOLDER / f"{game}.a26r"
    if facts is None or not path.exists():
        return None
    names = ("policy", "score", "random_score", "frames", "how", "mode", "difficulty")
    return Play(path, **{name: facts[name] for name in names})
