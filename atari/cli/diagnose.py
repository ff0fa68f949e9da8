"""`atari diagnose`: where the games of a policy end, what it does there, and what gets it on."""

import argparse
from pathlib import Path

from atari.base.progress import ProgressBar
from atari.cli.arguments import Commands, add_command
from atari.cli.policies import find_played, games_of
from atari.cli.printing import print_json
from atari.learning import PROTOCOLS, load_policy
from atari.learning.evaluation.protocols import MAX_EPISODES
from atari.task.arguments import add_task, show_task
from atari.task.fields import OF_GAME
from atari.task.parser import number, seed


def register(commands: Commands) -> None:
    """Add `atari diagnose`."""
    parser = add_command(commands, "diagnose", _diagnose, "find where the games of a policy end, and what gets it on")
    parser.epilog = "Example: atari diagnose runs/qbert; then open runs/qbert/diagnosis/index.html"
    parser.add_argument(
        "source",
        metavar="POLICY",
        help="a run folder, an SB3 zip, a TorchScript or ONNX file, MODULE:NAME, random or noop",
    )
    parser.add_argument("games", nargs="?", metavar="GAME", help="the game (default: that of the policy)")
    parser.add_argument("--protocol", metavar="NAME", help=f"{', '.join(PROTOCOLS)} (default: as in the training)")
    parser.add_argument(
        "--episodes", type=number(int, 1, MAX_EPISODES), default=100, metavar="N", help="whole games (default: 100)"
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of games and searches (default: 0)")
    parser.add_argument(
        "--frontiers", type=number(int, 0, 1000), default=3, metavar="N", help="moments that are searched (default: 3)"
    )
    parser.add_argument(
        "--seconds", type=number(float, 0.01, 86_400), default=10.0, metavar="X", help="of each search (default: 10)"
    )
    parser.add_argument("--sample", action="store_true", help="draw the actions of stochastic policies")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="for the page and its files (default: RUN/diagnosis)"
    )
    add_task(parser, OF_GAME, preset=False)


def _diagnose(args: argparse.Namespace) -> int:
    from atari.learning.diagnosis.diagnosis import diagnose
    from atari.learning.diagnosis.page import write_diagnosis

    policy = load_policy(args.source, sample=args.sample)
    (game,) = find_played(args, [args.games] if args.games else [], None if args.games else policy)
    if show_task(args, games_of(policy, game, args.protocol)[0]):
        return 0
    folder = args.output or _folder(args.source, game.id)
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
            games=args.episodes,
            seed=args.seed,
            seconds=args.seconds,
            frontiers=args.frontiers,
            progress=progress,
        )
    page = write_diagnosis(found, folder)
    if args.json:
        print_json({"page": page, "text": str(found), "options": found.options, "scores": found.plays.scores.tolist()})
        return 0
    print(f"{found}\n\n{page}")
    return 0


def _folder(source: str, game: str) -> Path:
    """`diagnosis` in a run folder; for another policy a folder of the game in the working folder."""
    return Path(source, "diagnosis") if Path(source, "config.json").is_file() else Path("diagnosis", game)
