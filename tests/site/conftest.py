from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest
import site_modules


@pytest.fixture(scope="session")
def site_module() -> Callable[[str], ModuleType]:
    """Loads a module of scripts/site by the name of its file."""
    return site_modules.load


@pytest.fixture(scope="session")
def public() -> ModuleType:
    return site_modules.load("public")


@pytest.fixture(scope="session")
def definitions(public: ModuleType) -> list[tuple[str, Any]]:
    """The module and the definition of every public name."""
    return [(module, found) for module in public.MODULES for found in public.definitions(module)]
