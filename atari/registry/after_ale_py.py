"""The IDs that a later `import ale_py` leaves as they are.

ale-py registers its own IDs when it is imported, and would replace those of this package, with a warning for each. To
import it first would take nearly as long as this whole package. So its import is watched.
"""

import sys
from collections.abc import Iterable
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

import gymnasium


def keep(env_ids: Iterable[str]) -> None:
    """Let the specs of these IDs outlive the import of ale-py, if it is not imported yet."""
    if "ale_py" not in sys.modules:
        sys.meta_path.insert(0, _Finder(tuple(env_ids)))


class _Finder:
    """Finds `ale_py` as Python does. While the module runs, the IDs are not in the registry."""

    def __init__(self, env_ids: tuple[str, ...]) -> None:
        self._env_ids = env_ids

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        if name != "ale_py" or (spec := PathFinder.find_spec(name, path, target)) is None or spec.loader is None:
            return None
        run = spec.loader.exec_module

        def exec_module(module: ModuleType) -> None:
            registry = gymnasium.registry
            kept = {env_id: registry.pop(env_id) for env_id in self._env_ids if env_id in registry}
            try:
                run(module)
            finally:
                registry.update(kept)

        spec.loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec
