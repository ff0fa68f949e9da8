"""The messages between the page and the inspection.

The inspection sends binary messages, one a frame:

    offset  type          content
    0       uint8         1, the version
    1       uint8         flags: 1 playing, 2 an agent plays, 4 the game is over, 8 the screen is a preview,
                          16 there is a fork, 32 the fork's screen is a preview
    2       uint16        height of the screen
    4       uint32 x 3    the present frame, the oldest and the newest one
    16      int32 x 2     score, and score of the fork
    24      uint16        lives
    26      uint16        number of histories, n
    28      uint32        version of the inspection's state (`state` below)
    32      128           RAM
    160     height * 160  screen, palette indices
            128, height * 160   the same for the fork, if there is one
            n * (2 + 240) for each history, byte index, number of values, and values, the newest last

All integers are little-endian. The other messages are JSON objects: to the page {"hello"}, {"state"}, {"objects"},
{"pixels"}, {"bytes"}, {"error"}, {"notice"}; to the inspection {"do": the name of a command, and its arguments}.
"""

import base64
import json
import struct
from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any

import numpy as np

import atari._emulator as _emulator
from atari.base import json_text
from atari.base.typed_table import check_table
from atari.lab.inspector.inspection import HISTORY, SPEEDS, Inspection

VERSION = 1
_HEAD = struct.Struct("<BBH3I2iHHI")
_MOST_BYTES, _MOST_DEPTH = 4096, 4
MOST_PLACES = 40
"""The number of places of a search that are sent."""


def hello(inspection: Inspection) -> dict[str, Any]:
    """The message with all that is fixed during an inspection."""
    game = inspection.game
    return {
        "hello": {
            "game": game.id,
            "title": game.title,
            "height": game.screen.height,
            "palette": base64.b64encode(_emulator.palette(game.screen.format).tobytes()).decode(),
            "labels": inspection.readings.names,
            "facts": inspection.readings.facts(),
            "interventions": {name: one.description for name, one in inspection.interventions.items()},
            "task_interventions": {one.name: one.description for one in inspection.env.interventions},
            "speeds": SPEEDS,
            "history": HISTORY,
            "agent": None if inspection.agent is None else inspection.agent.name,
        }
    }


def state(inspection: Inspection) -> dict[str, Any]:
    """The message with all that only commands change."""
    search = inspection.search
    return {
        "state": {
            "speed": inspection.speed,
            "frozen": inspection.frozen,
            "interventions": [*inspection.active.added],
            "watched": inspection.watched,
            "selected": inspection.selected,
            "names": inspection.names,
            "changes": [vars(change) for change in inspection.changes[-20:]],
            "search": {
                "candidates": search.candidates if search.filters else [],
                "places": [[str(place), list(place.bytes)] for place in search.places[:MOST_PLACES]],
                "left": len(search.places),
                "before": inspection.searched.tolist(),
                "applied": [each.call for each in search.filters],
            },
        }
    }


def frame(inspection: Inspection) -> bytes:
    """The binary message of the present frame."""
    main, fork = inspection.main, inspection.fork
    screen, preview = inspection.screen(main)
    parts = [main.core.ram().tobytes(), screen.tobytes()]
    flags = inspection.playing | inspection.by_agent << 1 | inspection.over << 2 | preview << 3
    if fork is not None:
        screen, preview = inspection.screen(fork)
        parts += [fork.core.ram().tobytes(), screen.tobytes()]
        flags |= 16 | preview << 5
    shown = inspection.watched if inspection.selected is None else [inspection.selected, *inspection.watched]
    for index in shown:
        values = inspection.active.history(index, HISTORY)
        parts.append(bytes((index, len(values))) + values.tobytes().ljust(HISTORY, b"\0"))
    head = _HEAD.pack(
        VERSION,
        flags,
        inspection.game.screen.height,
        main.at,
        main.first,
        main.end,
        main.score,
        fork.score if fork else 0,
        min(main.core.lives, 65535),
        len(shown),
        inspection.version % 2**32,
    )
    return b"".join([head, *parts])


def overlay(inspection: Inspection) -> dict[str, Any]:
    """The objects on the screen and the values of labels."""
    values, objects = inspection.readings.read(inspection.ram())
    return {"objects": objects, "values": values}


def news(inspection: Inspection, known: str) -> tuple[str, list[dict[str, Any]]]:
    """The state as JSON, and the messages after a frame to a page with the state `known`. Clears error and notice."""
    shown, present = overlay(inspection), json.dumps(state(inspection))
    messages = [shown] if any(shown.values()) else []
    if present != known:
        messages.append(json.loads(present))
    messages += [{kind: text} for kind in ("error", "notice") if (text := getattr(inspection, kind))]
    inspection.error = inspection.notice = ""
    return present, messages


_COMMANDS: dict[str, Callable[..., Any]] = {
    **{
        name: getattr(Inspection, name)
        for name in (
            "play pause step seek take_over new_game hold poke freeze release intervene undo name close_fork select "
            "watch new_search filter undo_filter"
        ).split()
    },
    "speed": Inspection.set_speed,
    "agent": Inspection.let_agent_play,
    "fork": Inspection.open_fork,
    "pixels": Inspection.pixels_of,
    "bytes": Inspection.bytes_of,
}
"""The method of a command. The annotations of its parameters are the types of the command's arguments."""


def run(inspection: Inspection, text: str) -> list[dict[str, Any]]:
    """Run a command of the page, and return the answers. A command that fails is answered by its error."""
    try:
        name, arguments = _parse(text)
        if name not in ("pixels", "bytes"):  # these two change nothing that the page shows
            inspection.version += 1
        result = _COMMANDS[name](inspection, **arguments)
    except (TypeError, ValueError, RuntimeError) as error:
        return [{"error": str(error)}]
    except Exception as error:  # no mistake of the user
        inspection.fail(error)
        return []
    if name == "pixels":
        pixels, source = result
        bits = base64.b64encode(np.packbits(pixels).tobytes()).decode()
        return [{"pixels": {**arguments, "count": int(pixels.sum()), "source": source, "bits": bits}}]
    if name == "bytes":
        return [{"bytes": {**arguments, "found": result[0], "elsewhere": result[1]}}]
    return []


def _parse(text: str) -> tuple[str, dict[str, Any]]:
    message = json_text.parse(text, "a command", most_bytes=_MOST_BYTES, most_depth=_MOST_DEPTH)
    name = message.pop("do", None) if isinstance(message, dict) else None
    if not isinstance(name, str) or name not in _COMMANDS:
        raise ValueError(f"a command is a JSON object whose `do` is one of {', '.join(_COMMANDS)}")
    _, *parameters = signature(_COMMANDS[name]).parameters.values()  # the first is the inspection
    kinds = {each.name: each.annotation for each in parameters}
    required = {each.name: each.annotation for each in parameters if each.default is Parameter.empty}
    return name, check_table(message, f"the command {name}", required, kinds)
