"""The base classes: an environment and wrappers, with the method names of each Gym version."""

from typing import Any

import pytest

import atari.classic as gym
from atari.classic import logger


class Counter(gym.Env):
    """Counts up; done at 3."""

    metadata = {"render.modes": ["ansi"]}  # noqa: RUF012
    reward_range = (0, 1)
    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Discrete(4)
    closed = False

    def reset(self) -> int:
        self.n = 0
        return 0

    def step(self, action: Any) -> Any:
        self.n += action
        return self.n, 1.0, self.n == 3, {}

    def render(self, mode: str = "human") -> str:
        return f"{mode} {self.n}"

    def seed(self, seed: int | None = None) -> list[int]:
        return [seed or 7]

    def close(self) -> None:
        self.closed = True


METHODS = ("reset", "step", "render", "seed", "close")
Counter2016: Any = type(
    "Counter2016",
    (gym.Env,),
    {f"_{name}" if name in METHODS else name: value for name, value in vars(Counter).items() if name[0] != "_"},
)
"""The same with the names before 2018."""


@pytest.mark.parametrize("kind", [Counter, Counter2016])
@pytest.mark.parametrize("wrapped", [False, True])
def test_names_of_any_year(kind: type[gym.Env], wrapped: bool) -> None:
    env = gym.Wrapper(kind()) if wrapped else kind()
    assert env.reset() == 0
    assert [env.step(1) for _ in range(3)] == [(1, 1.0, False, {}), (2, 1.0, False, {}), (3, 1.0, True, {})]
    assert (env.render(), env.render("ansi"), env.render(mode="ansi")) == ("human 3", "ansi 3", "ansi 3")
    assert env.seed(4) == [4]
    with env as same:
        assert same is env
    assert env.unwrapped.closed  # type: ignore[attr-defined]


def test_what_is_missing_is_named() -> None:
    class Empty(gym.Env):
        pass

    for call, name in ((lambda e: e.reset(), "reset"), (lambda e: e.step(0), "step"), (lambda e: e.render(), "render")):
        with pytest.raises(NotImplementedError, match=rf"^Empty has no {name}\(\); define it$"):
            call(Empty())
    assert Empty().seed(3) == []
    Empty().close()


def test_an_attribute_named_like_an_old_method_is_no_method() -> None:
    class Seeded(gym.Env):
        _seed, _close = 5, True

    assert Seeded().seed(1) == []
    Seeded().close()


def test_a_wrapper_is_transparent() -> None:
    env = gym.Wrapper(Counter())
    env.reset()
    env.step(1)
    assert env.n == 1
    assert env.unwrapped is env.env
    assert (env.reward_range, env.metadata, env.spec) == ((0, 1), Counter.metadata, None)
    assert env.action_space is Counter.action_space
    assert str(env) == "<Wrapper<Counter instance>>"
    env.reward_range = (-1, 1)
    assert (env.reward_range, env.env.reward_range) == ((-1, 1), (0, 1))
    for name in ("_private", "missing"):
        with pytest.raises(AttributeError, match=name):
            getattr(env, name)


def test_wrappers_of_observation_reward_and_action() -> None:
    class Fives(gym.ObservationWrapper):
        def observation(self, observation: Any) -> Any:
            return 5 * observation

    class Twos(gym.ObservationWrapper):
        def _observation(self, observation: Any) -> Any:  # as before 2018
            return 2 * observation

    class Minus(gym.RewardWrapper):
        def _reward(self, reward: Any) -> Any:  # as before 2018
            return -reward

    class Opposite(gym.ActionWrapper):
        def action(self, action: Any) -> Any:
            return 1 - action

    env = Opposite(Minus(Twos(Fives(Counter()))))
    assert env.reset() == 0
    assert env.step(0) == (10, -1.0, False, {})
    assert env.step(1) == (10, -1.0, False, {})
    assert str(env) == "<Opposite<Minus<Twos<Fives<Counter instance>>>>>"
    with pytest.raises(NotImplementedError, match=r"^ObservationWrapper has no observation\(\); define it$"):
        gym.ObservationWrapper(Counter()).reset()


def test_a_wrapper_goes_around_an_environment() -> None:
    with pytest.raises(
        TypeError, match=r"a wrapper of atari.classic goes around one of its environments, got 'Pong-v0'"
    ):
        gym.Wrapper("Pong-v0")  # type: ignore[arg-type]


def test_uploading_says_that_there_is_nowhere_to(capsys: pytest.CaptureFixture[str]) -> None:
    logger.warn_once.cache_clear()
    gym.upload("results", algorithm_id="random", api_key="mine")
    assert capsys.readouterr().err.startswith(
        "atari.classic: gym.upload() does nothing, as the site it went to is closed"
    )


def test_wrappers_of_2016_call_the_names_of_2016() -> None:
    class Around(gym.Wrapper):
        def _reset(self) -> Any:
            return self.env.reset() - 1

        def _render(self, mode: str = "human", close: bool = False) -> Any:
            env: Any = self.env
            return None if close else env._render(mode)

    env: Any = Around(Counter2016())
    assert (env.reset(), env.render("ansi"), env.render(close=True)) == (-1, "ansi 0", None)
    cart: Any = gym.make("CartPole-v0")
    cart.reset()
    assert cart._render("rgb_array").shape == cart.env._render("rgb_array").shape == (400, 600, 3)
    cart._close()
    cart.unwrapped._close()
