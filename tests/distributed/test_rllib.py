"""RLlib trains on vector environments by ID and on single ones; its workers import the package because of `atari:`."""

import sys
from typing import Any

import gymnasium
import numpy as np
import pytest
from documents import blocks

import atari

pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = [pytest.mark.ray, pytest.mark.usefixtures("cluster")]

BLOCKS = blocks("ray")
PIXELS = {"channels_last": True, "dtype": "float32"}


def configuration(algorithm: str, env_id: str, workers: int, **options: Any) -> Any:
    """A configuration has a small network, and iterations that take a second."""
    from ray.rllib.algorithms.dqn import DQNConfig
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig

    config: Any = {"dqn": DQNConfig, "ppo": PPOConfig}[algorithm]()
    config.environment(env_id, env_config=options)
    config.env_runners(gym_env_vectorize_mode="vector_entry_point", num_envs_per_env_runner=4, num_env_runners=workers)
    config.rl_module(model_config=DefaultModelConfig(conv_filters=[[8, 8, 4], [8, 4, 2]], head_fcnet_hiddens=[16]))
    if algorithm == "ppo":
        return config.training(train_batch_size_per_learner=200, minibatch_size=50, num_epochs=1)
    memory = {"type": "PrioritizedEpisodeReplayBuffer", "capacity": 1000}
    config.training(
        train_batch_size_per_learner=16, num_steps_sampled_before_learning_starts=50, replay_buffer_config=memory
    )
    return config.reporting(min_sample_timesteps_per_iteration=50)


@pytest.mark.parametrize(
    ("algorithm", "workers", "options"),
    [("ppo", 0, {"max_num_frames_per_episode": 400}), ("dqn", 1, {"preset": "baselines"})],
)
def test_an_algorithm_trains_on_a_vector(algorithm: str, workers: int, options: dict[str, Any]) -> None:
    algo = configuration(algorithm, "atari:ALE/Pong-v5", workers, **PIXELS, **options).build_algo()
    try:
        kinds = algo.env_runner_group.foreach_env_runner(
            lambda runner: type(runner.env.unwrapped).__name__, local_env_runner=not workers
        )
        assert kinds == ["AtariVectorEnv"]
        results = [algo.train() for _ in range(3)]
    finally:
        algo.stop()
    steps = [result["num_env_steps_sampled_lifetime"] for result in results]
    assert 150 <= steps[2] == 3 * steps[0]
    losses = [result["learners"]["default_policy"]["total_loss"] for result in results]
    assert np.isfinite([float(loss) for loss in losses]).all()
    if algorithm == "ppo" and "preset" not in options:
        finished = [result["env_runners"].get("num_episodes_lifetime", 0) for result in results]
        assert finished[2] == 4  # after 100 steps of 4 frames, in 600 steps of 4 environments


@pytest.mark.parametrize("dtype", ["float32", "uint8"])
def test_episodes_are_those_of_the_vector(dtype: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What RLlib keeps of each episode, after many more steps, beside copies made of each step."""
    from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner

    played = Record()
    for name in ("reset", "step"):
        monkeypatch.setattr(atari.AtariVectorEnv, name, played.copying(getattr(atari.AtariVectorEnv, name)))
    options = {"preset": "baselines", "channels_last": True, "dtype": dtype}
    config = configuration("ppo", "atari:ALE/Breakout-v5", 0, **options).debugging(seed=7)
    monkeypatch.setattr(SingleAgentEnvRunner, "make_module", lambda runner: setattr(runner, "module", None))
    runner = SingleAgentEnvRunner(config=config, worker_index=0)
    chunks = runner.sample(num_timesteps=1200, random_actions=True)
    runner.stop()
    kept = [
        (np.stack(chunk.get_observations()), np.array(chunk.get_actions()), np.array(chunk.get_rewards()))
        for chunk in chunks
    ]
    assert len(kept) > 8
    assert sum(len(rewards) for *_, rewards in kept) == sum(len(rewards) for *_, rewards in played.episodes())
    assert sorted(map(digest, kept)) == sorted(map(digest, played.episodes()))


class Record:
    """Copies of what a vector in NEXT_STEP mode returned."""

    def __init__(self) -> None:
        self.steps: list[Any] = []

    def copying(self, method: Any) -> Any:
        def call(envs: Any, *args: Any, **kwargs: Any) -> Any:
            results = method(envs, *args, **kwargs)
            self.steps.append((args[0].copy() if args else None, *(np.array(value) for value in results[:-1])))
            return results

        return call

    def episodes(self) -> list[tuple[Any, Any, Any]]:
        """Observations, actions and rewards of each that has a step."""
        found: list[tuple[list[Any], list[Any], list[Any]]] = []
        for env in range(4):
            ended = True
            for actions, observations, *rest in self.steps:
                if ended:
                    found.append(([], [], []))
                else:
                    found[-1][1].append(actions[env])
                    found[-1][2].append(rest[0][env])
                found[-1][0].append(observations[env])
                ended = bool(rest) and bool(rest[1][env] | rest[2][env])
        return [tuple(map(np.array, episode)) for episode in found if episode[1]]


def digest(episode: tuple[Any, Any, Any]) -> tuple[Any, ...]:
    observations, actions, rewards = episode
    return observations.shape, observations.tobytes(), actions.tolist(), rewards.tolist()


def test_a_worker_has_the_ids_without_an_import() -> None:
    import ray

    # Variables of its own give it a new process; another one may have imported the package for an earlier test.
    @ray.remote(runtime_env={"env_vars": {"ATARI_TEST": "new"}})
    def kind(env_id: str) -> tuple[bool, str]:
        import gymnasium

        before = "atari" in sys.modules
        return before, type(gymnasium.make(env_id).unwrapped).__module__

    assert ray.get(kind.remote("atari:ALE/Pong-v5")) == (False, "atari.env.env")


def test_its_wrappers_return_what_they_return_around_ale_py() -> None:
    from ray.rllib.env.wrappers.atari_wrappers import wrap_atari_for_new_api_stack

    options = {"game": "breakout", "obs_type": "rgb", "frameskip": 1, "repeat_action_probability": 0.0}
    ale = gymnasium.envs.registration.EnvSpec("Peer/Breakout-v5", "ale_py.env:AtariEnv", kwargs=options)
    theirs = wrap_atari_for_new_api_stack(gymnasium.make(ale), framestack=4)
    ours = wrap_atari_for_new_api_stack(
        gymnasium.make("atari:ALE/Breakout-v5", frameskip=1, repeat_action_probability=0.0), framestack=4
    )
    assert isinstance(ours.unwrapped, atari.AtariEnv)
    ours.action_space.seed(0)
    np.testing.assert_array_equal(ours.reset(seed=3)[0], theirs.reset(seed=3)[0])
    ends = 0
    for _ in range(600):
        action = ours.action_space.sample()
        result, expected = ours.step(action), theirs.step(action)
        np.testing.assert_array_equal(result[0], expected[0])
        assert result[1:4] == expected[1:4]
        if result[2] or result[3]:
            ends += 1
            np.testing.assert_array_equal(ours.reset()[0], theirs.reset()[0])
    assert ends > 5


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block_of_the_documentation(name: str) -> None:
    exec(compile(BLOCKS[name], name, "exec"), {"__name__": "__main__"})


def test_there_is_a_block() -> None:
    assert BLOCKS
