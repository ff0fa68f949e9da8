"""Attributes of environments, specs and random numbers."""

import pytest
from old_scripts import marks, run

MAKE = "import gym\nenv = gym.make('{}')\nstate = env.reset()\n"


def value(env_id: str, expression: str) -> object:
    return run(MAKE.format(env_id) + f"value = {expression}\n")["value"]


def test_attributes_behind_wrappers() -> None:
    assert value("FrozenLake-v0", "(env.nS, env.nA, env.env.nS, len(env.P), len(env.unwrapped.P), env.s)") == (
        *(16, 4, 16, 16, 16),
        0,
    )
    assert value("Breakout-v4", "(env.ale.lives(), env.get_action_meanings()[1], env.unwrapped.ale.lives())") == (
        5,
        "FIRE",
        5,
    )
    assert value("Breakout-v4", "(env.unwrapped._get_ram().shape, env.env._get_image().shape)") == (
        (128,),
        (210, 160, 3),
    )
    assert value("Breakout-v4", "env.step(0)[3]['ale.lives']") == 5
    assert value("CartPole-v1", "(env._max_episode_steps, env.reward_range)") == (500, (float("-inf"), float("inf")))


def test_an_id_in_front_of_an_attribute_changes_too() -> None:
    names = run(
        "import gym\nn = gym.make('FrozenLake-v0').env.nS\nlimit = gym.make('Taxi-v2').spec.timestep_limit\n"
        "steps = gym.make('FrozenLake-v0')._max_episode_steps\nlives = gym.make('Pong-v3').ale.lives()\n"
    )
    assert (names["n"], names["limit"], names["steps"], names["lives"]) == (16, 200, 100, 0)


def test_attributes_of_own_wrappers() -> None:
    names = run(
        "import gym\nclass Count(gym.Wrapper):\n    n = 3\n    def twice(self):\n        return self.n * 2\n"
        "class Outer(gym.Wrapper):\n    pass\n"
        "env = Outer(Count(gym.make('CartPole-v1')))\nvalue = env.n, env.twice(), Count(env).n\n"
    )
    assert names["value"] == (3, 6, 3)


def test_specs() -> None:
    assert value(
        "CartPole-v1", "(env.spec.timestep_limit, env.spec.id, gym.spec('CartPole-v1').max_episode_steps)"
    ) == (
        *(500, "CartPole-v1"),
        500,
    )
    tags = "env.spec.tags.get('wrapper_config.TimeLimit.max_episode_steps')"
    assert value("CartPole-v1", tags) == 500
    assert marks(MAKE.format("CartPole-v1") + "print(env.spec.trials)\n") == ["a spec has no trials now"]


def test_random_numbers() -> None:
    names = run(
        MAKE.format("CartPole-v1")
        + "r = env.unwrapped.np_random\na = env.np_random.randint(1, 4)\nb = env.np_random.rand(2, 3)\n"
        "c = env.np_random.rand(2)\nd = env.np_random.randn()\ne = env.np_random.uniform(0, 1)\n"
    )
    assert names["a"] in (1, 2, 3)
    assert (names["b"].shape, names["c"].shape) == ((2, 3), (2,))
    assert marks(MAKE.format("CartPole-v1") + "env.np_random.seed(3)\n") == [
        "np_random is a numpy.random.Generator now, which has no seed()"
    ]


@pytest.mark.parametrize(
    ("line", "mark"),
    [
        ("env._max_episode_steps = 5", "max_episode_steps=...) changes the time limit"),
        ("env.configure(remotes=1)", "no configure()"),
        ("env.gravity = 3", "outermost wrapper alone"),
        ("print(env.reward_range)", "no reward_range now"),
        ("env.reward_range = (0, 1)", "no reward_range now"),
    ],
)
def test_marks(line: str, mark: str) -> None:
    assert mark in marks(MAKE.format("CartPole-v1") + line + "\n")[0]


def test_the_state_of_an_environment_can_be_set() -> None:
    assert value("CartPole-v1", "1\nenv.state = (0, 0, 0.1, 0)\nobs, _, _, _ = env.step(0)")
