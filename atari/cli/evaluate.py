"""`atari evaluate`: whole games of policies by an evaluation protocol, beside each other and published results."""

import argparse
import glob
import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gymnasium.error import DependencyNotInstalled

from atari.base.progress import ProgressBar
from atari.cli.arguments import Commands, add_command
from atari.cli.policies import find_played, games_of
from atari.cli.printing import print_json, print_table
from atari.learning import (
    GAME_SETS,
    PROTOCOLS,
    Published,
    Result,
    compare,
    evaluate,
    load_policy,
)
from atari.learning.evaluation.compare import Comparison, comparison_faults
from atari.learning.evaluation.played import EvaluatedGame
from atari.learning.evaluation.protocols import MAX_EPISODES, find_protocol
from atari.learning.evaluation.results import GameResult, estimates_of, score_tables
from atari.learning.evaluation.variants import AXES, find_axes
from atari.learning.policy_folder import is_policy_folder, policies_in
from atari.policy import LoadedPolicy
from atari.task import Task
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
    parser.add_argument(
        "--variants",
        metavar="AXES",
        help=f"play variants of each game, too, with one change at a time: {', '.join(AXES)}; modes*difficulties is a "
        "product",
    )
    parser.add_argument(
        "--beside",
        action="append",
        default=[],
        metavar="SOURCE",
        help="another policy that plays the same games, a folder of policies, or files such as 'class/*.pt'; may be "
        "repeated",
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="save the result, JSON; or a page of the scores, .html"
    )
    parser.add_argument(
        "--compare", action="append", default=[], metavar="NAME", help="a published agent, such as dopamine/rainbow"
    )
    parser.add_argument("--frames", type=number(int, 1), metavar="N", help="compare at N frames of training")
    parser.add_argument("--human", default="noop57", metavar="TABLE", help="human scores (default: noop57)")
    parser.add_argument("--mixed", action="store_true", help="compare although protocols or budgets differ")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw the scores, or the comparison of --compare: .svg, .png, .pdf"
    )
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
    agents, not_played = _agents(args, games)
    tasks = [games_of(agents[0].policies[game.id], game, args.protocol)[0] for game in games]
    check_comparable(args, tasks, [_trained_frames(agent) for agent in agents])
    if any(show_task(args, task) for task in tasks):
        return 0
    results = _play(args, games, agents, not_played)
    own = results if args.beside else next(iter(results.values()))
    comparison = None
    if args.compare:
        comparison = compare(own, args.compare, frames=args.frames, human=args.human, mixed=args.mixed)
    if args.output:
        _save(args, games, agents, results, not_played, comparison)
    if args.plot and comparison is not None:
        comparison.plot(args.plot)
    elif args.plot:
        from atari.learning.evaluation.plot import plot_scores  # here, because it imports Matplotlib

        plot_scores(estimates_of(_tables(results)), args.plot)
    _print(args, results, not_played, comparison)
    return 0


def _check_before_playing(args: argparse.Namespace) -> None:
    """Raise errors before the games, which may take hours, rather than after them."""
    Published.human_scores(args.human)
    check_comparable(args, (), ())
    if args.variants:
        find_axes(args.variants)
        if args.beside or args.compare:
            raise ValueError(
                "--variants are of one agent, and compared with its scores; leave --beside and --compare out"
            )
    if args.beside and args.output and not _is_page(args):
        raise ValueError(f"--beside saves a page, as -o scores.html, got {args.output}; --json prints all results")
    if args.plot or _is_page(args):
        import atari.learning.evaluation.plot  # noqa: F401 - raises an error without Matplotlib
    for file in (args.output, args.plot):
        if file and not file.absolute().parent.is_dir():
            raise FileNotFoundError(f"there is no folder {file.absolute().parent} for {file.name}")


