"""Agents of one's own: a copied script trains with its own class, and its run is loaded from the kept copy."""

import ast
import inspect
import io
import re
import subprocess
import sys
from contextlib import closing, nullcontext
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

torch = pytest.importorskip("torch")

from cli_tools import Capture, Patch  # noqa: E402
from small_trainings import SMALL as SMALL_OPTIONS  # noqa: E402
from small_trainings import make_options  # noqa: E402

import atari.learning.agents.ppo  # noqa: E402
from atari.cli import main  # noqa: E402
from atari.learning import RunFolder, load_policy  # noqa: E402
from atari.learning.agent import agent_code, kept_agent  # noqa: E402
from atari.learning.agents import AGENTS, find_agent  # noqa: E402
from atari.learning.programs import trusted_file  # noqa: E402
from atari.learning.training import Training  # noqa: E402

SMALL = "--fast --num-envs 4 --horizon 16 --minibatch 32 --total-steps 128".split()
SOURCE = Path(str(atari.learning.agents.ppo.__file__)).read_text()
CHANGED = SOURCE.replace(
    "    def update(self) -> dict[str, float]:",
    "    def update(self) -> dict[str, float]:\n        self.own = 'own'",
    1,
).replace('"entropy": entropy,', '"entropy": entropy,\n            "own": float(len(self.own)),', 1)
"""PPO with a column of its own in the log."""


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: Patch) -> Path:
    """A user who has not yet trusted any program."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setattr("atari.learning.programs.user_data_path", lambda *_, **__: tmp_path / "data" / "atari-envs")
    return tmp_path


@pytest.fixture
def script(tmp_path: Path) -> Path:
    file = tmp_path / "my_ppo.py"
    file.write_text(CHANGED)
    return file


def run_as_main(script: Path, patch: Patch) -> None:
    """Run a script as `python script.py`."""
    module = ModuleType("__main__")
    module.__file__ = str(script)
    patch.setitem(sys.modules, "__main__", module)
    exec(compile(script.read_text(), str(script), "exec"), vars(module))


def trained(script: Path, folder: Path) -> Path:
    own = {"num_envs": 4, "horizon": 16, "minibatch": 32, "total_steps": 128}
    kind = agent_code(script).kind
    finish(script, kind.options_class.of("pong", **{**kind.fast, **own}), folder)
    return folder


def finish(agent: Any, options: Any, folder: Path) -> None:
    with closing(Training.begin(agent, options, folder)) as training:
        training.run()


@pytest.mark.parametrize("name", AGENTS)
def test_a_script_imports_ten_names_of_one_page_at_most(name: str) -> None:
    page = (Path(__file__).parents[2] / "docs/runs.md").read_text(encoding="utf-8")
    table = page.partition("## The names that an agent imports")[2].partition("\n## ")[0]
    documented = set(re.findall(r"^\| `(\w+)`", table, re.MULTILINE))
    assert len(documented) <= 10
    tree = ast.parse(Path(inspect.getfile(find_agent(name))).read_text(encoding="utf-8"))
    found = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and "atari" in str(node.module)]
    assert [node.module for node in found] == ["atari.learning"]
    assert {alias.name for alias in found[0].names} <= documented
    modules = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert modules <= {"numpy", "torch", "torch.nn.functional"}


def test_the_script_runs_its_own_class(script: Path, tmp_path: Path) -> None:
    command = [sys.executable, str(script), "pong", *SMALL, "-o", str(tmp_path / "mine")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr
    run = RunFolder.open(tmp_path / "mine")
    assert [row["own"] for row in run.rows()] == [3.0, 3.0]
    assert (run.config["agent"], run.config["programs"]["agent"]["file"]) == ("my_ppo", str(script))
    assert run.read_program("agent") == script.read_bytes()
    script.unlink()  # the run has its copy
    assert main(["train", "--resume", str(run.path), "--total-steps", "256", "--games", "0"]) == 0
    assert [row["own"] for row in run.rows()] == [3.0] * 4


def test_the_command_trains_the_file(script: Path, tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["train", "--fast", *SMALL[1:], "my_ppo.py", "pong", "--games", "0"]) == 0
    assert "runs/pong-my_ppo-pixels-seed0" in capsys.readouterr().out
    run = RunFolder.open("runs/pong-my_ppo-pixels-seed0")
    assert run.rows()[0]["own"] == 3.0
    assert kept_agent(run).kind.__name__ == "PPO"
    assert main(["evaluate", str(run.path), "--protocol", "dqn2015", "--episodes", "1"]) == 0
    assert "my_ppo" in capsys.readouterr().out


def test_a_strangers_program_is_not_executed(script: Path, tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    run = trained(script, tmp_path / "mine")
    trusted_file().unlink()
    for call in (load_policy, Training.resume):
        with pytest.raises(PermissionError, match=r"agent.py is a program .*my_ppo.py:PPO.*trust\(\)"):
            call(run)
    assert main(["evaluate", str(run), "--episodes", "1"]) == 1
    assert "if you trust its author" in capsys.readouterr().err
    RunFolder.open(run).trust()
    assert load_policy(run).name == "my_ppo (mine)"


@pytest.mark.parametrize(("answer", "is_trusted"), [("y\n", True), ("\n", False), ("no\n", False)])
def test_a_terminal_asks(answer: str, is_trusted: bool, script: Path, tmp_path: Path) -> None:
    run = trained(script, tmp_path / "mine")
    trusted_file().unlink()

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

        def readline(self, *_: int) -> str:
            return answer

    with Patch.context() as patch:
        patch.setattr("sys.stdin", terminal := Terminal())
        patch.setattr("sys.stderr", terminal)
        with nullcontext() if is_trusted else pytest.raises(PermissionError):
            load_policy(run)
    assert f"{run / 'agent.py'} is a program of this run ({script}:PPO)" in terminal.getvalue()
    assert trusted_file().exists() == is_trusted


def test_a_changed_copy_is_refused(script: Path, tmp_path: Path) -> None:
    run = trained(script, tmp_path / "mine")
    (run / "agent.py").write_text(CHANGED + "\n")
    with pytest.raises(ValueError, match=r"agent.py is not the program of the training"):
        load_policy(run)
    (run / "agent.py").unlink()
    with pytest.raises(FileNotFoundError, match=r"there is no file .*agent.py"):
        load_policy(run)


@pytest.mark.parametrize("guard", ["", "if __name__ == '__main__': "])
def test_a_script_that_trains_when_it_is_loaded_is_refused(guard: str, tmp_path: Path, monkeypatch: Patch) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "from atari.learning.agent import agent_code\nfrom atari.learning.agents.ppo import PPO\n"
        f"class Mine(PPO): pass\n{guard}agent_code(Mine)\n"
    )
    text = "a run loads Mine from a copy of .*`if __name__ == '__main__':`"
    with nullcontext() if guard else pytest.raises(ValueError, match=text):
        run_as_main(script, monkeypatch)


def test_a_class_is_taken(tmp_path: Path) -> None:
    from atari.learning.agents.ppo import PPO

    training = Training.begin(PPO, make_options("ppo", total_steps=64), tmp_path / "ppo")
    assert training.folder.config["agent"] == "ppo"
    assert "programs" not in training.folder.config
    training.close()

    class Inside(PPO):
        pass

    with pytest.raises(ValueError, match=r"Inside stands inside of something else"):
        agent_code(Inside)
    with pytest.raises(TypeError, match=r"derived from atari.learning.Agent with all its methods, got int"):
        agent_code(int)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"PPO takes options of PPOOptions, got PQNOptions"):
        Training.begin(PPO, make_options("pqn"), tmp_path / "no")
    without_file: dict[str, Any] = {"__name__": "nowhere"}
    exec("from atari.learning.agents.ppo import PPO\nclass Mine(PPO): pass", without_file)
    with pytest.raises(ValueError, match=r"Mine stands in no file"):
        agent_code(without_file["Mine"])


NO_AGENT = "import atari\n"
ABSTRACT = "from atari.learning.agent import Agent\nclass Mine(Agent):\n    def update(self): ...\n"
TWO = "from atari.learning.agents.ppo import PPO\nclass One(PPO): ...\nclass Two(PPO): ...\n"


@pytest.mark.parametrize(
    ("text", "agent", "expected"),
    [
        ("def broken(:\n", "x.py", r"x.py cannot be loaded: SyntaxError: .*line 1"),
        ("1 / 0\n", "x.py", r"x.py cannot be loaded: ZeroDivisionError"),
        ("raise SystemExit('end')\n", "x.py", r"x.py cannot be loaded: SystemExit: end"),
        ("from atari.learning.agents.ppo import Nothing\n", "x.py", r"may be for another release of atari-envs: Imp"),
        ("import no_such_package\n", "x.py", r"x.py cannot be loaded: ModuleNotFoundError"),
        (NO_AGENT, "x.py", r"x.py has no agent: no class derived from atari.learning.Agent"),
        (ABSTRACT, "x.py", r"Mine in .*x.py lacks .*make_network.*; it may be for another release"),
        (TWO, "x.py", r"x.py has several agents; name one of them, as in .*x.py:One"),
        (TWO, "x.py:Three", r"x.py has no agent Three"),
        (b"\xff\xfe\x00", "x.py", r"x.py cannot be loaded: "),
    ],
)
def test_files_without_an_agent(text: str | bytes, agent: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "x.py").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ValueError, match=expected):
        agent_code(str(tmp_path / agent))
    if text == TWO:
        assert agent_code(f"{tmp_path / 'x.py'}:Two").kind.__name__ == "Two"


def test_a_run_stopped_before_its_configuration_begins_again(script: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "agent.py").write_text(CHANGED)
    trained(script, tmp_path / "mine")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "agent.py").write_text("another program")
    with pytest.raises(FileExistsError):
        trained(script, tmp_path / "other")


def test_a_loop_of_ones_own_keeps_its_program(tmp_path: Path) -> None:
    with RunFolder.begin(tmp_path / "own", "mine", atari.Task.of("pong"), {}, programs={"loop": __file__}) as run:
        assert run.read_program("loop") == run.program("loop").read_bytes() == Path(__file__).read_bytes()
        with pytest.raises(FileNotFoundError, match="keeps no program 'agent', but loop"):
            run.read_program("agent")
    with pytest.raises(ValueError, match=r"one of ppo, pqn, dqn, got 'mine' in .*; a policy of a loop of your own"):
        kept_agent(RunFolder.open(tmp_path / "own"))
    with pytest.raises(FileNotFoundError, match=r"there is no file nowhere.py"):
        RunFolder.begin(tmp_path / "no", "mine", atari.Task.of("pong"), {}, programs={"loop": "nowhere.py"})
    assert not (tmp_path / "no").exists()


class TestExtend:
    @pytest.mark.parametrize("agent", ["ppo", "dqn"])
    def test_a_complete_training_has_more_steps(self, agent: str, tmp_path: Path) -> None:
        first, last = (800, 1600) if agent == "dqn" else (128, 256)
        for name, steps in (("whole", last), ("extended", first)):
            keep = {"keep_memory": True, "memory": 2000} if agent == "dqn" else {}
            finish(agent, make_options(agent, total_steps=steps, **keep), tmp_path / name)
        with RunFolder.open(tmp_path / "extended", lock=True) as run:
            with pytest.raises(ValueError, match=rf"has made [\d,]+ steps, so total_steps must be above, got {first}"):
                run.extend(first)
            run.extend(last)
        with closing(Training.resume(tmp_path / "extended")) as training:
            assert training.run() == "steps"
        runs = [RunFolder.open(tmp_path / name) for name in ("whole", "extended")]
        assert [row["step"] for row in runs[0].rows()] == [row["step"] for row in runs[1].rows()]
        one, other = (run.load_weights() for run in runs)
        if agent == "ppo":  # DQN's epsilon and memory follow the number of steps
            assert all(torch.equal(one[name], other[name]) for name in one)


NET = """
import torch

