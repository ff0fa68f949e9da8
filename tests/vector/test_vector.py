"""The properties of the vector environment besides equality with ale-py's."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from vector_tools import begun, make, play

import atari
from atari.base.gymnasium_versions import AutoresetMode
from atari.games.actions import Action


def test_the_number_of_threads_does_not_show() -> None:
    runs = []
    for threads in (1, 2, 3, 8):
        envs = make(num_envs=5, num_threads=threads, episodic_life=True)
        runs.append([envs.reset(seed=5)[0].tobytes(), *play(envs, 150, seed=5)])
    assert all(run == runs[0] for run in runs)


class TestGames:
    def test_several_in_one_pool(self) -> None:
        envs = make(["pong", "breakout", "skiing"], None)
        assert envs.single_action_space == gymnasium.spaces.Discrete(18)
        observation, info = envs.reset(seed=1)
        assert info["action_mask"].sum(1).tolist() == [6, 4, 3]
        assert info["action_mask"][1].tolist() == [index in (0, 1, 3, 4) for index in range(18)]
        single = make("breakout", 1, full_action_space=True)
        alone, _ = single.reset(seed=2)
        for action in (1, 4, 4, 0, 3, 11):
            assert np.array_equal(observation[1], alone[0])
            observation, *_, info = envs.step(np.full(3, action))
            alone, *_ = single.step(np.array([action]))
        assert info["lives"].tolist()[1] == 5

    def test_their_number_is_checked(self) -> None:
        with pytest.raises(ValueError, match="a game for each of the 3 environments, got 2"):
            make(["pong", "breakout"], 3)
        with pytest.raises(ValueError, match="did you mean 'breakout'"):
            make(["pong", "brekout"], None)

    def test_modes_and_difficulties_of_each(self) -> None:
        envs = make("breakout", 2, mode=[0, 20], difficulty=[0, 1], obs_type="ram")
        observation, _ = envs.reset(seed=3)
        for index, (mode, difficulty) in enumerate([(0, 0), (20, 1)]):
            alone, _ = make("breakout", 1, mode=mode, difficulty=difficulty, obs_type="ram").reset(seed=3 + index)
            assert np.array_equal(observation[index], alone[0])
        with pytest.raises(ValueError, match="breakout has no mode 7"):
            make("breakout", 2, mode=[0, 7])
        with pytest.raises(ValueError, match="a difficulty for each of the 2 environments"):
            make("breakout", 2, difficulty=[0])

    def test_the_games_whose_continuous_actions_ale_py_mistakes(self) -> None:
        envs = make("skiing", 1, continuous=True, obs_type="ram", use_fire_reset=False, noop_max=0, frameskip=1)
        core = atari.cores.NativeCore("skiing", seed=0, repeat_action_probability=0.0)
        core.reset()
        envs.reset(seed=0)
        for _ in range(30):
            observation, *_ = envs.step(np.array([[1.0, 0.0, 0.0]], np.float32))
            core.act(atari.Action.RIGHT)
        assert np.array_equal(observation[0], core.ram())


class TestBuffers:
    @pytest.mark.parametrize(
        "keep",
        [
            lambda observation: observation,
            lambda observation: observation[1, 2:],
            lambda observation: observation.reshape(-1)[7:].view(np.int8),
            memoryview,
            np.from_dlpack,
        ],
    )
    def test_what_is_held_stays(self, keep: Any) -> None:
        envs = make("pong", 2, frameskip=7)
        held = [keep(envs.reset(seed=0)[0])]
        copies = [np.array(held[0])]
        for _ in range(6):
            held.append(keep(envs.step(np.array([2, 3]))[0]))
            copies.append(np.array(held[-1]))
        assert all(np.array_equal(one, copied) for one, copied in zip(held, copies, strict=True))
        assert not np.array_equal(copies[0], copies[-1])

    def test_final_observations_that_are_held_stay(self) -> None:
        envs = begun("pong", 2, obs_type="dict", autoreset_mode="SameStep", max_num_frames_per_episode=4, seed=0)
        held = [envs.step(np.array([2, 3]))[4]["final_obs"] for _ in range(5)]
        assert len({final["image"].ctypes.data for final in held}) == 5
        assert len({final["ram"].ctypes.data for final in held}) == 5
        assert all(part.flags.writeable for part in (*held[0].values(), *envs.step(np.array([2, 3]))[0].values()))

    def test_results_do_not_depend_on_what_users_do_to_them(self) -> None:
        mine, untouched = make("pong", 2), make("pong", 2)
        observation, _ = mine.reset(seed=0)
        untouched.reset(seed=0)
        for _ in range(6):
            observation[:] = 77
            observation, reward, *_ = mine.step(np.array([2, 3]))
            reward[:] = 9
            assert np.array_equal(observation, untouched.step(np.array([2, 3]))[0])

    @pytest.mark.parametrize(
        "out",
        [
            np.zeros((2, 4, 84, 84), np.int8),
            np.zeros((1, 4, 84, 84), np.uint8),
            np.zeros((2, 4, 84, 168), np.uint8)[..., ::2],
            np.zeros((2, 4, 84, 84), np.uint8)[..., ::-1],
            np.frombuffer(bytes(2 * 4 * 84 * 84), np.uint8).reshape(2, 4, 84, 84),
            [1],
            {"image": np.zeros((2, 4, 84, 84), np.uint8)},
        ],
    )
    def test_out_is_checked(self, out: Any) -> None:
        """A first one, and one after another that fits; nothing is played."""
        envs, other, good = make("pong", 2), make("pong", 2), np.zeros((2, 4, 84, 84), np.uint8)
        error, text = ValueError, r"must be a writable C-contiguous uint8 array of shape \(2, 4, 84, 84\)"
        if isinstance(out, dict):
            error, text = TypeError, "must be an array"
        for one in (envs, other):
            one.reset(seed=0)
        for _ in range(2):
            with pytest.raises(error, match=f"out {text}"):
                envs.step(np.array([2, 3]), out=out)
            assert envs.step(np.array([2, 3]), out=good)[0] is good
            assert np.array_equal(good, other.step(np.array([2, 3]))[0])

    def test_out_of_a_dict(self) -> None:
        envs = begun("pong", 2, obs_type="dict", seed=0)
        out = {"image": np.zeros((2, 4, 84, 84), np.uint8), "ram": np.zeros((2, 128), np.uint8)}
        observation, *_ = envs.step(np.array([0, 0]), out=out)
        assert observation["ram"] is out["ram"]
        assert out["ram"].any()
        assert out["image"].any()
        with pytest.raises(TypeError, match="a dict of image and ram"):
            envs.step(np.array([0, 0]), out=out["image"])


class TestAutoreset:
    def test_disabled_waits_for_a_reset(self) -> None:
        envs = begun("breakout", 3, autoreset_mode=AutoresetMode.DISABLED, max_num_frames_per_episode=8, seed=0)
        envs.step(np.zeros(3, int))
        observation, _, _, truncated, _ = envs.step(np.zeros(3, int))
        assert truncated.tolist() == [True, True, True]
        kept = observation.copy()
        mask = np.array([False, True, False])
        observation, _ = envs.reset(options={"reset_mask": mask})
        assert np.array_equal(observation[~mask], kept[~mask])
        assert not observation[1, :3].any()  # a new stack
        observation, reward, _, truncated, _ = envs.step(np.ones(3, int))
        assert truncated.tolist() == [True, False, True]
        assert np.array_equal(observation[~mask], kept[~mask])
        assert reward.tolist() == [0, 0, 0]

    @pytest.mark.parametrize("seed", [41, [41, 42]])
    def test_a_seed_of_a_partial_reset_counts_those_reset(self, seed: Any) -> None:
        """As in ale-py: the k-th environment that is reset gets seed + k, not environment i seed + i."""
        envs, others = make(), make()
        envs.reset(seed=0)
        expected, _ = others.reset(seed=[0, 41, 42])
        observation, _ = envs.reset(seed=seed, options={"reset_mask": np.array([False, True, True])})
        assert np.array_equal(observation, expected)

    @pytest.mark.parametrize(
        ("mask", "error", "text"),
        [
            ([True, False, True], TypeError, "reset_mask must be a boolean numpy array"),
            (np.array([1, 0, 1]), TypeError, "reset_mask must be a boolean numpy array"),
            (np.array([True]), ValueError, r"shape \(3,\), got \(1,\)"),
        ],
    )
    def test_masks_are_checked(self, mask: Any, error: type[Exception], text: str) -> None:
        envs = begun(seed=0)
        with pytest.raises(error, match=text):
            envs.reset(options={"reset_mask": mask})

    @pytest.mark.parametrize("options", [[], 3, "new_game"])
    def test_options_that_are_no_dict_are_refused(self, options: Any) -> None:
        envs = make()
        for call in (envs.reset, envs.reset_async, envs.reset_mask):
            with pytest.raises(TypeError, match="the options of a reset are a dict"):
                call(**{"options": options})

    def test_the_first_reset_is_of_all(self) -> None:
        with pytest.raises(gymnasium.error.ResetNeeded, match=r"the first reset\(\) must reset every"):
            make().reset(options={"reset_mask": np.array([True, False, True])})


class TestSeeds:
    def test_one_number_is_the_first_of_several(self) -> None:
        envs = make("alien", 3)
        first = envs.reset(seed=10)[0].copy()
        assert np.array_equal(envs.reset(seed=[10, 11, 12])[0], first)
        assert np.array_equal(envs.reset(seed=np.array([10, 11, 12], np.int32))[0], first)

    def test_negative_ones_and_none_keep_the_generators(self) -> None:
        envs, other = begun("alien", 2, seed=1), begun("alien", 2, seed=1)
        assert np.array_equal(envs.reset(seed=[-1, 5])[0][0], other.reset()[0][0])
        assert np.array_equal(envs.reset(seed=[None, 5])[0][0], other.reset()[0][0])

    @pytest.mark.parametrize(
        ("seed", "error"),
        [
            ("3", TypeError),
            (1.5, TypeError),
            (True, TypeError),
            ([1.5, 2.0, 3.0], TypeError),
            ([1], ValueError),
            ([[1], [2], [3]], ValueError),
            (-3, ValueError),
            (2**32, ValueError),
            ([1, 2, 2**32], ValueError),
        ],
    )
    def test_others_are_refused(self, seed: Any, error: type[Exception]) -> None:
        envs = make()
        with pytest.raises(error, match="seed"):
            envs.reset(seed=seed)
        envs.reset(seed=1)

    def test_without_a_seed_starts_differ(self) -> None:
        frames = {tuple(make("pong", 4).reset()[1]["frame_number"].tolist()) for _ in range(6)}
        assert len(frames) > 1


@pytest.mark.parametrize("mode", [AutoresetMode.SAME_STEP, "SameStep", "SAME_STEP", "same_step"])
def test_a_mode_has_its_value_and_its_name(mode: Any) -> None:
    assert make("pong", 2, autoreset_mode=mode).metadata["autoreset_mode"] is AutoresetMode.SAME_STEP


class TestBadInput:
    @pytest.mark.parametrize(
        ("actions", "error", "text"),
        [
            (np.array([0, 99, 0]), ValueError, "action 99 in row 1 is not within 0..3"),
            (np.array([0, 0, -1]), ValueError, "action -1 in row 2 is not within 0..3"),
            (np.array([0, 1]), ValueError, r"shape \(3,\), got \(2,\)"),
            (np.array([[0, 1, 2]]), ValueError, r"shape \(3,\), got \(1, 3\)"),
            (np.array([0.0, 1.0, np.nan]), TypeError, "must be integers"),
            (np.array([True, False, True]), TypeError, "must be integers"),
            (np.array([0, 1, 2**63], np.uint64), ValueError, "not within"),
            ([0, Action.FIRE, 0], TypeError, "Action.FIRE is an ALE action; pass env.unwrapped.get_action_meanings"),
            ("abc", TypeError, "must be integers"),
            (None, TypeError, "must be integers"),
        ],
    )
    def test_actions(self, actions: Any, error: type[Exception], text: str) -> None:
        envs = begun(seed=0)
        with pytest.raises(error, match=text):
            envs.step(actions)
        *_, info = envs.step([0, 1, 2])
        assert info["env_id"].tolist() == [0, 1, 2]

    @pytest.mark.parametrize(
        ("motion", "error"),
        [
            ((0.5, np.nan, 0.0), ValueError),
            ((1.5, 0.0, 0.0), ValueError),
            ((0.5, 0.0), ValueError),
            (("a", 0, 0), TypeError),
        ],
    )
    def test_continuous_actions(self, motion: Any, error: type[Exception]) -> None:
        envs = begun("pong", 1, continuous=True, seed=0)
        with pytest.raises(error, match="action"):
            envs.step(np.array([motion]))
        envs.step(np.zeros((1, 3), np.float32))

    @pytest.mark.parametrize(
        ("options", "error", "text"),
        [
            ({"num_envs": 0}, ValueError, "num_envs must be within 1..1000000, got 0"),
            ({"num_envs": None}, TypeError, "num_envs is needed"),
            ({"game": []}, ValueError, "at least one game"),
            ({"game": "pongg"}, ValueError, "did you mean 'pong'"),
            ({"thread_affinity_offset": -2}, ValueError, "thread_affinity_offset must be within -1..10000, got -2"),
            ({"batch_size": 4}, ValueError, "batch_size must be within 0..3, got 4"),
            ({"frameskip": 0}, ValueError, "frameskip"),
            ({"img_height": 0}, ValueError, "img_height"),
            ({"img_height": 211}, ValueError, "img_height must be at most 210"),
            ({"noop_max": -1}, ValueError, "noop_max"),
            ({"max_num_frames_per_episode": 0}, ValueError, "max_num_frames_per_episode"),
            ({"autoreset_mode": "Never"}, ValueError, "'NextStep', 'SameStep', 'Disabled', got 'Never'"),
            ({"render_mode": "human"}, ValueError, "render_mode must be 'rgb_array' or None"),
            ({"mode": "1"}, TypeError, "mode must be an integer, None, or a sequence"),
            ({"num_threads": 1.5}, TypeError, "num_threads"),
        ],
    )
    def test_options(self, options: dict[str, Any], error: type[Exception], text: str) -> None:
        with pytest.raises(error, match=text):
            make(**options)

    def test_calls_out_of_turn(self) -> None:
        envs = make()
        actions = np.zeros(3, int)
        with pytest.raises(gymnasium.error.ResetNeeded):
            envs.step(actions)
        with pytest.raises(gymnasium.error.NoAsyncCallError, match="send"):
            envs.recv()
        envs.reset(seed=0)
        with pytest.raises(gymnasium.error.NoAsyncCallError, match="send"):
            envs.recv()
        envs.send(actions)
        with pytest.raises(gymnasium.error.AlreadyPendingCallError, match="recv"):
            envs.send(actions)
        with pytest.raises(gymnasium.error.AlreadyPendingCallError, match="recv"):
            envs.step(actions)
        *_, info = envs.recv()
        assert info["env_id"].tolist() == [0, 1, 2]
        envs.send(actions)
        first, _ = envs.reset(seed=0)  # the reset drops the actions that were sent
        assert np.array_equal(first, make().reset(seed=0)[0])


class TestAsync:
    def test_batches_are_of_those_that_are_ready(self) -> None:
        envs, all_of_them = make("pong", 4, batch_size=2), make("pong", 4, batch_size=0)
        assert envs.action_space.shape == (2,)
        expected = [all_of_them.reset(seed=3)[0].copy()]
        for _ in range(40):
            expected.append(all_of_them.step(np.full(4, 2))[0].copy())
        observation, info = envs.reset(seed=3)
        steps = np.zeros(4, int)
        for _ in range(60):
            assert observation.shape == (2, 4, 84, 84)
            for row, index in enumerate(info["env_id"]):
                if steps[index] <= 40:
                    assert np.array_equal(observation[row], expected[steps[index]][index])
            steps[info["env_id"]] += 1
            envs.send(np.full(2, 2))
            observation, _, _, _, info = envs.recv()
        assert steps.min() > 5  # every environment is played

    def test_one_thread_serves_all_in_turn(self) -> None:
        envs = make("pong", 5, batch_size=2, num_threads=1)
        order = [envs.reset(seed=0)[1]["env_id"].tolist()]
        order += [envs.step(np.zeros(2, int))[4]["env_id"].tolist() for _ in range(4)]
        assert order == [[0, 1], [2, 3], [4, 0], [1, 2], [3, 4]]

    def test_final_observations(self) -> None:
        options = {"autoreset_mode": "SameStep", "max_num_frames_per_episode": 4, "num_threads": 1}
        envs, whole = begun("pong", 4, batch_size=2, seed=0, **options), begun("pong", 4, seed=0, **options)
        expected = whole.step(np.zeros(4, int))
        for _ in range(2):
            envs.send(np.zeros(2, int))
            envs.recv()
        *_, info = envs.step(np.zeros(2, int))
        assert info["env_id"].tolist() == [2, 3]
        assert np.array_equal(info["final_obs"], expected[4]["final_obs"][2:])

    def test_a_reset_forgets_what_is_in_flight(self) -> None:
        envs = begun("pong", 4, batch_size=1, seed=0)
        envs.send(np.array([0]))
        for _ in range(3):
            _, info = envs.reset(seed=0)
            assert info["episode_frame_number"][0] <= 30

    def test_no_partial_resets(self) -> None:
        envs = begun("pong", 4, batch_size=2)
        with pytest.raises(ValueError, match="batch_size=0"):
            envs.reset(options={"reset_mask": np.array([True, False, True, True])})
