"""Makes one file of the page: `python web/bundle.py FOLDER` reads the page in FOLDER and writes FOLDER/atari.html.

It opens without a server, where browsers permit neither modules nor fetch: the modules become one script, in the order
of their imports, and the other files are in it as base64. Of the site it writes files.json, the list that worker.js
keeps, and into index.html what a browser can load at once, before the modules say so.
"""

import base64
import gzip
import hashlib
import json
import re
import sys
from pathlib import Path

IMPORT = re.compile(r"^import \{([^}]*)\} from \"\./([\w-]+)\.js\";\n", re.MULTILINE)
EXPORT = re.compile(r"^export ((?:async )?(?:function|class|const) (\w+))", re.MULTILINE)
WHOLE_TABLE = "table/table.json.gz"
LOADS = "<!-- loads -->\n"
PACKED = ("core.wasm", "catch.bin", "table/index.json", "table/games/catch.json")
POLICY = (
    "default-src 'none'; script-src {script} 'wasm-unsafe-eval' data:; style-src {style}; img-src data:; "
    "base-uri 'none'; form-action 'none'"
)


def script(folder: Path, main: str = "main") -> str:
    """One classic script of the module `main` and all that it imports, each in a function of its own."""
    parts: dict[str, str] = {}

    def add(name: str) -> None:
        if name in parts:
            return
        text = (folder / f"{name}.js").read_text(encoding="utf-8")
        for match in IMPORT.finditer(text):
            add(match[2])
        exported = ", ".join(match[2] for match in EXPORT.finditer(text))
        body = EXPORT.sub(r"\1", IMPORT.sub(lambda match: f"const {{{match[1]}}} = ${match[2]};\n", text))
        for word in ("import", "export"):
            if re.search(rf"^\s*{word}\b", body, re.MULTILINE):
                raise ValueError(f"{name}.js has a form of {word} that the bundle does not have")
        parts[name] = f"const ${name} = (() => {{\n{body}\nreturn {{ {exported} }};\n}})();\n"

    add(main)
    return '"use strict";\n' + "".join(parts.values())


def packed(name: str, data: bytes) -> str:
    """A file in the page: a script of no type that a browser runs."""
    return f'<script type="application/octet-stream" id="file:{name}">{base64.b64encode(data).decode()}</script>\n'


def one_file(folder: Path) -> str:
    """The page in one file."""
    code, style = script(folder), (folder / "page.css").read_text(encoding="utf-8")
    if "</script" in code or "</style" in style:
        raise ValueError("the page has the end of a script or a style in a text")
    files = "".join(packed(name, gzip.compress((folder / name).read_bytes(), 9, mtime=0)) for name in PACKED)
    files += packed(WHOLE_TABLE.removesuffix(".gz"), (folder / WHOLE_TABLE).read_bytes())
    files += packed("worklet.js", (folder / "worklet.js").read_bytes())
    policy = POLICY.format(script=_hash(code), style=_hash(style))
    page = (folder / "index.html").read_text(encoding="utf-8")
    for pattern, text in (
        (r'content="default-src[^"]*"', f'content="{policy}"'),
        (LOADS, ""),
        (r'<link rel="stylesheet"[^>]*>', f"<style>{style}</style>"),
        (r'<script type="module"[^>]*></script>\n', f"{files}<script>{code}</script>\n"),
    ):
        page, count = re.subn(pattern, lambda _, text=text: text, page)
        if count != 1:
            raise ValueError(f"index.html has {count} times {pattern}")
    return page


def site_page(folder: Path) -> str:
    """index.html of the site."""
    modules = re.findall(r"^const \$([\w-]+) = ", script(folder), re.MULTILINE)
    links = [f'<link rel="modulepreload" href="{name}.js">\n' for name in modules]
    links += [f'<link rel="preload" href="{name}" as="fetch" crossorigin>\n' for name in PACKED[:3]]
    return (folder / "index.html").read_text(encoding="utf-8").replace(LOADS, "".join(links))


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def main() -> None:
    """Write the files."""
    folder = Path(sys.argv[1])
    (folder / "atari.html").write_text(one_file(folder), encoding="utf-8")
    (folder / "index.html").write_text(site_page(folder), encoding="utf-8")
    site = ["./", "page.css", *sorted(path.name for path in folder.glob("*.js") if path.name != "worker.js")]
    site += PACKED
    (folder / "files.json").write_text(json.dumps(site), encoding="utf-8")


if __name__ == "__main__":
    main()