def check_comparable(args: argparse.Namespace, tasks: Iterable[Task], trained: Sequence[int | None]) -> None:
    """Check that agents can be compared with `args.compare` before games or trainings that may take hours.

    Args:
        args: a command line with `--compare`, `--protocol` and `--mixed`; it may have `--frames` and `--human`.
        tasks: the tasks that are played.
        trained: the frames of training of each agent; None are not known.

    Raises:
        ValueError: they are not comparable, and `--mixed` is not given.
    """
    if not args.compare:
        return
    chosen = {name: getattr(args, name) for name in ("frames", "human") if hasattr(args, name)}
    played = ((task.game, json.loads(task.to_json())) for task in tasks)
    faults, _ = comparison_faults(find_protocol(args.protocol), played, args.compare, trained, **chosen)
    if faults and not args.mixed:
        raise ValueError(f"these are not comparable: {'; '.join(faults)}; --mixed compares them, and says so")


@dataclass(frozen=True)
class _Agent:
    """A policy for each game. The errors of a policy that was found `in_folder` do not end the command."""

    name: str
    policies: Mapping[str, LoadedPolicy]
    in_folder: bool


def _trained_frames(agent: _Agent) -> int | None:
    """The frames of training of all policies of an agent; None if they differ, or are not known."""
    trained = {getattr(policy, "training_frames", None) for policy in agent.policies.values()}
    return trained.pop() if len(trained) == 1 else None


def _agents(args: argparse.Namespace, games: Sequence[EvaluatedGame]) -> tuple[list[_Agent], dict[str, str]]:
    """The agents of a command line, and the names of those in folders that cannot play, with the reasons."""
    agents: list[_Agent] = []
    not_played: dict[str, str] = {}
    for source in (args.source, *(one for pattern in args.beside for one in _sources(pattern))):
        found: Iterable[tuple[str, LoadedPolicy | str]] = [(source, "")]
        if in_folder := is_policy_folder(source):
            found = policies_in(Path(source), args.sample)
        for name, policy in found:
            if name in [agent.name for agent in agents]:
                raise ValueError(f"{name} is named twice among the agents; leave one of them out")
            if in_folder and isinstance(policy, str):
                not_played[name] = policy
                continue
            own = _policies(name, games, args.sample) if isinstance(policy, str) else {one.id: policy for one in games}
            try:
                for game in games:
                    games_of(own[game.id], game, args.protocol)
            except _REFUSED as error:
                if not in_folder:
                    raise
                not_played[name] = str(error)
            else:
                agents.append(_Agent(name, own, in_folder))
    if not agents:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in not_played.items())
        raise ValueError(f"no policy of {args.source} can play: {reasons}")
    return agents, not_played


def _sources(pattern: str) -> list[str]:
    """The files of a pattern, which the shells of Windows do not expand; any other source is the only one.

    Raises:
        FileNotFoundError: no file fits the pattern.
    """
    if "*" not in pattern:
        return [pattern]
    if found := sorted(glob.glob(pattern)):
        return found
    raise FileNotFoundError(f"there are no files {pattern}; give the folder of the policies")


_REFUSED = (TypeError, ValueError, OSError)
"""Errors of a policy that does not fit the games, or returns no actions."""


def _policies(source: str, games: Sequence[EvaluatedGame], sample: bool) -> dict[str, LoadedPolicy]:
    sources = {game.id: source.replace("{game}", game.id) for game in games}
    loaded = {one: load_policy(one, sample=sample) for one in dict.fromkeys(sources.values())}
    return {game: loaded[one] for game, one in sources.items()}


def _play(
    args: argparse.Namespace, games: Sequence[EvaluatedGame], agents: Sequence[_Agent], not_played: dict[str, str]
) -> dict[str, Result]:
    """The results of the agents by name. The number of games is printed before the first one."""
    results: dict[str, Result] = {}
    try:
        for agent in agents:
            try:
                results[agent.name] = _play_one(args, games, agent, len(agents) if agent is agents[0] else 0)
            except _REFUSED as error:
                if not agent.in_folder:
                    raise
                not_played[agent.name] = str(error)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("before all games had ended; nothing is saved") from None
    if not results:
        raise ValueError(f"no policy could play: {not_played}")
    return results


