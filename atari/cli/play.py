"""`atari play`: play a game in a window, by keyboard or gamepad, and write a replay."""

import argparse
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from atari.cli.arguments import GAME_HELP, Commands, add_command, add_rom
from atari.cli.multiplayer import is_match, make_match, match_task
from atari.cli.printing import print_json
from atari.play import Session, play
from atari.play.controls import HELP, HELP_SEVERAL
from atari.play.outputs import start_pygame
from atari.task.arguments import SCREEN, add_task, given_options, show_task, task_of
from atari.task.parser import HelpFormatter, number, seed
from atari.task.task import BY_FRAME


class _KeysFormatter(HelpFormatter, argparse.RawDescriptionHelpFormatter):
    """Keeps the lines of the table of keys."""


def register(commands: Commands) -> None:
    """Add `atari play`."""
    parser = add_command(commands, "play", _play, "play a game in a window, and write a replay of it")
    parser.formatter_class = _KeysFormatter
    parser.epilog = f"keys:\n{HELP}\n\nkeys of several players:\n{HELP_SEVERAL}"
    parser.add_argument("game", metavar="GAME", help=f"{GAME_HELP}; with --players also a name of PettingZoo's")
    add_rom(parser)
    parser.add_argument(
        "--opponent",
        action="append",
        default=[],
        metavar="POLICY",
        help="player 2 is random, noop, a run folder, an SB3 zip, a TorchScript or ONNX file, or MODULE:NAME; may be "
        "repeated, for player 3 and so on",
    )
    parser.add_argument("--seed", type=seed, metavar="N", help="seed of the game (default: random)")
    parser.add_argument(
        "--scale", type=number(int, 1, 16), default=3, metavar="N", help="rows of the display a pixel (default: 3)"
    )
    parser.add_argument("--full-screen", action="store_true", help="fill the display")
    parser.add_argument("--no-sound", action="store_true", help="play no sound")
    replay = parser.add_mutually_exclusive_group()
    replay.add_argument(
        "--replay",
        type=Path,
        metavar="FILE",
        help="the replay, with the suffix .a26r (default: replays/GAME-TIME.a26r)",
    )
    replay.add_argument("--no-replay", action="store_true", help="write no replay")
    parser.add_argument(
        "--state", type=Path, metavar="FILE", help="the saved state of F5 and F9 (default: states/GAME.state)"
    )
    add_task(
        parser,
        ("game", "play", "begin", "lives", "limits", "obs_type"),
        refused=("continuous", "continuous_action_threshold"),
        fixed=SCREEN,
    )


def _play(args: argparse.Namespace) -> int:
    match = bool(args.opponent) or is_match(args)
    if match:
        task = match_task(args)
    else:
        if "obs_type" in given_options(args):
            raise ValueError("--obs-type needs --players; see `atari play --help`")
        task = task_of(args, base=BY_FRAME)
    if show_task(args, task):
        return 0
    start_pygame()  # raises without pygame or a display, before any file is created or replaced
    name = f"{task.game}-{task.players}-players" if match else task.game
    replay = args.replay
    if replay is None and not (match or args.no_replay):
        replay = Path("replays", f"{task.game}-{time.strftime('%Y%m%d-%H%M%S')}.a26r")
    new_folders = [] if replay is None else [folder for folder in replay.parents if not folder.exists()]
    files = {"replay": replay, "state": args.state or Path("states", f"{name}.state")}
    session: Any
    if match:
        session = make_match(args, task, "--opponent", args.opponent)(**files)
    else:
        session = Session(task, rom=args.rom, seed=args.seed, **files)
    try:
        play(session, scale=args.scale, sound=not args.no_sound, full_screen=args.full_screen)
    finally:
        session.close()
        if replay is not None and not session.frames:
            replay.unlink()
            with suppress(OSError):  # a folder that is not empty stays
                for folder in new_folders:
                    folder.rmdir()
    written = [path.resolve() for path in (replay, *session.files) if path is not None and path.exists()]
    own = {"players": task.players, "mode": task.mode, "scores": session.scores}
    result = {
        "game": task.game,
        "frames": session.frames,
        **(own if match else {"best_score": session.best}),
        "files": written,
    }
    if args.json:
        print_json(result)
    else:
        if not session.frames:
            line = f"{task.definition.title}: nothing was played" + (", and no replay was written" if replay else "")
        elif match:
            line = f"{session.title}   ({session.frames:,} frames)"
        else:
            line = f"{task.definition.title}: {session.frames:,} frames, best score {session.best:,}"
        print(line)
        print("".join(f"  {path}\n" for path in written), end="")
    return 0