class Net(torch.nn.Module):
    def __init__(self, space):
        super().__init__()
        self.layer = torch.nn.Linear(space.shape[0] * space.shape[1] * space.shape[2], 8)

    def forward(self, observations):
        return torch.relu(self.layer(observations.flatten(1)))
"""


class TestNetwork:
    @pytest.mark.parametrize("agent", AGENTS)
    def test_one_of_ones_own_is_trained_and_loaded_from_its_copy(
        self, agent: str, home: Path, monkeypatch: Any, capsys: Any
    ) -> None:
        monkeypatch.chdir(home)
        Path("my_net.py").write_text(NET)
        options = {**SMALL_OPTIONS[agent], **({"keep_memory": "true", "learning_starts": 64} if agent == "dqn" else {})}
        small = [f"--{name.replace('_', '-')}={value}" for name, value in options.items()]
        words = [agent, "pong", "--fast", *small, "--total-steps", "128", "--network", "my_net.py:Net", "-o", "run"]
        assert main(["train", *words, "--games", "0"]) == 0
        Path("my_net.py").unlink()
        run = RunFolder.open("run")
        assert run.config["options"]["network"] == "network.py:Net"
        assert run.load_weights()["encoder.layers.layer.weight"].shape[0] == 8
        assert main(["train", "--resume", "run", "--total-steps", "1024", "--games", "0"]) == 0
        trusted_file().unlink()
        capsys.readouterr()
        assert main(["evaluate", "run", "--episodes", "1"]) == 1
        assert "network.py is a program" in capsys.readouterr().err

    @pytest.mark.parametrize(
        ("network", "text"),
        [
            ("my_net.py", "name the class or function in my_net.py, as in my_net.py:Net"),
            ("my_net.py:Nett", "my_net.py has no class or function Nett"),
            ("no_net.py:Net", "there is no file no_net.py"),
            ("my_nte", "network must be one of nature, small, mlp, bits"),
            ("my_net.py:torch", "my_net.py has no class or function torch"),
        ],
    )
    def test_mistakes(self, network: str, text: str, home: Path, monkeypatch: Any, capsys: Any) -> None:
        monkeypatch.chdir(home)
        Path("my_net.py").write_text(NET)
        assert main(["train", "ppo", "pong", "--network", network, "-o", "run"]) in (1, 2)
        assert text in capsys.readouterr().err
        assert not Path("run").exists()
