"""The command line of trainings: `atari train`, and each agent's script."""

import argparse
import math
import sys
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import fields
from datetime import timedelta
from functools import partial
from pathlib import Path
from typing import Any, get_type_hints

import gymnasium

from atari.base.program import ctrl_c_as_event, interruptible, run
from atari.base.progress import ProgressBar
from atari.base.typed_table import fits, in_text
from atari.learning.agent import Agent, AgentCode, agent_code
from atari.learning.options import FAST_RAM, NOT_FOR_AGENTS, TrainingOptions, option_from_text
from atari.learning.run_folder import RunFolder
from atari.learning.training import Training
from atari.task import Task
from atari.task.arguments import add_task, descriptions, given_options, read_game, show_task, task_of
from atari.task.description import summary
from atari.task.parser import Parser, add_refused, as_type


def train(
    code: AgentCode,
    argv: Sequence[str],
    prog: str,
    output: argparse.ArgumentParser | None = None,
    args: argparse.Namespace | None = None,
) -> Path | None:
    """Train an agent as a command line says, and return the run folder.

    With `--print-task` nothing is trained, and the result is None.

    Args:
        code: the agent.
        argv: the command line without the agent.
        prog: the command, for help and errors.
        output: a parser of the caller's flags and of `--json`, with which the task is printed as JSON.
        args: the values of these flags so far, to which the values of the command line are added.
    """
    parser = _parser(code.kind, prog, output)
    args = parser.parse_args(argv, args)
    try:
        options = _options(code.kind, args)
        if args.print_task:
            show_task(args, options.task)
            return None
        kind = "ram" if options.from_ram else "pixels"
        folder = args.run or _new_folder(f"{options.task.game}-{code.name}-{kind}-seed{options.seed}")
        training = Training.begin(code, options, folder)
    except (TypeError, ValueError, FileNotFoundError, FileExistsError, gymnasium.error.NameNotFound) as error:
        parser.error(str(error))
    show_task(args, options.task)
    memory = training.agent.memory
    if memory is not None and not args.json:
        print(
            f"{folder / 'memory.replay'} takes {memory.nbytes / 1e9:,.2g} GB until the training is complete", flush=True
        )
    _run(training)
    return folder


def game_among(code: AgentCode, argv: Sequence[str], prog: str) -> str:
    """The game of a command line without the agent, as the user names it. Unknown options are left out."""
    return _parser(code.kind, prog, None).parse_known_args(argv)[0].game


def training_options(code: AgentCode, argv: Sequence[str], prog: str) -> TrainingOptions:
    """The options of the training that a command line without the agent and a run folder describes.

    A mistake in the command line ends the program with the usage and the error, see `argparse`.
    """
    parser = _parser(code.kind, prog, None)
    args = parser.parse_args(argv)
    for flag, value in (("--print-task", args.print_task), ("-o", args.run)):
        if value:
            parser.error(f"{flag} is for one training; leave it out")
    try:
        options: TrainingOptions = _options(code.kind, args)
    except (TypeError, ValueError, FileNotFoundError, gymnasium.error.NameNotFound) as error:
        parser.error(str(error))
    return options


def _options(agent: type[Agent], args: argparse.Namespace) -> Any:
    game, kind, fields_of_task = read_game(args.game), agent.options_class, given_options(args)
    names = {field.name for field in fields(kind)}
    own = {name: value for name, value in vars(args).items() if name in names}
    measured: dict[str, Any] = {}
    if args.fast:
        if isinstance(game, Task):
            raise ValueError(f"--fast changes what is played, and {args.game} says it; leave one of them out")
        ram = not task_of(args, agent=True, default=agent.fast["preset"]).kind.image
        measured = {**agent.fast, **(FAST_RAM if ram else {})}
    named = {} if args.preset is None else {"preset": args.preset}
    return kind.of(game, **{**measured, **named, **fields_of_task, **own})


def resume(path: Path, as_json: bool = False) -> None:
    """Continue a training that is not complete. Without `as_json`, the first printed line is a summary of its task."""
    with RunFolder.open(path, lock=True) as folder:  # its end removes a memory that a kill has left
        ended = folder.config.get("ended")
        if not as_json:
            print(summary(folder.task), flush=True)
    if ended is None:
        _run(Training.resume(path))
    elif not as_json:
        print(f"the training in {path} is complete ({_REASONS.get(ended, ended)}); only its games are played again")


_REASONS = {"steps": "all steps are done", "score": "the score was reached"}


def finish_run(path: Path, episodes: int) -> Any:
    """Evaluate a policy and write its report; see `atari.learning.report`."""
    from atari.learning.report import finish

    with RunFolder.open(path, lock=True) as folder, ProgressBar(total=episodes, unit=" games", disable=None) as bar:
        bar.set_description("evaluation")
        return finish(folder, episodes, lambda done, total: bar.update(done - bar.n))


