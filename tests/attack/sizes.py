"""Images of every size that the fields accept, of every kind, at every SIMD level, in several lanes.

A vector's observations are compared with a single environment's, and with OpenCV's of whole screens; those of a level
with those of scalar code. Each level plays in a process of its own, whose C library checks a guard byte behind each
block of memory; arrays for `out=` lie between guards.
"""

import atexit
import hashlib
import os
import random
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from field_values import task_of, value_of
from guarded import Guards

import atari
import atari._emulator as _emulator
from atari.env.settings import filled
from atari.games.catalog import games
from atari.task.fields import GROUPS
from atari.task.task import Task

LEVELS = ("scalar", "simd128", "avx2", "avx512")
CHECKING_LIBRARY = "libc_malloc_debug.so.0"
STEPS = 12
STACKS = 15  # stacks of frames from arrays, which take less time than games
MOST_IMAGES = 16  # of a stack: larger ones take long and are made by the same code

Bytes = npt.NDArray[np.uint8]
Leaves = dict[str, Bytes]


def attack(seed: int) -> None:
    """Play a task at a random level and by scalar code."""
    best = LEVELS.index(_emulator.simd_level())
    level = random.Random(seed).choice(LEVELS[1 : best + 1] or LEVELS[:1])
    found = {name: played(name, seed) for name in (level, "scalar")}
    assert found[level] == found["scalar"], f"{level} differs from scalar code: {found}"


