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


def all_definitions(public):
    return [(module, found) for module in public.MODULES for found in public.definitions(module)]


def test_every_module_with_public_names_has_a_page(site_module):
    public = site_module("public")
    of_gym = {name for name in public.modules_with_public_names() if name.startswith("atari.classic.")}
    assert set(public.modules_with_public_names()) - set(public.MODULES) - of_gym == NOT_PAGES


def test_every_public_name_has_a_docstring(site_module):
    public = site_module("public")
    assert [f"{module}.{found.name}" for module, found in all_definitions(public) if not found.docstring] == []


def test_every_public_name_is_found(site_module):
    """But for modules, and Gymnasium's classes under old names."""
    public = site_module("public")
    found = {(module, definition.name) for module, definition in all_definitions(public)}
    missing = {f"{module}.{name}" for module in public.MODULES for name in public.exported(module)} - {
        f"{module}.{name}" for module, name in found
    }
    assert missing == {
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


def test_every_definition_is_on_one_page(site_module):
    public = site_module("public")
    on_pages = [found.path for module, found in all_definitions(public) if found.page == module]
    assert len(on_pages) == len(set(on_pages))
    assert set(on_pages) == {found.path for _, found in all_definitions(public)}


def test_the_navigation_has_every_document():
    root = Path(__file__).parents[2]
    navigation = (root / "mkdocs.yml").read_text(encoding="utf-8")
    documents = {path.name for path in (root / "docs").glob("*.md")}
    assert documents <= set(re.findall(r"[\w.-]+\.md", navigation))
