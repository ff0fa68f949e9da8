"""The effects of each byte in one state of a game: bytes are changed in copies of the state, and screens compared."""

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray, Core

_CHANGES = (1, 255, 8, 248, 128)
"""Added to a byte, modulo 256."""
_FRAMES = 2
_MOST_BYTES = 12

Mask = npt.NDArray[np.bool_]


def changed_pixels(core: Core, index: int) -> Mask:
    """The pixels that another value of a byte changes within the next frames, (height, 160) bool.

    The core plays and is restored; its state does not change. If the game rewrites the byte before it draws, no pixel
    changes.
    """
    state = core.clone_state(include_rng=True)
    value = int(core.ram()[index])
    try:
        twin = _screens(core)
        changed = np.zeros(core.game.screen.shape, np.bool_)
        for change in _CHANGES:
            core.restore_state(state)
            core.set_ram(index, (value + change) % 256)
            changed |= (_screens(core) != twin).any(axis=0)
        return changed
    finally:
        core.restore_state(state)


def causes_of(core: Core, x: int, y: int) -> list[int]:
    """The bytes that change a pixel or its nearest neighbours within the next frames.

    Bytes that change the pixel itself come first, then bytes that change few other pixels.
    """
    height, width = core.game.screen.shape
    rows, columns = slice(max(0, y - 1), min(height, y + 2)), slice(max(0, x - 1), min(width, x + 2))
    found = []
    for index in range(128):
        changed = changed_pixels(core, index)
        if changed[rows, columns].any():
            found.append((not changed[y, x], int(changed.sum()), index))
    return [index for *_, index in sorted(found)][:_MOST_BYTES]


def ahead(core: Core) -> ByteArray:
    """The screen after the next frame without input, (height, 160) palette indices. The state does not change."""
    state = core.clone_state(include_rng=True)
    try:
        core.act(0)
        return core.screen()
    finally:
        core.restore_state(state)


def _screens(core: Core) -> ByteArray:
    screens = []
    for _ in range(_FRAMES):
        core.act(0)
        screens.append(core.screen())
    return np.stack(screens)
