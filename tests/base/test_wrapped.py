"""Pictures of wrapped environments, as IPython takes them."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import pytest
from env_tools import needs_gymnasium_1

import atari
import atari.classic
from atari.base.wrapped import page_of, show_wrapped
from atari.integrations.envpool import make_gymnasium
from atari.recording import RecordReplay

formatters: Any = pytest.importorskip("IPython.core.formatters")


def one(**options: Any) -> gymnasium.Env[Any, Any]:
    return atari.make("pong", **options)


def sync(**options: Any) -> Any:
    return gymnasium.vector.SyncVectorEnv([one, one], **options)


ENVIRONMENTS: dict[str, tuple[Callable[[], Any], int]] = {
    "make": (one, 1),
    "preset": (lambda: one(preset="dqn2015"), 1),
    "gymnasium.make": (lambda: gymnasium.make("ALE/Pong-v5"), 1),
    "wrapper": (lambda: gymnasium.wrappers.TimeLimit(one(), 10), 1),
    "make_vec": (lambda: gymnasium.make_vec("ALE/Pong-v5", num_envs=2), 1),
    "vector wrapper": (
        lambda: gymnasium.wrappers.vector.RecordEpisodeStatistics(atari.AtariVectorEnv("pong", 2)),
        1,
    ),
    "sync": (sync, 2),
    "async": (lambda: gymnasium.vector.AsyncVectorEnv([one, one]), 2),
    "envpool": (lambda: make_gymnasium("Pong-v5", num_envs=2), 1),
    "classic": (lambda: atari.classic.make("Pong-v0"), 1),
}
"""The environments, and the number of their pictures."""


@pytest.fixture
def html(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], Any]:
    """The HTML of an object in IPython."""
    formatter = formatters.DisplayFormatter()
    monkeypatch.setattr("IPython.get_ipython", lambda: SimpleNamespace(display_formatter=formatter))
    show_wrapped()
    return formatter.formatters["text/html"]


@needs_gymnasium_1
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_environments_in_wrappers_have_pictures(name: str, html: Callable[[Any], Any]) -> None:
    make, count = ENVIRONMENTS[name]
    env = make()
    env.reset()
    assert len(re.findall("<img[^>]*data:image/png", html(env))) == count
    env.close()
    assert html(env) is None


def test_a_replay_that_is_recorded_shows_its_environment(html: Callable[[Any], Any], tmp_path: Path) -> None:
    with RecordReplay(one(), tmp_path / "game.a26r") as env:
        env.reset(seed=0)
        assert html(env) == env.unwrapped._repr_html_()


def test_players(html: Callable[[Any], Any]) -> None:
    pytest.importorskip("pettingzoo")
    from atari.multiplayer import env, parallel_env

    for made in (env("pong"), parallel_env("pong")):
        made.reset(seed=0)
        assert "Pong: frame 3, first_0, second_0" in html(made)


@needs_gymnasium_1
def test_other_environments_stay(html: Callable[[Any], Any]) -> None:
    assert html(gymnasium.make("CartPole-v1")) is None
    assert html(gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode="sync")) is None
    assert html(atari.classic.make("CartPole-v0")) is None


def test_a_wrapper_may_have_a_picture_of_its_own(html: Callable[[Any], Any]) -> None:
    class Own(gymnasium.Wrapper[Any, Any, Any, Any]):
        def _repr_html_(self) -> str:
            return "<b>own</b>"

    assert html(Own(one())) == "<b>own</b>"


def test_many_single_environments() -> None:
    envs = gymnasium.vector.SyncVectorEnv([one] * 38)
    envs.reset(seed=0)
    page = str(page_of(envs))
    assert "38 environments, the first 36" in page
    assert page.count("<img") == 36


@needs_gymnasium_1
def test_no_page_while_other_processes_play() -> None:
    envs = gymnasium.vector.AsyncVectorEnv([one, one])
    envs.reset(seed=0)
    envs.step_async([0, 0])
    assert page_of(envs) is None
    envs.step_wait()
    assert page_of(envs)
    envs.close()


def test_the_package_registers_itself_in_ipython_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    program = "import sys, atari; sys.exit('IPython' in sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)
    cell = "import atari\natari.make('pong')"
    program = (
        "from IPython.core.interactiveshell import InteractiveShell as S; shell = S.instance()\n"
        f"print('<img' in shell.display_formatter.formatters['text/html'](shell.run_cell({cell!r}).result))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "True"
