"""Steps and resets of some of the environments: they alone are played, and behave as if all had been."""

import pickle
from collections import defaultdict
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
from atari.base.gymnasium_versions import AutoresetMode


def make(num_envs: int = 4, **options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("breakout", num_envs, **{"num_threads": 2, "preset": "envpool", **options})


def facts(results: Any, row: int) -> tuple[Any, ...]:
    """What a step returned for one environment."""
    observation, reward, terminated, truncated, info = results
    numbers = [info[name][row] for name in ("lives", "frame_number", "reward", "elapsed_step", "terminated")]
    return observation[row].tobytes(), reward[row], terminated[row], truncated[row], *numbers


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_each_environment_has_the_steps_it_would_have_had_with_all(mode: AutoresetMode) -> None:
    together, apart = (make(autoreset_mode=mode, episodic_life=True) for _ in range(2))
    rng = np.random.default_rng(0)
    steps = 150
    actions = rng.integers(4, size=(steps, 4))
    together.reset(seed=3)
    apart.reset(seed=3)
    expected = defaultdict(list)
    for row in actions:
        results = together.step(row)
        for environment in range(4):
            expected[environment].append(facts(results, environment))
    done = [0] * 4
    while min(done) < steps:
        chosen = [one for one in rng.permutation(4).tolist() if done[one] < steps][: rng.integers(1, 5)]
        results = apart.step([actions[done[one], one] for one in chosen], env_id=chosen)
        assert results[4]["env_id"].tolist() == chosen
        for row, one in enumerate(chosen):
            assert facts(results, row) == expected[one][done[one]]
            done[one] += 1


def test_final_observations_are_those_of_the_rows() -> None:
    envs = make(3, autoreset_mode="SameStep", preset=None, max_num_frames_per_episode=8)
    envs.reset(seed=0)
    envs.step(np.zeros(2, int), env_id=np.array([2, 0]))
    *_, truncated, info = envs.step(np.zeros(2, int), env_id=np.array([1, 2]))
    assert truncated.tolist() == [False, True]
    assert info["_final_obs"].tolist() == [False, True]
    assert info["final_obs"].shape == (2, 4, 84, 84)
    assert info["final_info"]["episode_frame_number"].shape == (2,)
    *_, info = envs.step(np.zeros(1, int), env_id=np.array([0]))
    assert info["_final_obs"].tolist() == [True]
    *_, info = envs.step(np.zeros(1, int), env_id=np.array([2]))
    assert not {"final_obs", "final_info", "_final_obs", "_final_info"} & set(info)


def test_send_and_recv() -> None:
    envs, other = make(), make()
    envs.reset(seed=1)
    other.reset(seed=1)
    envs.send([1, 2], env_id=[3, 0])
    observation, *_, info = envs.recv()
    assert info["env_id"].tolist() == [3, 0]
    assert np.array_equal(observation, other.step(np.array([2, 0, 0, 1]))[0][[3, 0]])
    assert envs.step(np.zeros(4, int))[0].shape == (4, 4, 84, 84)


def test_batches_of_fewer_take_the_last_batch_in_any_order() -> None:
    envs, other = make(batch_size=2, num_threads=1), make(num_threads=1)
    _, info = envs.reset(seed=1)
    other.reset(seed=1)
    seen = {}
    for _ in range(6):
        chosen = info["env_id"][::-1]
        envs.send(chosen % 4, env_id=chosen)
        observation, _, _, _, info = envs.recv()
        seen.update(zip(info["env_id"].tolist(), observation.copy(), strict=True))
    for _ in range(int(info["elapsed_step"][0])):
        expected = other.step(np.arange(4))[0]
    one = int(info["env_id"][0])
    assert np.array_equal(seen[one], expected[one])
    with pytest.raises(ValueError, match="must name all 2 environments of the last batch"):
        envs.send([0], env_id=info["env_id"][:1])
    others = np.setdiff1d(np.arange(4), info["env_id"])
    with pytest.raises(ValueError, match="is not of the last batch"):
        envs.send([0, 0], env_id=others)


@pytest.mark.parametrize(
    ("env_id", "error", "words"),
    [
        ([], ValueError, "at least one environment"),
        ([0, 0], ValueError, "environment 0 in row 1 is given twice"),
        ([4], IndexError, "environment 4 in row 0 does not exist; env_id is within 0..3"),
        ([-1], IndexError, "environment -1"),
        ([2**40], IndexError, "environment 1099511627776"),
        ([0.5], TypeError, "env_id must be integers"),
        (["a"], TypeError, "env_id must be integers"),
        ([[0]], ValueError, "shape"),
        (3, ValueError, "shape"),
    ],
)
def test_wrong_numbers_play_nothing(env_id: Any, error: type[Exception], words: str) -> None:
    envs, other = make(), make()
    envs.reset(seed=2)
    other.reset(seed=2)
    with pytest.raises(error, match=words):
        envs.step(np.zeros(np.size(env_id), int), env_id=env_id)
    for actions in ([0, 0], np.zeros(4, int)):
        with pytest.raises(ValueError, match=r"actions must have the shape \(1,\)"):
            envs.step(actions, env_id=[1])
    with pytest.raises(ValueError, match="action 4 in row 0"):
        envs.step([4], env_id=[1])
    with pytest.raises(ValueError, match="leave it or env_id out"):
        envs.step([0], out=np.empty((1, 4, 84, 84), np.uint8), env_id=[1])
    assert np.array_equal(envs.step(np.ones(4, int))[0], other.step(np.ones(4, int))[0])


def test_the_caller_may_change_its_array() -> None:
    envs = make()
    envs.reset(seed=0)
    chosen = np.array([3, 1])
    envs.send([0, 0], env_id=chosen)
    chosen[:] = 0
    assert envs.recv()[4]["env_id"].tolist() == [3, 1]


def test_a_reset_in_the_background() -> None:
    envs, other = make(), make()
    envs.reset_async(seed=4)
    observation, reward, terminated, truncated, info = envs.recv()
    assert np.array_equal(observation, other.reset(seed=4)[0])
    for zeros in (reward, terminated, truncated, info["elapsed_step"]):
        assert not zeros.any()
    envs.reset_async()
    with pytest.raises(gymnasium.error.AlreadyPendingCallError):
        envs.step(np.zeros(4, int))
    assert envs.reset(seed=4)[0].shape == observation.shape  # results that wait are dropped
    with pytest.raises(gymnasium.error.NoAsyncCallError):
        envs.recv()


@pytest.mark.parametrize("preset", ["envpool", "baselines"])
def test_a_new_game_after_a_lost_life(preset: str) -> None:
    envs = make(2, preset=preset, episodic_life=True)
    envs.reset(seed=0)
    lost = np.zeros(2, bool)
    while not lost.any():
        _, _, lost, _, _ = envs.step(np.zeros(2, int))
    state = envs.snapshot()
    assert envs.reset(options={"reset_mask": lost})[1]["lives"][lost].max() == 4
    envs.restore(None, state)
    assert envs.reset(options={"reset_mask": lost, "new_game": True})[1]["lives"][lost].tolist() == [5] * lost.sum()


class TestTask:
    TASK = atari.Task.of("breakout", preset="envpool")

    def test_it_is_the_preset_that_it_was_made_of(self) -> None:
        own, named = atari.AtariVectorEnv(self.TASK, 4), make()
        assert own.task == named.task == self.TASK
        assert np.array_equal(own.reset(seed=5)[0], named.reset(seed=5)[0])
        assert np.array_equal(own.step(np.arange(4))[0], named.step(np.arange(4))[0])

    def test_it_can_be_pickled(self) -> None:
        envs = atari.AtariVectorEnv(self.TASK, 2, channels_last=True, dtype=np.float32)
        envs.reset(seed=0)
        envs.step([1], env_id=[1])
        copy = pickle.loads(pickle.dumps(envs))
        assert copy.task == self.TASK
        assert np.array_equal(envs.step([2, 3])[0], copy.step([2, 3])[0])

    def test_images_are_free(self) -> None:
        envs = make(2, img_height=40, img_width=50, stack_num=2, grayscale=False)
        assert envs.reset(seed=0)[0].shape == (2, 2, 40, 50, 3)

    def test_options_change_it(self) -> None:
        envs = atari.AtariVectorEnv(self.TASK, 2, frameskip=3, reward_clipping=True, mode=[0, 4])
        assert [task.mode for task in envs.tasks] == [0, 4]
        assert envs.task == self.TASK.replace(frameskip=3, reward_clipping=True)

    def test_lanes_differ_in_games_modes_and_interventions(self) -> None:
        treated = self.TASK.replace(interventions=["strong_ball"], mode=8)
        envs = atari.AtariVectorEnv([self.TASK, treated, atari.Task.of("pong", preset="envpool")])
        singles = [atari.make(task) for task in envs.tasks]
        observation, _ = envs.reset(seed=3)
        for step in range(60):
            for row, single in enumerate(singles):
                expected = single.reset(seed=3 + row)[0] if step == 0 else single.step(step % 4)[0]
                assert np.array_equal(observation[row], expected)
            actions = [int(task.action_set[(step + 1) % 4]) for task in envs.tasks]
            observation = envs.step(np.array(actions))[0]

    @pytest.mark.parametrize("games", [("breakout", "boxing"), ("boxing", "breakout")])
    def test_all_actions_of_games_are_alike(self, games: tuple[str, ...]) -> None:
        """All 18 actions of Boxing are its minimal ones, too."""
        envs = atari.AtariVectorEnv([atari.Task.of(game, preset="envpool", actions="full") for game in games])
        assert envs.single_action_space.n == 18

    def test_lanes_do_not_differ_in_more(self) -> None:
        with pytest.raises(ValueError, match="these differ in frameskip: 4 and 3"):
            atari.AtariVectorEnv([self.TASK, self.TASK.replace(frameskip=3)])
        with pytest.raises(ValueError, match="have other sizes; add img_height=84"):
            atari.AtariVectorEnv(["ALE/Pong-v5", "ALE/Adventure-v5"])
