"""The command line `atari`: what the library knows and does, for people at a terminal and for scripts.

Results go to stdout, as text or with `--json` as one JSON document; progress and errors go to stderr. The exit code
is 0, 1 for a failure, 2 for a wrong command line, 130 after Ctrl-C.
"""

import argparse
import os
import sys
from collections.abc import Sequence

import gymnasium

import atari
from atari.cli import demo, facts, play, record, replay, roms, verify
from atari.cli.command import print_error

_EXAMPLES = """\
examples:
  atari demo breakout                      play and write videos/breakout-0.mp4
  atari record pong -o pong.mp4            let a policy play, and film it with sound
  atari replay verify game.a26             does a recorded game play as it did?
  atari play ms_pacman                     play it yourself, in a window
  atari explain PongDeterministic-v4       what an environment ID means
  atari info ms_pacman --json              all facts of a game
  atari list --ids | grep Pong             every environment ID
  atari roms verify                        are the ROM files right?
  atari verify pong --frames 10000         do our emulator and ale-py agree?
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line (without the program's name; None is that of the process) and return its exit code."""
    try:
        code = _run(argv)
        print(end="", flush=True)  # a reader that has gone is noticed here, not when the interpreter ends
    except BrokenPipeError:  # `atari list | head -1`: the reader has all it wanted
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt as interrupt:
        print(" ".join(("atari: interrupted", *map(str, interrupt.args))), file=sys.stderr)
        return 130
    except (OSError, RuntimeError, ValueError, gymnasium.error.Error) as error:
        print_error(error)
        return 1
    return code


def _run(argv: Sequence[str] | None) -> int:
    try:
        args = _parser().parse_args(argv)
    except SystemExit as exit_:  # argparse has printed help, version or what is wrong
        return int(exit_.code or 0)
    code: int = args.run(args)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="atari",
        description="Atari 2600 games as Gymnasium environments.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"atari-envs {atari.__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for group in (facts, roms, verify, demo, record, replay, play):
        group.add_commands(commands)
    return parser
