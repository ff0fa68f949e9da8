"""Intrinsic rewards: what the learner gets, what the score stays, an exact resume, trust, and errors."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from small_trainings import make_options, train, user_without_trust  # noqa: E402

from atari.cli import main  # noqa: E402
from atari.learning import RunFolder, TrainingEnvironments, load_policy  # noqa: E402
from atari.learning.agents import AGENTS  # noqa: E402
from atari.learning.programs import trusted_file  # noqa: E402
from atari.learning.training import Training  # noqa: E402

SOURCE = """
import torch

class Bonus:
    '''A linear layer that learns to predict the mean brightness: a reward that depends on all steps before.'''

    def __init__(self, envs, seed):
        torch.manual_seed(seed)
        self.layer = torch.nn.Linear(1, 1)
        self.optimizer = torch.optim.Adam(self.layer.parameters(), 0.01)
        self.steps = 0

    def __call__(self, observations, actions, info):
        self.steps += 1
        seen = torch.from_numpy(observations).float().flatten(1).mean(1, keepdim=True) / 255
        errors = (self.layer(torch.from_numpy(actions).float()[:, None]) - seen).square()[:, 0]
        self.optimizer.zero_grad()
        errors.mean().backward()
        self.optimizer.step()
        return errors

    def columns(self):
        return {"calls": self.steps}

    def state(self):
        return self.layer.state_dict(), self.optimizer.state_dict(), self.steps

    def restore(self, state):
        self.layer.load_state_dict(state[0])
        self.optimizer.load_state_dict(state[1])
        self.steps = state[2]
"""


class Constant:
    """Pays the number of the environment."""

    def __init__(self, envs: Any, seed: int) -> None:
        self.given, self.infos = (envs.num_envs, seed), list[Any]()

    def __call__(self, observations: Any, actions: Any, info: Any) -> Any:
        self.infos.append((observations.shape, actions.copy(), info["lives"].shape))
        return np.arange(len(actions)) / 2

    def state(self) -> None: ...

    def restore(self, state: None) -> None: ...


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user who has not yet trusted any program, in the folder of `my_bonus.py`."""
    user_without_trust(tmp_path, monkeypatch)
    Path("my_bonus.py").write_text(SOURCE)
    return tmp_path


def options(agent: str, program: str = "my_bonus.py:Bonus", **given: Any) -> Any:
    from atari.learning.options import TrainingOptions, option_from_text

    return make_options(agent, intrinsic_reward=option_from_text(TrainingOptions, "intrinsic_reward", program), **given)


def test_the_learner_gets_it_and_the_score_is_without_it() -> None:
    played = []
    for made in (None, Constant):
        environments = TrainingEnvironments(make_options("ppo", seed=5, intrinsic_reward=made), 3)
        environments.reset(seed=0)
        results = [environments.step(np.full(3, 2)) for _ in range(300)]
        played.append((np.array([one[1] for one in results]), environments.take_games()))
        if made is not None:
            program: Any = environments.intrinsic
            assert program._program.given == (3, 5)
            (shape, actions, lives) = program._program.infos[-1]
            assert (shape, actions.tolist(), lives) == ((3, *environments.shape), [2, 2, 2], (3,))
            assert program.take_columns() == {"intrinsic_reward": 0.5}
            assert np.isnan(program.take_columns()["intrinsic_reward"])
        else:
            assert environments.intrinsic is None
        environments.close()
    (plain, games), (paid, same_games) = played
    assert (paid.dtype, plain.dtype) == (np.float64, np.int32)
    np.testing.assert_array_equal(paid, plain + np.array([0, 0.5, 1]))
    assert plain.any()
    assert games == same_games


@pytest.mark.parametrize(
    ("agent", "own"),
    [*((agent, {"workers": workers}) for agent in AGENTS for workers in (1, 2)), ("ppo", {"restart_share": 0.5})],
)
def test_a_resumed_training_is_equal_to_the_bit(agent: str, own: dict[str, Any]) -> None:
    steps = {"dqn": 1600}.get(agent, 256)
    given = {"total_steps": steps, "checkpoint_minutes": 0.0, **own}
    whole = train(agent, options(agent, **given), "whole")
    with closing(Training.begin(agent, options(agent, **given), Path("stopped"))) as training:
        training.run(stop=AfterUpdates(1))
        assert training.agent.steps < steps
    Path("my_bonus.py").unlink()  # the run has its copy
    with closing(Training.resume(Path("stopped"))) as training:
        assert training.run() == "steps"
    resumed = RunFolder.open("stopped")
    one, other = whole.load_weights(), resumed.load_weights()
    assert all(torch.equal(one[name], other[name]) for name in one)
    columns = ("step", "intrinsic_reward", "calls", "loss")
    rows = [[[row[name] for name in columns] for row in run.rows()] for run in (whole, resumed)]
    assert rows[0] == rows[1]
    assert np.isfinite(rows[0]).all()
    assert len(rows[0]) > 1


class AfterUpdates:
    """An event that is set after some updates."""

    def __init__(self, count: int) -> None:
        self._left = count

    def is_set(self) -> bool:
        self._left -= 1
        return self._left < 0


def test_it_changes_what_is_learned() -> None:
    runs = [
        train("ppo", make_options("ppo", total_steps=128, intrinsic_reward=made), name)
        for made, name in ((None, "plain"), (Constant, "paid"))
    ]
    assert "intrinsic_reward" not in runs[0].rows()[0]
    assert [row["intrinsic_reward"] for row in runs[1].rows()] == pytest.approx(
        [0.25, 0.25]
    )  # two workers with two each
    one, other = (run.load_weights() for run in runs)
    assert not all(torch.equal(one[name], other[name]) for name in one)


