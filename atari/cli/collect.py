"""`atari collect`: a policy plays a game, and the frames, RAM, labels, actions and rewards become a data set."""

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from atari.cli.arguments import GAME_HELP, add_command, find_game, number
from atari.cli.output import print_json
from atari.recording import Replay

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands", name: str = "collect") -> None:
    """Add `atari collect`, which is `atari lab collect` too."""
    parser = add_command(commands, name, _collect, "let a policy play a game, and write what happens as data")
    parser.epilog = f"Example: atari {name} pong --policy random --episodes 3 -o pong.h5"
    parser.add_argument("game", metavar="GAME", help=GAME_HELP)
    parser.add_argument(
        "--policy",
        default="random",
        metavar="POLICY",
        help="random, noop, MODULE:FUNCTION, a run folder of `atari train`, an SB3 zip, a TorchScript or ONNX file, or "
        "a replay, such as game.a26 (default: random)",
    )
    parser.add_argument("--episodes", type=number(int, 1), default=1, metavar="N", help="number of games (default: 1)")
    parser.add_argument(
        "--seed", type=number(int, 0), default=0, metavar="N", help="seed of games and policy (default: 0)"
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUTPUT",
        help="a file (.h5, .hdf5, .parquet), or the ID of a Minari dataset, such as atari/pong/random-v0",
    )
    parser.add_argument("--format", choices=("minari", "parquet", "hdf5"), help="the format (default: by the output)")
    parser.add_argument("--frames", choices=("rgb", "grayscale"), default="rgb", help="their colours (default: rgb)")
    parser.add_argument("--labels", metavar="NAMES", help="names of labels, with commas between (default: all)")
    parser.add_argument(
        "--ray",
        metavar="ADDRESS",
        help="let the workers of a Ray cluster play: auto, HOST:PORT, or local, which starts one on this machine. A "
        ".parquet output is a folder then. The same command again goes on where one was stopped",
    )


def _collect(args: argparse.Namespace) -> int:
    game = find_game(args.game)
    labels = None if args.labels is None else [name for name in args.labels.split(",") if name]
    options: dict[str, Any] = {"format": args.format, "frames": args.frames, "labels": labels}
    result = (_collect_here if args.ray is None else _collect_by_workers)(args, game, options)
    result = {"game": game.id, "policy": args.policy, "seed": args.seed, **result}
    print_json(result) if args.json else print(_summary(result))
    return 0


def _collect_by_workers(args: argparse.Namespace, game: Any, options: dict[str, Any]) -> dict[str, Any]:
    from atari.integrations.ray import collect

    if args.policy.endswith(".a26"):
        raise ValueError(f"--ray plays games of a policy, and {args.policy} is a replay; leave out --ray")
    import ray

    if not ray.is_initialized():
        ray.init(args.ray, log_to_driver=False)
    seeds = range(args.seed, args.seed + args.episodes)
    with tqdm(unit=" games", total=len(seeds), disable=None) as bar:
        return collect(game, args.output, policy=args.policy, seeds=seeds, progress=bar.update, **options)


def _collect_here(args: argparse.Namespace, game: Any, options: dict[str, Any]) -> dict[str, Any]:
    from atari.lab.collect import check_output, write_dataset

    check_output(args.output, args.format)  # before the games are played
    with tempfile.TemporaryDirectory() as folder:
        if args.policy.endswith(".a26"):
            replay = Replay.load(args.policy)
            if replay.game != game:
                raise ValueError(f"{args.policy} is a replay of {replay.game.id}, not of {game.id}")
        else:
            replay = _play(args, game, Path(folder, "games.a26"))
        with tqdm(unit=" steps", disable=None) as bar:
            return write_dataset(replay, args.output, progress=bar.update, **options)


def _play(args: argparse.Namespace, game: Any, path: Path) -> Replay:
    from atari.learning import load_policy, record_games

    policy = load_policy(args.policy)
    seeds = range(args.seed, args.seed + args.episodes)
    record_games(policy, game, getattr(policy, "protocol", "baselines"), seeds, path)
    return Replay.load(path)


def _summary(result: dict[str, Any]) -> str:
    scores = ", ".join(f"{score:,.0f}" for score in result["scores"])
    return "\n".join(
        [
            f"{result['game']}: policy {result['policy']}, seed {result['seed']}",
            f"  episodes  {result['episodes']}, {result['steps']:,} steps",
            f"  scores    {scores}",
            f"  labels    {', '.join(result['labels']) or 'none'}",
            f"  data      {result['output']} ({result['format']})",
        ]
    )
