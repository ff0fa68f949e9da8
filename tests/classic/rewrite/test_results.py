"""Five values of `step` and two of `reset`, where scripts take them."""

import numpy as np
import pytest
from old_scripts import marks, rewritten, run

CART = "import gym\nenv = gym.make('CartPole-v1')\n"


def test_a_loop_until_done() -> None:
    names = run(
        CART + "env.seed(0)\nobservation = env.reset()\ndone, n = False, 0\nwhile not done:\n"
        "    observation, reward, done, info = env.step(1)  # to the right\n    n += 1\n"
    )
    assert names["done"] is True
    assert names["terminated"] is True
    assert 5 < names["n"] < 15
    assert names["observation"].shape == (4,)


def test_done_is_true_of_a_truncated_episode() -> None:
    names = run(
        CART.replace("'CartPole-v1'", "'CartPole-v1', max_episode_steps=3")
        + "env.reset()\nfor n in range(10):\n    _, _, done, info = env.step(n % 2)\n    if done: break\n"
        "cut = info.get('TimeLimit.truncated', False)\n"
    )
    assert (names["n"], names["done"], names["cut"], names["terminated"]) == (2, True, True, False)


def test_statements_that_share_a_line() -> None:
    names = run(CART + "env.reset(); d, n = False, 0\nwhile not d: s, r, d, _ = env.step(0); n += 1\n")
    assert names["n"] > 3


def test_targets_that_are_no_names() -> None:
    names = run(
        CART + "class A: pass\na = A()\na.state = env.reset()\nb = {}\n"
        "a.state, b['reward'], a.done, [*_] = env.step(0)\n[x, _, _, _] = env.step(0)\n"
    )
    assert names["a"].done is False
    assert names["x"].shape == names["a"].state.shape == (4,)


def test_values_that_are_not_assigned() -> None:
    names = run(
        CART + "import numpy as np\nfirst = np.reshape(env.reset(), [1, 4])\nstate = before = env.reset()\n"
        "done = env.step(0)[2]\nreward = env.step(0)[1]\nboth = env.step(0)[:2]\ninfo = env.step(0)[3]\n"
        "result = env.step(0)\nended = result[2]\no, r, d, i = result\n"
    )
    assert names["first"].shape == (1, 4)
    assert names["state"].shape == (4,)
    assert (names["done"], names["reward"], names["info"], names["ended"], names["d"]) == (False, 1.0, {}, False, False)
    assert len(names["both"]) == 2


def test_functions_that_pass_results_on() -> None:
    names = run(
        CART + "def start(env):\n    return env.reset()\ndef play(e, action):\n    return e.step(action)\n"
        "shape = start(env).shape\nobs, reward, done, info = play(env, 0)\n"
    )
    assert names["shape"] == (4,)
    assert names["done"] is False


def test_other_things_with_step_and_reset_stay() -> None:
    text = CART + (
        "class Agent:\n    def reset(self):\n        self.n = 0\n    def step(self, a, b):\n        return a\n"
        "agent = Agent()\nstate = agent.reset()\nloss = agent.step(1, 2)\noptimizer = agent\noptimizer.step(1, 2)\n"
    )
    assert rewritten(text).partition("class")[2] == text.partition("class")[2]


def test_vectors_that_return_four_values_until_today_stay() -> None:
    text = (
        "import gym\nfrom stable_baselines3.common.vec_env import DummyVecEnv\n"
        "env = DummyVecEnv([lambda: gym.make('CartPole-v1')])\nobs = env.reset()\nobs, rewards, dones, infos = env.step([0])\n"
    )
    assert rewritten(text) == text.replace("import gym\n", "import gymnasium as gym\n")


def test_names_that_are_taken() -> None:
    names = run(CART + "truncated = 7\nenv.reset()\no, r, done, i = env.step(0)\n")
    assert (names["truncated"], names["is_truncated"], names["done"]) == (7, False, False)


@pytest.mark.parametrize(
    "line",
    ["*rest, = env.step(0)", "f(env.step(0))", "all_of_them = [env.step(0) for _ in range(2)]", "x = env.step(0)[-2]"],
)
def test_marks(line: str) -> None:
    text = CART + f"env.reset()\nf = print\n{line}\n"
    assert marks(text) == ["step() returns five values now: observation, reward, terminated, truncated, info"]
    assert line in rewritten(text)


def test_vectors() -> None:
    names = run("""\
import gym
envs = gym.vector.SyncVectorEnv([lambda: gym.make("CartPole-v1") for _ in range(3)])
envs.seed(1)
observations = envs.reset()
last = None
for t in range(40):
    observations, rewards, dones, infos = envs.step([0, 0, 1])
    for i, done in enumerate(dones):
        if done:
            last, now = infos[i]["terminal_observation"], observations[i]
more = gym.vector.make("CartPole-v1", 2, asynchronous=False)
start = more.reset()
""")
    assert names["dones"].shape == (3,)
    assert names["last"].shape == (4,)
    assert np.abs(names["last"]).max() > 0.2 > 0.05 >= np.abs(names["now"]).max()  # the next episode has begun
    assert names["start"].shape == (2, 4)


def test_info_of_a_vector_is_marked() -> None:
    text = "import gym\nenvs = gym.vector.make('CartPole-v1', 2)\no, r, d, infos = envs.step([0, 1])\n"
    assert marks(text + "for info in infos:\n    print(info.get('terminal_observation'))\n") == [
        'a vector\'s infos are one dictionary now: infos["final_obs"][i]'
    ]
