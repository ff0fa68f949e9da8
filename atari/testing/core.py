"""`check_core`: the contract of `atari.cores.Core`, for authors of cores."""

from typing import Any

import numpy as np

from atari.cores import Core
from atari.games.game import Game
from atari.games.players import choices
from atari.testing.contract import broken_by, check_maker, refuses, require, require_same
from atari.testing.core_play import (
    ARRAYS,
    FIRE,
    NOOP,
    NUMBERS,
    MakeCore,
    made,
    new,
    play,
    players_of,
    shape_of,
    some_actions,
    unchanged,
    visible,
)
from atari.testing.core_snapshots import check_snapshots

LIMITS = (10, 1002)
"""Limits of frames; games that select their mode by playing do not accept the first."""


def check_core(make: MakeCore, *, reference: MakeCore | None = None, steps: int = 60) -> None:
    """Check that cores keep the contract of `atari.cores.Core`.

    A core for several players has their number as `players`, and `act_players`; `act` plays player 1's action, and NOOP
    of the others.

    The checks cover arrays and `out`, counters, limits and ends, seeds and sticky actions, modes, RAM, snapshots and
    cloned states, `close`, and arguments that must be refused before anything changes.

    Args:
        make: a function that makes a core of one game. It takes the options of a core by name: `seed`, `frame_skip`,
            `repeat_action_probability`, `mode`, `difficulty`, `max_num_frames_per_episode`, `sound`.
        reference: such a function for another core; frames, rewards, lives and ends must be the same.
        steps: number of random actions in a comparison.

    Raises:
        ContractError: the core breaks the contract; the message has the call, and the expected and the actual result.
        TypeError: `make` is no function.

    Example:
        >>> from functools import partial
        >>> from atari.cores import NativeCore, PlainCore
        >>> from atari.testing import check_core
        >>> check_core(partial(NativeCore, "pong"), reference=partial(PlainCore, "pong"))
    """
    check_maker("check_core", make, "MyCore(game, **options)")
    if reference is not None:
        check_maker("check_core", reference, "NativeCore(game, **options)")
    for check in (_check_new, _check_arrays, _check_out, _check_screens, _check_sound, _check_memory, _check_choices):
        check(make)
    for check in (_check_counters, _check_actions, _check_players):
        check(make)
    for check_play in (_check_seeds, _check_frame_skip, check_snapshots):
        check_play(make, steps)
    for check in (_check_end, _check_refusals, _check_close):
        check(make)
    if reference is not None:
        _check_reference(make, reference, steps)


def _check_new(make: MakeCore) -> None:
    core = new(make)
    members = [name for name in (*Core.__annotations__, *vars(Core)) if not name.startswith("_")]
    lacking = [name for name in members if not hasattr(core, name)]
    require(not lacking, f"{type(core).__name__} has no {', '.join(lacking)}; see atari.cores.Core")
    require(isinstance(core.name, str) and core.name, f"name must be a text, got {core.name!r}")
    require(isinstance(core.game, Game), f"game must be an atari.games.Game, got {core.game!r}")
    require(core.sound is False, f"sound must be False unless requested, got {core.sound!r}")
    for name in ("game_over", "truncated"):
        require(getattr(core, name) is False, f"{name} of a new core must be False, got {getattr(core, name)!r}")
    before = core.frame_number
    core.act(NOOP)
    added = core.frame_number - before
    require(added == 1, f"the first act of a new core must add 1 to frame_number, added {added}")


def _check_arrays(make: MakeCore) -> None:
    core = made(make)
    for name in ARRAYS:
        first = getattr(core, name)()
        _require_array(core, name, first)
        before = first.copy()
        first += 1
        require_same(before, getattr(core, name)(), name, f"an array of {name}() must belong to the caller")
    with unchanged(core, "redraw()"):
        try:
            drawn = core.redraw()
        except NotImplementedError:
            return
        _require_array(core, "screen_rgb", drawn)


def _require_array(core: Core, name: str, array: Any) -> None:
    shape = shape_of(core, name)
    fits = isinstance(array, np.ndarray) and (array.shape, array.dtype) == (shape, np.uint8)
    seen = f"{array.dtype} {array.shape}" if isinstance(array, np.ndarray) else f"{array!r:.60}"
    require(fits and array.flags.c_contiguous, f"{name}() must return a contiguous uint8 array {shape}, got {seen}")


