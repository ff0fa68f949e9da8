"""`atari evaluate`: whole games of a policy by an evaluation protocol, beside published results."""

import argparse
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from atari.base.progress import ProgressBar
from atari.cli.arguments import Commands, add_command
from atari.cli.policies import find_played, games_of
from atari.cli.printing import print_json, print_table
from atari.learning import (
    GAME_SETS,
    PROTOCOLS,
    Policy,
    Published,
    Result,
    compare,
    evaluate,
    load_policy,
)
from atari.learning.evaluation.compare import Comparison, budget_faults
from atari.learning.evaluation.played import EvaluatedGame
from atari.learning.evaluation.protocols import MAX_EPISODES, find_protocol, refusal
from atari.task.arguments import add_task, show_task
from atari.task.fields import OF_GAME
from atari.task.parser import number, seed


def register(commands: Commands) -> None:
    """Add `atari evaluate`."""
    parser = add_command(commands, "evaluate", _evaluate, "let a policy play whole games by a protocol, and score it")
    parser.add_argument(
        "source",
        nargs="?",
        metavar="SOURCE",
        help="a run folder, an SB3 zip, a TorchScript or ONNX file, MODULE:NAME, random or noop; {game} in it stands "
        "for the game's id",
    )
    parser.add_argument(
        "games",
        nargs="*",
        metavar="GAME",
        help=f"games, IDs, game files, or sets of games: {', '.join(GAME_SETS)} (default: that of a run folder). An ID "
        "must have the protocol's sticky actions, and show what the policy sees, RAM or images",
    )
    parser.add_argument(
        "--protocol", default="machado2018", metavar="NAME", help=f"{', '.join(PROTOCOLS)} (default: machado2018)"
    )
    parser.add_argument(
        "--episodes",
        type=number(int, 1, MAX_EPISODES),
        metavar="N",
        help="whole games of each game (default: as the protocol says)",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of the games, below 2**32 (default: 0)")
    parser.add_argument("--num-envs", type=number(int, 1), metavar="N", help="games at a time (default: up to 64)")
    parser.add_argument("--sample", action="store_true", help="draw the actions of stochastic policies")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="save the result, JSON")
    parser.add_argument(
        "--compare", action="append", default=[], metavar="NAME", help="a published agent, such as dopamine/rainbow"
    )
    parser.add_argument("--frames", type=number(int, 1), metavar="N", help="compare at N frames of training")
    parser.add_argument("--human", default="noop57", metavar="TABLE", help="human scores (default: noop57)")
    parser.add_argument("--mixed", action="store_true", help="compare although protocols or budgets differ")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the comparison: .svg, .png, .pdf")
    add_task(parser, OF_GAME, preset=False)
    parser.add_argument("--list", action="store_true", help="show protocols, sets of games and published agents")


def _evaluate(args: argparse.Namespace) -> int:
    if args.list:
        return _list(args)
    if args.source is None:
        with suppress(SystemExit):  # this function returns exit code 2
            args.parser.error("the following arguments are required: SOURCE (or --list)")
        return 2
    _check_before_playing(args)
    games = find_played(args, args.games, None if args.games else load_policy(args.source))
    policies = _policies(args, games)
    trained = {getattr(policy, "training_frames", None) for policy in policies.values()}
    frames = args.frames or (trained.pop() if len(trained) == 1 else None)
    check_comparable(args.compare, args.mixed, lambda agent: budget_faults(agent, frames))
    for game in games:
        if show_task(args, games_of(policies[game.id], game, args.protocol)[0]):
            return 0
    result = _play(args, games, policies)
    comparison = None
    if args.output:
        result.save(args.output)
    if args.compare:
        comparison = compare(result, args.compare, frames=args.frames, human=args.human, mixed=args.mixed)
        if args.plot:
            comparison.plot(args.plot)
    _print(args, result, comparison)
    return 0


def _check_before_playing(args: argparse.Namespace) -> None:
    """Raise errors before the games, which may take hours, rather than after them."""
    protocol = find_protocol(args.protocol)
    Published.human_scores(args.human)
    check_comparable(args.compare, args.mixed, lambda agent: list(filter(None, [refusal(protocol, agent)])))
    if args.plot:
        if not args.compare:
            raise ValueError("--plot draws a comparison; name a published agent with --compare")
        import atari.learning.evaluation.plot  # noqa: F401 - raises an error without Matplotlib
    for file in (args.output, args.plot):
        if file and not file.absolute().parent.is_dir():
            raise FileNotFoundError(f"there is no folder {file.absolute().parent} for {file.name}")


def check_comparable(names: Sequence[str], mixed: bool, faults_of: Callable[[Published], list[str]]) -> None:
    """Raise ValueError for a published agent that is not comparable, unless agents are `mixed`."""
    for name in names:
        if (faults := faults_of(Published(name))) and not mixed:
            raise ValueError(f"{name} is not comparable: {'; '.join(faults)}; --mixed compares it, and says so")


def _policies(args: argparse.Namespace, games: tuple[EvaluatedGame, ...]) -> dict[str, Policy]:
    policies: dict[str, Policy] = {}
    loaded: dict[str, Policy] = {}
    for game in games:
        source = args.source.replace("{game}", game.id)
        if source not in loaded:
            loaded[source] = load_policy(source, sample=args.sample)
        policies[game.id] = loaded[source]
    return policies


def _play(args: argparse.Namespace, games: tuple[EvaluatedGame, ...], policies: dict[str, Policy]) -> Result:
    with ProgressBar(unit=" games", disable=None) as bar:

        def progress(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        try:
            return evaluate(
                policies,
                games,
                args.protocol,
                episodes=args.episodes,
                seed=args.seed,
                num_envs=args.num_envs,
                progress=progress,
            )
        except KeyboardInterrupt:
            raise KeyboardInterrupt("before all games had ended; nothing is saved") from None


def _print(args: argparse.Namespace, result: Result, comparison: Comparison | None) -> None:
    if args.json:
        print_json({"result": result.to_json(), "comparison": comparison and comparison.to_json()})
        return
    print(result)
    if comparison is not None:
        print(f"\n{comparison}")
    for file in (args.output, args.plot):
        if file:
            print(f"\n{file.absolute()}")


def _list(args: argparse.Namespace) -> int:
    agents = [Published(name) for name in Published.names()]
    comparable = {name: protocol.comparable for name, protocol in PROTOCOLS.items()}
    if args.json:
        names = [agent.name for agent in agents]
        print_json({"protocols": PROTOCOLS, "comparable": comparable, "sets": GAME_SETS, "published": names})
        return 0
    for protocol in PROTOCOLS.values():
        print(protocol)
    print()
    print_table((name, f"{len(games)} games") for name, games in GAME_SETS.items())
    print()
    fitting = {agent: name for name, names in comparable.items() for agent in names}
    rows: list[Any] = [("published agent", "games", "has", "comparable by protocol", "source")]
    for agent in agents:
        kind, protocol_name = "curves" if agent.has_curves else "scores", fitting.get(agent.name, "none")
        rows.append((agent.name, len(agent.games), kind, protocol_name, agent.source["repo"]))
    print_table(rows)
    return 0
