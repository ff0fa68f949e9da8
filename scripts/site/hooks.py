"""The functions that MkDocs calls while it builds the site: the pages made from data, and links between documents."""

import re
import warnings
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import check
import documents
import games
import hero
import notebooks
import player
import reference
from mkdocs.exceptions import PluginError
from mkdocs.plugins import event_priority
from mkdocs.structure.files import File, Files
from page import Page

# Each gives files of the site.
SOURCES: tuple[Callable[[], Iterator[Page]], ...] = (
    documents.pages,
    reference.pages,
    hero.pages,
    games.pages,
    player.pages,
    notebooks.pages,
)

# The replacements of <!-- site: NAME --> in a document.
INSERTS: dict[str, Callable[[], str]] = {
    "hero": hero.html,
    "games": lambda: "[All games](games/index.md){ .md-button }",  # a page that only the site has
    "player": player.link,
}
_INSERT = re.compile(r"<!-- site: ([\w.]+) -->")


@event_priority(100)  # before mkdocstrings reads it
def on_config(config: Any) -> Any:
    """Let the reference read the installed package: the sources in the top folder have no wrappers and ROMs."""
    spec = find_spec("atari.wrappers")
    if spec is None or spec.origin is None:
        raise PluginError("the package is not installed here; scripts/docs builds the site")
    package = Path(spec.origin).parents[1]
    if package.name != "atari":
        raise PluginError("the site is built from an installed package, not an editable one; scripts/docs installs it")
    config.plugins["mkdocstrings"].config["handlers"]["python"]["paths"] = [str(package.parent)]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the files that are made from data, and the reference to the navigation."""
    warnings.simplefilter("ignore")
    try:
        made = [page for source in SOURCES for page in source()]
    except reference.Undocumented as error:
        raise PluginError(str(error)) from None
    for page in made:
        if isinstance(page.content, Path):
            files.append(File.generated(config, page.path, abs_src_path=str(page.content)))
        else:
            files.append(File.generated(config, page.path, content=page.content))
    for section in config.nav:
        if "Reference" in section:
            section["Reference"] = ["reference/index.md", *({page.title: page.path} for page in made if page.title)]
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Make the links of a document in docs/ those of the site."""
    source = Path(config.docs_dir) / page.file.src_uri
    if not source.exists():
        return markdown
    for name in _INSERT.findall(markdown):
        if name not in INSERTS:
            raise PluginError(f"{page.file.src_uri}: there is nothing to insert named {name!r}")
    return documents.clean(_INSERT.sub(lambda match: INSERTS[match.group(1)](), markdown), source)


def on_post_build(config: Any) -> None:
    """Fail if a page that was written loads anything from another host, or links to a place that is not there."""
    found = list(check.faults(Path(config.site_dir)))
    if found:
        raise PluginError("\n".join(found))
