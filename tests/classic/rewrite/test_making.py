"""IDs, seeds, render modes, Monitor and wrappers."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest
from old_scripts import marks, moviepy, rewritten, run, videos


@pytest.mark.parametrize("env_id", ["FrozenLake-v0", "Taxi-v2", "Pendulum-v0", "PongDeterministic-v3"])
def test_ids_that_are_gone(env_id: str) -> None:
    env = run(f"import gym\nenv = gym.make('{env_id}')\nstate = env.reset()\n")["env"]
    assert env.spec.id != env_id
    assert env.spec.name == env_id.partition("-")[0]


def test_ids_that_still_exist() -> None:
    assert run("import gym\nenv = gym.make('Breakout-v0')\n")["env"].spec.id == "Breakout-v0"


def test_the_games_are_imported_where_a_script_may_make_one() -> None:
    for line in (
        "env = gym.make('Pong-ram-v0')",
        "env = gym.make(name)",
        "parser.add_argument('--env', default='Qbert-v4')",
    ):
        assert "import atari  # registers the Atari games\n" in rewritten(f"import gym\n{line}\n")
    assert "import atari" not in rewritten("import gym\nenv = gym.make('CartPole-v1')\n")


def test_a_seed_goes_to_the_reset_that_follows() -> None:
    names = run(
        "import gym\nimport numpy as np\nenv = gym.make('CartPole-v1')\n"
        "env.seed(42)\nenv.action_space.seed(42)\nnp.random.seed(42)\nstate = env.reset()\n"
    )
    assert np.array_equal(names["state"], gymnasium.make("CartPole-v1").reset(seed=42)[0])


def test_a_seed_before_a_loop_does_not_repeat_the_episode() -> None:
    text = "import gym\nenv = gym.make('CartPole-v1')\nenv.seed(5)\nstates = []\nfor _ in range(2):\n    states.append(env.reset())\n"
    first, second = run(text)["states"], run(text)["states"]
    assert np.array_equal(first, second)
    assert not np.array_equal(first[0], first[1])


def test_a_seed_in_a_wrapper_and_in_a_list() -> None:
    names = run("""\
import gym
class Same(gym.Wrapper):
    def seed(self, seed=None):
        return self.env.seed(seed)