@cache
def process(level: str) -> "subprocess.Popen[str]":
    """A process that plays seeds at a level."""
    environment = {**os.environ, "ATARI_SIMD": level}
    if sys.platform == "linux":
        environment |= {"LD_PRELOAD": CHECKING_LIBRARY, "GLIBC_TUNABLES": "glibc.malloc.check=3"}
    command = [sys.executable, "-c", "from attack.sizes import serve; serve()"]
    environment["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
    made = subprocess.Popen(
        command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    atexit.register(made.kill)
    return made


def played(level: str, seed: int) -> str:
    """What the process of a level prints for a seed; AssertionError if it ends."""
    child = process(level)
    assert child.stdin is not None
    assert child.stdout is not None
    assert child.stderr is not None
    child.stdin.write(f"{seed}\n")
    child.stdin.flush()
    line = child.stdout.readline()
    if not line:
        status, text = child.wait(), child.stderr.read()
        raise AssertionError(f"seed {seed} at level {level}: exit status {status}\n{text[-3000:]}")
    return line.strip()


def serve() -> None:
    """Play the seeds that come in, and print a digest of each."""
    for line in sys.stdin:
        print(digest(int(line)), flush=True)


def random_task(source: random.Random) -> Task:
    """A task with random observations, whose other fields let episodes end soon."""
    while True:
        game = games[source.choice(sorted(games))]
        fixed: dict[str, Any] = {name: value_of(source, name, game) for name in GROUPS["observation"]}
        for name in ("img_height", "img_width"):
            fixed[name] = fixed[name] if source.random() < 0.05 else value_of(source, name, game) or 1
        fixed["stack_num"] = fixed["stack_num"] and min(fixed["stack_num"], MOST_IMAGES)
        if fixed["obs_type"] == "ram":
            fixed |= {"img_height": None, "img_width": None}
        fixed |= {"agent_indicator": False, "sound_obs": False, "frameskip": source.choice((1, 2, 4))}
        fixed |= {"max_episode_steps": source.choice((None, 3, 5)), "noops": (0, source.choice((0, 3)))}
        task = task_of(source, game, fixed, 0)
        if task is not None:
            return task


def leaves(observation: Any) -> Leaves:
    """The arrays of an observation by name."""
    return dict(observation) if isinstance(observation, dict) else {"": observation}


def shrunk(array: Bytes, screen: tuple[int, int], size: tuple[int, int]) -> Bytes:
    """Images of the screen's size, with any axes before them, made smaller by OpenCV; other arrays as they are."""
    colours = array.ndim > 3 and array.shape[-3:-1] == screen
    if not colours and (array.ndim < 3 or array.shape[-2:] != screen):
        return array
    image = (*screen, 3) if colours else screen
    small = [cv2.resize(one, size[::-1], interpolation=cv2.INTER_AREA) for one in array.reshape(-1, *image)]
    before = array.shape[: array.ndim - len(image)]
    return np.asarray(small, np.uint8).reshape(*before, *size, *image[2:])


def digest(seed: int) -> str:
    """Play a task in vectors and a single environment, compare their observations, and return a digest of all."""
    source = random.Random(seed)
    found = hashlib.sha1()
    for _ in range(STACKS):
        found.update(stacked(source))
    task = random_task(source)
    screen = task.definition.screen.shape
    size = task.img_height or screen[0], task.img_width or screen[1]
    lanes, first = source.choice((1, 2, 3, 5)), source.randrange(1000)
    lane = source.randrange(lanes)
    options: dict[str, Any] = {"num_threads": source.choice((1, 2))}
    options["autoreset_mode"] = source.choice(("NextStep", "SameStep"))
    whole = replace(task, img_height=None, img_width=None)
    small, large = (atari.AtariVectorEnv(each, lanes, **options) for each in (task, whole))
    single = atari.make(task)
    seen = leaves(small.reset(seed=first)[0])
    pairs = compared(seen, leaves(large.reset(seed=first)[0]), screen, size)
    compare_lane(seen, lane, leaves(single.reset(seed=first + lane)[0]), task)
    guards, alive = Guards(source), True
    arrays = {name: guards.array(array.shape) for name, array in seen.items()}
    for _ in range(STEPS):
        found.update(b"".join(pairs))
        action = source.randrange(int(single.action_space.n))
        out: Any = None
        if task.stack_num is not None and source.random() < 0.5:  # without a stack, observations have another layout
            out = arrays if set(seen) != {""} else arrays[""]
        actions = np.full(lanes, action)
        results = small.step(actions, out=out)
        guards.check()
        seen = leaves(results[0])
        pairs = compared(seen, leaves(large.step(actions)[0]), screen, size)
        if alive:
            observation, _, terminated, truncated, _ = single.step(action)
            alive = not (terminated or truncated)
            if alive:
                compare_lane(seen, lane, leaves(observation), task)
    for each in (small, large, single):
        each.close()
    return found.hexdigest()


def stacked(source: random.Random) -> bytes:
    """The images of a stack of random frames, which must be those of whole frames made smaller."""
    game = games[source.choice(sorted(games))]
    rows = game.screen.height
    size = min(value_of(source, "img_height", game) or rows, rows), value_of(source, "img_width", game) or 160
    pixels = source.choice((_emulator.PixelFormat.GRAY, _emulator.PixelFormat.RGB, _emulator.PixelFormat.GRAY_OF_RGB))
    settings = {"pixels": pixels, "stack_num": source.choice((1, 1, 2, 4)), "maxpool": source.random() < 0.5}
    settings["end_frames"] = _emulator.EndFrames.LAST
    small, large = (
        _emulator.ObservationStack(
            filled(_emulator.ObservationSettings(), img_height=height, img_width=width, **settings),
            rows,
            game.screen.format,
        )
        for height, width in (size, (rows, 160))
    )
    random_values = np.random.default_rng(source.randrange(2**32))
    frame = random_values.integers(0, 256, (rows, 160), np.uint8)
    for stack in (small, large):
        stack.begin(frame)
    for _ in range(2):
        frame[random_values.integers(0, rows, 3)] = random_values.integers(0, 256, (3, 1), np.uint8)
        for stack in (small, large):
            stack.skip_ended(frame, 0, False)
    return b"".join(compared({"": small.observation()}, {"": large.observation()}, (rows, 160), size))


def compared(seen: Leaves, large: Leaves, screen: tuple[int, int], size: tuple[int, int]) -> Iterator[bytes]:
    """The bytes of a vector's observations, which must be those of whole screens made smaller."""
    assert seen.keys() == large.keys()
    found = []
    for name, array in seen.items():
        expected = shrunk(large[name], screen, size)
        assert array.shape == expected.shape, f"{name}: {array.shape}, expected {expected.shape}"
        assert np.array_equal(array, expected), f"{name} {size}: {np.count_nonzero(array != expected)} bytes differ"
        found.append(array.tobytes())
    return iter(found)


def compare_lane(seen: Leaves, lane: int, single: Leaves, task: Task) -> None:
    """A lane's observations must be those of a single environment."""
    for name, array in seen.items():
        expected = single[name] if name in single else next(iter(single.values()))
        one = array[lane].reshape(np.shape(expected)) if array[lane].size == np.size(expected) else array[lane]
        assert np.array_equal(one, expected), f"lane {lane} differs from a single environment: {name} of {task}"
