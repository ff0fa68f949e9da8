"""The two forms of the page: a site, for any static host, and `atari.html`, one file that opens without a server.

Without a server, browsers permit neither modules nor fetch. In the one file the modules are one script, in the order of
their imports, and the other files are in it as base64.
"""

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Mapping
from functools import lru_cache

ONE_FILE = "atari.html"

_IMPORT = re.compile(r"^import \{([^}]*)\} from \"\./([\w-]+)\.js\";\n", re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async )?(?:function|class|const) (\w+))", re.MULTILINE)
_LOADS = "<!-- loads -->\n"
_WHOLE_TABLE = "table/table.json.gz"
_POLICY = (
    "default-src 'none'; script-src {script} 'wasm-unsafe-eval' data:; style-src {style}; img-src data:; "
    "base-uri 'none'; form-action 'none'"
)


def site(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """The files of a site by name.

    Beside the given files it has `files.json`, the list of those that the service worker keeps after the first visit.
    Its `index.html` names what a browser can load at once, before the modules say so.

    Args:
        files: the files of a page, see `atari.web.shelf.page_files`.

    Raises:
        ValueError: the page's source has a form that this module does not read.
    """
    modules = re.findall(r"^const \$([\w-]+) = ", _script(files), re.MULTILINE)
    links = [f'<link rel="modulepreload" href="{name}.js">\n' for name in modules]
    links += [f'<link rel="preload" href="{name}" as="fetch" crossorigin>\n' for name in _first(files)]
    kept = ["./", "page.css", *sorted(name for name in files if name.endswith(".js") and name != "worker.js")]
    kept += [*_first(files), *_entries(files)]
    return {
        **files,
        "index.html": files["index.html"].replace(_LOADS.encode(), "".join(links).encode()),
        "files.json": json.dumps(kept).encode(),
    }


def one_file(files: Mapping[str, bytes]) -> str:
    """The page in one file; see `site`."""
    code, style = _script(files), files["page.css"].decode()
    if "</script" in code or "</style" in style:
        raise ValueError("the page has the end of a script or a style in a text")
    names = [*_first(files), *_entries(files), *(name for name in files if name.startswith("replays/"))]
    inside = "".join(_tag(name, _packed(files[name])) for name in names)
    inside += _tag(_WHOLE_TABLE.removesuffix(".gz"), files[_WHOLE_TABLE]) + _tag("worklet.js", files["worklet.js"])
    policy = _POLICY.format(script=_hash(code), style=_hash(style))
    page = files["index.html"].decode()
    for pattern, text in (
        (r'content="default-src[^"]*"', f'content="{policy}"'),
        (_LOADS, ""),
        (r'<link rel="stylesheet"[^>]*>', f"<style>{style}</style>"),
        (r'<script type="module"[^>]*></script>\n', f"{inside}<script>{code}</script>\n"),
    ):
        before, *after = re.split(pattern, page)
        if len(after) != 1:
            raise ValueError(f"index.html has {len(after)} times {pattern}")
        page = before + text + after[0]
    return page


def _first(files: Mapping[str, bytes]) -> list[str]:
    """The files that every visit loads, beside the modules."""
    return ["core.wasm", "shelf.json", "table/index.json", *json.loads(files["shelf.json"])["roms"]]


def _entries(files: Mapping[str, bytes]) -> list[str]:
    """The entries, in the table of games, of the games whose ROM comes with the page."""
    ids = [rom.rpartition("/")[2].removesuffix(".bin") for rom in json.loads(files["shelf.json"])["roms"]]
    return [f"table/games/{name}.json" for name in ids]


def _script(files: Mapping[str, bytes], main: str = "main") -> str:
    """One classic script of the module `main` and all that it imports, each in a function of its own."""
    parts: dict[str, str] = {}

    def add(name: str) -> None:
        if name in parts:
            return
        text = files[f"{name}.js"].decode()
        for match in _IMPORT.finditer(text):
            add(match[2])
        exported = ", ".join(match[2] for match in _EXPORT.finditer(text))
        body = _EXPORT.sub(r"\1", _IMPORT.sub(lambda match: f"const {{{match[1]}}} = ${match[2]};\n", text))
        for word in ("import", "export"):
            if re.search(rf"^\s*{word}\b", body, re.MULTILINE):
                raise ValueError(f"{name}.js has a form of {word} that the bundle does not have")
        parts[name] = f"const ${name} = (() => {{\n{body}\nreturn {{ {exported} }};\n}})();\n"

    add(main)
    return '"use strict";\n' + "".join(parts.values())


def _tag(name: str, data: bytes) -> str:
    """A file in the page: a script of no type that a browser runs."""
    return f'<script type="application/octet-stream" id="file:{name}">{base64.b64encode(data).decode()}</script>\n'


@lru_cache(maxsize=8)  # of the core above all, for the replays of a notebook
def _packed(data: bytes) -> bytes:
    return gzip.compress(data, 9, mtime=0)


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
