"""The rules of a game for several players, compiled for the emulator."""

from dataclasses import replace
from functools import lru_cache

import atari._emulator as _emulator
from atari.cores.native import make_game
from atari.games.compiler import compile_rules
from atari.games.game import Game
from atari.games.players import rules_of


@lru_cache(maxsize=64)
def compiled_for_players(
    game: Game, image: bytes, parameters: tuple[tuple[str, int], ...] = (), corrected: bool = False
) -> _emulator.Game:
    """The game with its rules for several players, built once and shared."""
    rules = rules_of(game)
    step_rules = rules.corrected if corrected and rules.corrected else rules.rules
    if parameters:
        step_rules = replace(step_rules, state={**step_rules.state, **dict(parameters)})
    return make_game(
        game,
        image,
        compile_rules(step_rules),
        legal_actions=range(18),
        starting_actions=rules.starting_actions,
        default_mode=rules.loading_mode,
        paddle_range=rules.paddle_range,
    )