def _check_out(make: MakeCore) -> None:
    core = made(make, sound=True)
    core.act(FIRE)
    for name in ARRAYS:
        shape, method = shape_of(core, name), getattr(core, name)
        out = np.full(shape, 77, np.uint8)
        require(method(out=out) is out, f"{name}(out) must return out")
        require_same(method(), out, "out", f"{name}(out) must fill out")
        for fault, bad in _bad_outs(shape).items():
            with refuses(f"{name}(out) with an out that is {fault}", ValueError):
                method(bad)
            require(np.all(np.asarray(bad) == 77), f"{name}(out) must not write to an out that is {fault}")


def _bad_outs(shape: tuple[int, ...]) -> dict[str, Any]:
    good = np.full(shape, 77, np.uint8)
    locked = good.copy()
    locked.flags.writeable = False
    return {
        "of another shape": good.reshape(1, *shape),
        "too small": good[1:],
        "of another dtype": good.astype(np.int8),
        "read-only": locked,
        "not contiguous": np.full((2 * shape[0], *shape[1:]), 77, np.uint8)[::2],
        "a list": good.tolist(),
    }


def _check_screens(make: MakeCore) -> None:
    core = made(make)
    core.act(NOOP)
    index, gray, rgb = core.screen().ravel(), core.screen_grayscale().ravel(), core.screen_rgb().reshape(-1, 3)
    both = np.unique(np.column_stack([index, gray, rgb]), axis=0)
    require(
        len(both) == len(np.unique(index)),
        f"each palette index of screen() must have one color and one luminance; {len(np.unique(index))} indices have "
        f"{len(both)} in screen_rgb() and screen_grayscale()",
    )


def _check_sound(make: MakeCore) -> None:
    silent, loud = new(make, seed=3), new(make, seed=3, sound=True)
    require(loud.sound is True, f"sound of a core made with sound=True must be True, got {loud.sound!r}")
    for core in (silent, loud):
        core.reset()
    actions = some_actions(silent, 30)
    play(silent, actions)
    require(not silent.audio().any(), "audio() must be zero unless the core was made with sound=True")
    require(loud.with_sound() is loud, "with_sound() of a core that makes sound must return that core")
    later = silent.with_sound()
    require(later is not silent and later.sound, "with_sound() must return a new core that makes sound")
    require_same(_silent(visible(silent)), _silent(visible(later)), "the core", "with_sound() must keep the state")
    expected = [_silent(one) for one in play(silent, actions)]
    require_same(expected, [_silent(one) for one in play(later, actions)], "play", "with_sound() must keep the game")
    play(loud, actions)
    heard = [one["audio"] for one in play(loud, actions)]
    require(any(one.any() for one in heard), "audio() of a core made with sound=True must not stay zero")


def _silent(state: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in state.items() if name != "audio"}


def _check_memory(make: MakeCore) -> None:
    core = made(make)
    expected = core.ram()
    for index, value in ((127, 255), (0, np.uint8(7))):
        core.set_ram(index, value)
        expected[index] = value
        require_same(expected, core.ram(), "ram()", f"set_ram({index}, {value}) must write this byte alone")
    wrong: tuple[tuple[Any, Any], ...] = ((-1, 0), (128, 0), (0.0, 0), (0, 256), (0, -1), (0, None))
    for arguments in wrong:
        call = f"set_ram{arguments}"
        with unchanged(core, call), refuses(call, TypeError, ValueError):
            core.set_ram(*arguments)


def _check_choices(make: MakeCore) -> None:
    core = made(make)
    for name, numbers in choices(core.game, players_of(core)).items():
        core = made(make)
        for number in numbers[:3]:
            seen = getattr(made(make, **{name: number}), name)
            require(seen == number, f"{name} of a core made with {name}={number} must be {number}, got {seen!r}")
            getattr(core, f"set_{name}")(number)
            seen = getattr(core, name)
            require(seen == number, f"{name} must be {number} after set_{name}({number}), got {seen!r}")
            seen = getattr(core.with_sound(), name)
            require(seen == number, f"with_sound() must keep the {name} {number}, got {seen!r}")
            core.seed(1)
            seen = getattr(core, name)
            require(seen == number, f"seed() must keep the {name} {number}, got {seen!r}")
        for wrong in (1000, "0"):
            with unchanged(core, f"set_{name}({wrong!r})"), refuses(f"set_{name}({wrong!r})", TypeError, ValueError):
                getattr(core, f"set_{name}")(wrong)
            with refuses(f"make({name}={wrong!r})", TypeError, ValueError):
                make(**{name: wrong})


