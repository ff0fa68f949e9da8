"""The suite `jax` of `bench.py`: steps in a compiled `lax.scan` beside a Python loop, ours and ale-py's."""

from collections.abc import Callable, Iterator
from functools import partial
from time import perf_counter
from typing import Any

import ale_py.vector_env
import numpy as np
from comparison import Comparison, Run

import atari
from atari.integrations.jax import xla

COUNT = 8


def comparisons() -> Iterator[Comparison]:
    """One step of one environment in compiled functions and in loops; all have one thread for each core."""
    sides = {
        "xla() in a scan": partial(scan, native, partial(xla, callback=False)),
        "callback in a scan": partial(scan, native, partial(xla, callback=True)),
        "loop": partial(loop, native),
        "ale-py's xla()": partial(scan, ale, lambda envs: envs.xla()),
        "ale-py's loop": partial(loop, ale),
    }
    yield Comparison(f"{COUNT} x 84x84 gray in JAX", [*sides.items()])


def native(game: str) -> Any:
    """Our vector environment."""
    return atari.AtariVectorEnv(game, COUNT, full_action_space=True)


def ale(game: str) -> Any:
    """ale-py's vector environment."""
    return ale_py.vector_env.AtariVectorEnv(game, COUNT, full_action_space=True)


def actions_of(steps: int) -> np.ndarray[Any, np.dtype[np.int32]]:
    """Rows of actions, one for each batch that `steps` steps of an environment need."""
    return np.random.default_rng(0).integers(18, size=(-(-steps // COUNT), COUNT), dtype=np.int32)


def loop(make: Callable[[str], Any], game: str) -> Run:
    """Steps in Python; a pixel of each observation is read, as in the scan."""
    envs = make(game)
    envs.reset(seed=0)

    def run(steps: int) -> float:
        actions = actions_of(steps)
        started = perf_counter()
        total = 0.0
        for batch in actions:
            observations, rewards, *_ = envs.step(batch)
            total += rewards.sum() + observations[0, 0].sum()
        return (perf_counter() - started) * steps / actions.size

    return run


def scan(make: Callable[[str], Any], functions: Callable[[Any], Any], game: str) -> Run:
    """Steps in one compiled function, which is compiled before the time is taken."""
    import jax

    envs = make(game)
    envs.reset(seed=0)
    handle, *_, step = functions(envs)
    compiled: dict[int, Any] = {}

    def one(carry: Any, batch: Any) -> Any:
        handle, total = carry
        handle, (observations, rewards, *_) = step(handle, batch)
        return (handle, total + rewards.sum() + observations[0, 0].sum()), ()

    def run(steps: int) -> float:
        actions = actions_of(steps)
        start = handle, jax.numpy.zeros((), "float32")
        if steps not in compiled:
            function = jax.jit(lambda carry, actions: jax.lax.scan(one, carry, actions)[0])
            compiled[steps] = function.lower(start, actions).compile()
        started = perf_counter()
        jax.block_until_ready(compiled[steps](start, actions))
        taken = perf_counter() - started
        assert not envs.closed  # this line keeps the environments: compiled functions do not
        return taken * steps / actions.size

    return run
