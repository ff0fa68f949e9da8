"""Causal maps in files: `save`, `load`, and `shipped_causes`, which loads the package's map of a game."""

import io
import json
import zipfile
import zlib
from dataclasses import asdict
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from atari.base import archives, durable, json_text
from atari.base.typed_table import check_table
from atari.base.validation import check_file
from atari.games.catalog import games
from atari.games.game import Game
from atari.lab.causal.map import ByteCauses, CausalMap, Suggestion

DATA = Path(__file__).parent / "data"
"""The folder of the maps of all games, a file each: `<id>.npz`."""

_FORMAT = 1
_MOST_BYTES = 1 << 20
_FACTS = {"format": int, "game": str, "height": int, "settings": dict, "suggestions": list}
_SUGGESTION = (
    "a suggestion",
    {"index": int, "kind": str, "support": int, "share": float},
    {"transform": str, "width": int, "height": int, "weight": int, "encoding": str},
)
_FLAGS = ("derived", "inert", "reward", "lives", "over")
_CELL_ROWS, _CELL_COLUMNS = 4, 4  # pixels of a cell: files store which cells a byte changes


def to_arrays(causal_map: CausalMap) -> dict[str, NDArray[np.generic]]:
    """The essence of a map, as `save` writes it: pixels in cells, without counts of pixels and effects of forks."""
    numbers, cells = [], []
    for byte in causal_map.bytes:
        flags = (getattr(byte, name) for name in _FLAGS)
        shares = (round(1000 * byte.rewritten), round(1000 * byte.seen))
        numbers.append([*flags, *shares, byte.frames, len(byte.writes), *(byte.box or (0, 0, 0, 0))])
        cells.append(_cells(byte.pixels))
    facts = {
        "format": _FORMAT,
        "game": causal_map.game,
        "height": causal_map.height,
        "settings": dict(causal_map.settings),
        "suggestions": [
            {key: value for key, value in asdict(each).items() if value is not None} for each in causal_map.suggestions
        ],
    }
    text = json.dumps(facts, separators=(",", ":")).encode()
    return {
        "facts": np.frombuffer(text, np.uint8),
        "numbers": np.array(numbers, np.uint16).T,
        "writes": np.array([other for byte in causal_map.bytes for other in byte.writes], np.uint8),
        "cells": np.packbits(np.stack(cells), axis=None),
    }


def save(causal_map: CausalMap, file: str | PathLike[str]) -> None:
    """Write the essence of a map to a file that `load` and `numpy.load` read, about 4 kB."""
    memory = io.BytesIO()
    np.savez_compressed(memory, allow_pickle=False, **to_arrays(causal_map))
    durable.write_file(Path(file), memory.getvalue())


def load(file: str | PathLike[str]) -> CausalMap:
    """The map in a file that `save` wrote.

    Raises:
        OSError: the file cannot be read.
        ValueError: the file is not a causal map of this version.
    """
    path = check_file(Path(file))
    if path.stat().st_size > _MOST_BYTES:
        raise ValueError(f"{path} is not a causal map: it has more than {_MOST_BYTES} bytes")
    wrong = f"{path} is not a causal map of this version"
    try:
        with zipfile.ZipFile(path) as archive:
            return _from_arrays({name: _array(archive, name) for name in ("facts", "numbers", "writes", "cells")})
    except (TypeError, ValueError, IndexError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"{wrong}: {error}; write it again by `atari causes`") from None


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """An array; its shape is checked before memory is allocated for it, which `numpy.load` does not do."""
    file = io.BytesIO(archives.read_member(archive, f"{name}.npy", _MOST_BYTES))
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError(f"{name!r} has another version of NumPy's format")
    shape, by_columns, dtype = np.lib.format.read_array_header_1_0(file)
    return np.frombuffer(file.read(), dtype).reshape(shape, order="F" if by_columns else "C")


def _from_arrays(arrays: dict[str, NDArray[Any]]) -> CausalMap:
    facts = json_text.parse(arrays["facts"].tobytes(), "JSON")
    if not isinstance(facts, dict) or facts.get("format") != _FORMAT:
        raise ValueError(f"its format is not {_FORMAT}, which this version reads")
    check_table(facts, "its facts", _FACTS)
    height, numbers, writes = facts["height"], arrays["numbers"], arrays["writes"]
    fits = 200 <= height <= 256 and numbers.shape == (13, 128)
    if not fits or len(writes) != numbers[8].sum() or (writes > 127).any():
        raise ValueError("its parts do not fit each other")
    shape = (128, -(-height // _CELL_ROWS), 160 // _CELL_COLUMNS)
    if arrays["cells"].shape != (-(-int(np.prod(shape)) // 8),):
        raise ValueError("its pixels do not fit its height")
    cells = np.unpackbits(arrays["cells"], count=int(np.prod(shape))).reshape(shape).astype(np.bool_)
    pixels = cells.repeat(_CELL_ROWS, 1).repeat(_CELL_COLUMNS, 2)[:, :height]
    ends = numbers[8].astype(np.int64).cumsum()
    found = []
    for index, row in enumerate(numbers.T.tolist()):
        flags, (rewritten, seen, frames, count, *box) = row[: len(_FLAGS)], row[len(_FLAGS) :]
        found.append(
            ByteCauses(
                index=index,
                **{name: bool(flag) for name, flag in zip(_FLAGS, flags, strict=True)},
                rewritten=rewritten / 1000,
                seen=seen / 1000,
                frames=frames,
                writes=tuple(writes[ends[index] - count : ends[index]].tolist()),
                box=(box[0], box[1], box[2], box[3]) if box[2] else None,
                pixels=pixels[index],
            )
        )
    suggestions = tuple(Suggestion(**check_table(each, *_SUGGESTION)) for each in facts["suggestions"])
    return CausalMap(facts["game"], height, facts["settings"], tuple(found), suggestions)


def _cells(pixels: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The cells of a screen in which a pixel is set."""
    rows = -(-len(pixels) // _CELL_ROWS)
    padded = np.zeros((rows * _CELL_ROWS, 160), np.bool_)
    padded[: len(pixels)] = pixels
    return np.asarray(padded.reshape(rows, _CELL_ROWS, -1, _CELL_COLUMNS).any((1, 3)))


@lru_cache(maxsize=16)
def _shipped(game_id: str) -> CausalMap:
    return load(DATA / f"{game_id}.npz")


def shipped_causes(game: str | Game) -> CausalMap:
    """The package's map of a game, as `causes` returns it with its default arguments.

    Its pixels are rounded to cells of 4 x 4, and it has no `pixel_counts`, `effects`, `ram`, `screen` and `task`.

    Raises:
        ValueError: the package has no map of this game; `causes` makes one.

    Example:
        >>> import atari
        >>> from atari.lab import shipped_causes
        >>> label = atari.games["pong"].ram_labels["score_player"]
        >>> byte = shipped_causes("pong").bytes[label.index]
        >>> byte.seen, byte.reward
        (1.0, True)
    """
    found = games.resolve(game)
    if not (DATA / f"{found.id}.npz").is_file():
        raise ValueError(f"the package has no causal map of {found.id}; make one by atari.lab.causes")
    return _shipped(found.id)
