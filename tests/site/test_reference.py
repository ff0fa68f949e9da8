import re
from pathlib import Path

# Modules whose `__all__` another module re-exports, or that hold names for other parts of the package only.
NOT_PAGES = {
    "atari.base.gymnasium_versions",
    "atari.env",
    "atari.integrations.envpool.atari",
    "atari.integrations.envpool.registration",
    "atari.multiplayer.base_atari_env",
    "atari.games.interventions",
    "atari.learning.memory",
    "atari.task",
    "atari.vector",
}


def test_every_module_with_public_names_has_a_page(public):
    named = {*public.modules_with_public_names()} - {*public.MODULES}
    assert {name for name in named if not name.startswith("atari.classic.")} == NOT_PAGES


def test_every_public_name_has_a_docstring(definitions):
    assert [f"{module}.{found.name}" for module, found in definitions if not found.docstring] == []


def test_every_public_name_is_found(public, definitions):
    """But for modules, and Gymnasium's classes under old names."""
    found = {f"{module}.{definition.name}" for module, definition in definitions}
    assert {f"{module}.{name}" for module in public.MODULES for name in public.exported(module)} - found == {
        "atari.ale_py.registration",
        "atari.ale_py.roms",
        "atari.classic.Space",
        "atari.classic.configuration",
        "atari.classic.envs",
        "atari.classic.error",
        "atari.classic.logger",
        "atari.classic.spaces",
        "atari.classic.utils",
        "atari.classic.vector",
        "atari.classic.version",
        "atari.classic.wrappers",
        "atari.cores",
        "atari.classic",
        "atari.integrations",
        "atari.integrations.envpool.atari",
        "atari.lab",
        "atari.learning",
        "atari.multiplayer",
        "atari.recording",
        "atari.roms",
        "atari.testing",
        "atari.wrappers",
    }


def test_every_definition_is_on_one_page(definitions):
    on_pages = [found.path for module, found in definitions if found.page == module]
    assert sorted(on_pages) == sorted({found.path for _, found in definitions})


def test_the_navigation_has_every_document():
    root = Path(__file__).parents[2]
    navigation = (root / "mkdocs.yml").read_text(encoding="utf-8")
    documents = {path.name for path in (root / "docs").glob("*.md")}
    assert documents <= set(re.findall(r"[\w.-]+\.md", navigation))


def test_every_definition_is_shown_once(definitions, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "scripts" / "site"))
    import reference

    pages = {page.path: page.content for page in reference.pages()}
    shown = [path for text in pages.values() for path in re.findall(r"^::: (\S+)$", text, re.MULTILINE)]
    assert sorted(shown) == sorted({found.path for _, found in definitions})
    assert "::: atari.learning.evaluation.evaluate.evaluate\n" in pages["reference/atari.learning.evaluation.md"]
    assert "[`evaluate`][atari.learning.evaluation.evaluate.evaluate]" in pages["reference/atari.learning.md"]
