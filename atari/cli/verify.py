"""`atari verify`: the differential test of the native core as a command."""

import argparse
import itertools
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from multiprocessing import active_children, get_context
from os import cpu_count
from pathlib import Path
from typing import Any

from atari.base.program import children_without_ctrl_c
from atari.base.progress import ProgressBar
from atari.cli.arguments import GAME_HELP, Commands, add_command
from atari.cli.printing import print_json
from atari.cores import CORES
from atari.cores.host_check import differences, machine, read_goldens
from atari.cores.verify import Difference, VerificationRun, read, verify
from atari.games.catalog import games
from atari.task import Task
from atari.task.arguments import SCREEN, add_task, given_options, show_task, task_of
from atari.task.parser import number, seed

_BASE = {"max_num_frames_per_episode": None, "frameskip": 1, "actions": "full"}
"""The test compares each frame, with its own actions. A name alone has no limit of frames."""


def register(commands: Commands) -> None:
    """Add `atari verify`."""
    parser = add_command(
        commands,
        "verify",
        _verify,
        "play the native core and another side by side and compare them at every frame (exit code 1: they differ)",
    )
    parser.add_argument("games", nargs="*", metavar="GAME", help=f"{GAME_HELP} (default: all games)")
    parser.add_argument("--frames", type=number(int, 1), default=600, help="frames of a run (default 600)")
    parser.add_argument(
        "--seeds", type=seed, nargs="+", default=[0], metavar="SEED", help="one run for each (default 0)"
    )
    parser.add_argument("--modes", action="store_true", help="one run for each mode and difficulty of a game")
    parser.add_argument("--pokes", action="store_true", help="overwrite bytes of RAM at random")
    parser.add_argument("--strengths", action="store_true", help="move paddles by fractions")
    parser.add_argument(
        "--core",
        choices=[name for name in CORES if name != "native"],
        default="ale",
        help="what the native core is compared with: ale-py (the default), or the native core without its shortcuts",
    )
    parser.add_argument(
        "--jobs",
        type=number(int, 1, 1024),
        default=cpu_count(),
        metavar="N",
        help="processes (default: all processors)",
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("differences"), metavar="FOLDER")
    parser.add_argument(
        "--machine",
        action="store_true",
        help="print what the native core runs on this machine, and compare ten games with check sums of ale-py",
    )
    parser.add_argument(
        "--replay", type=Path, metavar="FILE", help="play a difference again from the file written for it"
    )
    add_task(
        parser,
        ("mode", "difficulty", "repeat_action_probability", "max_num_frames_per_episode"),
        fixed={**SCREEN, "frameskip": 1, "actions": "full"},
        preset=False,
    )


def _verify(args: argparse.Namespace) -> int:
    if args.machine:
        _refuse_others(args, "machine", "plays its own ten games")
        return _verify_machine(args)
    if args.replay:
        _refuse_others(args, "replay", "plays what its file says", "output")
        runs = [read(args.replay)]
    else:
        given = given_options(args)
        if args.modes and (wrong := [name for name in ("mode", "difficulty") if name in given]):
            raise ValueError(f"--modes plays all of them; leave it or --{wrong[0]} out")
        names = args.games or [game.id for game in games.playable()]
        tasks = []
        for name in names:
            tasks.append(task_of(args, game=name, base=_BASE))
            if args.games or args.print_task:
                show_task(args, tasks[-1])
        if args.print_task:
            return 0
        runs = list(_runs(args, tasks))
    differences = []
    for difference in ProgressBar(_results(runs, args.jobs), total=len(runs), unit="run", disable=None):
        if difference:
            differences.append(difference)
            if not args.json:
                ProgressBar.write(
                    f"{difference}\n  to play it again: atari verify --replay {difference.write(args.output)}"
                )
    frames = sum(run.frames for run in runs)
    if args.json:
        print_json({"runs": len(runs), "frames": frames, "differences": [asdict(each) for each in differences]})
    else:
        print(f"{len(runs)} runs, {frames} frames, {len(differences)} differences")
    return 1 if differences else 0


def _refuse_others(args: argparse.Namespace, option: str, does: str, *accepted: str) -> None:
    """Refuse the options that have no effect beside `option`."""
    run = ("games", "frames", "seeds", "modes", "pokes", "strengths", "core", "jobs", "output", "replay", "machine")
    others = [name for name in run if (getattr(args, name) or None) != (args.parser.get_default(name) or None)]
    for name in (*others, *given_options(args)):
        if name not in (option, *accepted):
            flag = "its games" if name == "games" else f"--{name.replace('_', '-')}"
            raise ValueError(f"--{option} {does}; leave {flag} out")


def _verify_machine(args: argparse.Namespace) -> int:
    here = machine()
    found = {game: differences(game, golden) for game, golden in read_goldens().items()}
    wrong = {game: lines for game, lines in found.items() if lines}
    if args.json:
        print_json({**asdict(here), "games": len(found), "differences": wrong})
        return 1 if wrong else 0
    print(f"platform: {here.platform}, {here.python}")
    print(f"SIMD level: {here.simd}")
    print(f"translator: {here.translator or 'off'}")
    for game, lines in wrong.items():
        print(f"{game}: {'; '.join(lines)}")
    print(f"{len(found)} games of 1000 frames compared with ale-py's check sums, {len(wrong)} differ")
    return 1 if wrong else 0


def _runs(args: argparse.Namespace, tasks: list[Task]) -> Iterator[VerificationRun]:
    for task, seed_ in itertools.product(tasks, args.seeds):
        game = task.definition
        every = itertools.product(game.modes, game.difficulties)
        settings: Any = every if args.modes else [(task.set_mode, task.set_difficulty)]
        for mode, difficulty in settings:
            yield VerificationRun(
                game.id if game.file is None else str(game.file),
                frames=args.frames,
                seed=seed_,
                repeat_action_probability=task.repeat_action_probability,  # type: ignore[arg-type]  # of one player
                mode=mode,
                difficulty=difficulty,
                max_num_frames_per_episode=task.max_num_frames_per_episode or 0,
                pokes=args.pokes,
                strengths=args.strengths,
                cores=("native", args.core),
            )


def _results(runs: list[VerificationRun], jobs: int) -> Iterator[Difference | None]:
    """Yield the outcome of each run, in the order of completion."""
    if jobs == 1 or len(runs) == 1:
        yield from map(verify, runs)
        return
    # Processes are separate because ale-py can end its process, and spawned because the parent may have threads.
    with ProcessPoolExecutor(min(jobs, len(runs)), mp_context=get_context("spawn")) as pool:
        try:
            with children_without_ctrl_c():
                futures = [pool.submit(verify, run) for run in runs]
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            for child in active_children():  # a run may be long, and the pool would wait for its end
                child.kill()
            raise
