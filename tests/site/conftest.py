from collections.abc import Callable
from types import ModuleType

import pytest
import site_modules


@pytest.fixture(scope="session")
def site_module() -> Callable[[str], ModuleType]:
    """Loads a module of scripts/site by the name of its file."""
    return site_modules.load
