"""Reads the interface of chosen modules and classes of an installed package by `inspect`.

Compiled functions have no signature; their docstrings begin with one. The source of a class is read only where its
package is Python whose source may be read (`attributes_of_source`): never of an emulator.
"""

import ast
import importlib
import inspect
import re
from collections.abc import Iterable, Iterator
from typing import Any

from interfaces.compare import calls_on_self, set_on_self
from interfaces.enumerations import describe
from interfaces.facts import UNKNOWN, Fact, Versions, plain


class NotInstalled(Exception):
    """A peer that this Python does not have."""


def require(package: str, requirement: str) -> None:
    """Import a package.

    Raises:
        NotInstalled: there is none; the message says how it is installed.
    """
    try:
        importlib.import_module(package)
    except ImportError as error:
        raise NotInstalled(
            f"{package} is not installed here, so it was NOT compared: pip install {requirement}"
        ) from error


def versions(facts: Iterable[Fact], version: str) -> Versions:
    """Facts of one version."""
    return dict.fromkeys(facts, (version,))


def module_facts(name: str, package: str) -> Iterator[Fact]:
    """The facts of a module: its own public names, and those that it has from other modules of its package."""
    module = importlib.import_module(name)
    yield Fact(name, "", "module")
    for public in sorted({*vars(module), *getattr(module, "__all__", ())}):
        value = getattr(module, public, None)
        origin = getattr(value, "__module__", None) or name
        if public.startswith("_") or inspect.ismodule(value) or origin.partition(".")[0] != package:
            continue
        if inspect.isclass(value):
            yield from class_facts(f"{name}.{public}")
        elif callable(value):
            yield from function_facts(name, public, value, "function")
        elif public != "annotations":
            yield Fact(name, public, "value")


def class_facts(path: str, instance: Any = None) -> Iterator[Fact]:
    """The facts of a class: its public names, its signatures, the attributes of an instance, and what its members say."""
    module, _, name = path.rpartition(".")
    kind: Any = getattr(importlib.import_module(module), name)
    yield Fact(module, name, "class")
    members = getattr(kind, "__members__", {})
    for each in dir(kind):
        if each.startswith("_") or each in members or (issubclass(kind, dict) and hasattr(dict, each)):
            continue
        value = inspect.getattr_static(kind, each)
        if isinstance(value, property) or not callable(getattr(kind, each, None)):
            yield Fact(module, f"{name}.{each}", "attribute")
        else:
            yield from function_facts(module, f"{name}.{each}", value, "method")
    if members:
        yield Fact(module, name, "enumeration", describe(kind))
    else:
        yield from _initializer(module, name, kind)
    for each in dir(instance) if instance is not None else ():
        if not each.startswith("_") and not hasattr(kind, each):
            yield Fact(module, f"{name}.{each}", "attribute")


def facts_of_classes(paths: Iterable[str]) -> set[Fact]:
    """The facts of classes of Python, with the attributes that they set on `self`."""
    return {fact for path in paths for fact in (*class_facts(path), *attributes_of_source(path))}


def attributes_of_source(path: str) -> Iterator[Fact]:
    """The attributes that a class of Python sets on `self`, and the public methods that it calls there."""
    module, _, name = path.rpartition(".")
    kind = getattr(importlib.import_module(module), name)
    for each in sorted(set_on_self(kind)):
        if not each.startswith("_"):
            yield Fact(module, f"{name}.{each}", "attribute")
    for each in sorted(calls_on_self(kind)):
        if not each.startswith("_") and inspect.isfunction(getattr(kind, each, None)):
            yield Fact(module, f"{name}.{each}", "hook")


def _initializer(module: str, name: str, kind: type) -> Iterator[Fact]:
    if kind.__init__ is object.__init__:
        return
    text = _signature(kind, without_first=False)
    for each in [text] if text else documented("__init__", kind.__init__.__doc__):
        yield Fact(module, f"{name}.__init__", "method", each)


def function_facts(module: str, name: str, value: Any, kind: Any) -> Iterator[Fact]:
    """The facts of a function, or of a method as its class holds it; a compiled one may have several signatures."""
    function = value.__func__ if isinstance(value, (staticmethod, classmethod)) else value
    bound = kind == "function" or isinstance(value, staticmethod)
    text = _signature(function, without_first=not bound)
    texts = [text] if text else documented(name.rpartition(".")[2], getattr(function, "__doc__", None))
    for each in texts or [""]:
        yield Fact(module, name, kind, each)


def _signature(function: Any, *, without_first: bool) -> str:
    """The text of a signature; empty where C++ gives none."""
    try:
        return plain(inspect.signature(function), without_first=without_first)
    except (ValueError, TypeError):
        return ""


def documented(name: str, doc: str | None) -> list[str]:
    """The signatures with which the docstring of a compiled function begins, without `self` and without types."""
    found = []
    for line in (doc or "").splitlines():
        match = re.match(rf"(?:\d+\. )?{re.escape(name)}\((.*)\)(?: -> .*)?$", line.strip())
        if match:
            words = [_argument(each) for each in _split(match[1])]
            found.append(
                f"({', '.join(each for each in words if each != 'self')})".replace("(/, ", "(").replace("(/)", "()")
            )
    return list(dict.fromkeys(found))


def _split(text: str) -> Iterator[str]:
    """The parts of a text between commas that are in no brackets and in no quotes."""
    depth, start, quoted = 0, 0, False
    for place, letter in enumerate(text):
        quoted ^= letter == "'"
        if not quoted:
            depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and not depth and not quoted:
            yield text[start:place].strip()
            start = place + 1
    if text[start:].strip():
        yield text[start:].strip()


def _argument(text: str) -> str:
    """A parameter without its type, and with `...` for a default that is no literal."""
    name, colon, rest = text.partition(":")
    _, equals, default = (rest if colon else "").partition(" = ")  # those of types have no spaces
    if not equals:
        return name.strip()
    try:
        ast.literal_eval(default)
    except (SyntaxError, ValueError):
        default = repr(UNKNOWN)
    return f"{name}={default}"
