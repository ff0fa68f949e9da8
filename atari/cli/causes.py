"""`atari causes`: the effects of each byte of a game's RAM, as data and as an image."""

import argparse
import time
from os import cpu_count
from pathlib import Path
from typing import Any

from atari.base.progress import ProgressBar
from atari.cli.arguments import GAME_HELP, Commands, add_command, add_rom
from atari.cli.printing import print_json
from atari.task.arguments import SCREEN, add_task, show_task, task_of
from atari.task.parser import number, seed
from atari.task.task import BY_FRAME


def register(commands: Commands) -> None:
    """Add `atari causes`."""
    parser = add_command(
        commands, "causes", _causes, "find what each byte of a game's RAM causes, and write it as data and as a picture"
    )
    parser.add_argument("game", metavar="GAME", help=GAME_HELP)
    add_rom(parser)
    count = number(int, 1)
    parser.add_argument("--states", type=count, default=200, metavar="N", help="states of the game (default: 200)")
    parser.add_argument("--values", type=count, default=4, metavar="N", help="changes of a byte (default: 4)")
    parser.add_argument("--frames", type=count, default=4, metavar="N", help="frames after each (default: 4)")
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of play and values")
    parser.add_argument(
        "--threads", type=count, default=cpu_count(), metavar="N", help="threads (default: all processors)"
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("maps"), metavar="FOLDER", help="for GAME.npz and GAME.png"
    )
    fixed = {**SCREEN, **BY_FRAME}  # forks are played frame by frame beside a twin with the same random words
    add_task(parser, ("mode", "difficulty"), fixed=fixed, preset=False)


def _causes(args: argparse.Namespace) -> int:
    from atari.lab.causal.explore import causes
    from atari.lab.causal.files import save
    from atari.lab.causal.picture import write_png

    task = task_of(args, base=BY_FRAME)
    if show_task(args, task):
        return 0
    game = task.definition
    args.output.mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    with ProgressBar(total=args.states, unit=" states", disable=None, leave=False) as bar:
        options: dict[str, Any] = {"threads": args.threads, "progress": bar.update, "rom": args.rom}
        found = causes(task, args.states, args.values, args.frames, args.seed, **options)
    seconds = time.perf_counter() - start
    data, picture = args.output / f"{game.id}.npz", args.output / f"{game.id}.png"
    save(found, data)
    write_png(found, picture, game)
    if args.json:
        facts: dict[str, Any] = {"data": data, "picture": picture, "seconds": round(seconds, 1), "game": found.game}
        facts["suggestions"] = found.suggestions
        for kind in ("derived", "inert", "seen"):
            facts[kind] = [byte.index for byte in found.bytes if getattr(byte, kind)]
        print_json(facts)
        return 0
    print(f"{found!r}, in {seconds:.1f} seconds")
    for each in found.suggestions:
        print(f"  {each}")
    print(f"{data}\n{picture}")
    return 0
