"""The suites of `bench.py`: the contestants of each, and the functions that prepare a game and time it."""

import dataclasses
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import Any

import ale_py
import gymnasium
import numpy as np

import atari

sys.path.insert(0, str(Path(__file__).parent))  # PYTHONSAFEPATH leaves it out
import suite_jax
import suite_memory
import suite_multiplayer
import suite_ray
from comparison import Comparison, Contestant, Run


def raw() -> Iterator[Comparison]:
    """One emulated frame of a core, resets not counted."""
    yield Comparison("act", [("native", core_frames), ("ale-py", ale_py_frames)])
    yield Comparison(
        "act and screen_rgb into an array",
        [("native", partial(core_frames, rgb=True)), ("ale-py", partial(ale_py_frames, rgb=True))],
    )


def state() -> Iterator[Comparison]:
    """The calls of a core that start a game, save its state and restore it."""
    for name, part, ours, theirs in (
        (
            "construct, load and first reset", 0.003,
            lambda game: lambda: native_core(game).reset(), lambda game: lambda: loaded_ale(game).reset_game(),
        ),
        ("reset", 0.02, lambda game: native_core(game).reset, lambda game: loaded_ale(game).reset_game),
        ("reset with a seed", 0.005, core_seed, ale_py_seed),
        ("clone the state", 1.0, core_clone, ale_py_clone),
        ("restore the state", 1.0, core_restore, ale_py_restore),
    ):  # fmt: skip
        sides = [
            ("native", partial(repeated, make=ours)),
            ("ale-py", partial(repeated, make=theirs)),
        ]
        yield Comparison(name, sides, part)


def env() -> Iterator[Comparison]:
    """One step of an environment with RGB observations, resets not counted."""

    def ours(core: str) -> Callable[[str], Run]:
        return partial(steps_of, make=lambda game: atari.AtariEnv(game, core=core))

    sides = [(f"AtariEnv {core}", ours(core)) for core in atari.cores.CORES]
    yield Comparison("env.step", [*sides, ("ale-py AtariEnv", partial(steps_of, make=ale_py.AtariEnv))])


def preset() -> Iterator[Comparison]:
    """One step of DQN preprocessing, resets counted: vector environments make them within a step."""

    def ours(core: str, preset: str) -> Callable[[str], Run]:
        options = {"core": core, **atari.wrappers.preset_options(preset)}

        def wrapped(game: str) -> gymnasium.Env[Any, Any]:
            return atari.wrappers.preset(atari.AtariEnv(game, **options), preset)

        return partial(steps_of, make=wrapped, count_resets=True)

    sides = []
    for core in atari.cores.CORES:
        sides.append((f"4 x act {core}", partial(four_frames, name=core)))
        sides += [(f"{name} {core}", ours(core, name)) for name in ("dqn2015", "gymnasium", "ale_vector")]
    if has_envpool():
        sides.append(envpool_envs("EnvPool x1", 1))
    if find_spec("stable_baselines3") is not None:
        sides.append(("SB3 wrapper", partial(steps_of, make=sb3_preset, count_resets=True)))
    sides.append(("Gymnasium wrappers", partial(steps_of, make=gymnasium_preset, count_resets=True)))
    yield Comparison("preset.step", [*sides, ale_py_envs("ale-py vector x1", 1, num_threads=1)])


def vector() -> Iterator[Comparison]:
    """One step of one environment of a vector, resets counted."""
    for count, part in ((64, 3.0), (8, 1.0), (1, 0.5)):
        sides = [native_envs("native", count), native_envs("native dqn2015", count, preset="dqn2015")]
        yield Comparison(f"{count} x 84x84 gray", [*sides, *peer_envs(count)], part)
    rgb = {"grayscale": False, "stack_num": 1, "img_height": 210, "img_width": 160}
    yield Comparison("8 x 210x160 RGB", [native_envs("native", 8, **rgb), ale_py_envs("ale-py", 8, **rgb)], 0.5)
    ram = native_envs("native RAM", 64, obs_type="ram")
    yield Comparison("64 x RAM and 84x84 gray", [ram, native_envs("native gray", 64)], 3.0)
    cores = os.cpu_count() or 1
    threads = [native_envs(f"{n} threads", 64, num_threads=n) for n in (16, 8, 4, 2) if n <= cores]
    yield Comparison("64 x 84x84 gray, by threads", [*threads, native_envs("1 thread", 64, num_threads=1)], 3.0)
    # The cost of a call is the difference of these: all other work is done once for each environment.
    alone, shared = native_envs("a call for 1", 1, num_threads=1), native_envs("a call for 64", 64, num_threads=1)
    yield Comparison("84x84 gray on one thread", [shared, alone], 3.0)


def play(steps: Iterable[int] = (100, 16, 4)) -> Iterator[Comparison]:
    """One of several steps of one environment of a vector, on one thread, in one call of `play` or calls of `step`."""
    for length in steps:
        for frameskip in (1, 4):
            for count in (64, 8, 1):
                of = partial(sequences_of, length=length, count=count, frameskip=frameskip)
                sides = [("play", partial(of, together=True)), ("step", partial(of, together=False))]
                yield Comparison(f"{length} steps of {count}, frame skip {frameskip}", sides, max(3.0, count / 8))


