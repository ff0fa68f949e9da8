import doctest
import importlib

import gymnasium
import pytest

# Public functions without an example: they need a display, a notebook, the network or a package that few have.
WITHOUT_EXAMPLE = {
    "atari.classic.logger.undo_logger_setup",  # does nothing
    "atari.classic.scoreboard.upload",  # likewise
    "atari.classic.utils.reraise.reraise",  # raises always
    "atari.integrations.arrays.to_jax",
    "atari.learning.command.main",  # reads the command line of a script
    "atari.integrations.ray.rllib.env_creator",
    "atari.lab.widget.show",
    "atari.play.loop.play",
    "atari.roms.autorom.install",
}


@pytest.fixture
def documented(definitions):
    return [found for module, found in definitions if found.page == module]


def test_every_public_class_and_function_has_an_example(documented):
    found = [found for found in documented if found.kind in ("class", "function")]
    assert {each.path for each in found if ">>>" not in each.docstring} == WITHOUT_EXAMPLE


def run(found):
    """What doctest prints of an example; "" if it passes, or needs an extra or a newer ale-py than is installed."""
    lines: list[str] = []
    try:
        importlib.import_module(found.path.rpartition(".")[0])
    except gymnasium.error.DependencyNotInstalled:
        return ""
    except ModuleNotFoundError as error:
        if str(error.name).startswith("atari"):
            raise
        return ""
    example = doctest.DocTestParser().get_doctest(found.docstring, {}, found.path, found.path, 0)
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(example, out=lines.append)
    printed = "".join(lines)
    lacking = ("gymnasium.error.DependencyNotInstalled", "No module named 'gymnasium.")  # the latter in old releases
    return "" if any(error in printed for error in lacking) else printed


def test_examples_run(documented, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setattr("atari.integrations.envpool.spec._REGISTERED", {})  # an example adds a task
    failed = []
    for found in documented:
        if ">>>" in found.docstring:
            (tmp_path / found.path).mkdir()
            monkeypatch.chdir(tmp_path / found.path)
            failed.append(run(found))
    assert "".join(failed) == ""
