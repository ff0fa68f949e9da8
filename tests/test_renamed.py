"""Old names: each raises an error that says the new one, and the new one exists."""

import re
from importlib import import_module
from typing import Any

import pytest

from atari._renamed import RENAMED

RAY = "atari.integrations.ray."  # cannot be imported without Ray
MODULES = {old: new for old, new in RENAMED.items() if old.startswith("atari.") and not old.startswith(RAY)}


def found(path: str) -> Any:
    """The module with this path, or the attribute of a module or a class."""
    try:
        return import_module(path)
    except ModuleNotFoundError:
        owner, _, name = path.rpartition(".")
        return getattr(found(owner), name)


@pytest.mark.parametrize("old", MODULES)
def test_an_old_name_says_the_new_one(old: str) -> None:
    module, _, name = old.rpartition(".")
    with pytest.raises(ImportError, match=re.escape(f"{old} is now {RENAMED[old]}; docs/from-0.2.md has")):
        getattr(import_module(module), name)


@pytest.mark.parametrize("new", sorted({new for new in MODULES.values() if re.fullmatch(r"[\w.]+", new)}))
def test_a_new_name_exists(new: str) -> None:
    assert found(new) is not None
