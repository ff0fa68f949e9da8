"""Arrays for `out=`: between guards, of wrong shapes and dtypes, strided, reversed, read-only.

A call either fills the array with what it returns without `out=`, or raises and writes nothing. No call writes beside
the array. The methods with a parameter `out` are read from the classes.
"""

import inspect
import random
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

import atari
from atari.learning import ReplayMemory

GUARD = 0xA5
Array = npt.NDArray[Any]


def attack(seed: int) -> None:
    """Call each method with some arrays."""
    source = random.Random(seed)
    for name, call in calls(source):
        try:
            expected = np.array(call(None), copy=True)
        except NotImplementedError:  # AleCore.redraw
            continue
        for _ in range(12):
            check(source, name, call, expected)


def calls(source: random.Random) -> Iterator[tuple[str, Callable[[Any], Any]]]:
    """Functions of `out` whose results do not depend on earlier calls."""
    game = source.choice(("pong", "breakout", "carnival", "mr_do"))
    core = source.choice((atari.cores.NativeCore, atari.cores.PlainCore, atari.cores.AleCore))(game, sound=True)
    core.reset()
    options = {"obs_type": source.choice(("grayscale", "rgb", "ram")), "stack_num": source.choice((1, 3))}
    vector = atari.AtariVectorEnv(atari.Task.of(game, **options), source.choice((1, 2, 3)), num_threads=1)
    vector.reset(seed=1)
    for target in (core, vector.lanes[0]):
        for name in (name for name in dir(type(target)) if not name.startswith("_")):
            if takes_out(getattr(type(target), name)):
                yield (
                    f"{type(target).__name__}.{name}",
                    lambda out, target=target, name=name: getattr(target, name)(out),
                )
    saved, actions = vector.snapshot(), np.zeros(vector.num_envs, np.int64)

    def step(out: Any) -> Any:
        vector.restore(None, saved)
        return vector.step(actions, out=out)[0]

    yield "AtariVectorEnv.step", step
    memory = ReplayMemory(50, 2, (5, source.choice((4, 7))), stack_num=source.choice((1, 3)))
    memory.reset(np.random.default_rng(0).integers(0, 256, memory.frames().shape, np.uint8))
    yield "ReplayMemory.observations", lambda out: memory.observations(out=out)


def takes_out(method: Any) -> bool:
    """Whether a method has a parameter `out`."""
    method = inspect.unwrap(method) if callable(method) else method
    if hasattr(method, "__nb_signature__"):
        return "out:" in method.__nb_signature__[0][0]
    return inspect.isfunction(method) and "out" in inspect.signature(method).parameters


def check(source: random.Random, name: str, call: Callable[[Any], Any], expected: Array) -> None:
    """One array, which fits or does not."""
    memory, out = array(source, expected.shape)
    before, refused = memory.copy(), False
    try:
        result = call(out)
    except (TypeError, ValueError):
        refused = True
    what = f"{name}(out={out.dtype} {out.shape}, strides {out.strides}, writable {out.flags.writeable})"
    if refused:
        assert np.array_equal(memory, before), f"{what} was refused, but written"
        plain = out.shape == expected.shape and out.dtype == np.uint8 and out.flags.c_contiguous and out.flags.writeable
        assert not plain, f"{what} was refused"
        return
    assert out.flags.writeable, f"{what} is read-only, but was accepted"
    assert np.array_equal(np.asarray(result), expected), f"{what} returned another result"
    assert np.array_equal(out, expected), f"{what} was not filled"
    out[...] = np.frombuffer(bytes([GUARD]) * out.dtype.itemsize, out.dtype)[0]
    assert (memory == GUARD).all(), f"{what}: bytes beside the array were written"


def array(source: random.Random, shape: tuple[int, ...]) -> tuple[npt.NDArray[np.uint8], Array]:
    """The memory of an array with its guards, and the array, of this shape or of another one."""
    lengths = list(shape)
    if source.random() < 0.3:
        axis = source.randrange(len(lengths))
        lengths[axis] = max(0, lengths[axis] + source.choice((-1, 1, -lengths[axis])))
    if source.random() < 0.1:
        lengths.append(1)
    kind = np.dtype("u1") if source.random() < 0.8 else np.dtype(source.choice(("i1", "?", "i4", "f8")))
    step = source.choice((1, 1, 1, 2, -1))
    count = int(np.prod(lengths)) * abs(step) * kind.itemsize
    first = 8 * source.randrange(1, 9) + (source.randrange(8) if kind.itemsize == 1 else 0)
    memory = np.full(first + count + 300, GUARD, np.uint8)
    flat = memory[first : first + count].view(kind)
    made = np.reshape(flat, (*lengths[:-1], lengths[-1] * abs(step)))[..., ::step] if count else np.empty(lengths, kind)
    if source.random() < 0.15:
        made.flags.writeable = False
    return memory, made
