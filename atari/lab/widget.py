"""`show`: the inspector in a notebook, as a widget; a static picture where no widget runs.

A page that nbconvert writes has the widget's state and no kernel, and would show nothing. So a cell shows the picture
and the widget, and the widget hides the picture as soon as a kernel answers it.
"""

import asyncio
import contextlib
import html
import json
import re
import time
from collections.abc import Callable
from importlib import import_module, resources
from pathlib import Path
from typing import Any

import gymnasium

from atari.base.notebook import image
from atari.base.png import png
from atari.lab.inspector import export, protocol
from atari.lab.inspector.inspection import FRAMES_PER_SECOND, Inspection

_MODULES = ("dom.js", "screen.js", "bytes.js", "panels.js", "touch.js", "inspector.js", "widget.js")


def show(env: gymnasium.Env[Any, Any], *, agent: Any = None) -> Any:
    """Show the inspector of an environment in a notebook.

    With anywidget (extra `lab`) and a running notebook it is the inspector of `atari lab`: it plays the environment's
    core when its Play is pressed. Otherwise, also in the HTML that nbconvert writes, it is a picture of the screen and
    a table of the RAM.

    Args:
        env: an `AtariEnv` in any wrappers; wrappers do not see the frames that are played here.
        agent: an agent that plays instead of a person; see `atari.lab.inspector.inspection.Agent`.

    Returns:
        An object that the notebook shows. Its `inspection` is the `Inspection`, its `export(folder)` writes labels,
        interventions and the replay.

    Raises:
        TypeError: `env` is no `AtariEnv`.
    """
    inspection = Inspection(env, agent=agent)
    made = _widget_class()
    return StaticInspector(inspection) if made is None else made(inspection)


class StaticInspector:
    """A picture of the present state of an inspection: the screen, and the bytes with their names."""

    def __init__(self, inspection: Inspection) -> None:
        self.inspection = inspection

    def export(self, folder: str | Path) -> list[Path]:
        """Write the inspection's labels, interventions and replay into a folder; see `export_all`."""
        return export_all(self.inspection, Path(folder))

    def _repr_html_(self) -> str:
        return static_html(self.inspection)


def export_all(inspection: Inspection, folder: Path) -> list[Path]:
    """Write the inspection's labels, interventions and replay, if it has them, into a folder, and return the files.

    Raises:
        OSError: a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name in export.NAMES:
        path = folder / (f"{inspection.game.id}.a26r" if name == "replay.a26r" else f"{inspection.game.id}-{name}")
        with contextlib.suppress(ValueError):  # nothing to export
            export.write(inspection, name, path)
            files.append(path)
    return files


def static_html(inspection: Inspection) -> str:
    """The screen as a picture and the RAM as a table, without scripts."""
    core = inspection.active.core
    ram = core.ram()
    cell = "padding:1px 4px;text-align:center;font:12px monospace"
    columns = "".join(f'<th style="{cell};opacity:.6">{column:X}</th>' for column in range(16))
    rows = [f"<tr><th></th>{columns}</tr>"]
    for row in range(0, 128, 16):
        cells = [f'<th style="{cell};opacity:.6">{128 + row:02X}</th>']
        for index in range(row, row + 16):
            name = inspection.names.get(index) or next(iter(inspection.readings.names.get(index, ())), "")
            title = html.escape(f"byte {index}: {name}" if name else f"byte {index}", quote=True)
            weight = ";font-weight:bold" if name else ""
            cells.append(f'<td style="{cell}{weight}" title="{title}">{ram[index]:02X}</td>')
        rows.append(f"<tr>{''.join(cells)}</tr>")
    screen = image(png(core.screen_rgb()), f"the screen of {inspection.game.title}", inspection.game.screen.shape)
    return (
        f'<div style="display:flex;flex-wrap:wrap;gap:16px">{screen}<table>{"".join(rows)}</table></div>'
        f"<p>{html.escape(inspection.game.title)}, frame {inspection.at}, score {inspection.main.score}, "
        f"lives {core.lives}</p>"
    )


def bundle() -> str:
    """The front end as one JavaScript module, as anywidget takes it.

    The modules of the page import only each other and declare different names, so that their texts can be joined.
    """
    static = resources.files("atari.lab.inspector") / "static"
    text = "\n".join((static / name).read_text(encoding="utf-8") for name in _MODULES)
    text = re.sub(r"^import .*;\n", "", text, flags=re.MULTILINE)
    return re.sub(r"^export (?!default)", "", text, flags=re.MULTILINE)


def _widget_class() -> "Callable[[Inspection], Any] | None":
    try:
        import anywidget
    except ImportError:
        return None
    static = resources.files("atari.lab.inspector") / "static"

    class InspectorWidget(anywidget.AnyWidget):
        """The inspector in a notebook."""

        _esm = bundle()
        _css = (static / "inspector.css").read_text(encoding="utf-8")

        def __init__(self, inspection: Inspection) -> None:
            super().__init__()
            self.inspection = inspection
            self._players: asyncio.Task[None] | None = None
            self._known_state = ""  # the state that the front end has
            self._picture = f"atari-lab-{self.model_id}"  # the HTML id of the static picture
            self.on_msg(self._receive)

        def export(self, folder: str | Path) -> list[Path]:
            """Write the inspection's labels, interventions and replay into a folder; see `export_all`."""
            return export_all(self.inspection, Path(folder))

        def _ipython_display_(self) -> None:
            cell: Any = import_module("IPython.display")  # anywidget needs it
            cell.display(cell.HTML(f'<div id="{self._picture}">{static_html(self.inspection)}</div>'))
            shown = self._repr_mimebundle_()
            cell.display(shown[0] if isinstance(shown, tuple) else shown, raw=True)

        def _receive(self, widget: Any, message: Any, buffers: Any) -> None:
            """Run a message of the front end: its first, or a command."""
            if isinstance(message, dict) and message.get("do") == "open":
                self.send({**protocol.hello(self.inspection), "picture": self._picture})
                self._known_state = ""
                self._show()
                return
            for answer in protocol.run(self.inspection, json.dumps(message)):
                self.send(answer)
            self._show()
            if self.inspection.playing and (self._players is None or self._players.done()):
                self._players = asyncio.get_event_loop().create_task(self._play())

        async def _play(self) -> None:
            before = time.perf_counter()
            while self.inspection.playing:
                await asyncio.sleep(1 / FRAMES_PER_SECOND)
                now = time.perf_counter()
                self.inspection.tick(now - before)
                before = now
                self._show()

        def _show(self) -> None:
            try:
                self.send({"frame": 1}, [protocol.frame(self.inspection)])
                self._known_state, messages = protocol.news(self.inspection, self._known_state)
                for message in messages:
                    self.send(message)
            except Exception as error:
                self.inspection.fail(error)
                self.send({"error": self.inspection.error})

    return InspectorWidget
