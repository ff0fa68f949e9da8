"""Games of two to four players on the command line: `atari play --players` and `atari record --players`."""

import argparse
from pathlib import Path
from typing import Any

from atari.cli.arguments import find_game, number
from atari.games.pettingzoo import find_environment
from atari.games.players import rules_of
from atari.play.multiplayer_session import OBSERVATIONS, MultiplayerSession


def multiplayer(parser: argparse.ArgumentParser) -> None:
    """Add the options of games of several players."""
    parser.add_argument(
        "--players",
        type=number(int, 1),
        metavar="N",
        help="2, 3 or 4 players; GAME may then be a name of PettingZoo's, too, such as pong_v3",
    )
    parser.add_argument("--mode", type=number(int, 0), metavar="N", help="mode of the game; see `atari info GAME`")
    parser.add_argument("--difficulty", type=number(int, 0), metavar="N", help="difficulty of the game")
    parser.add_argument(
        "--obs",
        choices=OBSERVATIONS,
        help="what policies of several players see that do not say it: uint8, (rows, 160, 3), (rows, 160) or (128,) "
        "(default: rgb)",
    )


def make_match(
    args: argparse.Namespace, option: str, names: list[str], state: Path | None = None, replay: Path | None = None
) -> MultiplayerSession:
    """The game of the arguments; its policies are `names`, from player 1 on with --policy, else from player 2 on.

    It is recorded in `replay`.

    Raises:
        ValueError: there is no such game, mode or policy, or the number of players is wrong.
    """
    game, mode = _game_and_mode(args)
    rules = rules_of(game)
    players = args.players or next((players for players, modes in rules.modes.items() if mode in modes), None)
    if args.players is not None and args.players not in rules.modes:
        raise ValueError(f"{args.game} is for {_either(rules.modes)} players, got --players {args.players}")
    count = players or min(rules.modes)
    first = 0 if option == "--policy" else 1
    if len(names) == 1 and option == "--policy":
        names = names * count
    if len(names) > count - first or (option == "--policy" and len(names) != count):
        often = f"once, or {count} times" if option == "--policy" else f"at most {count - first} times"
        raise ValueError(f"{args.game} has {count} players; give {option} {often}, got {len(names)}")
    policies = dict(zip(range(first, count), names, strict=False))
    return MultiplayerSession(
        game,
        rom=args.rom,
        players=players,
        mode=mode,
        difficulty=args.difficulty,
        seed=args.seed,
        policies=policies,
        obs_type=args.obs or "rgb",
        state=state or Path("states", f"{game.id}-{count}-players.state"),
        replay=replay,
    )


def _game_and_mode(args: argparse.Namespace) -> tuple[Any, int | None]:
    """The game, and its mode: that of --mode, or the one that an environment of PettingZoo has."""
    if args.game.endswith(".toml"):
        return find_game(args.game, playable=False), args.mode
    environment = find_environment(args.game)
    if environment is None:
        return find_game(args.game, playable=False), args.mode
    game = find_game(environment.game, playable=False)
    if args.mode is not None:
        return game, args.mode
    if args.players is not None and args.players not in environment.players:
        allowed = _either(environment.players)
        raise ValueError(f"{environment.id} is for {allowed} players, got --players {args.players}")
    own = {"num_players": args.players} if args.players and "num_players" in environment.defaults else {}
    return game, environment.choose(own)


def _either(numbers: Any) -> str:
    return " or ".join(map(str, numbers))
