"""The pages of the reference: each public name of each module, from its docstring."""

import re
from collections.abc import Iterator

from page import Page
from public import MODULES, definitions, module_docstring

# Classes with public methods in a base class that has no page.
_WITH_METHODS_OF_BASES = {"atari.learning.memory.replay_memory.ReplayMemory"}

# Pages of their own, of definitions in these modules, for modules whose page would be too long to read.
_PARTS = {
    "atari.learning": {
        "evaluation": ("evaluation",),
        "memory": ("memory",),
        "training": ("training", "environments", "options", "restarts", "run_folder"),
    },
}


class Undocumented(Exception):
    """Public names have no docstring."""


def pages() -> Iterator[Page]:
    """A page for each module, and their index.

    Raises:
        Undocumented: a public name has no docstring; the text names all of them.
    """
    missing = [f"{module}.{found.name}" for module in MODULES for found in definitions(module) if not found.docstring]
    if missing:
        raise Undocumented(f"public names without a docstring: {', '.join(missing)}")
    yield Page("reference/index.md", "\n".join(_index()))
    for module in MODULES:
        yield Page(f"reference/{module}.md", "\n".join(_page(module)), module)
        for part in _PARTS.get(module, ()):
            title = f"{module}: {part}"
            text = [f"# {title}\n", f"Names of [`{module}`]({module}.md).\n", *_definitions(module, part)]
            yield Page(f"reference/{module}.{part}.md", "\n".join(text), title)


def _index() -> Iterator[str]:
    yield "# Reference\n"
    yield "Every public name, from its docstring. The [guides](../vector.md) say how they go together.\n"
    yield "| module | |"
    yield "|---|---|"
    for module in MODULES:
        yield f"| [`{module}`]({module}.md) | {_first_sentence(module_docstring(module))} |"


def _page(module: str) -> Iterator[str]:
    yield f"# {module}\n"
    yield f"{_first_sentence(module_docstring(module))}\n"
    yield "| name | |"
    yield "|---|---|"
    for definition in definitions(module):
        yield f"| [`{definition.name}`][{definition.path}] | {_first_sentence(definition.docstring)} |"
    yield ""
    yield from _definitions(module, "")


def _definitions(module: str, part: str) -> Iterator[str]:
    """The definitions on a page: those of a part of a module, or for part "" all others of it."""
    for definition in definitions(module):
        if definition.page == module and _part(module, definition.path) == part:
            bases = "    options:\n      inherited_members: true\n" if definition.path in _WITH_METHODS_OF_BASES else ""
            yield f"::: {definition.path}\n{bases}"


def _part(module: str, path: str) -> str:
    for part, homes in _PARTS.get(module, {}).items():
        if path.startswith(tuple(f"{module}.{home}." for home in homes)):
            return part
    return ""


def _first_sentence(docstring: str) -> str:
    sentence = docstring.split("\n\n")[0].replace("\n", " ").strip()
    return re.sub(r"`docs/([\w-]+)\.md`", r"[\1](../\1.md)", sentence.replace("|", "\\|"))
