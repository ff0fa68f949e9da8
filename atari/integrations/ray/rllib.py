"""RLlib's new API stack on `AtariVectorEnv`: one vector environment in each env runner.

RLlib's env runner assumes autoreset in NEXT_STEP mode: it uses the observation after an end as the first
observation of the next episode.
"""

import inspect
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np
import ray
from ray.rllib.callbacks.callbacks import RLlibCallback
from ray.tune.registry import register_env

from atari.base.gymnasium_versions import AutoresetMode, VectorWrapper, autoreset_mode
from atari.base.validation import check_name
from atari.cores.options import SEED_LIMIT
from atari.task.task import GameLike, look_up
from atari.vector.env import AtariVectorEnv

ALGORITHMS = ("PPO", "DQN", "IMPALA", "APPO")
_RUN_OPTIONS = {*inspect.signature(AtariVectorEnv).parameters} - {"game", "num_envs", "options"}
"""Options of `AtariVectorEnv` that are not fields of the task."""


def register(name: str = "atari") -> str:
    """Register `env_creator` for RLlib under a name, for all workers, and return the name.

    Workers need no import: they find the name in the cluster.

    Example:
        >>> from ray.rllib.algorithms.ppo import PPOConfig
        >>> config = PPOConfig().environment(register(), env_config={"game": "pong", "channels_last": True})
        >>> config = config.env_runners(gym_env_vectorize_mode="vector_entry_point", num_envs_per_env_runner=8)
    """
    register_env(name, env_creator)
    return name


def env_creator(env_config: Mapping[str, Any]) -> "EpisodeVectorEnv":
    """The vector environment of one env runner, for `gym_env_vectorize_mode="vector_entry_point"`.

    Args:
        env_config: `game`, for `AtariVectorEnv` ("pong", "ALE/Pong-v5", an `atari.Task`), or a list of games;
            RLlib's `num_envs`; all others are options of `AtariVectorEnv`. Environment i plays game i of a list, which
            repeats after its end. Workers do not have IDs that your program registered itself: for them use
            `Task.of(ID)`, like `config`. `num_threads` is the number of CPUs of the env runner, unless given.

    Returns:
        A wrapper around an `AtariVectorEnv`.

    Raises:
        TypeError, ValueError: see `AtariVectorEnv`; or `game` is missing; or the autoreset mode is not NEXT_STEP; or
            there are more games than environments.
        gymnasium.error.NameNotFound: there is no such ID.
    """
    options = dict(env_config)
    num_envs = int(options.pop("num_envs", 1))
    if "game" not in options:
        raise TypeError("env_config needs 'game': a game ('pong'), an ID ('ALE/Pong-v5') or a list of them")
    mode = autoreset_mode(options.pop("autoreset_mode", AutoresetMode.NEXT_STEP))
    if mode is not AutoresetMode.NEXT_STEP:
        raise ValueError(
            f"RLlib's env runner loses a transition of each episode with autoreset_mode={mode.value!r}; leave it out"
        )
    game = options.pop("game")
    games = list(game) if isinstance(game, Sequence) and not isinstance(game, str) else [game]
    if not games:
        raise ValueError("env_config['game'] is an empty list; name at least one game")
    if len(games) > num_envs:
        raise ValueError(f"{len(games)} games need as many environments; num_envs_per_env_runner is {num_envs}")
    played = [games[index % len(games)] for index in range(num_envs)]
    options.setdefault("num_threads", _cpus())
    return EpisodeVectorEnv(AtariVectorEnv(played, num_envs, **options))


def _cpus() -> int:
    """The number of CPUs of this Ray worker; outside workers 0, which means all CPUs of the machine."""
    if not ray.is_initialized() or ray.get_runtime_context().get_actor_id() is None:
        return 0
    return max(1, int(ray.get_runtime_context().get_assigned_resources().get("CPU", 1)))


class EpisodeVectorEnv(VectorWrapper):
    """An `AtariVectorEnv` for RLlib's env runner.

    `info` is empty: RLlib would make a dict of each environment's values in each step, and keep them with the
    episodes. `finished` has the scores of whole games, which `GameScores` reports. With one seed, `reset` gives
    environment i the seed `seed * num_envs + i`. Env runners get consecutive seeds, so no two of their environments
    have the same seed.
    """

    def __init__(self, envs: AtariVectorEnv) -> None:
        super().__init__(envs)
        self.finished: list[tuple[float, int]] = []
        """Return and length in frames of each whole game that has ended, until the next report clears them."""

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """New episodes; see `AtariVectorEnv.reset`."""
        if isinstance(seed, (int, np.integer)):
            first = int(seed) * self.num_envs
            seed = [(first + index) % SEED_LIMIT for index in range(self.num_envs)]
        observations, info = self.env.reset(seed=seed, options=options)
        self._keep(info)
        return _copied(observations), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """One step of each environment; see `AtariVectorEnv.step`."""
        observations, rewards, terminations, truncations, info = self.env.step(actions)
        self._keep(info)
        return _copied(observations), rewards, terminations, truncations, {}

    def _keep(self, info: dict[str, Any]) -> None:
        if "episode" in info:
            games, ended = info["episode"], info["_episode"]
            self.finished += zip(games["r"][ended].tolist(), games["l"][ended].tolist(), strict=True)


