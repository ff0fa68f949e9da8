"""`atari.integrations.ray.config` trains in the workers of a cluster, which import nothing by themselves."""

import copy
import pickle
import time
from typing import Any

import gymnasium
import numpy as np
import pytest
from own_process import run_program

import atari

pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = pytest.mark.ray

from atari.integrations.ray import GameScores, config, env_creator  # noqa: E402


def small(algorithm: str, game: Any, **options: Any) -> Any:
    """A configuration whose iterations take a second."""
    made = config(algorithm, game, num_envs=4, **options).debugging(seed=3)
    if algorithm == "PPO":
        return made.training(train_batch_size_per_learner=200, minibatch_size=50, num_epochs=1)
    if algorithm == "DQN":
        memory = {"type": "PrioritizedEpisodeReplayBuffer", "capacity": 1000}
        made.training(
            train_batch_size_per_learner=16, num_steps_sampled_before_learning_starts=50, replay_buffer_config=memory
        )
        return made.reporting(min_sample_timesteps_per_iteration=100)
    made.training(train_batch_size_per_learner=80).learners(num_learners=0)
    return made.env_runners(rollout_fragment_length=20).reporting(min_time_s_per_iteration=1)


@pytest.mark.parametrize(
    ("algorithm", "game", "obs", "preset"),
    [
        ("PPO", "pong", "pixels", "baselines"),
        ("PPO", ["pong", "breakout"], "ram", None),
        ("DQN", "PongNoFrameskip-v4", "pixels", "dqn2015"),
        ("DQN", "ALE/Breakout-v5", "ram", "baselines"),
        ("IMPALA", ["ALE/Pong-v5", "ALE/Breakout-v5"], "pixels", None),
        ("IMPALA", "breakout", "ram", "baselines"),
        ("APPO", "ALE/Pong-v5", "pixels", "baselines"),
        ("APPO", "Pong-ram-v4", "ram", None),
    ],
)
def test_an_algorithm_trains_in_remote_workers(
    cluster: Any, algorithm: str, game: Any, obs: str, preset: str | None
) -> None:
    observed = {"obs_type": "ram"} if obs == "ram" else {}
    algo = small(algorithm, game, preset=preset, **observed).build_algo()
    try:
        assert algo.config.callbacks_class is GameScores
        nodes = algo.env_runner_group.foreach_env_runner(node_and_kind, local_env_runner=False)
        assert [kind for _, kind in nodes] == ["AtariVectorEnv"] * 2
        before = weights(algo)
        deadline = time.monotonic() + 180  # IMPALA's and APPO's first iterations may have no results
        while time.monotonic() < deadline:
            result = algo.train()
            if "learners" in result and result["env_runners"]["num_env_steps_sampled_lifetime"] >= 300:
                break
        losses = [float(value) for name, value in result["learners"]["default_policy"].items() if "loss" in name]
        assert losses
        assert np.isfinite(losses).all()
        assert any((before[name] != now).any() for name, now in weights(algo).items())
    finally:
        algo.stop()


def node_and_kind(runner: Any) -> tuple[str, str]:
    import ray

    return ray.get_runtime_context().get_node_id(), type(runner.env.unwrapped).__name__


def weights(algo: Any) -> dict[str, Any]:
    state = algo.learner_group.get_state()["learner"]["rl_module"]["default_policy"]
    return {name: np.array(value) for name, value in state.items()}


def test_the_scores_of_whole_games_are_reported(cluster: Any) -> None:
    """The frame limit ends games at once; RLlib's episodes are the same games then."""
    made = small("PPO", "pong", obs_type="ram", num_env_runners=1, max_num_frames_per_episode=400)
    algo = made.build_algo()
    try:
        results = [algo.train()["env_runners"] for _ in range(3)]
    finally:
        algo.stop()
    ended = [result for result in results if result["num_games"]]
    assert sum(result["num_games"] for result in ended) == results[-1]["num_episodes_lifetime"] == 4
    assert [result["game_frames_mean"] for result in ended] == [400] * len(ended)
    assert all(-10 < result["game_return_mean"] <= 0 for result in ended)