def sizes(counts: Iterable[int]) -> Iterator[Comparison]:
    """The steps of `vector` over numbers of environments, for a plot."""
    for count in counts:
        sides = [native_envs("native", count), native_envs("native RAM", count, obs_type="ram"), *peer_envs(count)]
        yield Comparison(f"{count} x 84x84 gray", sides, min(4.0, max(0.5, count / 16)))


SUITES: dict[str, Callable[..., Iterator[Comparison]]] = {
    "raw": raw,
    "state": state,
    "env": env,
    "preset": preset,
    "vector": vector,
    "play": play,
    "sizes": sizes,
    "memory": suite_memory.comparisons,
    "multiplayer": suite_multiplayer.comparisons,
    "ray": suite_ray.comparisons,
    "jax": suite_jax.comparisons,
}


def random_choices(actions: list[Any], steps: int) -> list[Any]:
    """The same random actions for every contestant."""
    generator = np.random.default_rng(0)
    return [actions[index] for index in generator.integers(len(actions), size=steps)]


# Frames. Both loops do the same work in Python, so the ratio is that of the emulators.


def core_frames(game: str, name: str = "native", rgb: bool = False) -> Run:
    """Frames of a core."""
    core = atari.cores.CORES[name](game, repeat_action_probability=0.0)
    core.reset()
    pixels = core.screen_rgb()
    actions = [int(action) for action in core.game.minimal_actions]

    def run(steps: int) -> float:
        choices = random_choices(actions, steps)
        resets = 0.0
        started = perf_counter()
        for action in choices:
            if core.game_over:
                paused = perf_counter()
                core.reset()
                resets += perf_counter() - paused
            core.act(action)
            if rgb:
                core.screen_rgb(pixels)
        return perf_counter() - started - resets

    return run


def four_frames(game: str, name: str) -> Run:
    """The emulator's part of a preset's step: four frames of a core, without reading the screen."""
    run = core_frames(game, name)
    return lambda steps: run(4 * steps)


def ale_py_frames(game: str, rgb: bool = False) -> Run:
    """Frames of ale-py's raw interface."""
    ale = loaded_ale(game)
    ale.reset_game()
    pixels = ale.getScreenRGB()
    actions = [int(action.value) for action in ale.getMinimalActionSet()]

    def run(steps: int) -> float:
        choices = random_choices(actions, steps)
        resets = 0.0
        started = perf_counter()
        for action in choices:
            if ale.game_over():
                paused = perf_counter()
                ale.reset_game()
                resets += perf_counter() - paused
            ale.act(action)
            if rgb:
                ale.getScreenRGB(pixels)
        return perf_counter() - started - resets

    return run


def native_core(game: str) -> atari.cores.NativeCore:
    """A native core without sticky actions."""
    return atari.cores.NativeCore(game, repeat_action_probability=0.0)


def ale_py_rom(game: str) -> Path:
    """The ROM file that ale-py carries."""
    path = ale_py.roms.get_rom_path(game)
    assert path is not None
    return path


def loaded_ale(game: str) -> Any:
    """ale-py's raw interface without sticky actions."""
    ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)  # no banner, no line per load
    ale = ale_py.ALEInterface()
    ale.setFloat("repeat_action_probability", 0.0)
    ale.loadROM(ale_py_rom(game))
    return ale


# Starting, saving and restoring: `call = make(game)`, then `call()` is one step.


def repeated(game: str, make: Callable[[str], Callable[[], object]]) -> Run:
    """Calls, one after the other."""
    call = make(game)

    def run(steps: int) -> float:
        started = perf_counter()
        for _ in range(steps):
            call()
        return perf_counter() - started

    return run


def core_seed(game: str) -> Callable[[], object]:
    """A reset with a seed."""
    core = native_core(game)

    def call() -> None:
        core.seed(1)
        core.reset()

    return call


def ale_py_seed(game: str) -> Callable[[], object]:
    """A reset with a seed, which ale-py takes when it loads."""
    ale = loaded_ale(game)
    path = ale_py_rom(game)

    def call() -> None:
        ale.setInt("random_seed", 1)
        ale.loadROM(path)
        ale.reset_game()

    return call


def core_clone(game: str) -> Callable[[], object]:
    """A copy of the state in memory."""
    core = native_core(game)
    core.reset()
    return core.clone_state


def ale_py_clone(game: str) -> Callable[[], object]:
    """A copy of the state in memory."""
    ale = loaded_ale(game)
    ale.reset_game()
    return ale.cloneState  # type: ignore[no-any-return]


def core_restore(game: str) -> Callable[[], object]:
    """A restore of a copy of the state."""
    core = native_core(game)
    core.reset()
    saved = core.clone_state()
    return lambda: core.restore_state(saved)


def ale_py_restore(game: str) -> Callable[[], object]:
    """A restore of a copy of the state."""
    ale = loaded_ale(game)
    ale.reset_game()
    saved = ale.cloneState()
    return lambda: ale.restoreState(saved)


