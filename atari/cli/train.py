"""`atari train`: an agent learns to play a game."""

import argparse
from importlib.util import find_spec
from pathlib import Path

import gymnasium

from atari.cli.arguments import Commands, add_command, number
from atari.cli.printing import print_json
from atari.cli.sweep import add_sweep, is_sweep, run_sweep
from atari.learning.agents import AGENTS


def register(commands: Commands) -> None:
    """Add `atari train`."""
    parser = add_command(commands, "train", _train, "let an agent learn to play a game")
    parser.usage = (
        "atari train AGENT GAME [options]\n       atari train --resume RUN [options]\n"
        "       atari train AGENT GAMES --seeds SEEDS [--jobs N] [-o FOLDER] [--protocol NAME] [options]"
    )
    parser.epilog = (
        "`atari train ppo --help` shows the options of an agent, and those that change what is played. "
        "Examples: atari train ppo pong --fast; atari train dqn Breakout-ram-v4 --network mlp"
    )
    parser.add_argument("--resume", type=Path, metavar="RUN", help="go on with the training in a run folder")
    _add_games(parser)
    add_sweep(parser)
    parser.add_argument(
        "words", nargs=argparse.REMAINDER, metavar="AGENT GAME", help=f"{', '.join(AGENTS)}, its game and its options"
    )


def _add_games(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--games",
        type=number(int, 0),
        default=30,
        metavar="N",
        help="whole games of the evaluation after the training; 0 leaves it and the report out (default: 30)",
    )


def _train(args: argparse.Namespace) -> int:
    if find_spec("torch") is None:
        raise gymnasium.error.DependencyNotInstalled("atari train needs torch: pip install 'atari-envs[learn]'")
    from atari.learning.command import finish_run, resume, train
    from atari.learning.run import RunFolder

    if args.resume is not None:
        extra = [*args.words, *(f"--{name}" for name in ("seeds", "jobs") if getattr(args, name) is not None)]
        if extra:
            raise ValueError(f"a training goes on with its own options; leave out {' '.join(extra)}")
        resume(args.resume, args.json)
        folder = args.resume
    elif is_sweep(args, args.words):
        try:
            return run_sweep(args, args.words)
        except SystemExit as exit_:  # argparse has printed help or the error
            return int(exit_.code or 0)
    else:
        agent, *words = args.words or [""]
        if agent not in AGENTS:
            raise ValueError(f"name an agent ({', '.join(AGENTS)}) and a game, as in `atari train ppo pong --fast`")
        output = argparse.ArgumentParser(add_help=False)  # flags that may also precede the agent
        output.add_argument("--json", action="store_true", help="print one JSON document")
        _add_games(output)
        args = argparse.Namespace(json=args.json, games=args.games)
        try:
            trained = train(agent, words, f"atari train {agent}", output, args)
        except SystemExit as exit_:  # argparse has printed help or the error
            return int(exit_.code or 0)
        if trained is None:  # --print-task
            return 0
        folder = trained
    result = finish_run(folder, int(args.games)) if args.games else None
    if args.json:
        task = RunFolder.open(folder).config["task"]
        print_json({"run": folder, "task": task, "evaluation": result and result.to_json()})
        return 0
    if result is not None:
        print(result)
    print(f"\n{(folder / 'report.html' if result else folder).absolute()}")
    return 0
