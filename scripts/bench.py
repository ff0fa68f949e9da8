#!/usr/bin/env python
"""Measures the speed of this package and of its peers in alternating runs, and prints medians.

Suites:
    raw     one emulated frame, resets not counted: `NativeCore.act` beside ale-py's `ALEInterface.act`; then the same
            with the screen read as RGB after every frame, into an existing array
    state   construction with loading and first reset; reset; reset with a seed; clone and restore of the state: the
            native core beside ale-py's raw interface
    env     one step of an environment with RGB observations, resets not counted: `AtariEnv` beside ale-py's `AtariEnv`
    preset  one step of DQN preprocessing (4 frames, 84x84, stack of 4), resets counted: `atari.wrappers.preset` beside
            Gymnasium's wrappers and ale-py's and EnvPool's vector environments with one environment and one thread
    vector  one step of one environment of a vector, resets counted, with 64, 8 and 1 environments on all cores:
            `AtariVectorEnv` beside ale-py's and EnvPool's; then RGB, RAM, one thread beside several, the cost of a call
    play    one of 100, 16 or 4 steps of one environment of a vector, on one thread: in one call of
            `AtariVectorEnv.play`, beside calls of `step`; by default of one game
    sizes   the steps of `vector` over numbers of environments, by default of one game: the others take a minute to make
            1024; scripts/bench/plot_vector.py draws what --json writes
    memory  sampling from a `ReplayMemory`, uniform and by priority, beside the buffers of Stable-Baselines3, TorchRL,
            cpprb and Dopamine where they are installed; adding to it; and its size, plain and compressed. By default
            times of one game and sizes of all
    multiplayer  one step of one game of two players with DQN preprocessing, resets counted, on one thread:
            `AtariVectorEnv` with `players=2` beside PettingZoo with SuperSuit, which must be installed; games have
            PettingZoo's names
    ray     one step of one environment of RLlib's env runner, in CPU time, by parts: `AtariVectorEnv` beside RLlib's
            own wrappers of ale-py; needs the extra `ray`
    jax     one step of one environment of a vector of 8, resets counted: `xla(envs)` in a compiled scan, by callback
            and without, beside a Python loop, and both of ale-py's vector; needs the extra `jax`

Each number is the median over the rounds; in each round every contestant runs once, in turn, so that a slow phase of
the machine affects all of them. All play the same actions. The ratio is that of the medians. `raw` over all games takes
about three minutes, `vector` over all games half an hour.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import atari
import atari.multiplayer

sys.path.insert(0, str(Path(__file__).parent / "bench"))
import suite_memory
import suite_multiplayer
from comparison import Comparison
from suites import SUITES, without_envpool

Times = dict[str, list[float]]
"""Microseconds a step by contestant, one value a round."""

GAMES = ["breakout", "pong", "ms_pacman", "seaquest", "space_invaders", "montezuma_revenge", "qbert", "enduro"]

PACKAGES = (
    *("atari-envs", "ale-py", "envpool", "gymnasium", "numpy"),
    *("stable-baselines3", "torchrl", "cpprb", "dopamine-rl", "torch"),
    *("pettingzoo", "supersuit", "multi-agent-ale-py", "ray", "jax"),
)


def measure(comparisons: list[Comparison], game: str, steps: int, rounds: int) -> dict[str, Times]:
    """The times of a game by comparison."""
    times: dict[str, Times] = {comparison.name: {} for comparison in comparisons}
    runs = []
    for comparison in comparisons:
        count = max(1, round(steps * comparison.part))
        for name, prepare in comparison.contestants:
            run = prepare(game)
            run(max(1, count // 5))  # warm up
            runs.append((run, count, times[comparison.name].setdefault(name, [])))
    for _ in range(rounds):
        for run, count, values in runs:
            values.append(run(count) / count * 1e6)
    return times


def ratios(results: dict[str, Times], name: str, reference: str) -> dict[str, float]:
    """By game, a contestant's speed as a multiple of the reference's."""
    return {
        game: statistics.median(times[reference]) / statistics.median(times[name]) for game, times in results.items()
    }


def table(title: str, results: dict[str, Times]) -> str:
    """The medians of one comparison by game and contestant, the ratios, and their summary over the games."""
    names = list(next(iter(results.values())))
    reference = names[-1]
    width = max(len(game) for game in results)
    columns = {name: max(len(name), 17) for name in names}
    by_name = {name: ratios(results, name, reference) for name in names}
    lines = [
        f"{title}: microseconds (median), and in brackets how many times as fast as {reference}",
        " " * width + "".join(f"  {name:>{column}}" for name, column in columns.items()),
    ]
    for game, times in results.items():
        cells = {name: f"{statistics.median(times[name]):.1f} ({by_name[name][game]:5.2f}x)" for name in names}
        lines.append(f"{game:{width}}" + "".join(f"  {cells[name]:>{column}}" for name, column in columns.items()))
    for name in names[:-1]:
        lines += [f"{name}: {line}" for line in summary(by_name[name])]
    if "EnvPool" in names:
        ours = [name for name in names if name not in ("EnvPool", reference)]
        beside = {name: summary(ratios(results, name, "EnvPool")) for name in ours}
        lines += [f"{name} beside EnvPool: {line}" for name in ours for line in beside[name]]
    lines.append(f"spread of the rounds: {spread(results):.0%} of the median (typically)")
    return "\n".join(lines)


def summary(values: dict[str, float]) -> list[str]:
    """The summary of ratios by game, as lines of text."""
    worst = sorted(values, key=values.__getitem__)[:10]
    mean = statistics.geometric_mean(values.values())
    lines = [f"geometric mean {mean:.2f}x over {len(values)} games, minimum {values[worst[0]]:.2f}x ({worst[0]})"]
    if len(values) > 10:
        quartiles = statistics.quantiles(values.values(), n=4, method="inclusive")
        lines.append("quartiles " + ", ".join(f"{quartile:.2f}x" for quartile in quartiles))
        lines.append("ten worst " + ", ".join(f"{game} {values[game]:.2f}x" for game in worst))
    return lines


def spread(results: dict[str, Times]) -> float:
    """The range of a contestant's rounds divided by their median; the median over all contestants and games."""
    return statistics.median(
        (max(values) - min(values)) / statistics.median(values)
        for times in results.values()
        for values in times.values()
    )


