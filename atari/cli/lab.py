"""`atari lab`: the inspector, a local page to see, search and change the RAM of a game."""

import argparse
import sys
import webbrowser
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium

from atari.base.extras import install_extra
from atari.cli.arguments import GAME_HELP, Commands, add_command, add_rom, find_game
from atari.cli.printing import print_json
from atari.games.catalog import games
from atari.roms.search import ENDINGS
from atari.task.arguments import SCREEN, add_task, given_options, read_game, show_task, task_of
from atari.task.parser import number, seed
from atari.task.task import BY_FRAME, look_up

if TYPE_CHECKING:
    from atari.lab.inspector.inspection import Inspection


def register(commands: Commands) -> None:
    """Add `atari lab`."""
    parser = add_command(commands, "lab", _lab, "see, search and change the RAM of a game, on a local page")
    parser.epilog = "`atari causes GAME` writes a causal map, `atari collect GAME` a data set."
    parser.add_argument(
        "source",
        metavar="SOURCE",
        help=f"{GAME_HELP}, a replay (.a26r), a run folder of `atari train`, or a saved state",
    )
    add_rom(parser)
    parser.add_argument(
        "--agent",
        metavar="AGENT",
        help="who plays: a run folder, an SB3 zip, a TorchScript or ONNX file, MODULE:NAME, random (default: you)",
    )
    parser.add_argument("--seed", type=seed, metavar="N", help="seed of the game (default: 0)")
    parser.add_argument(
        "--port", type=number(int, 0, 65_535), default=0, metavar="N", help="port of the page (default: a free one)"
    )
    parser.add_argument("--no-browser", action="store_true", help="open no browser; print the address")
    add_task(
        parser,
        ("mode", "difficulty", "repeat_action_probability", "max_num_frames_per_episode", "interventions"),
        fixed={**SCREEN, "frameskip": 1, "actions": "full"},
        preset=False,
    )


def _lab(args: argparse.Namespace) -> int:
    if find_spec("aiohttp") is None:
        raise gymnasium.error.DependencyNotInstalled(f"atari lab needs aiohttp: {install_extra('lab')}")
    from atari.lab.inspector.server import serve

    session = _session(args)
    if show_task(args, session.env.task):
        return 0
    browser = None if args.no_browser else _open_browser

    def ready(url: str) -> None:
        if args.json:
            print_json({"url": url})
        else:
            print(f"{session.game.title}: {url}\nCtrl-C ends it.", flush=True)

    serve(session, port=args.port, browser=browser, ready=ready)
    return 0


def _open_browser(url: str) -> None:
    try:
        opened = webbrowser.open(url)
    except webbrowser.Error:
        opened = False
    if not opened:
        print("no browser could be opened; open the address above in one", file=sys.stderr, flush=True)


def _session(args: argparse.Namespace) -> "Inspection":
    """The session of a command line: a game, a replay, a run folder or a saved state."""
    from atari.env import AtariEnv
    from atari.lab.inspector.inspection import Inspection
    from atari.lab.inspector.sources import inspection_of_replay, inspection_of_snapshot
    from atari.recording.replay.file_format import is_replay

    path, source = Path(args.source), args.source
    of_replay = is_replay(path)
    names_game = path.suffix.lower() in (".toml", ".json", *ENDINGS) or not path.is_file()
    of_game = names_game and not of_replay and not path.is_dir()
    if not of_game:
        given = [*given_options(args), *(["seed"] if args.seed is not None and not path.is_dir() else [])]
        if given:
            raise ValueError(f"{source} says what is played; leave --{given[0].replace('_', '-')} out")
    seed_ = args.seed or 0
    if path.is_dir():
        if args.agent is not None or args.rom is not None:
            raise ValueError(
                f"{source} is a run folder, whose agent plays, with the ROM that is found; leave --agent and --rom out"
            )
        player = _agent(source)
        game: Any = getattr(player, "game", None)
        if game is None:
            raise ValueError(f"{source} does not say which game it plays")
        task = player.task_in(find_game(game)).emulator_task().replace(actions="full", obs_type="rgb")
        return Inspection(AtariEnv(task), agent=player, seed=seed_)
    player = _agent(args.agent)
    if of_game:
        found = look_up(read_game(source))
        sticky = 0.0 if player is None else player.task_in(games.find(found.definition)).repeat_action_probability
        task = task_of(args, found, base={**BY_FRAME, "repeat_action_probability": sticky})
        return Inspection(AtariEnv(task, rom=args.rom), agent=player, seed=seed_)
    return (inspection_of_replay if of_replay else inspection_of_snapshot)(path, rom=args.rom, agent=player)


def _agent(source: str | None) -> Any:
    if source is None:
        return None
    from atari.learning.frame_agent import FrameAgent

    return FrameAgent(source)
