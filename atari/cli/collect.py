"""`atari collect`: a policy plays a game, and observations, RAM, labels, actions and rewards become a data set."""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any, get_args

from atari.base.progress import ProgressBar
from atari.cli.arguments import GAME_HELP, Commands, add_command
from atari.cli.policies import NOT_RECORDED, UNCLIPPED, find_played, games_of, replay_of
from atari.cli.printing import print_json
from atari.cores.options import SEED_LIMIT
from atari.lab.dataset import Observations, check_output, write_dataset
from atari.lab.dataset_check import check_dataset
from atari.lab.dataset_reader import read_dataset
from atari.lab.labels import Labels, UnknownLabelError
from atari.learning import load_policy
from atari.learning.evaluation.played import EvaluatedGame
from atari.learning.evaluation.protocols import MAX_EPISODES
from atari.recording import Replay
from atari.recording.episodes import check_seen
from atari.recording.replay.file_format import is_replay
from atari.task.arguments import add_task, given_options, show_task
from atari.task.parser import number, seed


def register(commands: Commands) -> None:
    """Add `atari collect`."""
    parser = add_command(commands, "collect", _collect, "let a policy play a game, and write what happens as data")
    parser.epilog = "Example: atari collect pong --policy random --episodes 3 -o pong.h5"
    parser.add_argument(
        "game",
        metavar="GAME",
        nargs="?",
        help=f"{GAME_HELP}. An ID is played unchanged; a policy that needs another task is refused",
    )
    parser.add_argument(
        "--policy",
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
        metavar="OUTPUT",
        help="a file (.h5, .hdf5, .parquet), or the ID of a Minari dataset, such as atari/pong/random-v0",
    )
    parser.add_argument("--format", choices=("minari", "parquet", "hdf5"), help="the format (default: by the output)")
    parser.add_argument(
        "--observations",
        choices=get_args(Observations),
        help="the frame of each step: seen, what the policy saw; screen, the last screen of the step in RGB; "
        "grayscale, the same in gray; or ram, none (default: seen for a policy with a task, else screen)",
    )
    parser.add_argument("--labels", metavar="NAMES", help="names of labels, with commas between (default: all)")
    parser.add_argument(
        "--ray",
        metavar="ADDRESS",
        help="let the workers of a Ray cluster play: auto, HOST:PORT, or local, which starts one on this machine. A "
        ".parquet output is a folder then. The same command again goes on where one was stopped",
    )
    parser.add_argument(
        "--check",
        metavar="DATA",
        help="in place of a game: compare the checksums of a data set, and its actions with those that its policy "
        "chooses from the stored observations; --policy names a policy that the data set does not name, or that is a "
        "program",
    )
    add_task(parser, refused=NOT_RECORDED, fixed=UNCLIPPED)


def _collect(args: argparse.Namespace) -> int:
    if args.check is not None:
        return _check(args)
    for option, value in (("GAME", args.game), ("--output", args.output)):
        if value is None:
            raise ValueError(f"{option} is missing; name it, or a data set to --check; see `atari collect --help`")
    args.policy = args.policy or "random"
    labels = None if args.labels is None else [name.strip() for name in args.labels.split(",") if name.strip()]
    options: dict[str, Any] = {"format": args.format, "labels": labels}
    seeds = range(args.seed, args.seed + args.episodes)
    if seeds[-1] >= SEED_LIMIT:
        raise ValueError(f"seeds are below {SEED_LIMIT}; {args.episodes} games from --seed {args.seed} on are too many")
    replay, game, player = None, None, None
    if is_replay(args.policy):
        if args.ray is not None:
            raise ValueError(f"--ray plays games of a policy, and {args.policy} is a replay; leave out --ray")
        replay = replay_of(args, args.policy)
        task, options["observations"] = replay.task, args.observations or "screen"
    else:
        policy = load_policy(args.policy)
        (game,) = find_played(args, [args.game], policy)
        task, player = games_of(policy, game)
        options["observations"] = args.observations or player.stored_observations
    try:
        Labels(task.definition, labels)  # before the games are played
    except UnknownLabelError as error:
        raise ValueError(str(error)) from None
    if show_task(args, task):
        return 0
    if options["observations"] == "seen":
        check_seen(task)  # before the games are played
    if args.ray is not None and game is not None:
        result = _collect_by_workers(args, game, seeds, options)
    else:
        check_output(args.output, args.format)  # before the games are played
        with tempfile.TemporaryDirectory() as folder, ProgressBar(unit=" steps", disable=None) as bar:
            facts: dict[str, Any] = {"task": json.loads(task.to_json())}
            if player is not None:
                player.record(seeds, path := Path(folder, "games.a26r"))
                replay = Replay.load(path, game=task.definition)
                facts |= {"policy": args.policy, "seeds": list(seeds)}
                own = player
                options["chosen"] = lambda episode, steps: own.choices(seeds[episode], steps)
            assert replay is not None
            result = {**write_dataset(replay, args.output, facts=facts, progress=bar.update, **options), **facts}
    result = {"game": task.game, "policy": args.policy, "seed": args.seed, **result}
    print_json(result) if args.json else print(_summary(result))
    return 0


_OF_PLAY = {
    **dict.fromkeys(("game", "output", "format", "observations", "labels", "ray", "preset")), "episodes": 1, "seed": 0,
}  # fmt: skip
"""The arguments that a check does not have, with their defaults."""


def _check(args: argparse.Namespace) -> int:
    given = [name for name, default in _OF_PLAY.items() if getattr(args, name) != default] + [*given_options(args)]
    if given:
        raise ValueError(f"--check reads {args.check} alone; leave {', '.join(given)} out")
    if Path(args.check).exists():
        check_dataset(args.check)  # before its facts are read
    facts = read_dataset(args.check).facts
    named, kind = facts.get("policy"), facts["observations"]["kind"]
    if args.policy is None and (named is None or kind != "seen"):
        print_json({}) if args.json else print(f"{args.check} is undamaged; it has no actions of a policy to compare")
        return 0
    if args.policy is None and _is_program(str(named)):
        raise ValueError(f"{args.check} was played by {named}, which is a program; if you trust it: --policy {named}")
    agreement = check_dataset(args.check, load_policy(args.policy or str(named)))
    assert agreement is not None
    columns = "steps", "equal", "near_ties", "different"
    counts = {name: dict(zip(columns, numbers, strict=True)) for name, *numbers in agreement.table.rows}
    print_json(counts) if args.json else print(agreement)
    return 0


def _is_program(policy: str) -> bool:
    """Whether loading a policy by a name that a file of a stranger contains could run a program."""
    path = Path(policy)
    return not (policy in ("random", "noop") or path.is_dir() or (path.suffix == ".onnx" and path.is_file()))


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
