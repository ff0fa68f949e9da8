"""`atari lab`: the inspector, a local page to see, search and change the RAM of a game."""

import argparse
import sys
import webbrowser
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium

from atari.cli.arguments import add_command, add_rom, find_game, number
from atari.task import Task

if TYPE_CHECKING:
    from atari.cli.arguments import Commands
    from atari.lab.inspector.session import Session

_HIGHEST_PORT = 65535


def register(commands: "Commands") -> None:
    """Add `atari lab`. Its subcommands are in lab_map.py and lab_collect.py."""
    parser = add_command(commands, "lab", _lab, "see, search and change the RAM of a game, on a local page")
    parser.epilog = "`atari lab map GAME` writes a causal map, `atari lab collect GAME` a data set."
    parser.add_argument(
        "source",
        metavar="SOURCE",
        help="a game, a game definition (.toml), a replay (.a26), a run folder of `atari train`, or a saved state",
    )
    add_rom(parser)
    parser.add_argument(
        "--agent",
        metavar="AGENT",
        help="who plays: a run folder, an SB3 zip, a TorchScript or ONNX file, MODULE:NAME, random (default: you)",
    )
    parser.add_argument("--seed", type=number(int, 0), default=0, metavar="N", help="seed of the game (default: 0)")
    parser.add_argument(
        "--port", type=number(int, 0), default=0, metavar="N", help="port of the page (default: a free one)"
    )
    parser.add_argument("--no-browser", action="store_true", help="open no browser; print the address")


def _lab(args: argparse.Namespace) -> int:
    if find_spec("aiohttp") is None:
        raise gymnasium.error.DependencyNotInstalled("atari lab needs aiohttp: pip install 'atari-envs[lab]'")
    if args.port > _HIGHEST_PORT:
        raise ValueError(f"a port is within 0..{_HIGHEST_PORT}, got {args.port}")
    from atari.lab.inspector.server import serve

    session = _session(args.source, args.rom, args.agent, int(args.seed))
    browser = None if args.no_browser else _open_browser
    if args.json:
        from atari.cli.output import print_json

        serve(session, port=args.port, browser=browser, ready=lambda url: print_json({"url": url}))
    else:
        serve(session, port=args.port, browser=browser, ready=partial(_print_address, session.game.title))
    return 0


def _print_address(title: str, url: str) -> None:
    print(f"{title}: {url}\nCtrl-C ends it.", flush=True)


def _open_browser(url: str) -> None:
    try:
        opened = webbrowser.open(url)
    except webbrowser.Error:
        opened = False
    if not opened:
        print("no browser could be opened; open the address above in one", file=sys.stderr, flush=True)


def _session(source: str, rom: Path | None, agent: str | None, seed: int) -> "Session":
    """The session of an argument: a game, a replay, a run folder or a saved state."""
    from atari.env import AtariEnv
    from atari.lab.inspector.session import Session
    from atari.lab.inspector.sources import session_of_replay, session_of_snapshot

    path = Path(source)
    if path.suffix == ".a26":
        return session_of_replay(path, rom=rom, agent=_agent(agent))
    if path.is_file() and path.suffix != ".toml":
        return session_of_snapshot(path, rom=rom, agent=_agent(agent))
    if path.is_dir():
        if agent is not None:
            raise ValueError(f"{source} is a run folder, whose agent plays; leave out --agent")
        player = _agent(source)
        game: Any = getattr(player, "game", None)
        if game is None:
            raise ValueError(f"{source} does not say which game it plays")
        return Session(AtariEnv(_frames_of(player.task_in(find_game(game)))), agent=player, seed=seed)
    player = _agent(agent)
    env = AtariEnv(find_game(source), rom=rom, **_OPTIONS)
    return Session(env, agent=player, seed=seed)


def _frames_of(task: Task) -> Task:
    """The frames of a task, one by one, with all actions."""
    return task.of_emulator().replace(actions="full", obs_type="rgb")


_OPTIONS: dict[str, Any] = {"frameskip": 1, "repeat_action_probability": 0.0, "full_action_space": True}


def _agent(source: str | None) -> Any:
    if source is None:
        return None
    from atari.learning.frame_agent import FrameAgent

    return FrameAgent(source)
