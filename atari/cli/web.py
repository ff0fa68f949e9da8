"""`atari web`: the page in which games play in a browser, with one's own replays and games."""

import argparse
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from atari.base.progress import ProgressBar
from atari.cli.arguments import Commands, add_command
from atari.cli.policies import PolicyGame
from atari.cli.printing import print_json, print_table, print_warning, printed_warnings
from atari.games.catalog import games
from atari.games.game import Game
from atari.recording import Replay
from atari.recording.replay import file_format
from atari.recording.replay.shown import on_page
from atari.task.parser import number
from atari.web.bundle import ONE_FILE
from atari.web.film import frames_of
from atari.web.folder import check_folder, write_page
from atari.web.shelf import Shown, check_built, own_image, unique

_LONGEST = 600
"""The most seconds of a film."""


def register(commands: Commands) -> None:
    """Add `atari web`."""
    parser = add_command(commands, "web", _web, "write a page in which games and replays play in a browser")
    parser.add_argument(
        "sources",
        nargs="*",
        metavar="SOURCE",
        help="a replay; a run folder or the file of a policy, which plays a game of its task; or the definition of a "
        "game of your own (.toml), whose ROM comes with the page (default: the page alone, in which `catch` plays)",
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("page"), metavar="FOLDER", help="for the page (default: page)"
    )
    parser.add_argument(
        "--seconds",
        type=number(float, 0, _LONGEST),
        default=60,
        metavar="S",
        help="the length of the films, which readers without a game's ROM see; 0 writes none (default: 60)",
    )


def _web(args: argparse.Namespace) -> int:
    check_built()
    check_folder(args.output)
    own = _own_games([source for source in args.sources if _is_game(source)])
    found = [_find(source, own) for source in args.sources if not _is_game(source)]
    with tempfile.TemporaryDirectory() as folder:
        replays = [
            one if isinstance(one, _Named) else _Named(one.play(Path(folder, f"{index}.a26r")), Path(one.source).stem)
            for index, one in enumerate(found)
        ]
        shown = unique(_shown(one, args.seconds) for one in replays)
    sizes = write_page(args.output, shown, own)
    if args.json:
        print_json(_facts(args.output, shown, sizes))
    else:
        _print(args.output, shown, sizes)
    return 0


def _is_game(source: str) -> bool:
    return source.endswith(".toml")


def _own_games(paths: list[str]) -> list[Game]:
    """The games of definitions.

    Raises:
        FileNotFoundError, ValueError: there is no such definition, or no ROM of the game, or the ROM of another game.
    """
    own: list[Game] = []
    for path in paths:
        game = games.resolve(path)
        same = _with_id(game.id, own)
        if same is not None:
            raise ValueError(f"{same.file} and {path} both define {game.id!r}; leave one of them out")
        own_image(game)
        own.append(game)
    return own


def _with_id(game_id: object, own: list[Game]) -> Game | None:
    return next((game for game in own if game.id == game_id), None)


def _find(source: str, own: list[Game]) -> "_Named | PolicyGame":
    """The replay or the policy of an argument.

    Raises:
        FileNotFoundError, ValueError: there is none; see `_read` and `PolicyGame.load`.
    """
    if not Path(source).exists():
        raise FileNotFoundError(
            f"there is no {source}; a SOURCE is a replay, a run folder, the file of a policy, or the definition of a "
            "game of your own (.toml)"
        )
    return _read(source, own) if file_format.is_replay(source) else PolicyGame.load(source)


@dataclass(frozen=True)
class _Named:
    """A replay with its name on the page.

    Attributes:
        playable: whether there is the ROM that a film needs.
    """

    replay: Replay
    name: str
    playable: bool = True


def _read(source: str, own: list[Game]) -> _Named:
    """The replay of a file.

    Raises:
        ValueError: the file is damaged, or of a game that is not known, or of another ROM.
        FileNotFoundError: there is no such file.
    """
    path = Path(source)
    content = file_format.read(path)
    game_id = content.header.get("game")
    game = _with_id(game_id, own)
    if game is None and game_id not in games:
        raise ValueError(f"{path} is a replay of {game_id!r}, a game of its own; name its definition (.toml), too")
    try:
        with printed_warnings():
            return _Named(Replay.load(path, game=game), path.stem)
    except FileNotFoundError as error:
        print_warning(f"{path} is on the page without a film, because its game cannot be played here: {error}")
        return _Named(Replay(path, content, game or games[str(game_id)]), path.stem, playable=False)


def _shown(one: _Named, seconds: float) -> Shown:
    replay = one.replay
    seconds = seconds if one.playable else 0
    frames = min(replay.frames_total, math.ceil(seconds * replay.game.screen.frame_rate))
    with ProgressBar(total=frames, unit=" frames", disable=None if frames else True, leave=False) as bar:
        return on_page(replay, seconds, name=one.name, progress=bar.update)


def _facts(folder: Path, shown: list[Shown], sizes: dict[str, int]) -> dict[str, Any]:
    return {
        "folder": folder.resolve(),
        "bytes": sum(sizes.values()) - sizes[ONE_FILE],
        "file": (folder / ONE_FILE).resolve(),
        "file_bytes": sizes[ONE_FILE],
        "replays": [
            {
                "name": one.name,
                "title": one.title,
                "bytes": len(one.replay),
                "film_seconds": _seconds(one),
                "film_bytes": len(one.film or b""),
            }
            for one in shown
        ],
    }


def _seconds(one: Shown) -> float:
    """The length of a film."""
    return frames_of(one.film) / one.game.screen.frame_rate if one.film else 0.0


def _print(folder: Path, shown: list[Shown], sizes: dict[str, int]) -> None:
    facts = _facts(folder, shown, sizes)
    print(f"{facts['file']}  {facts['file_bytes']:,} bytes; open it in a browser, or send it")
    print(f"{facts['folder']}  {facts['bytes']:,} bytes without this file; copy the folder to any web server")
    if shown:
        rows = [("  link", "title", "replay", "film")]
        for one in shown:
            film = f"{_seconds(one):.1f} s, {len(one.film):,} bytes" if one.film else "none"
            rows.append((f"  #show={one.name}", one.title, f"{len(one.replay):,} bytes", film))
        print_table(rows)
