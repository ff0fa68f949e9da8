"""`atari watch`: a policy plays in a window, with sound."""

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from atari.cli.arguments import GAME_HELP, add_command, number
from atari.cli.games_of_policies import add_game_options, find_played
from atari.cli.task_arguments import SEEDS, seed
from atari.learning import load_policy, record_games
from atari.learning.evaluation.played import usual_protocol
from atari.learning.evaluation.player import Player
from atari.learning.evaluation.protocols import PROTOCOLS, find_protocol
from atari.play.viewer import show_replay
from atari.play.window import start_pygame
from atari.recording import Replay
from atari.task.description import summary

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
        help=f"{', '.join(PROTOCOLS)} (default: games as in the training of a run folder; as an ID says, for a policy "
        "that does not say what it needs; else baselines)",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="of the first game, below 2**32 (default: 0)")
    parser.add_argument(
        "--scale", type=number(int, 1), default=3, metavar="N", help="rows of the display a pixel (default: 3)"
    )
    add_game_options(parser)
    parser.add_argument("--no-sound", action="store_true", help="play no sound")


def _watch(args: argparse.Namespace) -> int:
    start_pygame()  # raises without pygame or a display, before a game is played
    if args.source.endswith(".a26"):
        show_replay(Replay.load(args.source), scale=args.scale, sound=not args.no_sound)
        return 0
    policy = load_policy(args.source)
    (entry,) = find_played(args, [] if args.game is None else [args.game], policy)
    protocol = find_protocol(args.protocol) if args.protocol else usual_protocol(policy, entry)
    print(summary(Player(policy, protocol, entry).task), flush=True)
    game_seed, shown = args.seed, True
    with tempfile.TemporaryDirectory() as folder:
        while shown:
            path = Path(folder, f"{game_seed}.a26")
            ((score, _),) = record_games(policy, entry, protocol, [game_seed], path)
            print(f"seed {game_seed}: score {score:,.0f}", flush=True)
            shown = show_replay(Replay.load(path), scale=args.scale, sound=not args.no_sound)
            game_seed = (game_seed + 1) % SEEDS
    return 0
