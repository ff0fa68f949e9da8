"""Reads the interface of an imported package by `inspect`: names, signatures and members, never its source."""

import enum
import importlib
import inspect
import pkgutil
from collections.abc import Iterator, Mapping
from types import ModuleType
from typing import Any

from interfaces.facts import Fact, plain


def read(package: str, instances: Mapping[str, Any] | None = None, modules: tuple[str, ...] | None = None) -> set[Fact]:
    """The facts of a package that can be imported.

    Args:
        package: its name, such as "gymnasium".
        instances: an instance of a class by the import path of the class, such as "gymnasium.wrappers.RecordVideo"; it
            has the attributes that `__init__` sets.
        modules: only these; None means all modules of the package that can be imported.
    """
    facts: set[Fact] = set()
    for name in modules or sorted(_modules(package)):
        module = importlib.import_module(name)
        facts.add(Fact(name, "", "module"))
        facts |= set(_names(name, module, package))
    for path, instance in (instances or {}).items():
        module_name, _, name = path.rpartition(".")
        facts |= {
            Fact(module_name, f"{name}.{each}", "attribute")
            for each in dir(instance)
            if not each.startswith("_") and not hasattr(type(instance), each)
        }
    return facts


def _modules(package: str) -> Iterator[str]:
    yield package
    for each in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}.", onerror=lambda _: None):
        if any(part.startswith(("_", "test")) for part in each.name.split(".")[1:]):
            continue
        try:
            importlib.import_module(each.name)
        except Exception:  # it needs another package
            continue
        yield each.name


def _names(name: str, module: ModuleType, package: str) -> Iterator[Fact]:
    public = getattr(module, "__all__", None) or [each for each in vars(module) if not each.startswith("_")]
    for each in public:
        value = getattr(module, each, None)
        origin = str(getattr(value, "__module__", "") or "")
        if inspect.ismodule(value) or (origin and origin.partition(".")[0] != package.partition(".")[0]):
            continue
        if inspect.isclass(value):
            yield from _class(name, each, value, package)
        elif callable(value):
            yield Fact(name, each, "function", _signature(value, without_first=False))
        else:
            yield Fact(name, each, "value")


def _class(module: str, name: str, kind: type, package: str) -> Iterator[Fact]:
    yield Fact(module, name, "class")
    if issubclass(kind, enum.Enum) or hasattr(kind, "__members__"):
        members: Mapping[str, Any] = kind.__members__  # pybind11 and nanobind have it too
        for member, value in members.items():
            yield Fact(module, f"{name}.{member}", "member", str(int(value)) if _is_number(value) else "")
    for each in dir(kind):
        if each.startswith("_") or each in getattr(kind, "__members__", ()):
            continue
        value = inspect.getattr_static(kind, each)
        if isinstance(value, (property, type(None))) or not callable(getattr(kind, each, None)):
            yield Fact(module, f"{name}.{each}", "attribute")
        else:
            bound = isinstance(value, (staticmethod, classmethod))
            yield Fact(module, f"{name}.{each}", "method", _signature(getattr(kind, each), without_first=not bound))
    try:
        yield Fact(module, f"{name}.__init__", "method", plain(inspect.signature(kind)))
    except (ValueError, TypeError):  # C++ gives no signature
        return


def _is_number(value: Any) -> bool:
    try:
        int(value)
    except (TypeError, ValueError):
        return False
    return True


def _signature(function: Any, *, without_first: bool) -> str:
    """The text of a signature; empty where C++ gives none."""
    try:
        return plain(inspect.signature(function), without_first=without_first)
    except (ValueError, TypeError):
        return ""
