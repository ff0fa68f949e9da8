"""`atari completion`: a script for the shell, with which Tab completes commands, options, games, IDs and presets."""

import argparse
from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING, Any

import gymnasium

from atari import env_ids
from atari.cli.arguments import Parser, add_command
from atari.cli.output import print_json
from atari.games.catalog import games

if TYPE_CHECKING:
    from atari.cli.arguments import Commands

_BASH = """\
_atari_words() {{ compgen -W "$1" -- "$2"; }}
_atari_games() {{
  case "$1" in
    [A-Z]*) compgen -W "$_atari_ids" -- "$1" ;;
    *) compgen -W "$_atari_game_ids" -- "$1"; compgen -f -X '!*.toml' -- "$1" ;;
  esac
}}
_atari_sources() {{ _atari_games "$1"; compgen -f -- "$1"; }}
_atari_policies() {{ compgen -W "random noop" -- "$1"; compgen -f -- "$1"; }}
_atari_agents() {{ compgen -W "{agents}" -- "$1"; _atari_games "$1"; }}
_atari_presets() {{ compgen -W "{presets}" -- "$1"; }}
_atari_protocols() {{ compgen -W "{protocols}" -- "$1"; }}
_atari_game_ids="{games}"
_atari_ids="{ids}"
_shtab_atari_lab_pos_0_choices=(map collect)
"""

_ZSH = """\
_atari_game_ids=({games})
_atari_ids=({ids})
_atari_games() {{ compadd -a _atari_game_ids; compadd -a _atari_ids; _files -g '*.toml' }}
_atari_sources() {{ compadd map collect; _atari_games; _files }}
_atari_policies() {{ compadd random noop; _files }}
_atari_agents() {{ compadd {agents}; _atari_games }}
_atari_presets() {{ compadd {presets} }}
_atari_protocols() {{ compadd {protocols} }}
_shtab_atari_lab() {{
  local context state line curcontext="$curcontext" options
  if (( CURRENT > 2 )) && [[ $words[2] == (map|collect) ]]; then
    options=_shtab_atari_lab_$words[2]_options
    shift words
    (( CURRENT -= 1 ))
    _arguments -C -s ${{(P)options}}
  else
    _arguments -C -s $_shtab_atari_lab_options
  fi
}}
"""
"""Overrides shtab's function for `lab`, whose first argument is a source or a command of its own."""

_TCSH = """\
set _atari_game_ids = ({games})
set _atari_ids = ({ids})
alias _atari_games 'echo $_atari_game_ids $_atari_ids; ls'
alias _atari_sources 'echo map collect $_atari_game_ids; ls'
alias _atari_policies 'echo random noop; ls'
alias _atari_agents 'echo {agents} $_atari_game_ids'
alias _atari_presets 'echo {presets}'
alias _atari_protocols 'echo {protocols}'
"""

_PREAMBLES = {"bash": _BASH, "zsh": _ZSH, "tcsh": _TCSH}

_COMPLETED = {
    "game": "games",
    "games": "games",
    "id": "games",
    "words": "agents",
    "source": "policies",
    "policy": "policies",
    "opponent": "policies",
    "agent": "policies",
    "preset": "presets",
    "protocol": "protocols",
}
"""By the destination of an argument, the kind of words that complete it; files complete an argument of a path."""


def register(commands: "Commands") -> None:
    """Add `atari completion`."""
    parser = add_command(commands, "completion", _completion, "print a script that completes commands with Tab")
    parser.epilog = (
        "bash: atari completion bash >~/.local/share/bash-completion/completions/atari; "
        "zsh: atari completion zsh >FOLDER/_atari, with a FOLDER that $fpath has; "
        "tcsh: atari completion tcsh >~/.atari.tcsh, with `source ~/.atari.tcsh` in ~/.tcshrc. "
        "It needs shtab (extra 'completion')."
    )
    parser.add_argument("shell", metavar="SHELL", choices=tuple(_PREAMBLES), help="bash, zsh or tcsh")


def _completion(args: argparse.Namespace) -> int:
    try:
        import shtab
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            "atari completion needs shtab: pip install 'atari-envs[completion]'"
        ) from None
    parser = _whole_parser(args.shell)
    _attach(parser, shtab.FILE)
    from atari.learning.agents import AGENTS
    from atari.learning.evaluation.protocols import PROTOCOLS
    from atari.task import PRESETS

    words = {
        "agents": AGENTS,
        "presets": PRESETS,
        "protocols": PROTOCOLS,
        "games": games,
        "ids": env_ids.ids(),
    }
    preamble = _PREAMBLES[args.shell].format(**{name: " ".join(each) for name, each in words.items()})
    script = shtab.complete(parser, shell=args.shell, preamble=preamble)
    print_json({"shell": args.shell, "script": script}) if args.json else print(script)
    return 0


class _Below:
    """Adds the commands `lab map` and `lab collect` to the parser of `lab`, as the shell sees them."""

    def __init__(self, commands: Any) -> None:
        self._commands = commands

    def add_parser(self, name: str, **options: Any) -> argparse.ArgumentParser:
        parser: argparse.ArgumentParser = self._commands.add_parser(name.split()[-1], **options)
        return parser


def _whole_parser(shell: str) -> argparse.ArgumentParser:
    """The parser of all commands. Those of two words are commands of the parser of the first word."""
    from atari.cli import _COMMANDS, _SUBCOMMANDS

    parser = Parser(prog="atari", description="Atari 2600 games as Gymnasium environments.")
    parser.add_argument("--version", action="version", version="")
    commands = parser.add_subparsers(metavar="COMMAND")
    for name in _COMMANDS:
        import_module(f"atari.cli.{name}").register(commands)
    lab = commands.choices["lab"]
    source = next(action for action in lab._actions if action.dest == "source")
    inner = lab.add_subparsers(metavar="COMMAND")
    for name in _SUBCOMMANDS:
        import_module(f"atari.cli.{name.replace(' ', '_')}").register(_Below(inner))
    vars(source)["complete"] = _completers("sources")
    if shell == "tcsh":  # its rules count words, and the source and the command are the same word
        lab._actions.remove(source)
        vars(inner)["complete"] = _completers("sources")
    return parser


def _completers(kind: str) -> dict[str, str]:
    """What completes words of a kind, by shell: functions, and in tcsh the output of an alias."""
    name = f"_atari_{kind}"
    return {"bash": name, "zsh": name, "tcsh": f"`{name}`"}


def _attach(parser: argparse.ArgumentParser, files: Any) -> None:
    """Give each argument of games, policies, presets, protocols or paths the attribute that shtab reads."""
    for action in _actions(parser):
        kind = _COMPLETED.get(action.dest)
        if action.choices is not None or hasattr(action, "complete"):
            continue
        if action.metavar in ("FILE", "PATH", "RUN", "FOLDER"):
            vars(action)["complete"] = files
        elif kind:
            vars(action)["complete"] = _completers(kind)


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _actions(below)
