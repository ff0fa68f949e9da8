"""`atari collect`: a policy plays a game, and the frames, RAM, labels, actions and rewards become a data set."""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from atari.base.progress import ProgressBar
from atari.cli.arguments import GAME_HELP, Commands, add_command
from atari.cli.policies import NOT_RECORDED, UNCLIPPED, find_played, games_of, replay_of
from atari.cli.printing import print_json
from atari.cores.options import SEED_LIMIT
from atari.lab.dataset import check_output, write_dataset
from atari.lab.labels import Labels, UnknownLabelError
from atari.learning import load_policy
from atari.learning.evaluation.played import EvaluatedGame
from atari.learning.evaluation.protocols import MAX_EPISODES
from atari.recording import Replay
from atari.recording.replay.file_format import is_replay
from atari.task.arguments import add_task, show_task
from atari.task.parser import number, seed


def register(commands: Commands) -> None:
    """Add `atari collect`."""
    parser = add_command(commands, "collect", _collect, "let a policy play a game, and write what happens as data")
    parser.epilog = "Example: atari collect pong --policy random --episodes 3 -o pong.h5"
    parser.add_argument(
        "game",
        metavar="GAME",
        help=f"{GAME_HELP}. An ID is played unchanged; a policy that needs another task is refused",
    )
    parser.add_argument(
        "--policy",
        default="random",
        metavar="POLICY",
        help="random, noop, MODULE:FUNCTION, a run folder of `atari train`, an SB3 zip, a TorchScript or ONNX file, or "
        "a replay, such as game.a26r (default: random)",
    )
    parser.add_argument(
        "--episodes", type=number(int, 1, MAX_EPISODES), default=1, metavar="N", help="number of games (default: 1)"
    )
    parser.add_argument(
        "--seed", type=seed, default=0, metavar="N", help="seed of the first game and policy, below 2**32 (default: 0)"
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
    add_task(parser, refused=NOT_RECORDED, fixed=UNCLIPPED)


def _collect(args: argparse.Namespace) -> int:
    labels = None if args.labels is None else [name.strip() for name in args.labels.split(",") if name.strip()]
    options: dict[str, Any] = {"format": args.format, "frames": args.frames, "labels": labels}
    seeds = range(args.seed, args.seed + args.episodes)
    if seeds[-1] >= SEED_LIMIT:
        raise ValueError(f"seeds are below {SEED_LIMIT}; {args.episodes} games from --seed {args.seed} on are too many")
    replay, game, record = None, None, None
    if is_replay(args.policy):
        if args.ray is not None:
            raise ValueError(f"--ray plays games of a policy, and {args.policy} is a replay; leave out --ray")
        replay = replay_of(args, args.policy)
        task = replay.task
    else:
        policy = load_policy(args.policy)
        (game,) = find_played(args, [args.game], policy)
        task, record = games_of(policy, game)
    try:
        Labels(task.definition, labels)  # before the games are played
    except UnknownLabelError as error:
        raise ValueError(str(error)) from None
    if show_task(args, task):
        return 0
    if args.ray is not None and game is not None:
        result = _collect_by_workers(args, game, seeds, options)
    else:
        check_output(args.output, args.format)  # before the games are played
        with tempfile.TemporaryDirectory() as folder, ProgressBar(unit=" steps", disable=None) as bar:
            facts: dict[str, Any] = {"task": json.loads(task.to_json())}
            if record is not None:
                record(seeds, path := Path(folder, "games.a26r"))
                replay = Replay.load(path, game=task.definition)
                facts |= {"policy": args.policy, "seeds": list(seeds)}
            assert replay is not None
            result = {**write_dataset(replay, args.output, facts=facts, progress=bar.update, **options), **facts}
    result = {"game": task.game, "policy": args.policy, "seed": args.seed, **result}
    print_json(result) if args.json else print(_summary(result))
    return 0


def _collect_by_workers(
    args: argparse.Namespace, game: EvaluatedGame, seeds: range, options: dict[str, Any]
) -> dict[str, Any]:
    import ray

    from atari.integrations.ray import collect

    if not ray.is_initialized():
        ray.init(args.ray, log_to_driver=False)
    with ProgressBar(unit=" games", total=len(seeds), disable=None) as bar:
        return collect(game, args.output, policy=args.policy, seeds=seeds, progress=bar.update, **options)


def _summary(result: dict[str, Any]) -> str:
    scores = ", ".join(f"{score:,.0f}" for score in result["scores"])
    return "\n".join(
        [
            f"  policy    {result['policy']}, seed {result['seed']}",
            f"  episodes  {result['episodes']}, {result['steps']:,} steps",
            f"  scores    {scores}",
            f"  labels    {', '.join(result['labels']) or 'none'}",
            f"  data      {result['output']} ({result['format']})",
        ]
    )
