"""Sweeps of `atari train`: several games, seeds or values of options, each training in a process of its own.

As a program, `python -m atari.cli.sweep WORDS` is `atari WORDS` in such a process: it ends as after Ctrl-C when its
stdin ends, as it does when the sweep is killed.
"""

import _thread
import argparse
import os
import shutil
import sys
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from atari.cli.evaluate import check_comparable
from atari.cli.printing import print_json, print_table
from atari.learning import GAME_SETS
from atari.learning.evaluation.protocols import MAX_EPISODES, find_protocol
from atari.task.parser import Parser, number

if TYPE_CHECKING:
    from atari.learning.agent import AgentCode
    from atari.learning.sweep.plan import Chosen

FLAGS = ("--seeds", "--grid", "--jobs")
"""Flags that make a training a sweep."""


def add_sweep(parser: argparse.ArgumentParser) -> None:
    """Add the flags that may also precede the agent."""
    parser.add_argument("--seeds", metavar="SEEDS", help="a sweep: train with each of these seeds, such as 0-2 or 0,7")
    parser.add_argument(
        "--grid",
        action="append",
        metavar="OPTION=VALUES",
        help="a sweep: train with each of these values of an option, such as learning_rate=1e-4,3e-4; several of these "
        "flags train with all combinations",
    )
    parser.add_argument(
        "--jobs", type=number(int, 1, 1024), metavar="N", help="a sweep: processes at a time (default: 1)"
    )


def is_sweep(args: argparse.Namespace, code: "AgentCode", words: Sequence[str]) -> bool:
    """Whether a command line of `atari train`, without the agent, names several games, seeds or values."""
    from atari.learning.command import game_among

    if (args.seeds, args.jobs, args.grid) != (None, None, None) or any(
        word.partition("=")[0] in FLAGS for word in words
    ):
        return True
    if not any("," in word or word in GAME_SETS for word in words):
        return False
    games = game_among(code, _parser().parse_known_args(words)[1], _program(code))
    return games in GAME_SETS or ("," in games and not Path(games).exists())


def run_sweep(args: argparse.Namespace, code: "AgentCode", words: Sequence[str]) -> int:
    """Do the sweep of a command line, without the agent: GAMES, flags of the sweep and options of the trainings."""
    import atari.learning.evaluation.plot  # noqa: F401 - raises an error without Matplotlib, before the trainings
    from atari.learning.command import training_options
    from atari.learning.sweep.plan import check_folder, check_protocol, find_games, find_grid, find_seeds, plan
    from atari.learning.sweep.processes import grid_words
    from atari.learning.sweep.report import comparable_agents, planned_frames

    args, games, options = _parsed(args, code, words)
    protocol = find_protocol(args.protocol)
    folder = args.folder or Path("runs", f"{code.name}-sweep")

    def resolve(game: str, seed: int, chosen: "Chosen") -> Any:
        words = [game, *options, *grid_words(chosen), "--seed", str(seed)]
        return training_options(code, words, _program(code))

    seeds = find_seeds("0" if args.seeds is None else args.seeds)
    runs = plan(find_games(games), seeds, folder, resolve, find_grid(args.grid or ()))
    check_protocol(runs, protocol)
    check_folder(folder, code, runs, resolve)
    check_comparable(args, [run.options.task for run in runs], [planned_frames(runs)])
    settings = _do(args, code, options, folder, runs)
    return _finish(args, code.name, folder, runs, settings, args.compare or comparable_agents(runs, protocol))


def _program(code: "AgentCode") -> str:
    """The words that begin a training, for errors."""
    return f"atari train {code.name}"


def _parsed(
    args: argparse.Namespace, code: "AgentCode", words: Sequence[str]
) -> tuple[argparse.Namespace, str, list[str]]:
    """The flags of a sweep, the word of its games, and the options of its trainings.

    Raises:
        ValueError: the options have a seed.
    """
    from atari.learning.command import game_among

    args, options = _parser().parse_known_args(words, argparse.Namespace(**vars(args)))
    games = game_among(code, options, _program(code))
    places = [place for place, word in enumerate(options) if word == games]
    free = [place for place in places if place == 0 or not options[place - 1].startswith("-")]
    del options[(free or places)[0]]
    if any(word.partition("=")[0] == "--seed" for word in options):
        raise ValueError("a sweep has --seeds, such as --seeds 0-2; leave --seed out")
    return args, games, options


