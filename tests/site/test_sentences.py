"""What sentences of the documents say about names: calls, flags, and code that a link promises."""

import contextlib
import dataclasses
import importlib
import inspect
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import gymnasium
import pytest
from package_modules import SOURCES

import atari

pytest.importorskip("torch", reason="without it the agents, whose options and flags the pages name, are not imported")

from atari.cli.completion import _actions, _whole_parser

TOP = Path(__file__).resolve().parents[2]
DOCS = TOP / "docs"
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in [*DOCS.glob("*.md"), *DOCS.glob("recipes/*.md")])
BLOCK = re.compile(r"^ *```.*?^ *```$", re.DOTALL | re.MULTILINE)
OTHERS = {"--env", "--gym-packages", "--modern"}
"""Flags of other programs: rl_zoo3, and `python -m atari.classic`."""
CODE = re.compile(r"`([^`\n]+)`")


def sentences(page: str) -> str:
    """A page without its blocks of code."""
    return BLOCK.sub("", (DOCS / page).read_text(encoding="utf-8"))


@cache
def public() -> dict[str, list[Any]]:
    """The package's public functions, classes and methods, by their last name and by "Class.method"."""
    found: dict[str, list[Any]] = {}
    of_gym = [name for name in SOURCES if name.startswith("atari.classic") and "algorithmic" not in name]
    for module in [name for name in SOURCES if name not in of_gym and "._" not in name]:
        with contextlib.suppress(ImportError, gymnasium.error.DependencyNotInstalled):
            for name in getattr(importlib.import_module(module), "__all__", ()):
                with contextlib.suppress(ImportError, AttributeError, gymnasium.error.DependencyNotInstalled):
                    made = getattr(importlib.import_module(module), name)
                    found.setdefault(name, []).append(made)
                    for own, method in inspect.getmembers(made, callable) if inspect.isclass(made) else ():
                        if not own.startswith("_"):
                            found.setdefault(f"{name}.{own}", []).append(method)
    return found


def calls(text: str) -> Iterator[tuple[str, str, list[str]]]:
    """The calls in inline code with named arguments: the code, the name that is called, the names of the arguments."""
    for code in CODE.findall(text):
        match = re.fullmatch(r"([\w.]+)\((.*)\)", code)
        if match:
            names = re.findall(r"(?:^|, )(\w+)=", match[2])
            if names:
                yield code, match[1], names


def parameters(name: str) -> list[set[str]]:
    """The parameters of what a name may mean; of a callable with any keywords, the package's options, too, and the words of its docstring."""
    parts = name.split(".")
    made = public().get(".".join(parts[-2:])) or public().get(parts[-1]) or []
    return [own | options() | words(one) if keywords else own for one in made for own, keywords in [signature(one)]]


def words(made: Any) -> set[str]:
    """The words of a docstring."""
    return set(re.findall(r"\w+", inspect.getdoc(made) or ""))


def signature(made: Any) -> tuple[set[str], bool]:
    """The names of the parameters of a callable, and whether it takes any keywords."""
    try:
        listed = inspect.signature(made).parameters
    except (TypeError, ValueError):
        return set(), True
    return set(listed), any(parameter.kind is parameter.VAR_KEYWORD for parameter in listed.values())


@cache
def options() -> set[str]:
    """The fields of a task, and the parameters of all public callables."""
    fields = {field.name for field in dataclasses.fields(atari.Task)}
    return fields.union(*(signature(one)[0] for made in public().values() for one in made))


@pytest.mark.parametrize("page", [page for page in PAGES if page != "classic.md"])  # its functions are Gym's
def test_calls_have_the_arguments_that_a_page_names(page: str) -> None:
    for code, name, names in calls(sentences(page)):
        known = parameters(name)
        assert not known or any(set(names) <= one for one in known), code


@cache
def flags() -> set[str]:
    """The flags of all commands, of the agents, and of the scripts of this repository."""
    found = {flag for action in _actions(_whole_parser()) for flag in action.option_strings}
    for script in [*TOP.glob("scripts/**/*"), *TOP.glob("tests/*/__main__.py"), *TOP.glob("examples/*.py")]:
        if script.is_file():
            found |= set(re.findall(r"(?<![\w-])--[a-z][\w-]*", script.read_text(encoding="utf-8", errors="ignore")))
    with contextlib.suppress(gymnasium.error.DependencyNotInstalled, ImportError):
        agents = importlib.import_module("atari.learning.agents")
        kinds = [agents.find_agent(name).options_class for name in agents.AGENTS]
        found |= {f"--{field.name.replace('_', '-')}" for kind in kinds for field in dataclasses.fields(kind)}
    return found


@pytest.mark.parametrize("page", PAGES)
def test_flags_of_a_page_are_flags_of_commands(page: str) -> None:
    named = {flag for code in CODE.findall(sentences(page)) for flag in re.findall(r"(?<![\w-])--[a-z][\w-]*", code)}
    assert named - flags() - OTHERS == set()


@pytest.mark.parametrize("page", PAGES)
def test_a_link_leads_to_the_code_that_it_names(page: str) -> None:
    """The words of a link in code, such as [`load_policy`](evaluation.md#policies), stand in the page it leads to."""
    for words, target in re.findall(r"\[([^\]\n]*`[^\]\n]*)\]\(([^)\s]+)\)", sentences(page)):
        path, _, _ = target.partition("#")
        file = (DOCS / page).parent / path if path else DOCS / page
        if "://" in target or file.suffix != ".md":
            continue
        text = file.read_text(encoding="utf-8")
        for code in CODE.findall(words):
            assert re.split(r"[(=]", code)[0].rpartition(".")[2] in text, (words, target)


def test_the_checks_find_what_is_wrong() -> None:
    text = "`evaluate(policy, episodes=3)`, `evaluate(policy, rounds=3)`, and `Training.run(progress=show)`"
    found = [(name, names) for _, name, names in calls(text)]
    assert found == [("evaluate", ["episodes"]), ("evaluate", ["rounds"]), ("Training.run", ["progress"])]
    assert "--preset" in flags()
    assert any(known and "episodic_life" in known for known in parameters("AtariVectorEnv"))
    assert sum(bool(parameters(name)) for page in PAGES for _, name, _ in calls(sentences(page))) > 20
