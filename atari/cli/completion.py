"""`atari completion`: a script for the shell, with which Tab completes commands, options, games, IDs and presets."""

import argparse
from collections.abc import Iterator
from typing import Any

import gymnasium

from atari.base.extras import install_extra
from atari.base.program import print_exact
from atari.cli.arguments import Commands, add_command
from atari.cli.printing import print_json
from atari.games.catalog import games
from atari.task import env_ids

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
"""

_ZSH = """\
_atari_game_ids=({games})
_atari_ids=({ids})
_atari_games() {{ compadd -a _atari_game_ids; compadd -a _atari_ids; _files -g '*.toml' }}
_atari_sources() {{ _atari_games; _files }}
_atari_policies() {{ compadd random noop; _files }}
_atari_agents() {{ compadd {agents}; _atari_games }}
_atari_presets() {{ compadd {presets} }}
_atari_protocols() {{ compadd {protocols} }}
"""

_TCSH = """\
set _atari_game_ids = ({games})
set _atari_ids = ({ids})
alias _atari_games 'echo $_atari_game_ids $_atari_ids; ls'
alias _atari_sources 'echo $_atari_game_ids; ls'
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
"""The kind of words that complete an argument, by its destination; files complete a path."""


def register(commands: Commands) -> None:
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
            f"atari completion needs shtab: {install_extra('completion')}"
        ) from None
    parser = _whole_parser()
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
    print_json({"shell": args.shell, "script": script}) if args.json else print_exact(f"{script}\n")
    return 0


def _whole_parser() -> argparse.ArgumentParser:
    from atari.cli import _parser

    parser = _parser([])
    commands = next(action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    source = next(action for action in commands.choices["lab"]._actions if action.dest == "source")
    vars(source)["complete"] = _completers("sources")
    return parser


def _completers(kind: str) -> dict[str, str]:
    """The completer of words of a kind, by shell: a function, and in tcsh the output of an alias."""
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
