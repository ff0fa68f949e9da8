"""`atari watch`: a policy plays in a window, with sound."""

import argparse
import tempfile
from pathlib import Path

from atari.cli.arguments import GAME_HELP, Commands, add_command
from atari.cli.policies import NOT_RECORDED, UNCLIPPED, find_played, games_of, replay_of
from atari.cores.options import SEED_LIMIT
from atari.learning import load_policy
from atari.learning.evaluation.protocols import PROTOCOLS
from atari.play.loop import show_replay
from atari.play.outputs import start_pygame
from atari.recording import Replay
from atari.recording.replay.file_format import is_replay
from atari.task.arguments import add_task, show_task
from atari.task.parser import number, seed


def register(commands: Commands) -> None:
    """Add `atari watch`."""
    parser = add_command(commands, "watch", _watch, "watch a policy play whole games, in a window")
    parser.add_argument(
        "source",
        metavar="SOURCE",
        help="a run folder, an SB3 zip, a TorchScript or ONNX file, MODULE:NAME, random, noop, or a replay (.a26r)",
    )
    parser.add_argument("game", nargs="?", metavar="GAME", help=f"{GAME_HELP} (default: that of the run folder)")
    parser.add_argument(
        "--protocol",
        metavar="NAME",
        help=f"{', '.join(PROTOCOLS)} (default: games as in the training of a run folder; as an ID says, for a policy "
        "that does not say what it needs; else baselines)",
    )
    parser.add_argument(
        "--seed", type=seed, default=0, metavar="N", help="seed of the first game, below 2**32 (default: 0)"
    )
    parser.add_argument(
        "--scale", type=number(int, 1, 16), default=3, metavar="N", help="rows of the display a pixel (default: 3)"
    )
    parser.add_argument("--no-sound", action="store_true", help="play no sound")
    add_task(parser, refused=NOT_RECORDED, fixed=UNCLIPPED)


def _watch(args: argparse.Namespace) -> int:
    if is_replay(args.source):
        replay = Replay.load(args.source) if args.game is None else replay_of(args, args.source)
        if replay.players == 1 and show_task(args, replay.task):
            return 0
        show_replay(replay, scale=args.scale, sound=not args.no_sound)
        return 0
    policy = load_policy(args.source)
    (game,) = find_played(args, [] if args.game is None else [args.game], policy)
    task, player = games_of(policy, game, args.protocol)
    if show_task(args, task):
        return 0
    start_pygame()  # raises without pygame or a display, before a game is played
    game_seed, shown = args.seed, True
    with tempfile.TemporaryDirectory() as folder:
        while shown:
            path = Path(folder, f"{game_seed}.a26r")
            ((score, _),) = player.record([game_seed], path)
            print(f"seed {game_seed}: score {score:,.0f}", flush=True)
            replay = Replay.load(path, game=task.definition)
            shown = show_replay(replay, scale=args.scale, sound=not args.no_sound)
            game_seed = (game_seed + 1) % SEED_LIMIT
    return 0