def test_scores_can_be_copied_as_rllib_does() -> None:
    for other in (copy.deepcopy(GameScores()), pickle.loads(pickle.dumps(GameScores()))):
        assert type(other) is GameScores


def test_the_environment_is_the_vector_with_other_seeds() -> None:
    ours = env_creator({"game": "pong", "num_envs": 3, "preset": "baselines", "channels_last": True})
    plain = atari.AtariVectorEnv("pong", 3, preset="baselines", channels_last=True)
    assert ours.single_observation_space == plain.single_observation_space
    observations, info = ours.reset(seed=5)
    np.testing.assert_array_equal(observations, plain.reset(seed=[15, 16, 17])[0])
    assert info == {}
    for step in range(20):
        actions = np.full(3, step % 6)
        for value, expected in zip(ours.step(actions)[:4], plain.step(actions)[:4], strict=True):
            np.testing.assert_array_equal(value, expected)


@pytest.mark.parametrize("env_id", ["ALE/Pong-v5", "PongNoFrameskip-v4", "Pong-ramDeterministic-v0"])
def test_an_id_plays_what_it_says(env_id: str) -> None:
    ours = env_creator({"game": f"atari:{env_id}", "num_envs": 2})
    assert ours.unwrapped.task == atari.Task.of(env_id)
    plain = atari.AtariVectorEnv(env_id, 2)
    np.testing.assert_array_equal(ours.reset(seed=1)[0], plain.reset(seed=2)[0])
    for step in range(60):
        actions = np.array([step % 6, step % 5])
        np.testing.assert_array_equal(ours.step(actions)[0], plain.step(actions)[0])


def test_several_games_are_played_in_turn() -> None:
    envs = env_creator({"game": ["pong", "breakout"], "num_envs": 5})
    assert [lane.game.id for lane in envs.unwrapped.lanes] == ["pong", "breakout", "pong", "breakout", "pong"]
    assert envs.single_action_space.n == 18


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        ({}, TypeError, "env_config needs 'game'"),
        ({"game": []}, ValueError, "empty list"),
        ({"game": ["pong", "breakout", "freeway"]}, ValueError, "3 games need as many environments"),
        ({"game": "pong", "autoreset_mode": "SameStep"}, ValueError, "loses a transition"),
        ({"game": ["ALE/Pong-v5", "Breakout-v4"]}, ValueError, "differ in repeat_action_probability"),
        ({"game": "ALE/Pnog-v5"}, gymnasium.error.NameNotFound, "Pong"),
        ({"game": "pong", "frame_skip": 3}, TypeError, "did you mean 'frameskip'"),
    ],
)
def test_a_wrong_environment_is_refused(wrong: dict[str, Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        env_creator({"num_envs": 2, **wrong})


@pytest.mark.parametrize(
    ("given", "error", "text"),
    [
        ({"algorithm": "A3C"}, ValueError, "algorithm must be one of 'PPO'"),
        ({"obs_type": "sound"}, ValueError, "obs_type must"),
        ({"obs": "ram"}, TypeError, "did you mean 'obs_type'"),
    ],
)
def test_a_wrong_configuration_is_refused(given: dict[str, Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        config(**{"algorithm": "PPO", "game": "pong", **given})


def test_the_network_divides_bytes() -> None:
    import torch
    from ray.rllib.core.columns import Columns

    for algorithm in ("PPO", "DQN"):
        module = config(algorithm, "pong").get_rl_module_spec(env=None, spaces=spaces()).build()
        rows = torch.randint(0, 256, (2, 84, 84, 4), dtype=torch.uint8)
        with torch.no_grad():
            torch.manual_seed(0)
            out = module.forward_inference({Columns.OBS: rows})
            torch.manual_seed(0)
            same = module.forward_inference({Columns.OBS: rows.float()})
        for name, value in out.items():
            assert torch.equal(value, same[name])


def spaces() -> dict[str, Any]:
    from ray.rllib.core import DEFAULT_MODULE_ID

    envs = atari.AtariVectorEnv("pong", 1, channels_last=True)
    return {DEFAULT_MODULE_ID: (envs.single_observation_space, envs.single_action_space)}


def test_importing_the_package_does_not_import_ray() -> None:
    assert run_program("import sys, atari.integrations; print('ray' in sys.modules)") == "False\n"