envs = [Same(gym.make("CartPole-v1")) for _ in range(2)]
[env.seed(3) for env in envs]
states = [env.reset() for env in envs]
""")
    assert np.array_equal(*names["states"])


def test_a_seed_whose_result_is_used_is_marked() -> None:
    text = "import gym\nenv = gym.make('CartPole-v1')\nseeds = env.seed(1)\n"
    assert marks(text) == ["reset(seed=...) seeds an environment now, and returns no list of seeds"]


def test_a_picture() -> None:
    for argument in ("mode='rgb_array'", "'rgb_array'"):
        names = run(f"import gym\nenv = gym.make('Breakout-v4')\nenv.reset()\nimage = env.render({argument})\n")
        assert names["image"].shape == (210, 160, 3)


def test_a_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    names = run(
        "import gym\nenv = gym.make('CartPole-v1')\nenv.render()\nstate = env.reset()\nenv.render(mode='human')\n"
        "env.step(0)\nenv.render(close=True)\n"
    )
    assert names["env"].render_mode == "human"
    names["env"].close()


def test_text(capsys: pytest.CaptureFixture[str]) -> None:
    run("import gym\nenv = gym.make('FrozenLake-v0')\ns = env.reset()\nenv.render()\n")
    assert "FHFH" in capsys.readouterr().out


def test_a_state_that_is_set_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    """Books render a state that they set before any `reset`, which Gymnasium needs before the first `render`."""
    names = run(
        "import gym\nenv = gym.make('FrozenLake-v0', is_slippery=False).env\nenv.s = 14\nenv.render()\nenv.render()\n"
        "state, reward, done, info = env.step(2)\n"
    )
    assert (names["state"], names["reward"], names["done"]) == (15, 1, True)
    assert "HFF\x1b[41mG" not in capsys.readouterr().out


def test_render_modes_that_are_marked() -> None:
    make = "import gym\nenv = gym.make('CartPole-v1')\nenv.reset()\n"
    for test in ("slow", "n % 9 == 0", "n() and 1"):
        text = make + f"n = 0\nif {test}:\n    env.render()\n"
        assert 'render_mode="human" shows every step' in marks(text)[0]
        assert "episodes to see\nenv = gym.make" in rewritten(text)
    assert "shows no window" in marks(make + "env.render()\nimage = env.render('rgb_array')\n")[0]
    assert "make() gets the render mode" in marks(make + "env.render(mode)\n")[0]
    assert "where this environment is made" in marks("import gym\ndef f(env):\n    return env.render('rgb_array')\n")[0]


WINDOWS = {
    "if render:\n    env.render()": "render",
    "if args.render and n > 3:\n    env.render()": "args.render",
    "if n > 3:\n    if not render:\n        env.render()": "not render",
    "if render and args.render:\n    env.render()": "render and args.render",
    "if render:\n    env.render()\nif args.render:\n    env.render()": None,
    "if later:\n    env.render()": None,
    "if render:\n    pass\nelse:\n    env.render()": None,
    "def test(render):\n    if render: env.render()": None,
    "def show():\n    if render: env.render()": "render",
    "if n > 3 or 1:\n    env.render()": None,
    "if changed:\n    env.render()": None,
}


@pytest.mark.parametrize("lines", WINDOWS)
def test_a_window_under_a_condition(lines: str) -> None:
    text = (
        "import gym, types\nrender, changed = False, False\nargs = types.SimpleNamespace(render=False)\n"
        f"env = gym.make('CartPole-v1')\nenv.reset()\nlater, n = False, 2\n{lines}\n"
        "def f():\n    global changed\n    changed = True\n"
    )
    condition = WINDOWS[lines]
    end = f" if {condition} else None" if condition else ""
    assert f"env = gym.make('CartPole-v1', render_mode=\"human\"{end})\n" in rewritten(text)
    if condition in ("render", "args.render"):
        assert run(text)["env"].render_mode is None


def test_a_window_in_a_class_and_in_a_program() -> None:
    new = rewritten("""\
import gym
class Agent:
    def __init__(self, show):
        self.show = show
        self.env = gym.make("CartPole-v1")
    def play(self):
        if self.show:
            self.env.render()
def main(show):
    env = gym.make("Acrobot-v1")
    if show:
        env.render()
if __name__ == "__main__":
    other = gym.make("Pendulum-v0")
    other.render()
""")
    assert 'gym.make("CartPole-v1", render_mode="human" if self.show else None)' in new
    assert 'gym.make("Acrobot-v1", render_mode="human" if show else None)' in new
    assert 'gym.make("Pendulum-v1", render_mode="human")' in new
    assert "# atari.classic" not in new


def test_two_environments_have_their_own_modes() -> None:
    new = rewritten(
        "import gym\nenv = gym.make('CartPole-v1')\ntest_env = gym.make('CartPole-v1')\ntest_env.render()\n"
    )
    assert "env = gym.make('CartPole-v1')\ntest_env = gym.make('CartPole-v1', render_mode=\"human\")\n" in new


PLAY = """
env.seed(1)
lengths = []
for episode in range(3):
    observation = env.reset()
    t = 0
    while True:
        observation, reward, done, info = env.step(t % 2)
        t += 1
        if done:
            break
    lengths.append(t)