def circumstances() -> dict[str, Any]:
    """The facts on which the numbers depend: machine, commit, versions."""
    installed = {package.metadata["Name"]: package.version for package in metadata.distributions()}
    return {
        "machine": {"processor": processor(), "cores": os.cpu_count(), "system": platform.platform()},
        "commit": commit(),
        "versions": {
            "python": platform.python_version(),
            **{name: installed[name] for name in PACKAGES if name in installed},
        },
    }


def processor() -> str:
    """The model of the CPU."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def commit() -> str | None:
    """The commit of this file's repository, with "+" if something in it has changed; None without git."""
    here = Path(__file__).parent
    try:
        head, changed = (
            subprocess.run(["git", "-C", here, *words], capture_output=True, text=True, check=True).stdout.strip()
            for words in (["rev-parse", "HEAD"], ["status", "--porcelain"])
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return head + "+" * bool(changed)


def default_games(suite: str) -> list[str]:
    """The games that a suite measures."""
    if suite == "multiplayer":
        return suite_multiplayer.GAMES
    return GAMES[:1] if suite in ("play", "sizes", "memory", "ray", "jax") else GAMES


def main() -> None:
    """Parse the options, measure, print tables and write JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", choices=SUITES, default="raw")
    parser.add_argument(
        "--games",
        nargs="+",
        metavar="GAME",
        help="games to measure, or 'all' (default: eight well-known ones; of suites play and sizes breakout)",
    )
    parser.add_argument(
        "--envs",
        type=int,
        nargs="+",
        metavar="N",
        default=[1, 8, 64, 256, 1024],
        help="numbers of environments of suite sizes (default 1 8 64 256 1024)",
    )
    parser.add_argument("--steps", type=int, default=1000, help="steps of a run (default 1000; fewer of slow calls)")
    parser.add_argument("--rounds", type=int, default=5, help="alternating rounds (default 5)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every measured value, machine and versions")
    options = parser.parse_args()
    if min(options.steps, options.rounds, *options.envs) < 1:
        parser.error("--steps, --rounds and --envs take whole numbers of at least 1")
    games = options.games or default_games(options.suite)
    if games == ["all"]:
        games = [game.id for game in atari.games.playable()]
    for game in games:
        if options.suite != "multiplayer":
            atari.games.find(game)
        elif game not in atari.multiplayer.ENVIRONMENTS:
            parser.error(f"there is no {game!r} among {', '.join(atari.multiplayer.ENVIRONMENTS)}")
    comparisons = list(SUITES[options.suite](*([options.envs] if options.suite == "sizes" else [])))
    if options.suite != "multiplayer":
        comparisons = without_envpool(comparisons, games)
    results = {}
    for game in games:
        print(f"{game} ...", file=sys.stderr, flush=True)
        results[game] = measure(comparisons, game, options.steps, options.rounds)
    for comparison in comparisons:
        print(table(comparison.name, {game: times[comparison.name] for game, times in results.items()}), end="\n\n")
    if options.suite == "memory":
        print(suite_memory.bytes_table(options.games or GAMES))
    if options.json:
        run = {"suite": options.suite, "steps": options.steps, "rounds": options.rounds}
        document = {**run, **circumstances(), "unit": "microseconds, one value a round", "results": results}
        options.json.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
