"""Snapshots, cloned states and copies of an `AtariEnv`: what they restore, and which raise."""

import copy
import hashlib
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import over, play, started, unchanged

import atari
from atari import AtariEnv
from atari.cores import snapshot


def test_a_snapshot_goes_on_in_another_environment_also_over_a_reset() -> None:
    env, other = started("seaquest", frameskip=(2, 5)), AtariEnv("seaquest", frameskip=(2, 5))
    play(env, 30)
    other.restore(env.snapshot())
    assert play(other, 20) == play(env, 20)
    assert np.array_equal(other.reset()[0], env.reset()[0])
    assert play(other, 20) == play(env, 20)


def test_observation_options_may_differ_between_snapshot_and_restore() -> None:
    """For example, a game played with RAM observations continues with pixels."""
    player, watcher = started("pong", obs_type="ram"), AtariEnv("pong", render_mode="rgb_array")
    play(player, 30)
    watcher.restore(player.snapshot())
    assert np.array_equal(watcher.render(), player.core.screen_rgb())


def test_a_restored_environment_keeps_whether_it_was_reset() -> None:
    fresh, env = AtariEnv("pong"), started("pong")
    env.restore(fresh.snapshot())
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(0)


def test_a_restored_environment_keeps_that_the_episode_is_over() -> None:
    env = AtariEnv("breakout")
    env.restore(over(started()).snapshot())
    with pytest.warns(UserWarning, match="after the episode had ended"):
        env.step(0)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"frameskip": 3}, "with frameskip = 3, but this environment has 4; restore"),
        ({"full_action_space": True}, "with actions = 'full', but this environment has 'minimal'; restore"),
        ({"mode": 4, "frameskip": (2, 5)}, "mode = 4, but this environment has 0; frameskip = (2, 5), not 4; restore"),
        ({"game": "pong"}, "taken with game = 'pong', but this environment has 'breakout'"),
        ({"mode": 4}, "taken with mode = 4"),
        ({"difficulty": 1}, "taken with difficulty = 1"),
        ({"repeat_action_probability": 0.5}, "taken with repeat_action_probability = 0.5"),
        ({"max_num_frames_per_episode": 7}, "taken with max_num_frames_per_episode = 7"),
        ({"sound_obs": True}, "taken with sound = True"),
    ],
)
def test_a_snapshot_of_another_kind_of_environment_is_refused(options: dict[str, Any], text: str) -> None:
    env, other = started(), started(**options)
    with unchanged(env), pytest.raises(ValueError, match="the snapshot was taken with") as error:
        env.restore(other.snapshot())
    assert text in str(error.value)


def test_a_snapshot_of_a_core_is_not_one_of_an_environment() -> None:
    env = started()
    with unchanged(env), pytest.raises(ValueError, match="the snapshot was taken with of = None"):
        env.restore(env.core.snapshot())


