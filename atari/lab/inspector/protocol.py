"""The messages between the page and the session.

The session sends binary messages, one a frame:

    offset  type          content
    0       uint8         1, the version
    1       uint8         flags: 1 playing, 2 an agent plays, 4 the game is over, 8 the screen is a preview,
                          16 there is a fork, 32 the fork's screen is a preview
    2       uint16        height of the screen
    4       uint32 x 3    the present frame, the oldest and the newest one
    16      int32 x 2     score, and score of the fork
    24      uint16        lives
    26      uint16        number of histories, n
    28      uint32        version of the session's state (`state` below)
    32      128           RAM
    160     height * 160  screen, palette indices
            128, height * 160   the same for the fork, if there is one
            n * (2 + 240) for each history, byte index, number of values, and values, the newest last

All integers are little-endian. The other messages are JSON objects: to the page {"hello"}, {"state"}, {"objects"},
{"pixels"}, {"bytes"}, {"error"}, {"notice"}; to the session {"do": the name of a command, and its arguments}.
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
from atari.lab.inspector.session import HISTORY, SPEEDS, Session

VERSION = 1
_HEAD = struct.Struct("<BBH3I2iHHI")
_MOST_BYTES, _MOST_DEPTH = 4096, 4
MOST_PLACES = 40
"""The number of places of a search that are sent."""


def hello(session: Session) -> dict[str, Any]:
    """The message with all that is fixed during a session."""
    game = session.game
    return {
        "hello": {
            "game": game.id,
            "title": game.title,
            "height": game.screen.height,
            "palette": base64.b64encode(_emulator.palette(game.screen.format).tobytes()).decode(),
            "labels": session.readings.names,
            "facts": session.readings.facts(),
            "speeds": SPEEDS,
            "history": HISTORY,
            "agent": None if session.agent is None else session.agent.name,
        }
    }


def state(session: Session) -> dict[str, Any]:
    """The message with all that only commands change."""
    search = session.search
    return {
        "state": {
            "speed": session.speed,
            "frozen": session.frozen,
            "watched": session.watched,
            "selected": session.selected,
            "names": session.names,
            "changes": [vars(change) for change in session.changes[-20:]],
            "search": {
                "candidates": search.candidates if search.filters else [],
                "places": [[str(place), list(place.bytes)] for place in search.places[:MOST_PLACES]],
                "left": len(search.places),
                "before": session.searched.tolist(),
                "applied": [each.call for each in search.filters],
            },
        }
    }


def frame(session: Session) -> bytes:
    """The binary message of the present frame."""
    main, fork = session.main, session.fork
    screen, preview = session.screen(main)
    parts = [main.core.ram().tobytes(), screen.tobytes()]
    flags = session.playing | session.by_agent << 1 | session.over << 2 | preview << 3
    if fork is not None:
        screen, preview = session.screen(fork)
        parts += [fork.core.ram().tobytes(), screen.tobytes()]
        flags |= 16 | preview << 5
    shown = session.watched if session.selected is None else [session.selected, *session.watched]
    for index in shown:
        values = session.shown.history(index, HISTORY)
        parts.append(bytes((index, len(values))) + values.tobytes().ljust(HISTORY, b"\0"))
    head = _HEAD.pack(
        VERSION,
        flags,
        session.game.screen.height,
        main.at,
        main.first,
        main.end,
        main.score,
        fork.score if fork else 0,
        min(main.core.lives, 65535),
        len(shown),
        session.version % 2**32,
    )
    return b"".join([head, *parts])


def overlay(session: Session) -> dict[str, Any]:
    """The objects on the screen and the values of labels."""
    values, objects = session.readings.read(session.ram())
    return {"objects": objects, "values": values}


def news(session: Session, known: str) -> tuple[str, list[dict[str, Any]]]:
    """The state as JSON, and the messages after a frame to a page with the state `known`. Clears error and notice."""
    shown, present = overlay(session), json.dumps(state(session))
    messages = [shown] if any(shown.values()) else []
    if present != known:
        messages.append(json.loads(present))
    messages += [{kind: text} for kind in ("error", "notice") if (text := getattr(session, kind))]
    session.error = session.notice = ""
    return present, messages


_BYTE = int | None

_COMMANDS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "play": (Session.play, {}),
    "pause": (Session.pause, {}),
    "step": (Session.step, {"frames": int}),
    "seek": (Session.seek, {"frame": int}),
    "take_over": (Session.take_over, {}),
    "new_game": (Session.new_game, {}),
    "speed": (Session.set_speed, {"speed": float}),
    "hold": (Session.hold, {"vertical": int, "horizontal": int, "fire": bool}),
    "agent": (Session.let_agent_play, {"on": bool}),
    "poke": (Session.poke, {"index": int, "value": int}),
    "freeze": (Session.freeze, {"index": int, "value": _BYTE}),
    "release": (Session.release, {"index": int}),
    "undo": (Session.undo, {}),
    "name": (Session.name, {"index": int, "name": str}),
    "fork": (Session.open_fork, {}),
    "close_fork": (Session.close_fork, {"keep": bool}),
    "select": (Session.select, {"index": _BYTE}),
    "watch": (Session.watch, {"index": int, "on": bool}),
    "new_search": (Session.new_search, {}),
    "filter": (Session.filter, {"name": str, "low": int, "high": int}),
    "undo_filter": (Session.undo_filter, {}),
    "pixels": (Session.pixels_of, {"index": int}),
    "bytes": (Session.bytes_of, {"x": int, "y": int}),
}
"""The method and the types of the arguments, by the name of a command."""


def run(session: Session, text: str) -> list[dict[str, Any]]:
    """Run a command of the page, and return the answers. A command that fails is answered by its error."""
    try:
        name, arguments = _parse(text)
        if name not in ("pixels", "bytes"):  # these two change nothing that the page shows
            session.version += 1
        result = _COMMANDS[name][0](session, **arguments)
    except (TypeError, ValueError, RuntimeError) as error:
        return [{"error": str(error)}]
    except Exception as error:  # no mistake of the user
        session.fail(error)
        return []
    answers: list[dict[str, Any]] = []
    if name == "pixels":
        pixels, source = result
        bits = base64.b64encode(np.packbits(pixels).tobytes()).decode()
        count = int(pixels.sum())
        answers.append({"pixels": {"index": arguments["index"], "count": count, "source": source, "bits": bits}})
    elif name == "bytes":
        found, elsewhere = result
        answers.append({"bytes": {**arguments, "found": found, "elsewhere": elsewhere}})
    return answers


def _parse(text: str) -> tuple[str, dict[str, Any]]:
    """The name and the arguments of a command.

    Raises:
        ValueError: `text` is no command.
    """
    message = json_text.parse(text, "a command", most_bytes=_MOST_BYTES, most_depth=_MOST_DEPTH)
    name = message.pop("do", None) if isinstance(message, dict) else None
    if not isinstance(name, str) or name not in _COMMANDS:
        raise ValueError(f"a command is a JSON object whose `do` is one of {', '.join(_COMMANDS)}")
    method, kinds = _COMMANDS[name]
    parameters = signature(method).parameters
    required = {key: kind for key, kind in kinds.items() if parameters[key].default is Parameter.empty}
    return name, check_table(message, f"the command {name}", required, kinds)
