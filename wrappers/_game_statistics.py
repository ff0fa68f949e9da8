"""`GameStatistics`: statistics of the whole game, for the presets."""

from typing import Any

import gymnasium
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs

from atari.base.gymnasium_versions import adds_episode
from atari.env.episode_env import STEPS_WITHOUT_PROGRESS, WaitingCheck
from atari.env.restorable import Restorable
from atari.wrappers._checks import Environment, action_meanings, require_atari


class GameStatistics(Restorable, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Add the counts of `AtariEnv` to `info`: rewards before clipping, and whole games, across lost lives.

    Each `info` has, under EnvPool's names: "reward", the reward before clipping, a float; "elapsed_step", the steps of
    the game despite lost lives; "terminated", whether the game is over. When a game has ended, in the step or inside
    the reset, `info` has "episode", see `atari.wrappers.preset`. Gymnasium's `RecordEpisodeStatistics` adds this key
    itself: inside it, the info of a step has none.

    In games with FIRE, the first 9,000 frames in which nothing happens give a warning: the game may wait for it.

    Args:
        env: an `AtariEnv` with wrappers that do not change the reward.
    """

    def __init__(self, env: Environment) -> None:
        RecordConstructorArgs.__init__(self)
        super().__init__(env)
        self._atari = require_atari(env, "GameStatistics")
        meanings = action_meanings(env) if isinstance(env.action_space, spaces.Discrete) else []
        self._waiting = WaitingCheck(self._atari, meanings)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset, and add the statistics to `info`."""
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, self._with_statistics(info, 0.0, truncated=False)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step, and add the statistics to `info`."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        game = self._atari.driver.played
        game.steps += 1
        if game.steps % STEPS_WITHOUT_PROGRESS == 0:
            self._waiting.warn(action)
        return observation, reward, terminated, truncated, self._with_statistics(info, reward, truncated)

    def _with_statistics(self, info: dict[str, Any], reward: Any, truncated: bool) -> dict[str, Any]:
        driver = self._atari.driver
        over, ended = driver.core.game_over, driver.ended
        info = {**info, "reward": reward, "elapsed_step": driver.played.steps, "terminated": over}
        if ended is not None or truncated:  # `truncated` may come from a wrapper, unseen by the environment
            if not adds_episode(self):
                info["episode"] = ended or driver.played.statistics(driver.core)
            driver.ended = None
        return info
