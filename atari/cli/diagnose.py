"""`atari diagnose`: where the games of a policy end, what it does there, and what gets it on."""

import argparse
import math
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from atari.base.progress import ProgressBar
from atari.cli.arguments import Commands, add_command
from atari.cli.policies import find_played, games_of
from atari.cli.printing import print_json
from atari.learning import PROTOCOLS, load_policy
from atari.learning.evaluation.protocols import MAX_EPISODES
from atari.policy import LoadedPolicy
from atari.policy.needs import needs_of
from atari.task import Task
from atari.task.arguments import add_task, show_task
from atari.task.fields import OF_GAME
from atari.task.parser import number, seed


def register(commands: Commands) -> None:
    """Add `atari diagnose`."""
    parser = add_command(commands, "diagnose", _diagnose, "find where the games of a policy end, and what gets it on")
    parser.epilog = (
        "Examples: atari diagnose runs/qbert; then open runs/qbert/diagnosis/index.html. "
        "atari diagnose runs/qbert --probes; then read the table"
    )
    parser.add_argument(
        "source",
        metavar="POLICY",
        help="a run folder, an SB3 zip, a TorchScript or ONNX file, MODULE:NAME, random or noop",
    )
    parser.add_argument("games", nargs="?", metavar="GAME", help="the game (default: that of the policy)")
    parser.add_argument("--protocol", metavar="NAME", help=f"{', '.join(PROTOCOLS)} (default: as in the training)")
    parser.add_argument("--episodes", type=number(int, 1, MAX_EPISODES), metavar="N", help="whole games (default: 100)")
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of games and searches (default: 0)")
    parser.add_argument(
        "--frontiers", type=number(int, 0, 1000), metavar="N", help="moments that are searched (default: 3)"
    )
    parser.add_argument("--seconds", type=number(float, 0.01, 86_400), metavar="X", help="of each search (default: 10)")
    parser.add_argument(
        "--probes",
        type=number(int, 1),
        nargs="?",
        const=20_000,
        metavar="N",
        help="instead, print how well linear probes read AtariARI's labels of RAM from the features of the policy's "
        "network, of the same network with random weights, and from the pixels, in N states (default: 20000)",
    )
    parser.add_argument("--sample", action="store_true", help="draw the actions of stochastic policies")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="for the page and its files (default: RUN/diagnosis)"
    )
    add_task(parser, OF_GAME, preset=False)


def _diagnose(args: argparse.Namespace) -> int:
    from atari.learning.diagnosis.diagnosis import diagnose, only_game
    from atari.learning.diagnosis.page import write_diagnosis

    policy = load_policy(args.source, sample=args.sample)
    game = only_game(find_played(args, [args.games] if args.games else [], None if args.games else policy))
    task = games_of(policy, game, args.protocol)[0]
    if show_task(args, task):
        return 0
    if args.probes is not None:
        return _print_probes(args, policy, task)
    folder = args.output or _folder(args.source, game.id)
    options = {"games": args.episodes, "frontiers": args.frontiers, "seconds": args.seconds}
    folder.mkdir(parents=True, exist_ok=True)  # an error before the games, which take minutes
    with ProgressBar(unit=" games", disable=None, leave=False) as bar:

        def progress(part: str, done: int, total: int) -> None:
            bar.unit = f" {part}"
            bar.total, bar.n = total, done
            bar.refresh()

        found = diagnose(
            policy if args.sample else args.source,
            game,
            args.protocol,
            seed=args.seed,
            progress=progress,
            **{name: value for name, value in options.items() if value is not None},
        )
    if not args.json:
        print(f"{found}\n", flush=True)  # before the files, which a full disk can refuse
    page = write_diagnosis(found, folder)
    if args.json:
        print_json({"page": page, "text": str(found), "options": found.options, "scores": found.plays.scores.tolist()})
    else:
        print(page)
    return 0


def _print_probes(args: argparse.Namespace, policy: LoadedPolicy, task: Task) -> int:
    from atari.lab.probes import play_episodes, probe_table, ridge_probe, split_episodes

    for name in ("episodes", "frontiers", "seconds", "output"):
        if getattr(args, name) is not None:
            raise ValueError(f"--probes prints a table and plays no whole games; leave --{name} out")
    if not task.kind.image:
        raise ValueError(f"{policy.name} sees the RAM itself, and probes are of policies that see images")
    try:
        features, network = policy.features, policy.network
    except AttributeError as error:
        raise ValueError(str(error)) from None
    layout = needs_of(policy, task.definition).options
    episodes = play_episodes(task, args.probes, policy, seed=args.seed, **layout)
    data = split_episodes(episodes, task.game, seed=args.seed)
    results = {"trained": ridge_probe(features, data)}
    import_module("torch").manual_seed(args.seed)
    for part in network.modules():
        if hasattr(part, "reset_parameters"):
            part.reset_parameters()
    results["random"] = ridge_probe(features, data)
    newest = _newest_image(task, bool(layout.get("channels_last")))
    results["pixels"] = ridge_probe(lambda seen: seen[newest], data)
    if args.json:
        print_json(results)
    else:
        print(probe_table(results))
    return 0


def _newest_image(task: Task, channels_last: bool) -> Any:
    """The index of the newest image in observations (n, ...): a whole stack has as many times more pixels."""
    if task.stack_num is None:
        return np.s_[:]
    return np.s_[..., -math.prod(task.kind.colours) :] if channels_last else np.s_[:, -1]


def _folder(source: str, game: str) -> Path:
    """`diagnosis` in a run folder; for another policy a folder of the game in the working folder."""
    return Path(source, "diagnosis") if Path(source, "config.json").is_file() else Path("diagnosis", game)
