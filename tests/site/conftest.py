import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = Path(__file__).parents[2] / "scripts" / "site"


@pytest.fixture(scope="session")
def site_module() -> Callable[[str], ModuleType]:
    """Loads a module of scripts/site by the name of its file; only those that import no other one."""

    def load(name: str) -> ModuleType:
        full = f"site_{name}"
        if full not in sys.modules:
            spec = importlib.util.spec_from_file_location(full, FOLDER / f"{name}.py")
            assert spec is not None
            assert spec.loader is not None
            sys.modules[full] = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(sys.modules[full])
        return sys.modules[full]

    return load