def _do(args: argparse.Namespace, code: "AgentCode", options: Sequence[str], folder: Path, runs: Sequence[Any]) -> Any:
    """Train and evaluate all runs, and return the settings of the sweep.

    Raises:
        BlockingIOError: another sweep writes into the folder.
        KeyboardInterrupt: after Ctrl-C, when all processes have saved and ended.
        RuntimeError: runs have failed.
    """
    from atari.base import durable
    from atari.base.program import ctrl_c_as_event
    from atari.learning.sweep.plan import keep_programs
    from atari.learning.sweep.processes import Settings, do_runs
    from atari.learning.sweep.table import Table

    folder.mkdir(parents=True, exist_ok=True)
    lock = durable.lock_file(folder / "sweep.lock", f"a sweep writes into {folder}; wait for its end, or stop it")
    with lock, ctrl_c_as_event() as stop:
        values = [value for run in runs for value in run.chosen.values()]
        named = code.name if code.program is None else str(code.program)
        agent, *kept = keep_programs(folder, [named, *options, *values])
        words, copies = kept[: len(options)], iter(kept[len(options) :])
        runs = [replace(run, chosen={name: next(copies) for name in run.chosen}) for run in runs]
        protocol = find_protocol(args.protocol)
        episodes = protocol.episodes if args.episodes is None else args.episodes
        command = (sys.executable, "-m", "atari.cli.sweep")
        settings = Settings(agent, tuple(words), args.games, protocol, episodes, args.jobs or 1, command)
        done = do_runs(runs, settings, stop, Table(sys.stderr, *shutil.get_terminal_size()).show)
    if stop.is_set():
        raise KeyboardInterrupt("before all runs were done; the same command goes on")
    if failed := [one for one in done if one.state == "failed"]:
        reasons = "; ".join(f"{one.run.name}: {one.error}" for one in failed)
        raise RuntimeError(f"{len(failed)} of {len(runs)} runs failed: {reasons}")
    return settings


def _finish(
    args: argparse.Namespace, agent: str, folder: Path, runs: Sequence[Any], settings: Any, to: Sequence[str]
) -> int:
    from atari.learning.sweep.processes import evaluation_of
    from atari.learning.sweep.report import compare_runs, grid_rows, write_report

    results = [result for run in runs if (result := evaluation_of(run, settings)) is not None]
    comparison = compare_runs(f"{agent} ({folder.name})", runs, results, to, args.mixed)
    report = write_report(folder, agent, runs, settings, results, comparison)
    if args.json:
        shown = [
            {"run": run.path, "grid": run.values, "evaluation": result.to_json()}
            for run, result in zip(runs, results, strict=True)
        ]
        print_json({"runs": shown, "comparison": comparison and comparison.to_json(), "report": report})
        return 0
    rows: list[Sequence[object]] = [("run", "games", "mean", "std")]
    for run, result in zip(runs, results, strict=True):
        played = result.games[0]
        rows.append((run.name, len(played.scores), f"{played.mean:,.1f}", f"{played.std:,.1f}"))
    print(f"protocol {settings.protocol}\n")
    print_table(rows)
    if runs[0].chosen:
        print()
        print_table(grid_rows(runs, results))
    if comparison is not None:
        print(f"\n{comparison}")
    print(f"\n{report.absolute()}")
    return 0


def _parser() -> argparse.ArgumentParser:
    """The flags of a sweep after the games; the flags of `atari train` keep their values from before the agent."""
    parser = Parser(prog="atari train", add_help=False)
    parser.add_argument("-o", "--run", dest="folder", type=Path, metavar="FOLDER")
    parser.add_argument("--protocol", default="machado2018", metavar="NAME")
    parser.add_argument("--episodes", type=number(int, 1, MAX_EPISODES), metavar="N")
    parser.add_argument("--compare", action="append", default=[], metavar="NAME")
    parser.add_argument("--mixed", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--games", type=number(int, 0), metavar="N")
    add_sweep(parser)
    return parser


def main() -> int:
    """Run a command of `atari` until stdin ends."""
    from atari.cli import main as atari

    threading.Thread(target=_end_with_stdin, daemon=True).start()
    return atari()


def _end_with_stdin() -> None:
    while os.read(0, 1):  # not sys.stdin, whose lock would be held at the interpreter's end
        pass
    _thread.interrupt_main()


if __name__ == "__main__":
    sys.exit(main())
