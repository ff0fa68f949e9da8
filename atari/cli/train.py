"""`atari train`: an agent learns to play a game."""

import argparse
import difflib
from functools import partial
from pathlib import Path

from atari.base.extras import import_extra, install_extra
from atari.cli.arguments import Commands, add_command
from atari.cli.printing import print_json
from atari.cli.sweep import add_sweep, is_sweep, run_sweep
from atari.learning.agents import AGENTS
from atari.task.parser import Parser, as_type, number


def register(commands: Commands) -> None:
    """Add `atari train`."""
    parser = add_command(commands, "train", _train, "let an agent learn to play a game")
    parser.usage = (
        "atari train AGENT GAME [options]\n       atari train --resume RUN [--total-steps N] [options]\n"
        "       atari train AGENT GAMES --seeds SEEDS [--grid OPTION=VALUES] [--jobs N] [-o FOLDER] [--protocol NAME] "
        "[options]"
    )
    parser.epilog = (
        "`atari train ppo --help` shows the options of an agent, and those that change what is played. "
        "Examples: atari train ppo pong --fast; atari train dqn Breakout-ram-v4 --network mlp"
    )
    parser.add_argument("--resume", type=Path, metavar="RUN", help="go on with the training in a run folder")
    _add_games(parser)
    add_sweep(parser)
    parser.add_argument(
        "words",
        nargs=argparse.REMAINDER,
        metavar="AGENT GAME",
        help=f"{', '.join(AGENTS)}, or a Python file with an agent of your own; its game and its options",
    )


def _add_games(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--games",
        type=number(int, 0),
        default=30,
        metavar="N",
        help="whole games of the evaluation after the training; 0 leaves it and the report out (default: 30)",
    )


def _agent_among(words: list[str]) -> tuple[str, list[str]]:
    """The word that names the agent, and the other words: options may stand before it.

    A word after an option can be the option's value, so it is the agent only if no other word is.

    Raises:
        ValueError: no word names an agent.
    """
    from atari.learning.programs import is_program

    named = [place for place, word in enumerate(words) if word in AGENTS or is_program(word)]
    free = [place for place in named if place == 0 or not words[place - 1].startswith("-")]
    given = next((word for word in words if not word.startswith("-")), None)
    if not named and given is not None:
        files = [file for file in (f"{given}.py", f"{given}y") if file.endswith(".py") and Path(file).exists()]
        near = [*files, *difflib.get_close_matches(given, AGENTS, n=1, cutoff=0.5)]
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(AGENTS)}, and Python files of your own"
        raise ValueError(f"there is no agent {given!r}; {hint}")
    if not named:
        raise ValueError(
            f"name an agent ({', '.join(AGENTS)}, or a Python file such as my_ppo.py) and a game, as in "
            "`atari train ppo pong --fast`"
        )
    place = (free or named)[0]
    return words[place], words[:place] + words[place + 1 :]


def _parse_after_resume(args: argparse.Namespace) -> argparse.Namespace:
    """The options that follow `--resume RUN`."""
    from atari.learning.options import TrainingOptions, option_from_text

    parser = _output_parser()
    parser.add_argument("--total-steps", type=as_type(partial(option_from_text, TrainingOptions, "total_steps")))
    args, unknown = parser.parse_known_args(args.words, argparse.Namespace(**vars(args)))
    if unknown:
        raise ValueError(
            f"a training goes on with its own options, but for --total-steps N; leave out {' '.join(unknown)}"
        )
    return args


def _output_parser() -> argparse.ArgumentParser:
    """The flags that may stand before and after the agent."""
    parser = Parser(add_help=False)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    _add_games(parser)
    return parser


def _train(args: argparse.Namespace) -> int:
    import_extra("torch", f"atari train needs torch: {install_extra('learn')}")
    from atari.learning.agent import agent_code
    from atari.learning.command import finish_run, resume, train
    from atari.learning.run_folder import RunFolder

    if args.resume is not None:
        if args.seeds is not None or args.jobs is not None or args.grid:
            raise ValueError("--seeds, --grid and --jobs are for new trainings; leave them out beside --resume")
        args = _parse_after_resume(args)
        if args.total_steps is not None:
            with RunFolder.open(args.resume, lock=True) as run:
                run.extend(args.total_steps)
        resume(args.resume, args.json)
        folder = args.resume
    else:
        agent, words = _agent_among(args.words)
        code = agent_code(agent)
        try:
            if is_sweep(args, code, words):
                return run_sweep(args, code, words)
            args = argparse.Namespace(json=args.json, games=args.games)
            trained = train(code, words, f"atari train {agent}", _output_parser(), args)
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