def test_the_command_keeps_the_program(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["train", "pqn", "pong", "--fast", "--num-envs", "4", "--horizon", "16", "--minibatch", "32"]
    words += ["--total-steps", "64", "--intrinsic-reward", "my_bonus:Bonus", "-o", "run", "--games", "0"]
    assert main(words) == 0
    run = RunFolder.open("run")
    assert run.config["options"]["intrinsic_reward"] == "intrinsic_reward.py:Bonus"
    assert run.read_program("intrinsic_reward") == SOURCE.encode()
    assert run.rows()[0]["calls"] == 16


def test_a_strangers_program_is_not_executed(home: Path) -> None:
    Path("my_bonus.py").write_text(SOURCE + "\nfrom pathlib import Path\nPath('executed').touch()\n")
    run = train("ppo", options("ppo", total_steps=64))
    Path("executed").unlink()
    trusted_file().unlink()
    forget_modules()
    with pytest.raises(PermissionError, match=r"intrinsic_reward.py is a program \(.*my_bonus.py:Bonus\)"):
        Training.resume(run.path)
    assert main(["train", "--resume", "run", "--total-steps", "128"]) == 1
    assert load_policy(run.path).name == "ppo (run)"  # a policy does without it
    assert main(["evaluate", "run", "--protocol", "dqn2015", "--episodes", "1"]) == 0
    assert not Path("executed").exists()
    run.trust()
    Training.resume(run.path).close()
    assert Path("executed").exists()


def forget_modules() -> None:
    """Let programs be executed anew, as in another process."""
    import sys

    for name in [name for name in sys.modules if name.startswith("atari_program_")]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("returned", "text"),
    [
        ("0.5", r"intrinsic_reward Wrong must return finite numbers \(2,\), got float64 array\(0.5\)"),
        ("[1, 2, 3]", r"\(2,\), got int64 array\(\[1, 2, 3\]\)"),
        ("[1.0, float('nan')]", r"finite numbers \(2,\), got float64 .*nan"),
        ("['a', 'b']", r"finite numbers \(2,\), got <U1"),
        ("None", r"finite numbers \(2,\), got object array\(None"),
    ],
)
def test_what_it_must_return(returned: str, text: str) -> None:
    class Wrong(Constant):
        def __call__(self, *_: Any) -> Any:
            return eval(returned)

    environments = TrainingEnvironments(make_options("ppo", intrinsic_reward=Wrong), 2)
    environments.reset(seed=0)
    with pytest.raises(ValueError, match=text):
        environments.step(np.zeros(2, np.int64))
    environments.close()


@pytest.mark.parametrize(
    ("word", "text"),
    [
        ("my_bonus.py", "name the class or function in my_bonus.py"),
        ("my_bonus.py:Bonu", "my_bonus.py has no class or function Bonu"),
        ("no_bonus.py:Bonus", "there is no file no_bonus.py"),
        ("no_bonus:Bonus", "there is no module no_bonus in a Python file"),
        ("no.bonus:Bonus", "the module of no.bonus:Bonus cannot be found"),
        ("sys:exit", "there is no module sys in a Python file"),
        ("rnd", "intrinsic_reward must be FILE.py:NAME, MODULE:NAME or none, got 'rnd'"),
        ("my_bonus.py:torch", "my_bonus.py has no class or function torch"),
    ],
)
def test_mistakes(word: str, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", "ppo", "pong", "--intrinsic-reward", word, "-o", "run"]) in (1, 2)
    assert text in capsys.readouterr().err
    assert not Path("run").exists()


def test_what_is_no_intrinsic_reward() -> None:
    with pytest.raises(TypeError, match=r"intrinsic_reward must be a class or a function, .* got 'my_bonus.py:Bonus'"):
        make_options("ppo", intrinsic_reward="my_bonus.py:Bonus")
    stateless: Callable[..., Any] = make_stateless
    with pytest.raises(TypeError, match=r"intrinsic_reward make_stateless must make an object that is called with"):
        Training.begin("ppo", make_options("ppo", intrinsic_reward=stateless), Path("run"))
    assert not Path("run").exists()


@pytest.mark.parametrize(
    ("source", "error", "text"),
    [
        (
            "lambda envs: 0",
            TypeError,
            "intrinsic_reward <lambda> is called with the vector environment and a seed: .*2 were",
        ),
        ("FailingReward", RuntimeError, "intrinsic_reward FailingReward failed in a step: KeyError: 'labels'"),
    ],
)
def test_its_errors_name_it(source: str, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        TrainingEnvironments(make_options("ppo", intrinsic_reward=eval(source)), 2).step(np.zeros(2, np.int64))


def make_stateless(envs: Any, seed: int) -> Any:
    return lambda observations, actions, info: np.zeros(len(actions))


def test_columns_have_names_of_their_own() -> None:
    with pytest.raises(ValueError, match=r"columns\(\) of the intrinsic reward has 'loss', a column of the log"):
        train("ppo", make_options("ppo", intrinsic_reward=WithLoss))


class FailingReward(Constant):
    """Reads what is not there."""

    def __init__(self, envs: Any, seed: int) -> None:
        envs.reset(seed=0)

    def __call__(self, observations: Any, actions: Any, info: Any) -> Any:
        return info["labels"]


class WithLoss(Constant):
    """Has a column of the agent."""

    def columns(self) -> dict[str, float]:
        return {"loss": 1.0}