def _check_players(make: MakeCore) -> None:
    """Check `act_players`: `act` plays the same with an action of player 1, and NOOP of the others."""
    core, alone = made(make), made(make)
    others = [NOOP] * (players_of(core) - 1)
    if not others:
        return
    for action in some_actions(core, 20):
        rewards, expected = core.act_players([action, *others]), alone.act(action)  # type: ignore[attr-defined]
        call = f"act_players({[action, *others]})"
        require(len(rewards) == players_of(core), f"{call} must return a reward for each player, got {rewards!r}")
        require_same(
            {"reward": expected, **visible(alone)},
            {"reward": rewards[0], **visible(core)},
            "the core",
            f"{call} must play as act({action})",
        )
    for wrong in ([NOOP], [NOOP, NOOP, *others], [18, *others], [*others, None]):
        with unchanged(core, f"act_players({wrong})"), refuses(f"act_players({wrong})", TypeError, ValueError):
            core.act_players(wrong)  # type: ignore[attr-defined]


def _check_counters(make: MakeCore) -> None:
    core = made(make, frame_skip=3)
    before = [core.frame_number, core.episode_frame_number]
    for act in range(1, 5):
        core.act(NOOP)
        seen = [core.frame_number - before[0], core.episode_frame_number - before[1]]
        require(seen == [3 * act] * 2, f"{act} acts of frame_skip=3 must count {3 * act} frames, got {seen}")
    frames = core.frame_number
    core.reset()
    played, seen_frames = core.frame_number - frames, core.episode_frame_number
    require(
        played == seen_frames >= 0,
        f"reset() must keep frame_number and begin episode_frame_number again, got {played} and {seen_frames} frames",
    )


