"""PettingZoo's module `base_atari_env`: environments of a game and a number of players, in any mode."""

from collections.abc import Callable
from os import PathLike
from typing import Any

from pettingzoo.utils import wrappers
from pettingzoo.utils.conversions import parallel_to_aec_wrapper, parallel_wrapper_fn

from atari.games.catalog import games
from atari.games.players import rules_of
from atari.multiplayer.parallel import MultiplayerEnv

__all__ = ["BaseAtariEnv", "ParallelAtariEnv", "base_env_wrapper_fn", "parallel_to_aec_wrapper", "parallel_wrapper_fn"]


class ParallelAtariEnv(MultiplayerEnv):
    """A `MultiplayerEnv` with PettingZoo's arguments.

    Args:
        game: id of a game.
        num_players: 2, 3 or 4.
        mode_num: the mode, by Multi-Agent-ALE's number; None means the first for these players.
        env_name: the name in `metadata`; None means "custom_" and the game.
        seed, obs_type, full_action_space, max_cycles, render_mode, auto_rom_install_path: see `MultiplayerEnv`.

    Raises:
        KeyError, TypeError, ValueError, FileNotFoundError: see `MultiplayerEnv`.

    Example:
        >>> from atari.multiplayer.base_atari_env import ParallelAtariEnv
        >>> env = ParallelAtariEnv("pong", 2, mode_num=10, obs_type="ram")
        >>> env.mode, env.metadata["name"], env.observation_space("first_0").shape
        (10, 'custom_pong', (128,))
    """

    def __init__(
        self,
        game: str,
        num_players: int,
        mode_num: int | None = None,
        seed: int | None = None,
        obs_type: str = "rgb_image",
        full_action_space: bool = False,
        env_name: str | None = None,
        max_cycles: int = 100_000,
        render_mode: str | None = None,
        auto_rom_install_path: str | PathLike[str] | None = None,
    ) -> None:
        definition = games[game]
        modes = rules_of(definition).modes
        super().__init__(
            definition,
            players=num_players,
            mode=min(modes[num_players]) if mode_num is None and num_players in modes else mode_num,
            seed=seed,
            obs_type=obs_type,
            full_action_space=full_action_space,
            max_cycles=max_cycles,
            render_mode=render_mode,
            auto_rom_install_path=auto_rom_install_path,
        )
        self.metadata["name"] = env_name or f"custom_{game}"

    def step(self, action_dict: dict[str, int]) -> Any:
        """Play a step, see `MultiplayerEnv.step`."""
        return super().step(action_dict)


def BaseAtariEnv(**kwargs: Any) -> Any:
    """A `ParallelAtariEnv` in which agents take turns; the arguments are those of `ParallelAtariEnv`.

    Example:
        >>> from atari.multiplayer.base_atari_env import BaseAtariEnv
        >>> env = BaseAtariEnv(game="boxing", num_players=2)
        >>> env.reset(seed=0)
        >>> env.agent_selection
        'first_0'
    """
    return parallel_to_aec_wrapper(ParallelAtariEnv(**kwargs))


def base_env_wrapper_fn(raw_env_fn: Callable[..., Any]) -> Callable[..., Any]:
    """A function that makes an environment like `raw_env_fn`, with PettingZoo's checks.

    Example:
        >>> from atari.multiplayer.base_atari_env import BaseAtariEnv, base_env_wrapper_fn
        >>> env = base_env_wrapper_fn(BaseAtariEnv)(game="boxing", num_players=2)
    """

    def env_fn(**kwargs: Any) -> Any:
        return wrappers.OrderEnforcingWrapper(wrappers.AssertOutOfBoundsWrapper(raw_env_fn(**kwargs)))

    return env_fn
