"""`EpisodicLife`: a lost life ends the episode.

Learning to avoid the loss of a life is easier when it ends the return (Mnih et al. 2015). Implementations differ in
the effect of the next reset, see `on_reset`. The wrapper can be outside a frame skip, as in OpenAI's Baselines. It
can also be inside `DqnPreprocessing`, which then ends the skip at the frame in which the life is lost.
"""

from typing import Any, Literal, get_args

import numpy as np
from gymnasium import spaces

from atari.base.validation import check_name
from atari.env import AtariEnv
from atari.env.restorable import RestorableWrapper, State
from atari.wrappers._checks import Environment, has_noop, step_named

OnReset = Literal["noop", "continue", "new_game"]


class EpisodicLife(RestorableWrapper):
    """Terminate when a life is lost.

    A reset after a lost life continues the same game, so that agents reach all of it. A reset with a seed, and
    `reset(options={"new_game": True})`, start a new game. Lives are `info["lives"]`; games without lives are
    unaffected.

    Args:
        env: the environment.
        on_reset: the effect of a reset after a lost life:
            "noop": it plays one step of NOOP (Baselines, Stable-Baselines3);
            "continue": it plays nothing and returns the last observation again (EnvPool and DQN 2015 then play no-ops:
                put `NoopReset` around this);
            "new_game": it starts a new game (Gymnasium, ale-py's vector environment).
        last_life: also end when the last life is lost but the game is not over yet, as Gymnasium does; some games
            (Bank Heist, Frogger) continue for a while with no life left.

    Raises:
        ValueError: `on_reset` is not one of these.

    Example:
        >>> import atari
        >>> from atari.wrappers import EpisodicLife
        >>> env = EpisodicLife(atari.make("breakout"))
        >>> observation, info = env.reset(seed=0)
        >>> ended = False
        >>> while not ended:
        ...     observation, reward, ended, truncated, info = env.step(1)
        >>> info["lives"]
        4
    """

    def __init__(self, env: Environment, on_reset: OnReset = "noop", *, last_life: bool = False) -> None:
        check_name("on_reset", on_reset, get_args(OnReset))
        super().__init__(env, on_reset=on_reset, last_life=last_life)
        self._on_reset = on_reset
        self._last_life = last_life
        self._lives = 0
        self._last: tuple[Any, dict[str, Any]] = (None, {})
        self.life_lost = False
        """Whether a life has been lost since the last reset, and the game continues."""
        self.same_game = False
        """Whether the last reset continued the same game."""

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step; also terminate if a life was lost."""
        self._warn_if_restored()
        observation, reward, terminated, truncated, info = self.env.step(action)
        inner = self.unwrapped
        if isinstance(inner, AtariEnv) and inner.driver.replacement is not None and not has_noop(self.env):
            return observation, reward, terminated, truncated, info  # if the game has no NOOP, no step is played
        self._last = observation, info
        return observation, reward, self.observe(info["lives"], terminated, truncated), truncated, info

    def observe(self, lives: int, terminated: bool, truncated: bool) -> bool:
        """Update the state after a step or a frame; returns whether this terminated the episode."""
        lost = lives < self._lives and (lives > 0 or self._last_life)
        self._lives = lives
        self.life_lost = (self.life_lost or lost) and not (terminated or truncated)
        return terminated or lost

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Continue the same game if a life was lost, else start a new one.

        Args:
            seed: the seed of the environment; a seed starts a new game.
            options: "new_game" true starts a new game; all options are passed on.
        """
        new_game = seed is not None or self._on_reset == "new_game" or (options or {}).get("new_game", False)
        same_game = self.life_lost and not new_game
        if same_game and self._on_reset == "continue":
            self.same_game, self.life_lost = True, False
            observation, info = self._last
            return observation, dict(info)
        if same_game:
            observation, _, terminated, truncated, info = step_named(self.env, "NOOP")
            same_game = not (terminated or truncated)
        if not same_game:
            observation, info = self.env.reset(seed=seed, options=options)
        self.same_game, self.life_lost, self._lives = same_game, False, info["lives"]
        return observation, info

    def _save_state(self) -> State:
        """Omit the last observation unless a reset may return it again."""
        state: dict[str, Any] = {"lives": self._lives, "life_lost": self.life_lost, "same_game": self.same_game}
        if self._on_reset == "continue":
            observation, info = self._last
            space = self.env.observation_space
            known = observation is not None
            flat = spaces.flatten(space, observation) if known else np.zeros_like(spaces.flatten_space(space).sample())
            state |= {"known": known, "observation": flat, "info": info}
        return state

    def _load_state(self, state: State) -> dict[str, Any]:
        attributes = {"_lives": state["lives"], "life_lost": state["life_lost"], "same_game": state["same_game"]}
        if self._on_reset == "continue":
            observation = spaces.unflatten(self.env.observation_space, state["observation"])
            attributes["_last"] = observation if state["known"] else None, state["info"]
        return attributes
