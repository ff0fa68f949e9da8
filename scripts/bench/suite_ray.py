"""The suite `ray` of `bench.py`: an env runner of RLlib on `AtariVectorEnv` beside one on RLlib's own Atari wrappers.

Both run in workers of one local cluster, play the same preprocessing (64x64, four frames) with the same network, and
take turns. Times are CPU time of the worker, so they are those of one core, also on a busy machine.
"""

import atexit
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from time import process_time, thread_time
from typing import Any

from comparison import Comparison, Run

COUNT = 8
FILTERS = [[16, 4, 2], [32, 4, 2], [64, 4, 2], [128, 4, 2]]  # the values of RLlib's examples for Atari
PARTS = {
    "all": "sampling with a network",
    "environment": "of which the vector's step",
    "network": "of which the network",
    "python": "of which RLlib's Python (episodes, connectors, metrics)",
    "store": "to the driver through the object store",
    "random": "sampling without a network (random actions)",
}


def comparisons() -> Iterator[Comparison]:
    """One step of one environment of RLlib's env runner, by parts; needs the extra `ray`."""
    for part, title in PARTS.items():
        sides = [(side, partial(prepare, side, part)) for side in ("native", "RLlib's")]
        yield Comparison(f"{title}, {COUNT} environments", sides)


def prepare(side: str, part: str, game: str) -> Run:
    """The CPU seconds of one part; a sample has all parts of "all"."""
    player = runner(side, game, part == "random")

    def run(steps: int) -> float:
        if part in ("all", "random"):
            player.parts = sample(player.actor, steps)
        return player.parts["all" if part == "random" else part]

    return run


class Player:
    """A worker, and the CPU seconds of its last sample."""

    def __init__(self, actor: Any) -> None:
        self.actor = actor
        self.parts: dict[str, float] = {}


@cache
def runner(side: str, game: str, random: bool) -> Player:
    """A worker with an env runner; the first one starts the cluster."""
    import ray

    if not ray.is_initialized():
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        os.environ.setdefault("RAY_AUTH_MODE", "disabled")
        os.environ["PYTHONPATH"] = f"{Path(__file__).parent}:{os.environ.get('PYTHONPATH', '')}"
        folder = tempfile.mkdtemp(prefix="atari-ray-", dir="/tmp")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        atexit.register(ray.shutdown)
        ray.init(num_cpus=8, include_dashboard=False, object_store_memory=400_000_000, _temp_dir=folder)
    return Player(ray.remote(num_cpus=1)(Runner).remote(side, game, random))


def sample(actor: Any, steps: int) -> dict[str, float]:
    """Let a worker sample, fetch the episodes, and return the CPU seconds a step of each part, times `steps`."""
    import ray

    reference, parts, played = ray.get(actor.sample.remote(steps))
    started = process_time()
    episodes = ray.get(reference[0])
    assert sum(map(len, episodes)) == played
    parts["store"] += process_time() - started
    return {name: seconds / played * steps for name, seconds in parts.items()}


class Runner:
    """An env runner in a worker."""

    def __init__(self, side: str, game: str, random: bool) -> None:
        import torch
        from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner

        torch.set_num_threads(1)
        self.random = random
        self.runner = SingleAgentEnvRunner(config=configuration(side, game), worker_index=0)
        if random:
            self.runner.module = None
        self.seconds = {"environment": 0.0, "network": 0.0}
        self.runner.env.step = self.timed("environment", self.runner.env.step)
        if not random:
            self.runner.module.forward_exploration = self.timed("network", self.runner.module.forward_exploration)

    def timed(self, part: str, call: Callable[..., Any]) -> Callable[..., Any]:
        """A call whose CPU time counts as a part."""

        def wrapped(*args: Any, **options: Any) -> Any:
            started = thread_time()
            result = call(*args, **options)
            self.seconds[part] += thread_time() - started
            return result

        return wrapped

    def sample(self, steps: int) -> tuple[list[Any], dict[str, float], int]:
        """The episodes in the object store, the CPU seconds of each part, and the steps that were played."""
        import ray

        self.seconds.update(environment=0.0, network=0.0)
        started = process_time()
        episodes = self.runner.sample(num_timesteps=steps, random_actions=self.random)
        self.runner.get_metrics()
        seconds = process_time() - started
        started = process_time()
        reference = ray.put(episodes)
        parts = {"all": seconds, "store": process_time() - started, **self.seconds}
        parts["python"] = seconds - self.seconds["environment"] - self.seconds["network"]
        return [reference], parts, sum(map(len, episodes))


def configuration(side: str, game: str) -> Any:
    """The configuration of PPO, with RLlib's small network for 64x64 pixels."""
    from ray.rllib.connectors.env_to_module.frame_stacking import FrameStackingEnvToModule
    from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig

    from atari.integrations.ray import config

    # RLlib's wrappers: up to 30 no-ops, FIRE, episodes of one life, rewards as they are.
    options = {"reward_clipping": False, "img_height": 64, "img_width": 64}
    made = config("PPO", game, **options, num_envs=COUNT, num_env_runners=0)
    if side == "RLlib's":
        from ray.rllib.algorithms.ppo import PPOConfig

        made = PPOConfig().environment(partial(single, game))
        made.env_runners(num_envs_per_env_runner=COUNT, num_env_runners=0)
        made.env_runners(env_to_module_connector=lambda *_, **__: FrameStackingEnvToModule(num_frames=4))
    return made.rl_module(model_config=DefaultModelConfig(conv_filters=FILTERS, head_fcnet_hiddens=[256]))


def single(game: str, _: Any) -> Any:
    """RLlib's own environment, as its documentation makes it."""
    import gymnasium
    from ray.rllib.env.wrappers.atari_wrappers import wrap_atari_for_new_api_stack

    name = "".join(word.capitalize() for word in game.split("_"))
    env = gymnasium.make(f"ale_py:ALE/{name}-v5", frameskip=1, repeat_action_probability=0.0)
    return wrap_atari_for_new_api_stack(env, dim=64, framestack=None)
