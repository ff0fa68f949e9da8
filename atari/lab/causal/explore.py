"""`causes` plays a game, forks many of its states, and compares forks with changed bytes to unchanged twins."""

from collections.abc import Callable
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

import atari._emulator as _emulator
from atari.base.validation import check_integer
from atari.cores.compiled import compiled
from atari.cores.native import NativeCore
from atari.lab.causal.fit import suggest
from atari.lab.causal.map import ByteCauses, CausalMap
from atari.roms import find
from atari.roms import image as rom_image
from atari.task.task import GameLike, resolve_frames

_LONGEST_EPISODE = 3000  # frames
_CALLS = 20  # to the engine, for progress
_MOST = 0.95  # part of the forks that makes a byte derived or inert
_SOME = 0.01  # part of the forks that makes an effect an effect of the byte
_CLEAR = 0.02  # part of the forks seen on the screen that makes a pixel a pixel of the byte

_COUNTS = np.dtype(
    [
        *((name, np.uint32) for name in "forks vanished inert rewritten seen rewarded lives over".split()),
        ("seen_at", np.uint32, 60),
        ("writes", np.uint32, 128),
        ("later", np.uint32, 128),
    ]
)
"""The numbers of a byte, in the order of `ByteCauses` in emulator/lab/causes.hpp."""


def causes(
    game: GameLike,
    states: int = 200,
    values: int = 4,
    frames: int = 4,
    seed: int = 0,
    *,
    mode: int | None = None,
    difficulty: int | None = None,
    threads: int = 1,
    policy: Callable[[NativeCore], int] | None = None,
    progress: Callable[[int], object] | None = None,
    rom: str | PathLike[str] | None = None,
) -> CausalMap:
    """The effects of each byte of a game's RAM, found by play.

    From `states` states of seeded play, each of the 128 bytes is changed to `values` values: one more or less, one bit
    flipped, then random ones. Each fork is played for up to `frames` frames beside an unchanged twin, with the same
    actions and the same random words. Its screens are compared until they differ first, the rest after each frame.

    Args:
        game: an ID, a game's name, the path of a game file, a `Game` or an `atari.Task`, of one player. Only its mode
            and its difficulty count: frames are played one by one, without sticky actions.
        states: states of the game, 1..5000, from several episodes.
        values: forks of each state and byte, 1..64.
        frames: frames of each fork, 1..60.
        seed: seed of the play and of the values.
        mode, difficulty: the game's mode and difficulty; None takes them from `game`.
        threads: number of threads, 1..256. The result does not depend on it.
        policy: chooses the actions, ALE's numbers 0..17, from the core at each frame; None plays at random, and holds
            each action for some frames.
        progress: is called with the number of states done since the last call.
        rom: path of the ROM file; None searches.

    Returns:
        A `CausalMap`. `bytes[i]` has the effects of byte i: `derived`, `inert`, `rewritten`, `seen`, `frames`,
        `reward`, `lives`, `over`, `writes`, `pixels` and `box`. `pixel(x, y)` returns the bytes that change a pixel.
        `suggestions` are probable meanings of bytes, and `suggestion.label()` is one as a line of a game file. The
        classes, in `atari.lab.causal.map`, document all fields; `atari.lab.causal.files` stores maps.

    Raises:
        TypeError, ValueError: a number outside its range, as `Task.of`, or the task has another field that changes the
            game, such as `interventions`.

    Example:
        >>> from atari.lab import causes
        >>> found = causes("pong", states=5, values=2)
        >>> found.bytes[49].seen > 0.5, found.bytes[49].rewritten < 0.5  # the ball's position is seen, and is no copy
        (True, True)
    """
    for name, number, high in (("states", states, 5000), ("values", values, 64), ("frames", frames, 60)):
        check_integer(name, number, 1, high)
    check_integer("threads", threads, 1, 256)
    task = resolve_frames(game, mode, difficulty, owner="causes")
    chosen: dict[str, Any] = {"mode": task.set_mode, "difficulty": task.set_difficulty}
    core = NativeCore(task.definition, seed=seed, repeat_action_probability=0.0, rom=rom, **chosen)
    saved, actions, ram, screen = _play(core, states, frames, seed, policy)
    image = rom_image.read_image(find(core.game, rom))
    engine = _emulator.Causes(game=compiled(core.game, image), values=values, frames=frames, threads=threads, seed=seed)
    step = max(states // _CALLS, 1)
    for first in range(0, states, step):
        part = saved[first : first + step]
        engine.explore(part, actions[first : first + step], first)
        if progress is not None:
            progress(len(part))
    counts, effects, pixels = engine.counts().view(_COUNTS)[:, 0], engine.effects(), engine.pixels()
    return CausalMap(
        game=core.game.id,
        height=len(screen),
        settings={
            **{"states": states, "values": values, "frames": frames, "seed": seed},
            **{name: value for name, value in chosen.items() if value is not None},
        },
        task=task,
        bytes=tuple(map(_byte, range(128), counts, pixels)),
        suggestions=suggest(effects, counts["forks"], counts["seen"]),
        pixel_counts=pixels,
        effects=effects,
        ram=ram,
        screen=screen,
    )


def _play(
    core: NativeCore, states: int, frames: int, seed: int, policy: Callable[[NativeCore], int] | None
) -> tuple[list[_emulator.State], NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8]]:
    """States of a game, the actions of the frames after each, their RAM, and the screen of one in the middle."""
    generator = np.random.default_rng(seed)
    choices = [int(action) for action in core.game.minimal_actions]
    saved: list[_emulator.State] = []
    actions, ram = np.zeros((states, frames), np.uint8), np.zeros((states, 128), np.uint8)
    screen = core.screen_rgb()
    held, held_frames, until_next = 0, 0, 60
    core.reset()
    while len(saved) < states:
        if policy is not None:
            held = policy(core)
        elif held_frames == 0:
            held, held_frames = int(generator.choice(choices)), int(generator.integers(1, 16))
        core.act(held)
        held_frames, until_next = max(held_frames - 1, 0), until_next - 1
        if core.game_over or core.episode_frame_number >= _LONGEST_EPISODE:
            core.reset()
        elif until_next <= 0:
            actions[len(saved)] = held
            core.ram(ram[len(saved)])
            saved.append(core.clone_state(include_rng=True))
            until_next = int(generator.integers(20, 70))
            if len(saved) == states // 2 + 1:
                screen = core.screen_rgb()
    return saved, actions, ram, screen


