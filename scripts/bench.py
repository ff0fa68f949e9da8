#!/usr/bin/env python
"""How fast is it here? Times this package beside its peers, in alternating runs, and prints medians.

Suites:
    raw     one emulated frame: `Core.act` beside ale-py's `ALEInterface.act`
    env     one step of an environment with RGB observations: `AtariEnv` beside ale-py's `AtariEnv`
    preset  one step of DQN preprocessing (4 frames, 84x84, stack of 4): `atari.wrappers.preset` beside Gymnasium's
            wrappers and ale-py's and EnvPool's vector environments with one environment and one thread

Each number is the median over the rounds; in each round every contestant runs once, in turn, so that a slow moment of
the machine hits all alike. The ratio is that of the medians; the last row is the geometric mean over the games.
"""

import argparse
import dataclasses
import json
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import ale_py
import gymnasium
import numpy as np

import atari

Run = Callable[[int], None]
"""Takes so many steps."""


@dataclasses.dataclass(frozen=True)
class Contestant:
    """One side of a comparison: a name, and how to make it ready for a game."""

    name: str
    prepare: Callable[[str], Run]


def core_act(name: str) -> Callable[[str], Run]:
    """Frames of a core, screen not read."""

    def prepare(game: str) -> Run:
        core = atari.cores.CORES[name](game, repeat_action_probability=0.0)
        core.reset()
        actions = [int(action) for action in core.game.minimal_actions]

        def run(steps: int) -> None:
            for action in random_choices(actions, steps):
                if core.game_over:
                    core.reset()
                core.act(action)

        return run

    return prepare


def ale_py_act(game: str) -> Run:
    """Frames of ale-py's raw interface, screen not read."""
    ale = ale_py.ALEInterface()
    ale.setFloat("repeat_action_probability", 0.0)
    ale.loadROM(ale_py.roms.get_rom_path(game))
    actions = ale.getMinimalActionSet()

    def run(steps: int) -> None:
        for action in random_choices(actions, steps):
            if ale.game_over():
                ale.reset_game()
            ale.act(action)

    return run


def stepping(make: Callable[[str], gymnasium.Env[Any, Any]]) -> Callable[[str], Run]:
    """Steps of a single environment."""

    def prepare(game: str) -> Run:
        env = make(game)
        env.reset(seed=0)
        actions = list(range(int(env.action_space.n)))  # type: ignore[attr-defined]

        def run(steps: int) -> None:
            for action in random_choices(actions, steps):
                _, _, terminated, truncated, _ = env.step(action)
                if terminated or truncated:
                    env.reset()

        return run

    return prepare


def gymnasium_preset(game: str) -> gymnasium.Env[Any, Any]:
    """Gymnasium's wrappers on ale-py's environment."""
    env = gymnasium.wrappers.AtariPreprocessing(ale_py.AtariEnv(game, frameskip=1))
    return gymnasium.wrappers.FrameStackObservation(env, 4)


def ale_py_vector(game: str) -> Run:
    """ale-py's vector environment, one environment, one thread."""
    return _vector(ale_py.AtariVectorEnv(game, 1, num_threads=1), np.int64)


def envpool_vector(game: str) -> Run:
    """EnvPool, one environment, one thread."""
    import envpool

    task = atari.registration.stem(game) + "-v5"
    return _vector(envpool.make(task, env_type="gymnasium", num_envs=1, num_threads=1), np.int32)


def _vector(envs: Any, dtype: type) -> Run:
    envs.reset()
    count = int(getattr(envs, "single_action_space", envs.action_space).n)

    def run(steps: int) -> None:
        for action in random_choices(list(range(count)), steps):
            envs.step(np.full(1, action, dtype))

    return run


def random_choices(actions: list[int], steps: int) -> list[int]:
    """The same random actions for every contestant."""
    generator = np.random.default_rng(0)
    return [actions[index] for index in generator.integers(len(actions), size=steps)]