def main(agent: type[Agent]) -> None:
    """The command line of the script of an agent: trains the agent as its arguments say, and prints the run folder.

    Args:
        agent: the class of the agent, which stands in the script.

    Example:
        A script ends with these lines, and is called as `python my_agent.py pong --fast`:

            if __name__ == "__main__":
                main(MyAgent)
    """
    code = agent_code(agent)
    prog = f"python {sys.argv[0]}" if code.program else f"python -m atari.learning.agents.{code.name}"

    def command() -> int:
        with interruptible():
            folder = train(code, sys.argv[1:], prog)
        if folder is not None:
            print(folder)
        return 0

    if status := run(command, traceback=code.program is not None):
        sys.exit(status)


def _run(training: Training) -> None:
    """Train with a progress bar, or, if stderr is no terminal, with a line a minute."""
    agent, options, folder = training.agent, training.options, training.folder.path
    bar = ProgressBar(total=options.total_steps, initial=agent.steps, unit="step", unit_scale=True, disable=None)
    lines = Lines(agent.steps, options.total_steps)

    def show(steps: int, score: float) -> None:
        text = "no whole game yet" if math.isnan(score) else f"score {score:.1f}"
        bar.set_postfix_str(text, refresh=False)
        bar.update(steps - bar.n)
        if bar.disable:
            lines.show(steps, text)

    with closing(training), bar, ctrl_c_as_event() as stop:
        reason = training.run(stop, show)
    if reason == "stop":
        raise KeyboardInterrupt(f"at step {agent.steps:,}; go on with `atari train --resume {folder}`")


class Lines:
    """Progress for a log file: a line a minute on stderr."""

    def __init__(self, step: int, total: int, seconds: float = 60.0) -> None:
        self._first, self._total, self._seconds = step, total, seconds
        self._start = self._shown = time.monotonic()

    def show(self, step: int, text: str) -> None:
        """Print a line if a minute has passed since the last one."""
        now = time.monotonic()
        if now - self._shown < self._seconds:
            return
        self._shown = now
        speed = (step - self._first) / (now - self._start)
        left = timedelta(seconds=round(max(0, self._total - step) / speed)) if speed else "unknown time"
        print(f"{step:,} of {self._total:,} steps, {text}, {speed:,.0f}/s, {left} left", file=sys.stderr, flush=True)


def _parser(agent: type[Agent], prog: str, output: argparse.ArgumentParser | None) -> argparse.ArgumentParser:
    kind = agent.options_class
    parser = Parser(
        prog=prog,
        usage=f"{prog} GAME [options]; --help lists them",
        description=f"Train {agent.__name__}.",
        parents=[] if output is None else [output],
    )
    parser.add_argument(
        "game",
        metavar="GAME",
        help="a game, such as pong; an ID, which decides sticky actions, actions, and RAM or images; a game file; or a "
        "task (.json), which is played unchanged. "
        f"All else is as preset {kind.default_preset} has it, with clipped rewards, unless --preset or --fast name "
        "another one",
    )
    parser.add_argument("-o", "--run", type=Path, metavar="RUN", help="the new run folder (default: in runs/)")
    parser.add_argument("--fast", action="store_true", help="use the options of the list below, found by measurement")
    texts, kinds = descriptions(kind), get_type_hints(kind)
    for field in fields(kind):
        if field.name != "task":
            flag = f"--{field.name.replace('_', '-')}"
            default = "" if field.default is None else f" (default: {in_text(field.default)})"
            text = f"{texts[field.name]}{default}".replace("%", "%%")
            own: dict[str, Any] = {
                "type": as_type(partial(option_from_text, kind, field.name)),
                "default": argparse.SUPPRESS,
                "metavar": "X",
            }
            if fits(True, kinds[field.name]):
                own |= {"nargs": "?", "const": True}
            parser.add_argument(flag, help=text, **own)
    add_task(parser, refused=NOT_FOR_AGENTS)
    add_refused(parser, dict.fromkeys(_OF_SWEEPS, _SWEEP))
    listed, of_ram = (
        ", ".join(f"{name} {in_text(value)}" for name, value in options.items()) for options in (agent.fast, FAST_RAM)
    )
    parser.epilog = f"--fast: {listed}. From RAM it has instead: {of_ram}"
    return parser


_OF_SWEEPS = ("--seeds", "--grid", "--jobs", "--protocol", "--episodes", "--compare", "--mixed")
_SWEEP = (
    f"{', '.join(_OF_SWEEPS)} are for a sweep, `atari train AGENT GAMES --seeds 0-2`; one training has --seed, and "
    "`atari evaluate RUN --protocol NAME` evaluates it"
)


def _new_folder(name: str) -> Path:
    """The first of runs/NAME, runs/NAME-2, ... that does not exist."""
    folder, number = Path("runs", name), 1
    while folder.exists():
        number += 1
        folder = Path("runs", f"{name}-{number}")
    return folder