def _byte(index: int, counts: np.void, pixels: NDArray[np.uint16]) -> ByteCauses:
    """The effects of a byte, by its counts, a row of `_COUNTS`."""
    forks, seen, later = int(counts["forks"]), int(counts["seen"]), counts["later"].astype(np.int64)
    least = max(forks * _SOME, 2)
    return ByteCauses(
        index=index,
        derived=bool(counts["vanished"] >= _MOST * forks),
        inert=bool(counts["inert"] >= _MOST * forks),
        rewritten=round(int(counts["rewritten"]) / forks, 3),
        seen=round(seen / forks, 3),
        frames=int(counts["seen_at"].argmax()) + 1 if seen else 0,
        reward=bool(counts["rewarded"] >= least),
        lives=bool(counts["lives"] >= least),
        over=bool(counts["over"] >= least),
        writes=tuple(other for other in np.argsort(-later, kind="stable").tolist() if later[other] >= least),
        box=_box(pixels),
        pixels=pixels >= max(seen * _CLEAR, min(seen, 2), 1),
    )


def _box(pixels: NDArray[np.uint16]) -> tuple[int, int, int, int] | None:
    """The box around the pixels that changed at least a tenth as often as the most changed pixel."""
    rows, columns = np.nonzero(pixels >= max(pixels.max() / 10, 1))
    if not len(rows):
        return None
    left, top = int(columns.min()), int(rows.min())
    return left, top, int(columns.max()) + 1 - left, int(rows.max()) + 1 - top
