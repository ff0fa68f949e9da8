"""`atari demo`: `atari record` of a random agent with the preprocessing of DQN.

The agent gets DQN's observations, four 84x84 frames a step. The video shows every emulated frame of the console, with
sound.
"""

import argparse

import gymnasium

from atari.cli.arguments import GAME_HELP, Commands, add_command, number
from atari.cli.record import add_recording, record
from atari.task.arguments import add_task
from atari.task.resolution import is_id

_STEPS = 1000


def register(commands: Commands) -> None:
    """Add `atari demo`."""
    parser = add_command(commands, "demo", _demo, "let a random agent play a game, and write a video of it")
    parser.add_argument("game", metavar="GAME", nargs="?", default="breakout", help=f"{GAME_HELP} (default: breakout)")
    length = add_recording(parser)
    length.add_argument("--steps", type=number(int, 1), metavar="N", help=f"steps of the agent (default: {_STEPS})")
    parser.add_argument("--no-video", action="store_true", help="write nothing")
    add_task(parser, leave_out=("players",))
    parser.set_defaults(policy=["random"], episodes=1)


def _demo(args: argparse.Namespace) -> int:
    if args.no_video and args.output:
        raise ValueError("--no-video writes nothing; leave it or --output out")
    if args.seconds is None and args.steps is None:
        args.steps = _STEPS
    if args.preset is None and not (is_id(args.game) or args.game.endswith(".json")):
        args.preset = "dqn2015"
    try:
        return record(args)
    except gymnasium.error.DependencyNotInstalled as error:
        raise gymnasium.error.DependencyNotInstalled(f"{error}; or play without a video: --no-video") from None
