"""The header of a replay: the game, the ROM and the options that it names, checked before anything is played."""

from collections.abc import Mapping
from os import PathLike
from typing import Any

from atari.base.validation import check_name
from atari.env.env import ALE_OPTIONS
from atari.games.catalog import games
from atari.games.game import Game
from atari.games.interventions import resolve
from atari.recording.replay.file_format import Corrupt
from atari.recording.replay.players import make_core
from atari.recording.replay.recorded_core import rom_md5
from atari.task import Task
from atari.task.fields import DEFAULTS
from atari.task.resolution import translate

_MAY_BE_NONE = ("mode", "difficulty", "max_num_frames_per_episode", "interventions")
"""The options that may be None in a header."""


def game_of_header(
    header: Mapping[str, Any], game: str | PathLike[str] | Game | None, rom: str | PathLike[str] | None
) -> Game:
    """Check a header and find its game; `Replay.load` documents `game` and `rom`.

    Raises:
        Corrupt, ValueError, FileNotFoundError: see `Replay.load`.
    """
    if not isinstance(header.get("game"), str) or not isinstance(header.get("options"), dict):
        raise Corrupt("the replay is damaged: its header has no game, or no options")
    if game is None and header["game"] not in games:  # never a path: a replay must not choose files to read
        raise ValueError(f"{games.unknown(header['game'])}; pass the game file of a game of your own as game=")
    find = games.resolve if "players" in header else games.find
    found = find(header["game"] if game is None else game)
    for name, value in header.items():
        if name != "options" and not isinstance(value, (str, int, type(None))):
            raise Corrupt(f"the replay is damaged: its header is wrong ({name} is a {type(value).__name__})")
    if "players" not in header:
        _check_options(header, found)
    md5 = rom_md5(found, rom)
    if md5 != header.get("rom"):
        raise ValueError(
            f"the replay was recorded with a ROM of MD5 {header.get('rom')}, but the ROM of {found.id} here has "
            f"{md5}; pass the right one as rom="
        )
    if "players" in header:
        make_core(header, found, rom)
    return found


def _check_options(header: Mapping[str, Any], game: Game) -> None:
    """Check the options and the task in the header of a replay of one player."""
    options, task = header["options"], header.get("task")
    if not isinstance(task, str):
        raise Corrupt("the replay is damaged: its header has no task")
    try:
        for name, value in options.items():
            check_name("an option", name, ALE_OPTIONS)
            if value is None and name not in _MAY_BE_NONE:
                raise TypeError(f"{name} is null")
        interventions = options.get("interventions")
        # Names and paths are refused, because a replay must not choose files to read.
        if not all(isinstance(definition, dict) for definition in interventions or ()):
            raise TypeError("interventions must be a list of definitions")
        resolve(game, interventions)
        emulator_task(options, game)
        Task.from_json(task, game)
    except (TypeError, ValueError, OverflowError) as error:
        raise Corrupt(f"the replay is damaged: its header is wrong ({error})") from None


def emulator_task(options: Mapping[str, Any], game: Game) -> Task:
    """The task that an `AtariEnv` plays without wrappers, by the options in a header, which are ale-py's.

    Raises:
        TypeError, ValueError: an option is wrong.
    """
    given, _ = translate(options, "the replay")
    fields = {**DEFAULTS, "max_num_frames_per_episode": None, **given, "game": game}
    return Task(**fields)
