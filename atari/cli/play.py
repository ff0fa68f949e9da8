"""`atari play`: play a game in a window, by keyboard or gamepad, and write a replay."""

import argparse
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from atari.cli.arguments import GAME_HELP, add_command, add_rom, find_game, number
from atari.cli.multiplayer import make_match, multiplayer
from atari.cli.output import print_json
from atari.play import Session, play
from atari.play.controls import HELP, HELP_SEVERAL
from atari.play.window import start_pygame

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands") -> None:
    """Add `atari play`."""
    parser = add_command(commands, "play", _play, "play a game in a window, and write a replay of it")
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = f"keys:\n{HELP}\n\nkeys of several players:\n{HELP_SEVERAL}"
    parser.add_argument("game", metavar="GAME", help=GAME_HELP)
    add_rom(parser)
    multiplayer(parser)
    parser.add_argument(
        "--opponent",
        action="append",
        default=[],
        metavar="POLICY",
        help="player 2 is random, noop, a run folder, an SB3 zip, a TorchScript or ONNX file, or MODULE:NAME; may be "
        "repeated, for player 3 and so on",
    )
    parser.add_argument("--seed", type=number(int, 0), metavar="N", help="seed of the game (default: random)")
    parser.add_argument(
        "--scale", type=number(int, 1), default=3, metavar="N", help="rows of the display a pixel (default: 3)"
    )
    parser.add_argument("--full-screen", action="store_true", help="fill the display")
    parser.add_argument("--no-sound", action="store_true", help="play no sound")
    replay = parser.add_mutually_exclusive_group()
    replay.add_argument(
        "--replay", type=Path, metavar="FILE", help="the replay, with the suffix .a26 (default: replays/GAME-TIME.a26)"
    )
    replay.add_argument("--no-replay", action="store_true", help="write no replay")
    parser.add_argument(
        "--state", type=Path, metavar="FILE", help="the saved state of F5 and F9 (default: states/GAME.state)"
    )


def _play(args: argparse.Namespace) -> int:
    if args.opponent or (args.players is not None and args.players > 1):
        return _play_together(args)
    if args.obs is not None:
        raise ValueError("--obs needs --players; see `atari play --help`")
    game = find_game(args.game, playable=False)
    if not game.single_player and game.multiplayer is not None and args.players is None:
        raise ValueError(f"{game.id} has no game of one player; give --players {min(game.multiplayer.modes)}")
    game = find_game(args.game)
    start_pygame()  # raises without pygame or a display, before any file is created or replaced
    replay, new_folders = None, []
    if not args.no_replay:
        replay = args.replay or Path("replays", f"{game.id}-{time.strftime('%Y%m%d-%H%M%S')}.a26")
        new_folders = [folder for folder in replay.parents if not folder.exists()]
    session = Session(
        game,
        rom=args.rom,
        replay=replay,
        state=args.state or Path("states", f"{game.id}.state"),
        mode=args.mode,
        difficulty=args.difficulty,
        seed=args.seed,
    )
    try:
        play(session, scale=args.scale, sound=not args.no_sound, full_screen=args.full_screen)
    finally:
        session.close()
        if replay is not None and not session.frames:
            replay.unlink()
            with suppress(OSError):  # a folder that is not empty stays
                for folder in new_folders:
                    folder.rmdir()
    files = [path.resolve() for path in (replay, *session.video_files) if path is not None and path.exists()]
    result = {"game": game.id, "frames": session.frames, "best_score": session.best, "files": files}
    if args.json:
        print_json(result)
    else:
        print(f"{game.title}: {session.frames:,} frames, best score {session.best:,}")
        print("".join(f"  {path}\n" for path in files), end="")
    return 0


def _play_together(args: argparse.Namespace) -> int:
    """Play a game of several players."""
    start_pygame()
    session = make_match(args, "--opponent", args.opponent, args.state, args.replay)
    try:
        play(session, scale=args.scale, sound=not args.no_sound, full_screen=args.full_screen)
    finally:
        session.close()
    files = [path.resolve() for path in (args.replay, *session.video_files) if path is not None and path.exists()]
    result = {
        "game": session.game.id,
        "players": session.core.players,
        "mode": session.core.mode,
        "frames": session.frames,
        "scores": session.scores,
        "files": files,
    }
    if args.json:
        print_json(result)
    else:
        print(f"{session.title}   ({session.frames:,} frames)")
        print("".join(f"  {path}\n" for path in files), end="")
    return 0
