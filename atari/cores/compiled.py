"""The games and the rewards of the emulator, compiled from game definitions and from the expressions of tasks."""

from collections.abc import Iterable
from dataclasses import asdict, replace
from functools import lru_cache
from typing import Any

import atari._emulator as _emulator
from atari.games.compiler import CompiledRules, compile_rules
from atari.games.game import Game
from atari.games.players import rules_of
from atari.games.rewards import compile_reward
from atari.roms.image import md5

_F8_SWAPPED = {"bc24440b59092559a1ec26055fd1270e", "75ee371ccfc4f43e7d9b8f24e1266b55"}
_NO_RULES = CompiledRules(
    variables=4, initial=[], kept=[], outputs=[1, 3, 0, 2], step=[_emulator.END, 0], select_mode=[_emulator.END, 0]
)
"""The rules of a game without single-player rules: no reward, no lives, no end."""


@lru_cache(maxsize=128)
def compiled(game: Game, image: bytes) -> _emulator.Game:
    """The game for the emulator, built once and shared by all cores of the game."""
    return _emulator.make_game(**definition(game, image))


def definition(game: Game, image: bytes) -> dict[str, Any]:
    """The arguments of `_emulator.make_game` for the game with its rules for one player."""
    return _definition(
        game,
        image,
        compile_rules(game.rules) if game.rules else _NO_RULES,
        legal_actions=game.legal_actions or range(18),
        starting_actions=game.starting_actions,
        default_mode=game.default_mode,
    )


@lru_cache(maxsize=64)
def compiled_for_players(
    game: Game, image: bytes, parameters: tuple[tuple[str, int], ...] = (), corrected: bool = False
) -> _emulator.Game:
    """The game with its rules for several players, built once and shared by all cores of the game."""
    return _emulator.make_game(**definition_for_players(game, image, parameters, corrected))


def definition_for_players(
    game: Game, image: bytes, parameters: tuple[tuple[str, int], ...] = (), corrected: bool = False
) -> dict[str, Any]:
    """The arguments of `_emulator.make_game` for the game with its rules for several players."""
    rules = rules_of(game)
    step_rules = rules.corrected if corrected and rules.corrected else rules.rules
    if parameters:
        step_rules = replace(step_rules, state={**step_rules.state, **dict(parameters)})
    return _definition(
        game,
        image,
        compile_rules(step_rules),
        legal_actions=range(18),
        starting_actions=rules.starting_actions,
        default_mode=rules.loading_mode,
        paddle_range=rules.paddle_range,
    )


@lru_cache(maxsize=256)
def reward_formula(game: Game, text: str) -> _emulator.RewardFormula:
    """The formula of an expression, which environments share.

    Raises:
        ValueError: the expression is outside the language of `atari.games.rewards`.
    """
    compiled = compile_reward(game, text)
    try:
        return _emulator.RewardFormula(**asdict(compiled))
    except ValueError as error:
        raise ValueError(f"reward: {text!r} is too large for the emulator: {error}") from None


def _definition(
    game: Game,
    image: bytes,
    rules: CompiledRules,
    *,
    legal_actions: Iterable[int],
    starting_actions: Iterable[int],
    default_mode: int,
    paddle_range: tuple[int, int] | None = None,
) -> dict[str, Any]:
    """The arguments of `_emulator.make_game`, with rules for one or for several players."""
    controllers = game.controllers
    switches = 0x3F | (controllers.left_difficulty == "A") << 6 | (controllers.right_difficulty == "A") << 7
    swapped = md5(image) in _F8_SWAPPED and not game.rom.cartridge
    return {
        "image": image,
        "cartridge": "F8 SWAPPED" if swapped else game.rom.cartridge,
        "format": game.screen.format,
        "detect_format": game.screen.format_detected,
        "first_line": game.screen.first_line,
        "height": game.screen.height,
        "hmove_blanks": game.screen.hmove_blanks,
        "paddles": (controllers.left == "paddles", controllers.right == "paddles"),
        "swap_ports": controllers.swap_ports,
        "swap_paddles": controllers.swap_paddles,
        "paddle_range": paddle_range or controllers.paddle_range or (27450, 790196),
        "power_on_switches": switches,
        "legal_actions": [int(action) for action in legal_actions],
        "starting_actions": [int(action) for action in starting_actions],
        "default_mode": default_mode,
        "variables": rules.variables,
        "initial": rules.initial,
        "kept": rules.kept,
        "outputs": rules.outputs,
        "step": rules.step,
        "select_mode": rules.select_mode,
    }
