"""Gymnasium's environments with the old interface."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

import atari
import atari.classic as gym
from atari.classic.adapter import Adapter, adapt
from atari.classic.utils import seeding


class Probe(gymnasium.Env[Any, Any]):
    """Records its calls; the action decides how the episode ends."""

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 12}  # noqa: RUF012
    action_space = gymnasium.spaces.Discrete(4)
    observation_space = gymnasium.spaces.Discrete(10)

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode
        self.calls: list[Any] = []

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        self.calls.append(seed)
        return 0, {}

    def step(self, action: int) -> Any:
        """Bit 0: terminated; bit 1: truncated. (NumPy bools, for which `done is True` is false.)"""
        return 1, 2.5, np.bool_(action & 1), np.bool_(action & 2), {}

    def render(self) -> Any:
        self.calls.append(self.render_mode)
        return np.full((2, 3, 3), 7, np.uint8)


def test_steps_are_those_of_the_modern_interface() -> None:
    env, modern = gym.make("Pong-v4"), atari.make("Pong-v4")  # two to four frames a step, drawn by the seed
    env.seed(1)
    np.testing.assert_array_equal(env.reset(), modern.reset(seed=1)[0])
    for action in range(6):
        observation, reward, done, _ = env.step(action)
        expected, modern_reward, terminated, *_ = modern.step(action)
        np.testing.assert_array_equal(observation, expected)
        assert (reward, done) == (modern_reward, terminated)


def test_done_is_terminated_or_truncated() -> None:
    env = adapt(Probe())
    env.reset()
    assert env.step(0) == (1, 2.5, False, {})
    assert env.step(1) == (1, 2.5, True, {})
    assert env.step(2) == (1, 2.5, True, {"TimeLimit.truncated": True})
    assert env.step(3) == (1, 2.5, True, {"TimeLimit.truncated": False})
    assert env.step(1)[2] is True


def test_a_seed_waits_for_the_next_reset() -> None:
    probe = Probe()
    env = adapt(probe)
    env.reset()
    assert env.seed(5) == [5]
    assert env.seed(np.int64(6)) == [6]
    env.reset()
    env.reset()
    assert probe.calls == [None, 6, None]
    (chosen,) = env.seed()
    env.reset()
    assert probe.calls[-1] == chosen


@pytest.mark.parametrize("env_id", ["CartPole-v0", "Pong-ram-v0", "Taxi-v3"])
def test_the_generator_has_gyms_stream_from_the_seed_on(env_id: str) -> None:
    env: Any = gym.make(env_id)
    assert env.unwrapped.np_random.randint(5) in range(5)
    env.seed(4)
    expected = seeding.np_random(4)[0]
    assert [env.np_random.randint(100) for _ in range(5)] == [expected.randint(100) for _ in range(5)]
    env.unwrapped.np_random = np.random.RandomState(9)
    assert env.np_random.randint(1000) == np.random.RandomState(9).randint(1000)


def test_classic_control_draws_from_the_generator_and_others_do_not() -> None:
    for env_id, draws in (("CartPole-v0", True), ("Pong-ram-v4", False)):
        env: Any = gym.make(env_id)
        env.seed(4)
        env.reset()
        assert (env.np_random.randint(10**6) != seeding.np_random(4)[0].randint(10**6)) is draws


@pytest.mark.parametrize("wrong", [-1, 1.5, "x"])
def test_wrong_seeds(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"^a seed is an integer of 0 or more, or None, got "):
        adapt(Probe()).seed(wrong)


def test_reset_takes_no_seed() -> None:
    with pytest.raises(
        TypeError, match=r"^reset\(\) takes no seed here; call env.seed\(0\) before it, or use gymnasium.make$"
    ):
        gym.make("CartPole-v0").reset(seed=0)  # type: ignore[call-arg]


def test_a_copy_goes_on_where_it_was_made() -> None:
    for env_id in ("CartPole-v0", "Pong-ram-v0"):
        env = gym.make(env_id)
        env.reset()
        env.step(0)
        for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
            assert other._elapsed_steps == 1
            assert str(other) == str(env)
        twin = copy.deepcopy(env)
        for action in (0, 1, 1, 0, 1):
            np.testing.assert_array_equal(env.step(action)[0], twin.step(action)[0])


@pytest.mark.parametrize("env_id", ["CartPole-v0", "FrozenLake-v1", "Pong-ram-v0", "ALE/Breakout-v5"])
def test_a_seed_repeats_its_episodes(env_id: str) -> None:
    def episodes() -> list[bytes]:
        env.seed(3)
        env.action_space.seed(3)
        seen = []
        for _ in range(3):
            seen.append(env.reset())
            seen += [env.step(env.action_space.sample())[0] for _ in range(5)]
        return [np.asarray(observation).tobytes() for observation in seen]

    env = gym.make(env_id)
    first = episodes()
    assert first == episodes()
    assert first[:6] != first[6:12]  # the next episode is another


def test_an_atari_game_has_what_scripts_reach_for() -> None:
    env = gym.make("Breakout-v0")
    env.seed(0)
    env.reset()
    assert env.unwrapped.get_action_meanings() == ["NOOP", "FIRE", "RIGHT", "LEFT"]  # type: ignore[attr-defined]
    assert env.get_action_meanings() == ["NOOP", "FIRE", "RIGHT", "LEFT"]  # type: ignore[attr-defined]
    assert env.unwrapped.ale.lives() == env.ale.lives() == 5  # type: ignore[attr-defined]
    assert env.env.ale.getRAM().shape == (128,)  # type: ignore[attr-defined]
    info = env.step(1)[3]
    assert info["ale.lives"] == info["lives"] == 5


def test_attributes_are_the_environments_for_reading_and_writing() -> None:
    env = gym.make("CartPole-v0")
    env.reset()
    assert env.unwrapped.gravity == env.gravity == 9.8  # type: ignore[attr-defined]
    env.unwrapped.gravity = 1.6  # type: ignore[attr-defined]
    env.env.state = (0.0, 0.0, 0.1, 0.0)  # type: ignore[attr-defined]
    observation = env.step(1)[0]
    assert observation[2] == np.float32(0.1)  # the angle changes with the speed before the step
    assert env.unwrapped.modern.unwrapped.gravity == 1.6  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"^this CartPoleEnv has no attribute 'nothing'$"):
        _ = env.nothing  # type: ignore[attr-defined]
    env.observation_space, env.unwrapped.observation_space = (gym.spaces.Box(0, 1, (size,)) for size in (2, 3))
    assert (env.observation_space.shape, env.unwrapped.observation_space.shape) == ((2,), (3,))


def test_tables_of_toy_texts() -> None:
    cliff: Any = gym.make("CliffWalking-v0")
    assert (cliff.nS, cliff.nA, cliff.shape) == (48, 4, (4, 12))
    lake: Any = gym.make("FrozenLake-v0")
    assert (lake.nS, lake.nA) == (lake.env.nS, lake.unwrapped.nA) == (16, 4)
    for env in (lake, lake.env, lake.unwrapped):
        chances = [[p for p, *_ in env.P[14][action]] for action in range(4)]
        assert ([len(each) for each in chances], sum(chances[2])) == ([3] * 4, pytest.approx(1))


def test_names() -> None:
    assert str(gym.make("CartPole-v0")) == "<TimeLimit<CartPoleEnv<CartPole-v0>>>"
    assert str(adapt(Probe())) == "<Probe instance>"
    assert gym.make("CartPole-v0").reward_range == (-float("inf"), float("inf"))


# Actions


def test_step_before_reset() -> None:
    for env in (gym.make("CartPole-v0"), gym.make("Pong-v0"), adapt(Probe())):
        with pytest.raises(
            gym.error.ResetNeeded, match=r"^step\(\) came before the first reset\(\); call env.reset\(\) first$"
        ):
            env.step(0)


@pytest.mark.parametrize(
    ("wrong", "kind", "text"),
    [
        (2, ValueError, "the action 2 is not within 0..1; env.action_space.sample() gives one that is"),
        (-1, ValueError, "the action -1 is not within 0..1; env.action_space.sample() gives one that is"),
        (1.0, TypeError, "an action is an integer within 0..1, got 1.0"),
        (None, TypeError, "an action is an integer within 0..1, got None"),
        ("left", TypeError, "an action is an integer within 0..1, got 'left'"),
        ([0, 1], TypeError, "an action is an integer within 0..1, got [0, 1]"),
        ([1.0], TypeError, "an action is an integer within 0..1, got [1.0]"),
        ([[2]], ValueError, "the action 2 is not within 0..1; env.action_space.sample() gives one that is"),
    ],
)
def test_a_wrong_action_plays_nothing(wrong: Any, kind: type[Exception], text: str) -> None:
    env = gym.make("CartPole-v0")
    env.reset()
    before = env.state  # type: ignore[attr-defined]
    with pytest.raises(kind) as error:
        env.step(wrong)
    assert str(error.value) == text
    assert env.state is before  # type: ignore[attr-defined]


def test_actions_of_numpy_and_in_lists_are_integers_too() -> None:
    env, twin = gym.make("CartPole-v0"), gym.make("CartPole-v0")
    for each in (env, twin):
        each.seed(0)
        each.reset()
    for action in (np.int64(1), np.array(1), True, [1], np.array([1]), np.array([[1]]), (1,)):
        np.testing.assert_array_equal(env.step(action)[0], twin.step(1)[0])


def test_actions_of_a_box() -> None:
    """Scripts pass lists, other shapes of the same size, and numbers that the environment clips."""
    env = gym.make("Pendulum-v1")
    env.reset()
    for action in ([0.5], np.array([0.5]), np.array([[0.5]]), [9]):
        assert env.step(action)[0].shape == (3,)
    with pytest.raises(ValueError, match=r"^an action is an array of shape \(1,\), got one of shape \(2,\)$"):
        env.step([1, 2])
    with pytest.raises(TypeError, match=r"^an action is an array of shape \(1,\), got 'up'$"):
        env.step("up")


# Rendering


def test_a_mode_is_of_the_call_not_of_the_environment() -> None:
    probe = Probe()
    env = adapt(probe)
    env.reset()
    assert env.render(mode="rgb_array").shape == (2, 3, 3)
    assert env.render() is True
    assert probe.calls == [None, "rgb_array", "rgb_array"]
    assert probe.render_mode is None
    env.render(close=True)
    env.close()


def test_metadata_has_the_old_names() -> None:
    assert adapt(Probe()).metadata == {
        "render.modes": ["human", "rgb_array"],
        "video.frames_per_second": 12,
        "video.pixel_aspect": (1, 1),
    }
    breakout = gym.make("Breakout-v0").metadata
    assert (breakout["render.modes"], breakout["video.pixel_aspect"]) == (["human", "rgb_array"], (2, 1))
    assert breakout["video.frames_per_second"] == pytest.approx(59.92 / 3, abs=0.1)


@pytest.mark.parametrize("env_id", ["CartPole-v0", "MountainCar-v0", "Pendulum-v0", "Acrobot-v1", "Breakout-v0"])
def test_rgb_arrays(env_id: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gym.make(env_id)
    env.reset()
    image = env.render(mode="rgb_array")
    assert (image.dtype, image.ndim, image.shape[2]) == (np.uint8, 3, 3)
    assert len(np.unique(image)) > 1
    assert env.render() is True
    with pytest.raises(
        gym.error.UnsupportedMode, match=r"^this environment cannot render 'ansi'; it has human, rgb_array$"
    ):
        env.render(mode="ansi")
    env.close()


def test_the_window_shows_the_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each pixel of a game is two columns wide, and the window is enlarged."""
    import pygame

    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gym.make("Pong-v4")
    env.reset()
    env.render()
    window = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    assert pygame.display.get_caption()[0] == "Pong-v4"
    assert window.shape == (420, 640, 3)
    np.testing.assert_array_equal(window[::2, ::4], env.render(mode="rgb_array"))
    other = gym.make("CartPole-v0")
    other.reset()
    other.render()
    assert pygame.display.get_surface().get_size() == (600, 400)
    other.close()
    env.render()  # the other environment has closed the only window
    assert pygame.display.get_surface().get_size() == (640, 420)
    env.close()
    assert pygame.display.get_surface() is None


