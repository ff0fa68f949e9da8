"""Sweeps of `atari train`: several games or seeds, each training in a process of its own.

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
from pathlib import Path
from typing import Any

from atari.cli.arguments import number
from atari.cli.printing import print_json, print_table
from atari.learning import GAME_SETS
from atari.learning.agents import AGENTS
from atari.learning.evaluation.compare import budget_faults
from atari.learning.evaluation.protocols import MAX_EPISODES, find_protocol, refusal
from atari.learning.evaluation.published import Published

FLAGS = ("--seeds", "--jobs")
"""Flags that make a training a sweep."""


def add_sweep(parser: argparse.ArgumentParser) -> None:
    """Add the flags that may also precede the agent."""
    parser.add_argument("--seeds", metavar="SEEDS", help="a sweep: train with each of these seeds, such as 0-2 or 0,7")
    parser.add_argument(
        "--jobs", type=number(int, 1, 1024), metavar="N", help="a sweep: processes at a time (default: 1)"
    )


def is_sweep(args: argparse.Namespace, words: Sequence[str]) -> bool:
    """Whether a command line of `atari train` names several games or seeds."""
    flags = any(word.partition("=")[0] in FLAGS for word in words)
    games = words[1] if len(words) > 1 else ""
    several = games in GAME_SETS or ("," in games and not Path(games).exists())
    return flags or several or args.seeds is not None or args.jobs is not None


def run_sweep(args: argparse.Namespace, words: Sequence[str]) -> int:
    """Do the sweep of a command line: AGENT, GAMES, flags of the sweep and options of the trainings."""
    import atari.learning.evaluation.plot  # noqa: F401 - raises an error without Matplotlib, before the trainings
    from atari._interrupt import ctrl_c_as_event
    from atari.files import durable
    from atari.learning.command import options_of
    from atari.learning.sweep import plan
    from atari.learning.sweep.processes import Settings, do_runs
    from atari.learning.sweep.results import comparable_agents, planned_frames
    from atari.learning.sweep.table import Table

    agent, games, *rest = [*words, "", ""][: max(2, len(words))]
    if agent not in AGENTS or not games or games.startswith("-"):
        raise ValueError("name an agent and then its games, as in `atari train ppo pong,breakout --seeds 0-2`")
    args, options = _parser().parse_known_args(rest, argparse.Namespace(**vars(args)))
    if any(word.partition("=")[0] == "--seed" for word in options):
        raise ValueError("a sweep has --seeds, such as --seeds 0-2; leave --seed out")
    protocol = find_protocol(args.protocol)
    folder = args.folder or Path("runs", f"{agent}-sweep")

    def resolve(game: str, seed: int) -> Any:
        return options_of(agent, [game, *options, "--seed", str(seed)], f"atari train {agent}")

    seeds = plan.find_seeds("0" if args.seeds is None else args.seeds)
    runs = plan.plan(plan.find_games(games), seeds, folder, resolve)
    plan.check_protocol(runs, protocol)
    plan.check_folder(folder, agent, runs, resolve)
    frames = planned_frames(runs[0].options)
    for agent_ in map(Published, args.compare):
        faults = [fault for fault in (refusal(protocol, agent_), *budget_faults(agent_, frames)) if fault]
        if faults and not args.mixed:
            raise ValueError(f"{agent_.name} is not comparable: {'; '.join(faults)}; --mixed compares it, and says so")
    episodes = protocol.episodes if args.episodes is None else args.episodes
    command = (sys.executable, "-m", "atari.cli.sweep")
    settings = Settings(agent, tuple(options), args.games, protocol, episodes, args.jobs or 1, command)
    folder.mkdir(parents=True, exist_ok=True)
    lock = durable.lock_file(folder / "sweep.lock", f"a sweep writes into {folder}; wait for its end, or stop it")
    with lock, ctrl_c_as_event() as stop:
        table = Table(sys.stderr, *shutil.get_terminal_size())
        done = do_runs(runs, settings, stop, table.show)
    if stop.is_set():
        raise KeyboardInterrupt("; the same command goes on")
    if failed := [one for one in done if one.state == "failed"]:
        reasons = "; ".join(f"{one.run.name}: {one.error}" for one in failed)
        raise RuntimeError(f"{len(failed)} of {len(runs)} runs failed: {reasons}")
    return _finish(args, folder, runs, settings, args.compare or comparable_agents(runs, protocol))


def _finish(args: argparse.Namespace, folder: Path, runs: Sequence[Any], settings: Any, to: Sequence[str]) -> int:
    """Compare, write the page, and print the results."""
    from atari.learning.sweep.processes import evaluation_of
    from atari.learning.sweep.report import write_report
    from atari.learning.sweep.results import compare_runs

    results = [result for run in runs if (result := evaluation_of(run, settings)) is not None]
    comparison = compare_runs(f"{settings.agent} ({folder.name})", runs, results, to, args.mixed)
    report = write_report(folder, runs, settings, results, comparison)
    if args.json:
        shown = [{"run": run.path, "evaluation": result.to_json()} for run, result in zip(runs, results, strict=True)]
        print_json({"runs": shown, "comparison": comparison and comparison.to_json(), "report": report})
        return 0
    rows: list[Sequence[object]] = [("run", "games", "mean", "std")]
    for run, result in zip(runs, results, strict=True):
        played = result.games[0]
        rows.append((run.name, len(played.scores), f"{played.mean:,.1f}", f"{played.std:,.1f}"))
    print(f"protocol {settings.protocol}\n")
    print_table(rows)
    if comparison is not None:
        print(f"\n{comparison}")
    print(f"\n{report.absolute()}")
    return 0


def _parser() -> argparse.ArgumentParser:
    """The flags of a sweep after the games; those of `atari train` keep the values that they have before the agent."""
    parser = argparse.ArgumentParser(prog="atari train", add_help=False, allow_abbrev=False)
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
