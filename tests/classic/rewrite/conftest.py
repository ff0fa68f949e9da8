"""A rewritten script runs on Gymnasium 1.1 and newer."""

import gymnasium
import pytest


@pytest.fixture(autouse=True)
def modern_gymnasium() -> None:
    """Skip the tests with an older Gymnasium."""
    if not hasattr(gymnasium.vector, "AutoresetMode"):
        pytest.skip("a rewritten script needs Gymnasium 1.1 or newer")
