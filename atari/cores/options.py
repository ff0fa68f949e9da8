"""`CoreOptions`: the options of every core, checked against what the game offers."""

from dataclasses import dataclass, fields
from typing import Any

from atari.base.validation import AleError, as_integer, check_integer, check_probability
from atari.games.game import Game

SEED_LIMIT = 2**32
_FRAMES_LIMIT = 2**31


@dataclass(frozen=True)
class CoreOptions:
    """The options of a core, after checking."""

    repeat_action_probability: float = 0.25
    mode: int | None = None
    difficulty: int | None = None
    frame_skip: int = 1
    max_num_frames_per_episode: int = 0
    sound: bool = False
    color_averaging: bool = False

    @classmethod
    def check(cls, game: Game, /, **options: Any) -> "CoreOptions":
        """Check a user's options against the options that `game` offers; other arguments of a core have no effect."""
        options = {field.name: options.get(field.name, field.default) for field in fields(cls)}
        probability = options["repeat_action_probability"]
        checked = cls(
            repeat_action_probability=check_probability("repeat_action_probability", probability),
            mode=None if options["mode"] is None else check_mode(game, options["mode"]),
            difficulty=None if options["difficulty"] is None else check_difficulty(game, options["difficulty"]),
            frame_skip=check_integer("frame_skip", options["frame_skip"], 1, 10_000),
            max_num_frames_per_episode=check_integer(
                "max_num_frames_per_episode", options["max_num_frames_per_episode"], 0, _FRAMES_LIMIT - 1
            ),
            sound=bool(options["sound"]),
            color_averaging=bool(options["color_averaging"]),
        )
        if game.rules is not None and game.rules.selection_frames:
            _check_selection(game, game.rules.selection_frames, checked)
        return checked


def _check_selection(game: Game, frames: int, options: CoreOptions) -> None:
    """Raise an error for options with which the mode selection of a reset might never end.

    Within these bounds, ale-py's reset ended in each of thousands of trials.
    """
    because = f"{game.id} selects its mode at reset by playing, which may never end with"
    if options.repeat_action_probability > 0.7:
        raise ValueError(f"{because} repeat_action_probability above 0.7, got {options.repeat_action_probability}")
    if options.frame_skip > 4:
        raise ValueError(f"{because} frame_skip above 4, got {options.frame_skip}")
    needed, limit = frames * options.frame_skip, options.max_num_frames_per_episode
    if 0 < limit < needed:
        raise ValueError(f"{because} max_num_frames_per_episode below {needed}, got {limit}")


def check_mode(game: Game, mode: Any) -> int:
    """`mode` as an int, which must be one of the game's modes."""
    return _check_choice("mode", mode, game.modes, game)


def check_difficulty(game: Game, difficulty: Any) -> int:
    """`difficulty` as an int, which must be one of the game's difficulties."""
    return _check_choice("difficulty", difficulty, game.difficulties, game)


def _check_choice(name: str, value: Any, choices: tuple[int, ...], game: Game) -> int:
    number = as_integer(value)
    if number is None:
        raise TypeError(f"{name} must be an integer or None, got {value!r}")
    if number not in choices:
        raise AleError(f"{game.id} has no {name} {number}; it has {', '.join(map(str, choices))}")
    return number