def _check_end(make: MakeCore) -> None:
    try:
        limit, core = LIMITS[0], make(max_num_frames_per_episode=LIMITS[0], frame_skip=4)
    except ValueError:
        limit, core = LIMITS[1], new(make, max_num_frames_per_episode=LIMITS[1], frame_skip=4)
    core.reset()
    begun = core.episode_frame_number
    for act in range(1, (limit - begun) // 4 + 2):
        core.act(NOOP)
        frame, frames = min(begun + 4 * act, limit), core.episode_frame_number
        require(
            core.game_over or (core.truncated, frames) == (frame == limit, frame),
            f"with max_num_frames_per_episode={limit} and frame_skip=4, act {act} must end at frame {frame} with "
            f"truncated={frame == limit}, got frame {frames} with truncated={core.truncated}",
        )
    seen = visible(core)
    reward = core.act(FIRE)
    require(reward == 0, f"act() after the end must return the reward 0, got {reward}")
    require_same(_silent(seen), _silent(visible(core)), "the core", "act() after the end must change nothing")
    core.reset()
    ended = core.game_over or core.truncated or core.episode_frame_number != begun
    require(not ended, "reset() must begin a game, but game_over, truncated or episode_frame_number is an old one")


def _check_frame_skip(make: MakeCore, steps: int) -> None:
    one, four = made(make, seed=3), made(make, seed=3, frame_skip=4)
    if one.episode_frame_number:  # a reset that plays to select the mode depends on the frame skip
        return
    for action in some_actions(one, steps // 4):
        expected, reward = sum(one.act(action) for _ in range(4)), four.act(action)
        call = f"act({action}) with frame_skip=4"
        require(reward == expected, f"{call} must return the sum of four frames, {expected}, got {reward}")
        for name in ("ram", "screen"):
            require_same(getattr(one, name)(), getattr(four, name)(), f"{name}()", f"{call} must play four frames")


def _check_actions(make: MakeCore) -> None:
    expected = play(made(make), [3] * 5)
    integers: tuple[Any, ...] = (np.int64(3), np.uint8(3), np.array(3))
    for action in integers:
        other = made(make)
        with broken_by(f"act({action!r})"):
            seen = play(other, [action] * 5)
        require_same(expected, seen, "play", f"act({action!r}) must play as act(3)")
    core, idler = made(make), made(make)
    legal = core.game.legal_actions if players_of(core) == 1 else ()
    for action in range(18):
        if legal and action not in legal:
            expected, seen = play(idler, [NOOP] * 3), play(core, [action] * 3)
            require_same(expected, seen, "play", f"act({action}), which the game forbids, must play as act(0)")


def _check_seeds(make: MakeCore, steps: int) -> None:
    sticky = {"repeat_action_probability": 0.5}
    first = made(make, seed=11, **sticky)
    actions = some_actions(first, steps)
    expected = play(first, actions)
    require_same(expected, play(made(make, seed=11, **sticky), actions), "play", "equal seeds must give equal games")
    rams = [_last_ram(make, steps, seed=seed, frame_skip=4, **sticky) for seed in range(6)]
    require(
        len(set(rams)) > 1,
        f"six seeds gave the same RAM after {steps} acts of four frames with repeat_action_probability=0.5; seeds must "
        "decide sticky actions",
    )
    for seed in (0, 2**32 - 1):
        used, fresh = made(make, seed=5, **sticky), made(make, seed=seed, **sticky)
        play(used, actions[: steps // 2])
        used.seed(seed)
        used.reset()
        require_same(
            play(fresh, actions), play(used, actions), "play", f"seed({seed}) must start over as a core made with it"
        )


def _last_ram(make: MakeCore, steps: int, **options: Any) -> bytes:
    core = made(make, **options)
    for action in some_actions(core, steps):
        core.act(action)
    return core.ram().tobytes()


def _check_refusals(make: MakeCore) -> None:
    options = {
        "seed": (-1, 2**32, 1.5, None, True),
        "repeat_action_probability": (-0.1, 1.01, float("nan"), "0.5"),
        "frame_skip": (0, "4"),
        "max_num_frames_per_episode": (-1, 1.0),
    }
    for name, values in options.items():
        for value in values:
            with refuses(f"make({name}={value!r})", TypeError, ValueError):
                make(**{name: value})
    core = made(make)
    wrong: dict[str, tuple[Any, ...]] = {
        "act": (-1, 18, 2**70, 1.0, "1", None, [1], np.float32(1)),
        "seed": (-1, 2**32, 0.5, "1", None),
        "restore": (b"", b"ATARISNP" * 9, "text", bytearray(9), None),
        "restore_state": (None, b"", object()),
    }
    for method, values in wrong.items():
        for value in values:
            call = f"{method}({value!r:.40})"
            with unchanged(core, call), refuses(call, TypeError, ValueError):
                getattr(core, method)(value)
    for strength in (float("nan"), float("inf"), "1", None, [1.0]):
        call = f"act(3, {strength!r})"
        with unchanged(core, call), refuses(call, TypeError, ValueError):
            core.act(3, strength)  # type: ignore[arg-type]


def _check_close(make: MakeCore) -> None:
    core = made(make)
    saved, state = core.snapshot(), core.clone_state()
    core.close()
    with broken_by("close() after close()"):
        core.close()
    calls: dict[str, tuple[Any, ...]] = {
        "seed": (1,),
        "reset": (),
        "act": (NOOP,),
        "set_ram": (0, 0),
        "snapshot": (),
        "clone_state": (),
        "restore": (saved,),
        "restore_state": (state,),
    }
    for name, arguments in (calls | dict.fromkeys(ARRAYS, ())).items():
        with refuses(f"{name}() after close()", RuntimeError):
            getattr(core, name)(*arguments)
    for name in NUMBERS:
        with refuses(f"{name} after close()", RuntimeError):
            getattr(core, name)


def _check_reference(make: MakeCore, reference: MakeCore, steps: int) -> None:
    played: tuple[dict[str, Any], ...] = ({}, {"sound": True, "frame_skip": 2}, {"repeat_action_probability": 0.0})
    for seed, options in enumerate(played):
        core, other = made(make, seed=seed, **options), made(reference, seed=seed, **options)
        for index, action in enumerate(some_actions(other, steps, seed)):
            (expected,), (seen,) = play(other, [action]), play(core, [action])
            call = f"act({action}), number {index + 1} of a core made with seed={seed} and {options}"
            require_same(expected, seen, "the core", f"{call}, must be as on {other.name!r}")
            if expected["game_over"]:
                core.reset()
                other.reset()
