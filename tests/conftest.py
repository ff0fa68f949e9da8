"""The fixtures and settings of all tests."""

import gc
import os
import signal
import traceback
from collections.abc import Iterator
from pathlib import Path

import ale_pool
import ale_py
import gymnasium
import pytest

from atari.cores.ale import OLDEST_ALE_PY, _numbers

OLD = _numbers(gymnasium.__version__) < _numbers("1.4.0") or _numbers(ale_py.__version__) < _numbers(OLDEST_ALE_PY)

pytest.register_assert_rewrite("core_contract", "core_tools", "env_tools", "snapshot_contract", "cli_tools")

ale_pool.use_pool()

# A process that a shell has put into the background ignores Ctrl-C, and so do the programs that it runs.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


# CI runs the tests in two parts; the second has packages that the first lacks. Each process reads these variables.
NOTE_PASSED = os.environ.get("NOTE_PASSED")
"""A file for the names of the tests that pass."""
LEAVE_OUT = os.environ.get("LEAVE_OUT")
"""A file with the names of tests that are left out. A test that needs the packages was skipped, and has no name here."""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out the tests that `LEAVE_OUT` names."""
    if LEAVE_OUT:
        passed = set(Path(LEAVE_OUT).read_text(encoding="utf-8").splitlines())
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid in passed])
        items[:] = [item for item in items if item.nodeid not in passed]


def pytest_collection_finish() -> None:
    """Leave the objects of the imported modules out of later collections: tests collect often, each in a second."""
    gc.collect()
    gc.freeze()


def pytest_configure(config: pytest.Config) -> None:
    """Note passed tests in the process that collects the results of all."""
    if NOTE_PASSED and not hasattr(config, "workerinput"):
        config.pluginmanager.register(_Passed(Path(NOTE_PASSED)))


class _Passed:
    """Writes the names of passed tests."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", encoding="utf-8")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" and report.passed:
            print(report.nodeid, file=self._file)

    def pytest_unconfigure(self) -> None:
        self._file.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Skip a test that compares with a feature that the installed Gymnasium or ale-py lacks.

    With the releases that CI installs nothing is skipped, so no error is hidden there.
    """
    try:
        return (yield)
    except (AssertionError, AttributeError, ImportError, gymnasium.error.DependencyNotInstalled) as error:
        if OLD and (OLDEST_ALE_PY in str(error) or "need PettingZoo" in str(error) or _lacks_peer(error)):
            pytest.skip(str(error))
        raise


def _lacks_peer(error: Exception) -> bool:
    """Whether a line of a test, not of the package, uses a name that Gymnasium or ale-py lacks."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.name != "__getattr__"]
    where = Path(frames[-1].filename)
    missing = any(f"module '{peer}" in str(error) or f"from '{peer}" in str(error) for peer in ("gymnasium", "ale_py"))
    return missing and where.is_relative_to(Path(__file__).parent)
