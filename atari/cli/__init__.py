"""The command line `atari`. Each command has a module of its name, which is imported only when the command runs.

Results go to stdout, as text or with `--json` as one JSON document; progress and errors go to stderr. The exit code
is 0, 1 for a failure, 2 for a wrong command line, 130 after Ctrl-C.
"""

import argparse
import difflib
import sys
from collections.abc import Sequence
from importlib import import_module

import atari
from atari.base.program import interruptible, run
from atari.task.parser import Parser

_COMMANDS = tuple(
    "info roms verify record replay play train watch evaluate diagnose collect lab causes web completion".split()
)

_EXAMPLES = """\
examples:
  atari record breakout                    a random agent plays; writes videos/breakout-0.mp4
  atari record pong --policy runs/pong -o pong.mp4
                                           let a policy play, and record a video with sound
  atari replay verify game.a26r             compare a replay with its recording
  atari train ppo pong --fast              an agent learns, in minutes
  atari watch runs/pong-ppo-pixels-seed0   and plays
  atari play ms_pacman                     play a game by hand, in a window
  atari evaluate random pong               play whole games by a protocol, and score a policy
  atari diagnose runs/pong                 see where its games end, and what gets it on
  atari info                               what works here, and what is not installed
  atari info --games                       the list of games
  atari info ms_pacman                     all facts of a game
  atari info PongDeterministic-v4          what an environment ID means
  atari info --ids | grep Pong             every environment ID
  atari roms verify                        check the ROM files
  atari verify pong --frames 10000         compare the native core with ale-py
  atari completion bash >~/.local/share/bash-completion/completions/atari
                                           complete commands, options, games and IDs with Tab
  atari web game.a26r -o page              write a page in which it plays in a browser
  atari lab breakout                       see, search and change the game's RAM, on a local page
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line (without the program's name; None is `sys.argv`) and return its exit code.

    Without words it prints the help.
    """
    return run(lambda: _run(argv))


def _run(argv: Sequence[str] | None) -> int:
    try:
        words = (sys.argv[1:] if argv is None else [*argv]) or ["--help"]
        args, unknown = _parser(words).parse_known_args(words)
        if unknown and "words" in args:  # `atari train` parses them when it knows the agent
            args.words[:0] = unknown
        elif unknown:  # argparse itself would print the usage of `atari`, not of the command
            args.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    except SystemExit as exit_:  # argparse has printed help, the version or the error
        return int(exit_.code or 0)
    with interruptible():
        code: int = args.run(args)
    return code


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Return a parser with the command named in `words`, or with all commands if none is named."""
    parser = Parser(
        prog="atari",
        description="Atari 2600 games as Gymnasium environments.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"atari-envs {atari.__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    chosen = next((word for word in words if not word.startswith("-")), None)
    near = difflib.get_close_matches(chosen or "", _COMMANDS, n=1) if chosen not in _COMMANDS else []
    if near:
        parser.error(f"there is no command {chosen!r}; did you mean {near[0]!r}?")
    for name in (chosen,) if chosen in _COMMANDS else _COMMANDS:
        import_module(f"atari.cli.{name}").register(commands)
    return parser
