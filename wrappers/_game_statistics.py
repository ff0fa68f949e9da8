"""`GameStatistics`: what was played of the whole game, for the presets."""

from typing import Any

import gymnasium
from gymnasium.utils import RecordConstructorArgs

from atari.restorable import Restorable
from atari.wrappers._checks import Environment, require_atari


class GameStatistics(Restorable, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Add to `info` what `AtariEnv` counts: rewards before clipping, and whole games, across lost lives.

    Each `info` has, under EnvPool's names: "reward", the reward before clipping, a float; "elapsed_step", the steps of
    the game, lost lives do not matter; "terminated", whether the game is over. When a game has ended, in the step or
    inside the reset, `info` has "episode", see `atari.wrappers.preset`.

    Args:
        env: an `AtariEnv` with wrappers that do not change the reward.
    """

    def __init__(self, env: Environment) -> None:
        RecordConstructorArgs.__init__(self)
        super().__init__(env)
        self._atari = require_atari(env, "GameStatistics")

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset, and add the statistics to `info`."""
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, self._with_statistics(info, 0.0, truncated=False)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step, and add the statistics to `info`."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self._atari._game.steps += 1
        return observation, reward, terminated, truncated, self._with_statistics(info, reward, truncated)

    def _with_statistics(self, info: dict[str, Any], reward: Any, truncated: bool) -> dict[str, Any]:
        atari = self._atari
        over, ended = atari.core.game_over, atari._ended_game
        info = {**info, "reward": reward, "elapsed_step": atari._game.steps, "terminated": over}
        if ended is not None or truncated:  # truncated by a wrapper, which the environment does not see
            info["episode"] = ended or atari._game_statistics()
            atari._ended_game = None
        return info
