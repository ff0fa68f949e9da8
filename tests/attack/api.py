"""Hostile arguments to every public method of the environments, the cores and the extension module."""

import inspect
import math
import random
from collections.abc import Callable
from typing import Any

import numpy as np

import atari
import atari._emulator as _emulator
from atari.cores.compiled import reward_formula
from attack.findings import attempt

# These methods write a file of any name, or raise AttributeError for a name that does not exist.
LEFT_OUT = {"saveScreenPNG", "call", "get_attr", "set_attr"}
LEFT_OUT |= {"get_wrapper_attr", "set_wrapper_attr", "has_wrapper_attr"}


OWN_CHECKS = {"act", "act_until", "reset", "ram", "audio", "screen", "screen_rgb", "screen_grayscale", "redraw"}
"""Fast methods of cores, which are the binding's own. They convert each argument; the binding refuses a wrong number."""

FRAMES = {"play_frames", "play_until"}
"""Methods that need `frames` by name."""


class BadIndex:
    """Raises when it is used as an integer or a float."""

    def __index__(self) -> int:
        raise ValueError("no index")

    def __float__(self) -> float:
        raise ValueError("no float")


def hostile(source: random.Random) -> Any:
    """A value that no method expects, or one at the edge of what it expects."""
    makers: list[Callable[[], Any]] = [
        lambda: None,
        lambda: source.choice((0, 1, 2, 3, 17, 18, 127, 128, 255, 256)),
        lambda: source.choice((-1, -(2**31), 2**31, 2**32 - 1, 2**44, 2**63, 2**64, -(2**64))),
        lambda: source.choice((0.5, 1.5, math.nan, math.inf, -math.inf, 1e308, -0.0)),
        lambda: source.choice(("", "x", "ram", "rgb_array", "\0", "\ud800", "a" * 10_000)),
        lambda: source.choice((b"", b"ATARISNP", source.randbytes(200), bytearray(8), memoryview(b"abc"))),
        lambda: source.choice(([], (), {}, set(), [[]], {"a": []}, [None] * 3, [2**70])),
        lambda: array(source),
        lambda: [hostile(source) for _ in range(source.choice((1, 1, 2)))],
        BadIndex,
        lambda: source.choice((True, False, object(), int, len, Ellipsis)),
    ]
    return source.choice(makers)()


def array(source: random.Random) -> Any:
    """An array of any type, shape, strides and writability."""
    kind = source.choice(("u1", "i1", "i4", "i8", "u8", "f4", "f8", "?", "O", "U3", "c8", "V5", ">i4"))
    shape = source.choice(((), (0,), (1,), (2,), (3,), (128,), (2, 4, 84, 84), (210, 160, 3), (210, 160), (1, 0, 5)))
    made = np.zeros(shape, kind)
    if made.ndim and source.random() < 0.3:
        made = made[::-1] if source.random() < 0.5 else made[..., ::2]
    if source.random() < 0.2:
        made.flags.writeable = False
    return made


def targets(source: random.Random) -> list[Any]:
    """Objects in different phases of their life."""
    game = source.choice(("pong", "breakout", "montezuma_revenge"))
    env = atari.AtariEnv(game, obs_type=source.choice(("rgb", "grayscale", "ram")))
    mode = source.choice(("NextStep", "SameStep", "Disabled"))
    reward = source.choice((None, "reward - lives_lost / before.ram[0x8A]"))
    vector = atari.AtariVectorEnv(game, 2, num_threads=source.choice((1, 2)), autoreset_mode=mode, reward=reward)
    formula = reward_formula(env.game, "1 / lives + before.reward")
    for made in (env, vector):
        if source.random() < 0.8:
            made.reset(seed=source.randrange(100))
    engine = vector._engine if hasattr(vector, "_engine") else vector
    return [env, env.core, env.ale, vector, source.choice(vector.lanes), engine, formula, env.driver]


def attack(seed: int) -> None:
    """Call random methods with random arguments; the objects must go on working, or say that they are closed."""
    source = random.Random(seed)
    objects = targets(source)
    driver = objects[-1]
    for _ in range(60):
        target = source.choice(objects)
        names = [name for name in dir(target) if not name.startswith("_") and name not in LEFT_OUT]
        name = source.choice(names)
        method = attempt(lambda target=target, name=name: getattr(target, name))  # a property may raise, too
        if callable(method) and not inspect.isclass(method):
            arguments = [hostile(source) for _ in range(source.choice((0, 1, 1, 1, 2, 3)))]
            frames = source.choice((0, 1, 4, 70, -1, 2.5, None, "x"))
            named = {"frames": frames} if target is driver and method.__name__ in FRAMES else {}
            private = type(target).__module__ == _emulator.__name__ or method.__name__ in OWN_CHECKS
            attempt(
                lambda method=method, arguments=arguments, named=named: method(*arguments, **named), private=private
            )
    for name in source.sample([name for name in dir(_emulator) if not name.startswith("_")], 6):
        made = getattr(_emulator, name)
        if callable(made):
            arguments = [hostile(source) for _ in range(source.randrange(5))]
            attempt(lambda made=made, arguments=arguments: made(*arguments), private=True)
    for target in (objects[0], objects[3]):
        attempt(target.close)
        attempt(target.close)