# Environments.


def steps_of(game: str, make: Callable[[str], gymnasium.Env[Any, Any]], count_resets: bool = False) -> Run:
    """Steps of a single environment."""
    env = make(game)
    env.reset(seed=0)
    actions = list(range(int(env.action_space.n)))  # type: ignore[attr-defined]

    def run(steps: int) -> float:
        choices = random_choices(actions, steps)
        resets = 0.0
        started = perf_counter()
        for action in choices:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                paused = perf_counter()
                env.reset()
                resets += perf_counter() - paused
        seconds = perf_counter() - started
        return seconds if count_resets else seconds - resets

    return run


def gymnasium_preset(game: str) -> gymnasium.Env[Any, Any]:
    """Gymnasium's wrappers on ale-py's environment."""
    env = gymnasium.wrappers.AtariPreprocessing(ale_py.AtariEnv(game, frameskip=1))
    return gymnasium.wrappers.FrameStackObservation(env, 4)


def sb3_preset(game: str) -> gymnasium.Env[Any, Any]:
    """Stable-Baselines3's wrapper on ale-py's environment; it stacks no images."""
    from stable_baselines3.common.atari_wrappers import AtariWrapper

    return AtariWrapper(ale_py.AtariEnv(game, frameskip=1, repeat_action_probability=0.0))


def native_envs(name: str, count: int, **options: Any) -> Contestant:
    """Our vector environment."""
    return name, partial(batches_of, make=lambda game: atari.AtariVectorEnv(game, count, **options))


def ale_py_envs(name: str, count: int, **options: Any) -> Contestant:
    """ale-py's vector environment."""
    return name, partial(batches_of, make=lambda game: ale_py.AtariVectorEnv(game, count, **options))


def envpool_envs(name: str, count: int) -> Contestant:
    """EnvPool with as many threads as there are cores, at most one for each environment."""

    def make(game: str) -> Any:
        import envpool

        threads = min(count, os.cpu_count() or 1)
        return envpool.make(envpool_task(game), env_type="gymnasium", num_envs=count, num_threads=threads)

    return name, partial(batches_of, make=make, dtype=np.int32)


def peer_envs(count: int) -> list[Contestant]:
    """EnvPool, if it is installed, and ale-py."""
    return [*([envpool_envs("EnvPool", count)] if has_envpool() else []), ale_py_envs("ale-py", count)]


@cache
def has_envpool() -> bool:
    """Whether EnvPool is installed; prints a line if it is not."""
    found = find_spec("envpool") is not None
    if not found:
        print("EnvPool is not installed and is left out; pip install envpool brings it in.", file=sys.stderr)
    return found


def without_envpool(comparisons: list[Comparison], games: list[str]) -> list[Comparison]:
    """The comparisons; without EnvPool, and with a printed line, if EnvPool does not have all these games."""
    beside = any(side[0].startswith("EnvPool") for comparison in comparisons for side in comparison.contestants)
    if not beside:
        return comparisons
    import envpool

    known = set(envpool.list_all_envs())
    lacking = [game for game in games if envpool_task(game) not in known]
    if not lacking:
        return comparisons
    print(f"EnvPool lacks {', '.join(lacking)} and is left out.", file=sys.stderr)
    return [
        dataclasses.replace(
            comparison, contestants=[side for side in comparison.contestants if not side[0].startswith("EnvPool")]
        )
        for comparison in comparisons
    ]


def envpool_task(game: str) -> str:
    """EnvPool's name of a game."""
    return atari.task.env_ids.stem(game) + "-v5"


def batches_of(game: str, make: Callable[[str], Any], dtype: type[np.integer[Any]] = np.int64) -> Run:
    """Steps of a vector environment, counted by its environments."""
    envs = make(game)
    envs.reset()
    size = envs.num_envs if hasattr(envs, "num_envs") else len(envs)
    count = int(getattr(envs, "single_action_space", envs.action_space).n)

    def run(steps: int) -> float:
        batches = -(-steps // size)
        actions = np.random.default_rng(0).integers(count, size=(batches, size)).astype(dtype)
        started = perf_counter()
        for batch in actions:
            envs.step(batch)
        return (perf_counter() - started) * steps / (batches * size)

    return run


def sequences_of(game: str, length: int, count: int, frameskip: int, together: bool) -> Run:
    """Steps of a vector with preset dqn2015, `length` of them in a call or in as many calls; all from one state."""
    envs = atari.AtariVectorEnv(game, count, preset="dqn2015", frameskip=frameskip, num_threads=1)
    envs.reset(seed=0)
    start = envs.snapshot()

    def run(steps: int) -> float:
        calls = -(-steps // (count * length))
        actions = np.random.default_rng(0).integers(envs.single_action_space.n, size=(calls, count, length))
        batches = np.ascontiguousarray(actions.transpose(0, 2, 1)).reshape(-1, count)
        envs.restore(None, start)
        started = perf_counter()
        if together:
            for sequences in actions:
                envs.play(sequences, stop=False)
        else:
            for batch in batches:
                envs.step(batch)
        return (perf_counter() - started) * steps / (calls * count * length)

    return run