@pytest.mark.parametrize("duplicate", [copy.deepcopy, copy.copy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_keep_the_position_and_go_their_own_way(duplicate: Any) -> None:
    env = started("seaquest", frameskip=(2, 5), obs_type="grayscale")
    play(env, 30)
    other = duplicate(env)
    assert other.snapshot() == env.snapshot()
    expected = play(env, 20)
    assert play(other, 20) == expected
    play(other, 5)
    assert other.core.frame_number > env.core.frame_number


def test_a_pickle_goes_on_in_another_process(tmp_path: Path) -> None:
    env = started("pong", obs_type="ram", frameskip=(2, 5))
    play(env, 30)
    (tmp_path / "env").write_bytes(pickle.dumps(env))
    program = (
        "import hashlib, pickle\nenv = pickle.load(open('env', 'rb'))\n"
        "steps = [env.step(action)[0].tobytes() for action in [0, 1, 2, 3] * 10]\n"
        "print(hashlib.sha256(b''.join(steps)).hexdigest())"
    )
    result = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    steps = [env.step(action)[0].tobytes() for action in [0, 1, 2, 3] * 10]
    assert result.stdout.strip() == hashlib.sha256(b"".join(steps)).hexdigest()


def test_a_copy_keeps_the_spec() -> None:
    env = gymnasium.make("Pong-ramNoFrameskip-v4").unwrapped
    assert copy.deepcopy(env).spec == pickle.loads(pickle.dumps(env)).spec == env.spec
    assert env.spec is not None
    assert env.spec.id == "Pong-ramNoFrameskip-v4"


def test_a_wrapped_environment_can_be_copied_too() -> None:
    env = gymnasium.wrappers.FrameStackObservation(gymnasium.make("ALE/Seaquest-v5"), 3)
    env.reset(seed=0)
    play(env, 20)
    other = copy.deepcopy(env)
    assert play(other, 20) == play(env, 20)


def test_a_cloned_state_brings_the_game_back() -> None:
    env = started("breakout", repeat_action_probability=0.0, obs_type="ram")
    play(env, 30)
    state = env.clone_state()
    expected = play(env, 30)
    env.restore_state(state)
    assert play(env, 30) == expected


def test_a_cloned_state_can_leave_the_end_of_an_episode() -> None:
    env = started("breakout")
    state = env.clone_state()
    over(env)
    env.restore_state(state)
    assert env.step(0)[2] is False


def test_what_is_no_state_is_refused() -> None:
    env = started()
    with unchanged(env), pytest.raises(TypeError, match="restore_state takes what clone_state returned, got bytes"):
        env.restore_state(env.snapshot())


class TestTask:
    """A snapshot has the task that is played, also what `ale` has set."""

    def test_other_interventions_are_refused(self) -> None:
        env, other = started(), started(interventions=["guided_paddle"])
        text = r"with interventions = 'guided_paddle \(.*\)', but .* has None"
        with unchanged(env), pytest.raises(ValueError, match=text):
            env.restore(other.snapshot())

    def test_a_snapshot_without_a_task_is_damaged(self) -> None:
        env = started()
        facts, blobs = snapshot.unpack(env.snapshot())
        del facts["task"]
        with unchanged(env), pytest.raises(ValueError, match="damaged: its task is None"):
            env.restore(snapshot.pack(facts, blobs))

    def test_what_ale_has_set_is_in_the_task(self) -> None:
        env, plain = started(), started()
        before = env.snapshot()
        env.ale.setMode(8)
        env.ale.setDifficulty(1)
        saved = env.snapshot()
        for one, data in ((env, before), (plain, saved)):
            with unchanged(one), pytest.raises(ValueError, match=r"with mode = .*; difficulty = ., not"):
                one.restore(data)
        plain.ale.setMode(8)
        plain.ale.setDifficulty(1)
        plain.restore(saved)
        assert plain.task == env.task == AtariEnv("breakout", mode=8, difficulty=1).task
        copied = copy.deepcopy(env)
        assert copied.task == env.task
        assert play(copied, 20) == play(env, 20)

    def test_a_probability_that_ale_has_set_is_in_the_task(self) -> None:
        env, plain, twin = started(), started(), started()
        for one in (env, twin):
            one.ale.setFloat("repeat_action_probability", 0.5)
            one.ale.setInt("max_num_frames_per_episode", 900)
            one.reset(seed=3)
        with (
            unchanged(plain),
            pytest.raises(ValueError, match=r"probability = 0\.5, .* 0\.25; max_num.* 900, not None"),
        ):
            plain.restore(env.snapshot())
        twin.restore(env.snapshot())
        assert play(twin, 20) == play(env, 20)

    def test_another_path_of_the_same_game_file_is_no_difference(self, tmp_path: Path) -> None:
        text = (Path(atari.games.__file__).parent / "data" / "breakout.toml").read_text(encoding="utf-8")
        envs = []
        for folder in ("a", "b"):
            (tmp_path / folder).mkdir()
            (tmp_path / folder / "own.toml").write_text(text, encoding="utf-8")
            envs.append(AtariEnv(tmp_path / folder / "own.toml", rom=atari.roms.find("breakout")))
            envs[-1].reset(seed=len(envs))
        envs[1].restore(envs[0].snapshot())
        assert play(envs[1], 20) == play(envs[0], 20)