def _copied(observations: Any) -> Any:
    """Copies of observations.

    RLlib keeps every observation until the sample is complete. If the vector lent them, it would have to make new
    results at every step, which takes longer than this copy.
    """
    if isinstance(observations, dict):
        return {name: part.copy("K") for name, part in observations.items()}
    return observations.copy("K")


class GameScores(RLlibCallback):
    """Reports the scores of whole games beside RLlib's episodes, which may be single lives with clipped rewards.

    `algo.train()["env_runners"]` has `game_return_mean` and `game_frames_mean`, means over the last 100 games of each
    env runner, and `num_games`, of this iteration. Means are NaN if no game has ended. They need a preset.

    Example:
        >>> PPOConfig().callbacks(GameScores)  # doctest: +SKIP
    """

    def on_sample_end(self, *, env_runner: Any, metrics_logger: Any, **_: Any) -> None:
        """Report the games that ended after the last call."""
        envs = env_runner.env
        while not isinstance(envs, EpisodeVectorEnv) and hasattr(envs, "env"):
            envs = envs.env
        finished = getattr(envs, "finished", [])
        for score, frames in finished:
            metrics_logger.log_value("game_return_mean", score, window=100)
            metrics_logger.log_value("game_frames_mean", frames, window=100)
        metrics_logger.log_value("num_games", len(finished), reduce="sum")
        finished.clear()


def _with_network(algorithm: str, obs: str) -> Any:
    from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
    from ray.rllib.core.rl_module.rl_module import RLModuleSpec

    from atari.integrations.ray.networks import ScalingDQNCatalog, ScalingPPOCatalog

    made = getattr(import_module(f"ray.rllib.algorithms.{algorithm.lower()}"), f"{algorithm}Config")()
    catalog = ScalingDQNCatalog if algorithm == "DQN" else ScalingPPOCatalog
    layers: dict[str, Any] = {"fcnet_hiddens": [256, 256], "fcnet_activation": "relu"}
    if obs == "pixels":
        filters = [[32, 8, 4, "valid"], [64, 4, 2, "valid"], [64, 3, 1, "valid"]]
        layers = {"conv_filters": filters, "head_fcnet_hiddens": [512]}
    return made.rl_module(rl_module_spec=RLModuleSpec(catalog_class=catalog), model_config=DefaultModelConfig(**layers))


def config(
    algorithm: str,
    game: GameLike | Sequence[GameLike],
    *,
    preset: str | None = None,
    num_envs: int = 8,
    num_env_runners: int = 2,
    **options: Any,
) -> Any:
    """RLlib's configuration of an algorithm on Atari, ready for `build_algo()` or for changes.

    An ID decides sticky actions, actions, and RAM or pixels as observations; the preset decides the rest. For a
    game's name, the preset decides all of it. A `Task` is played unchanged. `env_config["game"]` has the tasks.

    Observations are bytes, and the networks scale them. Pixels have the network of Mnih et al. (2015).

    Args:
        algorithm: "PPO", "DQN", "IMPALA" or "APPO".
        game: a game, an ID or a task, or a list of them.
        preset: name of a preset; None means "baselines", or for a task its own fields.
        num_envs: environments of each env runner.
        num_env_runners: processes that play; with 0 the algorithm's own process plays.
        options: fields of `atari.Task`, such as obs_type="ram", and the other options of `AtariVectorEnv`.

    Returns:
        An `AlgorithmConfig` with the environment, the network, and the callback `GameScores`.

    Raises:
        TypeError, ValueError: there is no such algorithm, game, preset or option.

    Example:
        >>> algo = config("PPO", ["pong", "breakout"], num_envs=8).build_algo()  # doctest: +SKIP
        >>> algo.train()["env_runners"]["game_return_mean"]  # doctest: +SKIP
    """
    check_name("algorithm", algorithm, ALGORITHMS)
    games = list(game) if isinstance(game, Sequence) and not isinstance(game, str) else [game]
    running = {name: options.pop(name) for name in list(options) if name in _RUN_OPTIONS}
    tasks = [look_up(one).task_for_agent(preset, options, owner="config") for one in games]
    obs = "pixels" if tasks[0].kind.image else "ram"
    layout = {} if obs == "ram" else {"channels_last": True}
    env_config = {"game": tasks, **layout, **running}
    made = _with_network(algorithm, obs)
    made.environment(register(), env_config=env_config)
    made.env_runners(
        gym_env_vectorize_mode="vector_entry_point",
        num_envs_per_env_runner=num_envs,
        num_env_runners=num_env_runners,
    )
    made.callbacks(GameScores)
    return made