def contestants(suite: str) -> Iterator[Contestant]:
    """The contestants of a suite; the reference, to which ratios refer, comes last."""
    cores = list(atari.cores.CORES)
    if suite == "raw":
        for name in cores:
            yield Contestant(f"core={name}", core_act(name))
        yield Contestant("ale-py act", ale_py_act)
    elif suite == "env":
        for name in cores:
            yield Contestant(f"AtariEnv {name}", stepping(lambda game, name=name: atari.AtariEnv(game, core=name)))
        yield Contestant("ale-py AtariEnv", stepping(ale_py.AtariEnv))
    else:
        for name in cores:
            yield Contestant(f"4 x act {name}", four_acts(name))
            for preset in ("dqn2015", "gymnasium", "ale_vector"):
                yield Contestant(f"{preset} {name}", stepping(lambda game, n=name, p=preset: our_preset(game, n, p)))
        if has_envpool():
            yield Contestant("EnvPool x1", envpool_vector)
        yield Contestant("Gymnasium wrappers", stepping(gymnasium_preset))
        yield Contestant("ale-py vector x1", ale_py_vector)


def our_preset(game: str, core: str, preset: str) -> gymnasium.Env[Any, Any]:
    """A preset of this package."""
    env = atari.AtariEnv(game, core=core, **atari.wrappers.preset_options(preset))
    return atari.wrappers.preset(env, preset)


def four_acts(name: str) -> Callable[[str], Run]:
    """The emulator's part of a preset's step: four frames of a core, nothing looked at."""

    def prepare(game: str) -> Run:
        run = core_act(name)(game)
        return lambda steps: run(4 * steps)

    return prepare


def has_envpool() -> bool:
    """Whether EnvPool is installed."""
    from importlib.util import find_spec

    return find_spec("envpool") is not None


def measure(sides: list[Contestant], game: str, steps: int, rounds: int) -> dict[str, list[float]]:
    """Microseconds a step of each contestant, one value a round."""
    runs = {side.name: side.prepare(game) for side in sides}
    for run in runs.values():
        run(max(1, steps // 5))  # warm up
    times: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            started = time.perf_counter()
            run(steps)
            times[name].append((time.perf_counter() - started) / steps * 1e6)
    return times


def main() -> None:
    """Parse the options, measure, print a table or JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", choices=("raw", "env", "preset"), default="raw")
    parser.add_argument(
        "--games",
        nargs="+",
        metavar="GAME",
        default=["breakout", "pong", "ms_pacman", "seaquest", "space_invaders", "montezuma_revenge", "qbert", "enduro"],
        help="games to measure, or 'all' (default: eight well-known ones)",
    )
    parser.add_argument("--steps", type=int, default=1000, help="steps of a run (default 1000)")
    parser.add_argument("--rounds", type=int, default=5, help="alternating rounds (default 5)")
    parser.add_argument("--json", action="store_true", help="print every measured value as JSON")
    options = parser.parse_args()
    games = [game.id for game in atari.games.playable()] if options.games == ["all"] else options.games
    for game in games:
        atari.games.find(game)
    sides = list(contestants(options.suite))
    results = {}
    for game in games:
        print(f"{game} ...", file=sys.stderr, flush=True)
        results[game] = measure(sides, game, options.steps, options.rounds)
    print(json.dumps(results, indent=1) if options.json else table(results, [side.name for side in sides]))


def table(results: dict[str, dict[str, list[float]]], names: list[str]) -> str:
    """Microseconds a step by game and contestant, and how many times faster than the last one each is."""
    reference = names[-1]
    width = max(len(game) for game in (*results, "geometric mean"))
    columns = [max(len(name), 8) for name in names]
    lines = [
        "microseconds a step (median), and in brackets how many times as fast as " + reference,
        " " * width + "  " + "  ".join(f"{name:>{c + 8}}" for name, c in zip(names, columns, strict=True)),
    ]
    ratios: dict[str, list[float]] = {name: [] for name in names}
    for game, times in results.items():
        medians = {name: statistics.median(times[name]) for name in names}
        cells = []
        for name, column in zip(names, columns, strict=True):
            ratio = medians[reference] / medians[name]
            ratios[name].append(ratio)
            cells.append(f"{medians[name]:>{column}.1f} ({ratio:4.2f}x)")
        lines.append(f"{game:{width}}  " + "  ".join(cells))
    means = [f"{'':>{c}} ({statistics.geometric_mean(ratios[n]):4.2f}x)" for n, c in zip(names, columns, strict=True)]
    lines.append(f"{'geometric mean':{width}}  " + "  ".join(means))
    return "\n".join(lines)


if __name__ == "__main__":
    main()
