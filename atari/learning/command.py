"""The command line of trainings: `atari train`, and each agent's script."""

import argparse
import math
import sys
from collections.abc import Sequence
from contextlib import closing
from dataclasses import fields
from pathlib import Path
from typing import Any

import gymnasium
from tqdm import tqdm

from atari._interrupt import ctrl_c_as_event
from atari.learning.agents import find_agent
from atari.learning.options import TrainingOptions, descriptions, parse
from atari.learning.run import RunFolder
from atari.learning.training import Training
from atari.registration import resolve


def train(agent: str, argv: Sequence[str], prog: str) -> Path:
    """Train an agent as a command line says, and return the run folder."""
    found = find_agent(agent)
    parser = _parser(found, prog)
    args = parser.parse_args(argv)
    given = {name: value for name, value in vars(args).items() if name not in ("fast", "run")}
    measured = found.fast if args.fast else {}
    if given.get("obs") == "ram":
        measured = {**measured, "network": "mlp", **(found.fast_ram if args.fast else {})}
    given = {**measured, **given}
    try:
        options = found.options_class(**given)
        folder = args.run or _new_folder(f"{Path(options.game).stem}-{agent}-{options.obs}-seed{options.seed}")
        training = Training.begin(agent, options, folder)
    except (ValueError, FileExistsError) as error:
        parser.error(str(error))
    _run(training)
    return folder


def resume(folder: Path) -> None:
    """Continue a training."""
    _run(Training.resume(folder))


def finish_run(folder: Path, episodes: int) -> Any:
    """Evaluate a policy and write its report; see `atari.learning.report`."""
    from atari.learning.report import finish

    with tqdm(total=episodes, unit=" games", disable=None, desc="evaluation") as bar:
        return finish(RunFolder.open(folder), episodes, lambda done, total: bar.update(done - bar.n))


def main(agent: str) -> None:
    """The command line of an agent's script."""
    folder = train(agent, sys.argv[1:], f"python -m atari.learning.agents.{agent}")
    print(folder)


def _run(training: Training) -> None:
    """Train with a progress bar.

    Raises:
        KeyboardInterrupt: after Ctrl-C, when all is saved.
    """
    agent, options, folder = training.agent, training.options, training.folder.path
    bar = tqdm(total=options.total_steps, initial=agent.steps, unit="step", unit_scale=True, disable=None)

    def show(steps: int, score: float) -> None:
        bar.set_postfix_str("no whole game yet" if math.isnan(score) else f"score {score:.1f}", refresh=False)
        bar.update(steps)

    with closing(training), bar, ctrl_c_as_event() as stop:
        reason = training.run(stop, show)
    if reason == "stop":
        raise KeyboardInterrupt(f"at step {agent.steps:,}; go on with `atari train --resume {folder}`")


def _parser(agent: Any, prog: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=prog, usage=f"{prog} GAME [options]", description=f"Train {agent.__name__}.", allow_abbrev=False
    )
    parser.add_argument("game", metavar="GAME", type=_game, help="a game, such as pong, an ID or a game definition")
    parser.add_argument("-o", "--run", type=Path, metavar="RUN", help="the new run folder (default: in runs/)")
    parser.add_argument("--fast", action="store_true", help="use the options of the list below, found by measurement")
    texts = descriptions(agent.options_class)
    for field in fields(agent.options_class):
        if field.name != "game":
            flag = f"--{field.name.replace('_', '-')}"
            text = f"{texts[field.name]} (default: {_shown(field.default)})".replace("%", "%%")
            kind = _option_type(agent.options_class, field.name)
            parser.add_argument(flag, type=kind, default=argparse.SUPPRESS, metavar="X", help=text)
    parser.epilog = "--fast: " + ", ".join(f"{name} {_shown(value)}" for name, value in agent.fast.items())
    return parser


def _game(name: str) -> str:
    """The option `game` of an argument: a game, an ID's game, or the path of a game definition from any folder."""
    try:
        if name.endswith(".toml"):
            return str(Path(name).absolute())
        return resolve(name)[1] if "-v" in name or "/" in name else name
    except gymnasium.error.NameNotFound as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _option_type(options: type[TrainingOptions], name: str) -> Any:
    def convert(text: str) -> Any:
        try:
            return parse(options, name, text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return convert


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return "none" if value is None else ",".join(value) if isinstance(value, tuple) else str(value)


def _new_folder(name: str) -> Path:
    """The first of runs/NAME, runs/NAME-2, ... that does not exist."""
    folder, number = Path("runs", name), 1
    while folder.exists():
        number += 1
        folder = Path("runs", f"{name}-{number}")
    return folder
