"""The agents of `scripts/agents` run as commands, and those that learn play better than a random agent.

"Better" is a difference of the means of at least five standard errors, which has a probability of one in three million
by chance. Seeds are fixed, so a test always gives the same result.
"""

import random
import re
import runpy
import statistics
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from math import sqrt
from pathlib import Path
from typing import Any

import gymnasium
import pytest

FOLDER = Path(__file__).parent.parent.parent / "scripts" / "agents"
SCRIPTS = ("random_agent", "q_learning", "ram_pong")


@pytest.fixture(scope="module")
def script(request: pytest.FixtureRequest) -> Any:
    path = list(sys.path)
    yield {name: runpy.run_path(str(FOLDER / f"{name}.py")) for name in SCRIPTS}
    sys.path[:] = path


def standard_errors_apart(some: list[float], others: list[float]) -> float:
    error = sqrt(statistics.variance(some) / len(some) + statistics.variance(others) / len(others))
    return (statistics.mean(some) - statistics.mean(others)) / error


@pytest.fixture
def command(script: Any, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Runs a script's command line in this process: returns its status, and what it prints to stdout and stderr."""

    def run(name: str, *options: str) -> tuple[int, str, str]:
        status = 0
        try:
            script[name]["main"](list(options))
        except SystemExit as ended:
            status = ended.code
        return (status, *capsys.readouterr())

    return run


def test_q_learning_beats_chance_on_slippery_ice(script: Any) -> None:
    env = gymnasium.make("FrozenLake-v1", is_slippery=True)
    env.reset(seed=0)
    play_episode, evaluate = (script["q_learning"][name] for name in ("play_episode", "evaluate"))
    agent = script["q_learning"]["QLearner"](16, 4, seed=0)
    for _ in range(8_000):
        play_episode(env, agent)
    agent.epsilon = 0.0
    learned = evaluate(env, agent, 500)
    by_chance = evaluate(env, script["random_agent"]["RandomAgent"](env.action_space, 0), 500)
    assert standard_errors_apart(learned, by_chance) > 5
    assert statistics.mean(by_chance) < 0.05
    assert statistics.mean(learned) > 0.6  # the best policy has 0.74


def test_q_learning_of_pong_beats_chance(script: Any) -> None:
    pong = script["ram_pong"]
    env = pong["make_pong"]()
    env.reset(seed=0)
    agent = pong["LinearQLearner"](seed=0)
    for _ in range(15):
        pong["play_episode"](env, agent)
    learned = pong["evaluate"](env, agent, 5)
    by_chance = pong["evaluate"](env, script["random_agent"]["RandomAgent"](env.action_space, 0), 10)
    assert standard_errors_apart(learned, by_chance) > 5
    assert statistics.mean(by_chance) < -19


def test_a_step_of_q_learning(script: Any) -> None:
    agent = script["q_learning"]["QLearner"](3, 2, learning_rate=0.5, discount=0.9, exploration=95, seed=0)
    agent.train(1, 0, 1.0, 2)
    assert agent.q == [[0, 0], [0.5, 0], [0, 0]]
    agent.train(0, 1, 0.0, 1)
    assert agent.q == [[0, 0.225], [0.5, 0], [0, 0]]
    assert agent.epsilon == pytest.approx(0.98)
    for _ in range(200):
        agent.train(2, 0, 0.0, 2)
    assert agent.epsilon == 0.05
    agent.epsilon = 0.0
    assert [agent.select_action(state) for state in (0, 1)] == [1, 0]


@pytest.mark.parametrize(
    ("ball", "row"),
    [
        ((100, 100, -4, 4), 100),  # it moves away
        ((100, 100, 0, 4), 100),
        ((148, 100, 4, 2), 120),
        ((148, 190, 4, 4), 184),  # off the lower wall, at 207
        ((148, 50, 4, -4), 78),  # off the upper one, at 44
        ((100, 100, 1, 4), 126),  # off both
    ],
)
def test_where_the_ball_of_pong_arrives(script: Any, ball: tuple[int, int, int, int], row: float) -> None:
    assert script["ram_pong"]["landing"](*ball) == row


def test_the_ball_of_pong_turns_back_where_the_script_says(script: Any) -> None:
    """In the game itself: the rows at which the ball stops falling or rising."""
    pong = script["ram_pong"]
    env = pong["gymnasium"].make("PongNoFrameskip-v4", obs_type="ram")
    ram, _ = env.reset(seed=0)
    rows: Counter[int] = Counter()
    track: list[int] = []
    moves = random.Random(0)
    for _ in range(20_000):
        follow = 2 if ram[pong["PADDLE_Y"]] > ram[pong["BALL_Y"]] else 3
        ram, reward, terminated, truncated, _ = env.step(follow if moves.random() < 0.8 else moves.randrange(6))
        track = [*track, int(ram[pong["BALL_Y"]])][-3:]
        if reward or terminated or truncated:
            track = []
        elif len(track) == 3 and 0 not in track and (track[1] - track[0]) * (track[2] - track[1]) < 0:
            rows[track[1]] += 1
        if terminated or truncated:
            ram, _ = env.reset()
    assert min(rows) == pong["TOP"]
    assert max(range(100, 256), key=rows.__getitem__) == pong["BOTTOM"]  # a paddle can turn it a row lower


def test_a_random_agent_takes_every_action_and_repeats_with_its_seed(script: Any) -> None:
    random_agent = script["random_agent"]["RandomAgent"]
    runs = []
    for seed in (1, 1, 2):
        agent = random_agent(gymnasium.spaces.Discrete(3), seed)
        runs.append([int(agent.select_action(None)) for _ in range(3_000)])
    assert runs[0] == runs[1] != runs[2]
    # A count has a standard deviation of 26.
    assert all(abs(runs[0].count(action) - 1000) < 5 * 26 for action in range(3))


# As commands


@pytest.mark.parametrize("name", SCRIPTS)
def test_help(name: str, script: Any, command: Any) -> None:
    status, shown, _ = command(name, "--help")
    assert status == 0
    assert "--episodes" in shown
    assert script[name]["__doc__"].strip().splitlines()[0] in shown


def test_the_random_agent_plays_any_id(command: Any) -> None:
    words = ("Copy-v0", "--episodes", "3")
    line = [sys.executable, str(FOLDER / "random_agent.py"), *words]
    shown = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    assert [line.partition(":")[0] for line in shown.splitlines()[:3]] == [f"episode {n}" for n in (1, 2, 3)]
    assert re.fullmatch(r"mean return -?\d+\.\d\d", shown.splitlines()[3])
    assert command("random_agent", *words) == (0, shown, "")


def test_the_learners_print_their_progress(command: Any) -> None:
    status, shown, _ = command("q_learning", "--episodes", "20")
    assert status == 0
    *lines, last = shown.splitlines()
    assert [line.partition(":")[0] for line in lines] == [f"{2 * n} episodes" for n in range(1, 11)]
    assert re.fullmatch(r"mean return over 500 episodes: 0\.\d{3}, random 0\.\d{3}", last)
    status, shown, _ = command("ram_pong", "--episodes", "1", "--games", "2")
    assert status == 0
    assert re.fullmatch(r"points ahead in 2 games: -\d+\.\d, random -\d+\.\d", shown.splitlines()[-1])


@pytest.mark.parametrize(
    ("line", "text"),
    [
        (("random_agent", "--episodes", "0"), "argument --episodes: give a number, 1 or more, got '0'"),
        (("random_agent", "Pong-v9"), "error: Environment version `v9` for environment `Pong` doesn't exist"),
        (("q_learning", "FrozenPond-v1"), "error: Environment `FrozenPond` doesn't exist"),
        (("q_learning", "CartPole-v1"), "a table needs Discrete spaces, and CartPole-v1 has Box("),
        (("ram_pong", "--episodes", "ten"), "argument --episodes: give a number, 1 or more, got 'ten'"),
    ],
)
def test_mistakes_on_the_command_line(line: tuple[str, ...], text: str, command: Any) -> None:
    status, _, shown = command(*line)
    assert status == 2
    assert text in shown
