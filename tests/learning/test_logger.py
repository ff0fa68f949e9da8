"""A logger of the user's: each row, an end, errors that are warnings, a resume, and trust."""

import json
import warnings
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")

import small_trainings
from small_trainings import SMALL, make_options, user_without_trust

from atari.cli import main
from atari.learning import RunFolder, load_policy
from atari.learning.agents import AGENTS
from atari.learning.programs import trusted_file
from atari.learning.training import Training

SOURCE = """
import json

class Logger:
    def __init__(self, run):
        self.file = (run.path.parent / "seen.jsonl").open("a")
        self.write({"began": run.config["agent"], "game": run.task.game})

    def write(self, row):
        print(json.dumps(row), file=self.file)

    def __call__(self, row):
        self.write(row)

    def close(self):
        self.write({"ended": True})
        self.file.close()
"""


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user who has not yet trusted any program, in the folder of `my_logger.py`."""
    user_without_trust(tmp_path, monkeypatch)
    Path("my_logger.py").write_text(SOURCE)
    return tmp_path


def train(agent: str, logger: Any, path: str = "run", **given: Any) -> RunFolder:
    return small_trainings.train(agent, make_options(agent, logger=logger, **given), path)


def seen() -> list[dict[str, Any]]:
    return [json.loads(line) for line in Path("seen.jsonl").read_text().splitlines()]


@pytest.mark.parametrize("word", ["my_logger.py:Logger", "my_logger:Logger"])
@pytest.mark.parametrize("agent", AGENTS)
def test_it_gets_each_row(agent: str, word: str) -> None:
    own = [f"--{name.replace('_', '-')}={value}" for name, value in SMALL[agent].items()]
    steps = {"dqn": 2000}.get(agent, 256)
    words = ["train", agent, "pong", "--fast", *own, "--total-steps", str(steps), "--logger", word, "-o", "run"]
    assert main([*words, "--games", "0"]) == 0
    began, *rows, ended = seen()
    assert (began, ended) == ({"began": agent, "game": "pong"}, {"ended": True})
    run = RunFolder.open("run")
    names = ("step", "frames", "loss")
    assert [[row[name] for name in names] for row in rows] == [[row[name] for name in names] for row in run.rows()]
    assert rows[-1]["step"] == steps
    assert rows[-1]["frames"] == 4 * steps
    assert run.config["options"]["logger"] == "logger.py:Logger"


def test_a_resumed_training_goes_on_with_the_copy() -> None:
    run = train("ppo", logger_of("my_logger.py"), total_steps=128)
    Path("my_logger.py").unlink()
    assert main(["train", "--resume", "run", "--total-steps", "256", "--games", "0"]) == 0
    assert (
        [row["step"] for row in seen() if "step" in row] == [row["step"] for row in run.rows()] == [64, 128, 192, 256]
    )
    assert [row for row in seen() if "ended" in row] == [{"ended": True}] * 2


def logger_of(file: str) -> Any:
    from atari.learning.options import TrainingOptions, option_from_text

    return option_from_text(TrainingOptions, "logger", f"{file}:Logger")


class Failing:
    """A service that cannot be reached."""

    calls = 0

    def __init__(self, run: RunFolder) -> None: ...

    def __call__(self, row: Any) -> None:
        type(self).calls += 1
        raise ConnectionError("no route to host")

    def close(self) -> None:
        raise ConnectionError("no route to host at the end")


def test_its_errors_are_one_warning() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = train("ppo", Failing, total_steps=192)
    text = "logger Failing failed at step 64, and the training goes on: ConnectionError: no route to host; its later"
    assert [str(one.message).startswith(text) for one in caught if one.category is RuntimeWarning] == [True]
    assert Failing.calls == len(run.rows()) == 3
    assert run.config["ended"] == "steps"


def make_function(run: RunFolder) -> Any:
    return lambda row: run.path.with_name("rows").write_text(f"{row['step']}")


def test_a_function_makes_a_function() -> None:
    train("ppo", make_function, total_steps=128)
    assert Path("rows").read_text() == "128"


def broken(run: RunFolder) -> Any:
    raise ConnectionError("no key")


def none(run: RunFolder) -> Any:
    return None


def test_one_that_cannot_begin_is_an_error() -> None:
    with pytest.raises(RuntimeError, match="logger broken cannot be made: ConnectionError: no key"):
        train("ppo", broken, "one")
    with pytest.raises(TypeError, match=r"logger none must make an object that is called with each row, .* got None"):
        train("ppo", none, "two")
    assert RunFolder.open("one").rows() == []


def test_a_strangers_logger_is_not_executed() -> None:
    Path("my_logger.py").write_text(f"from pathlib import Path\nPath('executed').touch()\n{SOURCE}")
    run = train("ppo", logger_of("my_logger.py"), total_steps=64)
    Path("executed").unlink()
    trusted_file().unlink()
    import sys

    for name in [name for name in sys.modules if name.startswith("atari_program_")]:
        del sys.modules[name]  # as in another process
    with pytest.raises(PermissionError, match=r"logger.py is a program \(.*my_logger.py:Logger\)"):
        Training.resume(run.path)
    assert load_policy(run.path).name == "ppo (run)"  # a policy does without it
    assert not Path("executed").exists()
    config = json.loads((run.path / "config.json").read_text())
    del config["programs"]  # a run that names code which its folder does not have
    (run.path / "config.json").write_text(json.dumps(config))
    with pytest.raises(ValueError, match=r"config.json is damaged: logger must be a class or a function"):
        Training.resume(run.path)
