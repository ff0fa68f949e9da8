"""The fixtures and settings of all tests."""

import signal
import traceback
from collections.abc import Iterator
from pathlib import Path

import ale_py
import gymnasium
import pytest

from atari.cores.ale import OLDEST_ALE_PY, _numbers

OLD = _numbers(gymnasium.__version__) < _numbers("1.4.0") or _numbers(ale_py.__version__) < _numbers(OLDEST_ALE_PY)

pytest.register_assert_rewrite("core_contract", "core_tools", "env_tools", "snapshot_contract", "cli_tools")

# A process that a shell has put into the background ignores Ctrl-C, and so do the programs that it runs.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Skip a test that compares with a feature that the installed Gymnasium or ale-py lacks.

    With the releases that CI installs nothing is skipped, so no error is hidden there.
    """
    try:
        return (yield)
    except (AttributeError, ImportError, gymnasium.error.DependencyNotInstalled) as error:
        if OLD and (OLDEST_ALE_PY in str(error) or _lacks_peer(error)):
            pytest.skip(str(error))
        raise


def _lacks_peer(error: Exception) -> bool:
    """Whether a line of a test, not of the package, uses a name that Gymnasium or ale-py lacks."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.name != "__getattr__"]
    where = Path(frames[-1].filename)
    missing = any(f"module '{peer}" in str(error) or f"from '{peer}" in str(error) for peer in ("gymnasium", "ale_py"))
    return missing and where.is_relative_to(Path(__file__).parent)
