"""`atari watch`: a policy plays in a window, with sound."""

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from atari.cli.arguments import GAME_HELP, add_command, find_game, number
from atari.learning import load_policy, record_games
from atari.learning.evaluation.protocols import PROTOCOLS
from atari.play.viewer import show_replay
from atari.play.window import start_pygame
from atari.recording import Replay

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands") -> None:
    """Add `atari watch`."""
    parser = add_command(commands, "watch", _watch, "watch a policy play whole games, in a window")
    parser.add_argument(
        "source",
        metavar="SOURCE",
        help="a run folder, an SB3 zip, a TorchScript or ONNX file, MODULE:NAME, random, noop, or a replay (.a26)",
    )
    parser.add_argument("game", nargs="?", metavar="GAME", help=f"{GAME_HELP} (default: that of the run folder)")
    parser.add_argument(
        "--protocol",
        metavar="NAME",
        help=f"{', '.join(PROTOCOLS)} (default: baselines, or games as in the training of a run folder)",
    )
    parser.add_argument("--seed", type=number(int, 0), default=0, metavar="N", help="of the first game (default: 0)")
    parser.add_argument(
        "--scale", type=number(int, 1), default=3, metavar="N", help="rows of the display a pixel (default: 3)"
    )
    parser.add_argument("--no-sound", action="store_true", help="play no sound")


def _watch(args: argparse.Namespace) -> int:
    start_pygame()  # raises without pygame or a display, before a game is played
    if args.source.endswith(".a26"):
        show_replay(Replay.load(args.source), scale=args.scale, sound=not args.no_sound)
        return 0
    policy = load_policy(args.source)
    game = args.game or getattr(policy, "game", None)
    if game is None:
        raise ValueError(f"{args.source} does not say which game it plays; name one, as in `atari watch SOURCE pong`")
    protocol = args.protocol or getattr(policy, "protocol", "baselines")
    seed, shown = int(args.seed), True
    with tempfile.TemporaryDirectory() as folder:
        while shown:
            path = Path(folder, f"{seed}.a26")
            ((score, _),) = record_games(policy, find_game(game), protocol, [seed], path)
            print(f"seed {seed}: score {score:,.0f}", flush=True)
            shown = show_replay(Replay.load(path), scale=args.scale, sound=not args.no_sound)
            seed += 1
    return 0