def _play_one(args: argparse.Namespace, games: Sequence[EvaluatedGame], agent: _Agent, agents: int) -> Result:
    with ProgressBar(unit=" games", disable=None) as bar:

        def progress(done: int, total: int) -> None:
            if done == 0 and agents and (args.variants or args.beside):
                episodes = args.episodes or find_protocol(args.protocol).episodes
                counts = f"policies: {agents}, tasks: {total // episodes}, games of each: {episodes:,}"
                print(f"{agents * total:,} games ({counts})", file=sys.stderr, flush=True)
            bar.total = total
            bar.update(done - bar.n)

        return evaluate(
            agent.policies,
            games,
            args.protocol,
            variants=args.variants,
            episodes=args.episodes,
            seed=args.seed,
            num_envs=args.num_envs,
            progress=progress,
        )


def _is_page(args: argparse.Namespace) -> bool:
    return args.output is not None and args.output.suffix == ".html"


def _tables(results: Mapping[str, Result]) -> dict[str, dict[str, GameResult]]:
    """The results of each game, by agent, the best mean score first; with one agent, by variant."""
    first = next(iter(results.values()))
    names = dict.fromkeys(one.game for one in first.games)
    if len(results) == 1:
        return {game: first.variants(game) for game in names}
    ranked = {game: sorted(results, key=lambda name: -results[name][game].mean) for game in names}
    return {game: {name: results[name][game] for name in order} for game, order in ranked.items()}


def _about(results: Mapping[str, Result]) -> list[str]:
    """Sentences on how the games were played; one that is true of all agents has no name."""
    first = next(iter(results.values()))
    named: dict[str, list[str]] = {}
    for name, result in results.items():
        for note in result.notes:
            named.setdefault(note, []).append(name)
    notes = [note if len(names) == len(results) else f"{', '.join(names)}: {note}" for note, names in named.items()]
    return [f"protocol {first.protocol}; seed {first.seed}", *notes]


def _save(
    args: argparse.Namespace,
    games: Sequence[EvaluatedGame],
    agents: Sequence[_Agent],
    results: Mapping[str, Result],
    not_played: Mapping[str, str],
    comparison: Comparison | None,
) -> None:
    """Save the only result, or a page; with videos, unless it has variants."""
    if not _is_page(args):
        next(iter(results.values())).save(args.output)
        return
    from atari.learning.beside import write_scores

    videos = {} if args.variants else _videos(args, games, agents, results)
    shown = " and ".join(results) if len(results) <= _MOST_NAMES else f"{len(results)} policies"
    title = f"{shown} in {', '.join(game.id for game in games)}"
    write_scores(
        args.output,
        title,
        _tables(results),
        about=_about(results),
        videos=videos,
        not_played=not_played,
        comparison=comparison,
    )


_MOST_NAMES = 2
"""Policies that the title of a page names."""


def _videos(
    args: argparse.Namespace, games: Sequence[EvaluatedGame], agents: Sequence[_Agent], results: Mapping[str, Result]
) -> dict[tuple[str, str], str]:
    """The videos of a page by game and agent; none without PyAV, which is reported on stderr."""
    from atari.learning.beside import median_game
    from atari.recording.video.encoder import import_av

    try:
        import_av()
    except DependencyNotInstalled as error:
        print(f"{args.output} has no videos: {error}", file=sys.stderr)
        return {}
    played = [(agent, game) for agent in agents if agent.name in results for game in games]
    print(f"{len(played)} videos, one of each policy and game", file=sys.stderr, flush=True)
    videos = {}
    for agent, game in ProgressBar(played, unit=" videos", disable=None):
        result, name = results[agent.name], agent.name if args.beside else ""
        own = median_game(agent.policies[game.id], game, result.protocol, result[game.id], name)
        videos[game.id, agent.name] = own
    return videos


def _print(
    args: argparse.Namespace,
    results: Mapping[str, Result],
    not_played: Mapping[str, str],
    comparison: Comparison | None,
) -> None:
    first, compared = next(iter(results.values())), comparison and comparison.to_json()
    if args.json and args.beside:
        every = {name: result.to_json() for name, result in results.items()}
        print_json({"results": every, "not_played": not_played, "comparison": compared})
        return
    if args.json:
        print_json({"result": first.to_json(), "comparison": compared})
        return
    if args.beside:
        about, *notes = _about(results)
        notes += [f"{name}: not played: {reason}" for name, reason in not_played.items()]
        print("\n".join([about, "", *score_tables(_tables(results)), *([""] if notes else []), *notes]))
    else:
        print(first)
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
