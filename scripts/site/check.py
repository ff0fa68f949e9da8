"""Faults of a built site: requests to other hosts, and links to places that are not there."""

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Attributes that a browser loads when it shows a page; the href of <link> but for these relations too.
_LOADED = {"src", "poster", "srcset", "data"}
_ONLY_NAMED = {"canonical", "next", "prev", "alternate", "author", "license"}
_CSS_LOAD = re.compile(r"(?:url\(|@import\s+)\s*[\"']?((?:https?:)?//[^\"')\s]+)")


class _Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.links: list[str] = []
        self.ids: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.ids |= {values[name] for name in ("id", "name") if name in values}
        self.loaded += [value for name, value in values.items() if name in _LOADED]
        if tag == "link" and values.get("rel") not in _ONLY_NAMED:
            self.loaded.append(values.get("href", ""))
        elif tag == "a" and "href" in values:
            self.links.append(values["href"])
        self.loaded += _CSS_LOAD.findall(values.get("style", ""))


def faults(site: Path) -> Iterator[str]:
    """A sentence for each request to another host, and for each link to a file or an anchor that does not exist."""
    pages = {path.resolve(): _read(path) for path in sorted(site.rglob("*.html"))}
    for path, page in pages.items():
        if path.name == "404.html":  # its links are those of the host's root
            continue
        name = path.relative_to(site.resolve())
        for target in page.loaded:
            if target.startswith(("http:", "https:", "//")):
                yield f"{name} loads {target} from another host"
            elif target and not target.startswith("data:") and not _place(path, target).exists():
                yield f"{name} loads {target}, which does not exist"
        for target in page.links:
            yield from _broken(path, target, pages, name)
    for path in sorted(site.rglob("*.css")):
        for target in _CSS_LOAD.findall(path.read_text(encoding="utf-8")):
            yield f"{path.relative_to(site)} loads {target} from another host"


def _read(path: Path) -> _Page:
    page = _Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def _place(page: Path, target: str) -> Path:
    path = unquote(urlsplit(target).path)
    return (page.parent / path).resolve() if path else page


def _broken(page: Path, target: str, pages: dict[Path, _Page], name: Path) -> Iterator[str]:
    if urlsplit(target).scheme:
        return
    place, anchor = _place(page, target), unquote(urlsplit(target).fragment)
    if not place.exists():
        yield f"{name} links to {target}, which does not exist"
    elif re.match("$|__|.*=", anchor):  # `__search` is for the theme's script, and `game=pong` for one of the page
        return
    elif place in pages and anchor not in pages[place].ids:
        yield f"{name} links to {target}; the page has no such place"