def test_text_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    env = gym.make("FrozenLake-v0", is_slippery=False)
    env.reset()
    capsys.readouterr()
    env.step(1)
    env.render()
    printed = capsys.readouterr().out
    assert printed == env.render(mode="ansi") + "\n"
    assert "(Down)" in printed
    assert "\x1b[41mF\x1b[0mHFH" in printed


def test_rendering_before_the_first_reset(capsys: pytest.CaptureFixture[str]) -> None:
    """Toy texts had a state before the first reset, and books render it. The episode still begins with `reset`."""
    env = gym.make("Taxi-v3")
    env.seed(0)
    env.render()
    shown = capsys.readouterr().out
    with pytest.raises(gym.error.ResetNeeded):
        env.step(0)
    env.reset()
    env.render()
    assert capsys.readouterr().out == shown


def test_a_state_before_the_first_reset(capsys: pytest.CaptureFixture[str]) -> None:
    """Toy texts without a time limit begin at their construction; a state that is set stays."""
    env = gym.make("Taxi-v2").env
    env.s = 328
    env.render()
    assert env.s == 328
    assert (env.step(1)[0], env.s) == (228, 228)  # north
    assert gym.make("Blackjack-v0").unwrapped.step(0)[2] is True  # the player stops
    taxi = gym.make("Taxi-v2")
    taxi.env.s = 328
    taxi.env.s = taxi.env.s + 100
    assert taxi.unwrapped.s == 428
    assert gym.make("FrozenLake-v0").unwrapped.step(0)[0] in (0, 4)


def test_an_environment_that_only_shows_itself() -> None:
    class Shy(Probe):
        metadata = {"render_modes": ["human"]}  # noqa: RUF012

    shy = Shy()
    env = Adapter(shy)
    env.reset()
    env.render()
    assert shy.calls == [None, "human"]


def test_an_environment_without_rgb_array() -> None:
    class Blind(Probe):
        metadata = {"render_modes": []}  # noqa: RUF012

    env = Adapter(Blind())
    env.reset()
    with pytest.raises(gym.error.UnsupportedMode, match=r"^this environment cannot render 'human'; it has no mode$"):
        env.render()
