"""The formulas of rewards, made for the emulator from the expressions of tasks."""

from dataclasses import asdict
from functools import lru_cache

import atari._emulator as _emulator
from atari.games.game import Game
from atari.games.rewards import compile_reward


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