rewards = env.get_episode_rewards() if hasattr(env, 'rewards_of_monitor') else None
env.close()
"""


@pytest.mark.parametrize(
    "monitor",
    [
        "from gym.wrappers import Monitor\nenv = Monitor(env, {folder!r}, video_callable=lambda e: e % 2 == 0, force=True)",
        "from gym import wrappers\nenv = wrappers.Monitor(env, directory={folder!r}, video_callable=lambda e: e != 1)",
        "env = gym.wrappers.Monitor(env, {folder!r}, lambda e: e in (0, 2), True)",
        "env.monitor.start({folder!r}, force=True, video_callable=lambda e: e != 1)",
    ],
)
def test_monitor(monitor: str, tmp_path: Path) -> None:
    text = (
        "import gym\nenv = gym.make('CartPole-v1', max_episode_steps=20)\n"
        + monitor.format(folder=str(tmp_path))
        + PLAY
    )
    with moviepy():
        names = run(text.replace("rewards = ", "# "))
    first, _, third = names["lengths"]
    assert videos(tmp_path) == {"rl-video-episode-0.mp4": first + 1, "rl-video-episode-2.mp4": third + 1}


@pytest.mark.parametrize(
    "monitor",
    [
        "from gym.wrappers import Monitor\nenv = Monitor(env, {folder!r}, video_callable=lambda e: e == 0, force=True)",
        "env = gym.wrappers.Monitor(env, {folder!r}, lambda e: e == 0)",
        "env.monitor.start({folder!r}, video_callable=lambda e: e == 0)",
    ],
)
def test_monitor_of_a_game_needs_no_other_package(monitor: str, tmp_path: Path) -> None:
    text = "import gym\nenv = gym.make('Pong-v0', max_episode_steps=20)\n" + monitor.format(folder=str(tmp_path))
    names = run(text + PLAY.replace("rewards = ", "# "))
    assert names["lengths"] == [20, 20, 20]
    assert list(videos(tmp_path)) == ["rl-video-episode-0.mp4"]
    assert marks(text) == []
    other = text + "\nother = gym.wrappers.Monitor(gym.make('CartPole-v1'), 'folder')\n"
    assert set(marks(other)) == {"RecordVideo needs MoviePy: pip install moviepy"}


def test_monitor_without_videos(tmp_path: Path) -> None:
    text = f"import gym\nenv = gym.wrappers.Monitor(gym.make('CartPole-v1'), {str(tmp_path)!r}, video_callable=False, force=True)"
    names = run(text + PLAY.replace(" if hasattr(env, 'rewards_of_monitor') else None", ""))
    assert names["rewards"] == names["lengths"]
    assert names["info"]["episode"]["l"] == names["lengths"][-1]
    assert list(tmp_path.iterdir()) == []
    assert "the statistics are in info" in marks(text)[0]


def test_the_end_of_monitor_in_2016(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (
        f"import gym\nenv = gym.make('CartPole-v1', max_episode_steps=5)\nenv.monitor.start({str(tmp_path)!r})" + PLAY
    )
    with moviepy():
        run(
            text.replace("rewards = ", "# ").replace(
                "env.close()", f"env.monitor.close()\ngym.upload({str(tmp_path)!r}, api_key='k')"
            )
        )
    assert f"The results are in {tmp_path}" in capsys.readouterr().out
    assert "rl-video-episode-0.mp4" in videos(tmp_path)


def test_wrappers_with_other_names() -> None:
    names = run("""\
import gym
import numpy as np
from gym.wrappers import FrameStack, GrayScaleObservation as Gray, ResizeObservation, TransformObservation
from gym.wrappers.atari_preprocessing import AtariPreprocessing
env = gym.make("BreakoutNoFrameskip-v4", obs_type="image")
small = FrameStack(Gray(ResizeObservation(env, 42)), num_stack=3)
shape = small.reset().shape
old = gym.wrappers.FrameStack(AtariPreprocessing(gym.make("PongNoFrameskip-v4"), noop_max=2), 4, lz4_compress=True)
other = old.reset().shape
half = TransformObservation(gym.make("CartPole-v1"), lambda o: o / 2)
state = half.reset()
limited = gym.wrappers.TimeLimit(gym.make("CartPole-v1"), max_episode_steps=2)
""")
    assert names["shape"] == (3, 42, 42)
    assert names["other"] == (4, 84, 84)
    assert np.abs(names["state"]).max() <= 0.025


def test_dead_environments_are_marked() -> None:
    assert "Roboschool is no longer maintained" in marks("import gym\nenv = gym.make('RoboschoolAnt-v1')\n")[0]
