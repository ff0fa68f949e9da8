"""The part of the contract of cores that concerns snapshots and cloned states."""

import random
from typing import Any

from atari.cores import Core
from atari.testing.contract import refuses, require, require_same
from atari.testing.core_play import FIRE, NOOP, MakeCore, made, new, play, players_of, some_actions, unchanged, visible


def check_snapshots(make: MakeCore, steps: int) -> None:
    """Check that a snapshot taken at any time continues exactly, and that an invalid one changes nothing."""
    for sound in (False, True):
        _check_continuation(make, steps // 2, sound)
    _check_phases(make, steps // 2)
    _check_taking(make, steps // 2)
    _check_reset(make, steps // 2)
    _check_damage(make)
    _check_other_options(make)
    _check_clones(make, steps)


def _check_continuation(make: MakeCore, steps: int, sound: bool) -> None:
    core = made(make, seed=4, sound=sound)
    play(core, some_actions(core, steps))
    core.reset()
    play(core, some_actions(core, steps, seed=1))
    saved, seen = core.snapshot(), visible(core)
    require(type(saved) is bytes, f"snapshot() must return bytes, got {type(saved).__name__}")
    actions = some_actions(core, steps, seed=2)
    expected = play(core, actions)
    other = new(make, seed=99, sound=sound)
    for target, place in ((core, "in the same core"), (other, "in a new core of another seed")):
        target.restore(saved)
        require_same(seen, visible(target), "the core", f"restore() {place} must bring the visible state back")
        require(target.snapshot() == saved, f"after restore() {place}, snapshot() must return what was restored")
        require_same(expected, play(target, actions), "play", f"a restored snapshot must continue exactly {place}")


def _check_phases(make: MakeCore, steps: int) -> None:
    """Check snapshots before the first reset, and after a byte of RAM was set."""
    for phase in ("before the first reset", "after set_ram"):
        core = new(make, seed=1)
        if phase == "after set_ram":
            core.reset()
            core.act(FIRE, 0.3)
            core.set_ram(100, 3)
        saved = core.snapshot()
        expected = play(core, some_actions(core, steps))
        core.restore(saved)
        seen = play(core, some_actions(core, steps))
        require_same(expected, seen, "play", f"a snapshot taken {phase} must continue exactly")


def _check_taking(make: MakeCore, steps: int) -> None:
    watched, alone = made(make), made(make)
    actions = some_actions(watched, steps)
    for action in actions:
        watched.snapshot()
        watched.act(action)
    play(alone, actions)
    require_same(visible(alone), visible(watched), "the core", "snapshot() must not change the game")


def _check_reset(make: MakeCore, steps: int) -> None:
    """Check that a snapshot keeps the RAM and the generators that a reset depends on."""
    first, second = made(make, seed=1), made(make, seed=2)
    play(first, some_actions(first, steps))
    second.restore(first.snapshot())
    first.reset()
    second.reset()
    require_same(visible(first), visible(second), "the core", "a reset after restore() must be that of the snapshot")


def _check_damage(make: MakeCore) -> None:
    core = made(make)
    core.act(FIRE)
    good, draw = core.snapshot(), random.Random(0)
    cut = {f"a snapshot cut to {size} bytes": good[:size] for size in (8, len(good) // 2, len(good) - 1)}
    flipped = {}
    for place in draw.sample(range(len(good)), min(40, len(good))):
        bad = bytearray(good)
        bad[place] ^= 1 << place % 8
        flipped[f"a snapshot with a bit of byte {place} flipped"] = bytes(bad)
    for kind, data in (cut | flipped | {"a snapshot with a byte more": good + b"\0"}).items():
        with refuses(f"restore() of {kind}", ValueError):
            core.restore(data)
    with unchanged(core, "restore() of a damaged snapshot"), refuses("restore() of half a snapshot", ValueError):
        core.restore(good[: len(good) // 2])


def _check_other_options(make: MakeCore) -> None:
    core = made(make)
    others: dict[str, Any] = {"repeat_action_probability": 0.5}
    if players_of(core) == 1:  # a replay of several players plays with sound, and frame by frame, from any snapshot
        others |= {"frame_skip": 2, "sound": True}
    for name, value in others.items():
        other = made(make, **{name: value})
        call = f"restore() of a snapshot of a core made with {name}={value}"
        with unchanged(core, call), refuses(call, ValueError):
            core.restore(other.snapshot())


def _check_clones(make: MakeCore, steps: int) -> None:
    """Check RAM and numbers of cloned states: like ale-py's, a state may leave the framebuffer out."""
    core = made(make, seed=1, repeat_action_probability=0.5)
    play(core, some_actions(core, steps))
    actions = [NOOP, *some_actions(core, steps, seed=1)]
    _release(core)
    state, before = core.clone_state(include_rng=True), _numbers(core)
    expected = _trace(core, actions)
    for _ in range(2):
        _release(core)
        core.restore_state(state)
        require_same(before, _numbers(core), "the core", "restore_state() must bring RAM, lives and counters back")
        seen = _trace(core, actions)
        require_same(expected, seen, "play", "a cloned state with its generators must continue exactly")


def _release(core: Core) -> None:
    """Play NOOP until sticky actions hold it: a cloned state may leave the held action out."""
    for _ in range(20):
        core.act(NOOP)


def _numbers(core: Core) -> dict[str, Any]:
    names = ("lives", "frame_number", "episode_frame_number")
    return {"ram": core.ram(), **{name: getattr(core, name) for name in names}}


def _trace(core: Core, actions: list[int]) -> list[dict[str, Any]]:
    return [{"reward": core.act(action), **_numbers(core)} for action in actions]
