"""`atari collect`: a policy plays a game, and the frames, RAM, labels, actions and rewards become a data set."""

import argparse
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from atari.cli.arguments import GAME_HELP, add_command, number
from atari.cli.games_of_policies import add_game_options, find_played
from atari.cli.output import print_json
from atari.cli.task_arguments import SEEDS, seed
from atari.learning.evaluation.played import Entry
from atari.recording import Replay
from atari.task import Task
from atari.task.arguments import given_options
from atari.task.description import summary

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands", name: str = "collect") -> None:
    """Add `atari collect`, which is `atari lab collect` too."""
    parser = add_command(commands, name, _collect, "let a policy play a game, and write what happens as data")
    parser.epilog = f"Example: atari {name} pong --policy random --episodes 3 -o pong.h5"
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
        "a replay, such as game.a26 (default: random)",
    )
    parser.add_argument("--episodes", type=number(int, 1), default=1, metavar="N", help="number of games (default: 1)")
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
    add_game_options(parser)
    parser.add_argument(
        "--ray",
        metavar="ADDRESS",
        help="let the workers of a Ray cluster play: auto, HOST:PORT, or local, which starts one on this machine. A "
        ".parquet output is a folder then. The same command again goes on where one was stopped",
    )


def _collect(args: argparse.Namespace) -> int:
    (entry,) = find_played(args, [args.game])
    labels = None if args.labels is None else [name for name in args.labels.split(",") if name]
    options: dict[str, Any] = {"format": args.format, "frames": args.frames, "labels": labels}
    seeds = range(args.seed, args.seed + args.episodes)
    if seeds[-1] >= SEEDS:
        raise ValueError(f"seeds are below {SEEDS}; {args.episodes} games from --seed {args.seed} on are too many")
    result = (_collect_here if args.ray is None else _collect_by_workers)(args, entry, seeds, options)
    result = {"game": entry.id, "policy": args.policy, "seed": args.seed, **result}
    print_json(result) if args.json else print(_summary(result))
    return 0


def _collect_by_workers(
    args: argparse.Namespace, entry: Entry, seeds: range, options: dict[str, Any]
) -> dict[str, Any]:
    from atari.integrations.ray import collect

    if args.policy.endswith(".a26"):
        raise ValueError(f"--ray plays games of a policy, and {args.policy} is a replay; leave out --ray")
    import ray

    if not ray.is_initialized():
        ray.init(args.ray, log_to_driver=False)
    with tqdm(unit=" games", total=len(seeds), disable=None) as bar:
        return collect(entry, args.output, policy=args.policy, seeds=seeds, progress=bar.update, **options)


def _collect_here(args: argparse.Namespace, entry: Entry, seeds: range, options: dict[str, Any]) -> dict[str, Any]:
    from atari.lab.collect import check_output, write_dataset

    check_output(args.output, args.format)  # before the games are played
    facts: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        if args.policy.endswith(".a26"):
            replay = _replay(args, entry)
        else:
            replay, facts = _play(args.policy, entry, seeds, Path(folder, "games.a26"))
        with tqdm(unit=" steps", disable=None) as bar:
            result = write_dataset(replay, args.output, facts=facts, progress=bar.update, **options)
    return {**result, "task": facts.get("task")}


def _replay(args: argparse.Namespace, entry: Entry) -> Replay:
    """A replay of the game.

    Raises:
        ValueError: it is of another game, or GAME says more than the game, which the replay decides.
    """
    replay = Replay.load(args.policy)
    if replay.game != entry.task.definition:
        raise ValueError(f"{args.policy} is a replay of {replay.game.id}, not of {entry.id}")
    if entry.env_id is not None or given_options(args):
        raise ValueError(f"what was played is in the replay {args.policy}; name the game alone, {entry.id!r}")
    return replay


def _play(source: str, entry: Entry, seeds: range, path: Path) -> tuple[Replay, dict[str, Any]]:
    """Play games, and return their replay, and the facts about them that the data set has."""
    from atari.learning import load_policy, record_games
    from atari.learning.evaluation.played import usual_protocol
    from atari.learning.evaluation.player import Player

    policy = load_policy(source)
    protocol = usual_protocol(policy, entry)
    task = Player(policy, protocol, entry).task
    record_games(policy, entry, protocol, seeds, path)
    return Replay.load(path), {"task": json.loads(task.to_json()), "policy": source, "seeds": list(seeds)}


def _summary(result: dict[str, Any]) -> str:
    task = result.get("task")
    played = [f"  task      {summary(Task.from_json(json.dumps(task)))}"] if task else []
    scores = ", ".join(f"{score:,.0f}" for score in result["scores"])
    return "\n".join(
        [
            f"{result['game']}: policy {result['policy']}, seed {result['seed']}",
            *played,
            f"  episodes  {result['episodes']}, {result['steps']:,} steps",
            f"  scores    {scores}",
            f"  labels    {', '.join(result['labels']) or 'none'}",
            f"  data      {result['output']} ({result['format']})",
        ]
    )
