"""The policy of a run folder."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from atari.learning.agents import find_agent
from atari.learning.environments import RamStack
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.policy import ScoresPolicy
from atari.learning.run import RunFolder
from atari.learning.training import read_options


def run_policy(path: Path, sample: bool) -> ScoresPolicy:
    """The newest weights of a run folder as a policy; nothing in the folder is executed.

    Args:
        path: of the folder.
        sample: draw the actions of agents whose actions are drawn in training.

    Raises:
        FileNotFoundError, ValueError: it is no run folder, damaged, or of another version.
    """
    folder = RunFolder.open(path)
    options, weights = read_options(folder), folder.load_weights()
    agent, task = find_agent(folder.config["agent"]), options.task
    rows, columns = task.definition.screen.shape
    size = (128,) if options.from_ram else (task.img_height or rows, task.img_width or columns)
    network = agent.make_network(options, (options.stack, *size), len(task.action_set))
    try:
        network.load_state_dict(weights)
    except RuntimeError as error:
        raise ValueError(f"{path / 'policy.pt'} has weights of another network: {error}") from None
    log = folder.rows()
    facts: dict[str, Any] = {
        "name": f"{folder.config['agent']} ({path.name})",
        "training_frames": int(log[-1]["frames"]) if log else None,
        "task": task,
        "sample": sample or agent.sample,
        "game": task.game,
    }

    def scores(observations: Any) -> npt.NDArray[np.float32]:
        with torch.no_grad():
            values: npt.NDArray[np.float32] = network.scores(torch.from_numpy(observations)).numpy()
        return values

    torch.set_num_threads(1)
    of_ram = options.from_ram
    policy = RamPolicy(scores, options.stack, options.padding, **facts) if of_ram else ScoresPolicy(scores, **facts)
    policy.protocol = training_protocol(folder)  # type: ignore[attr-defined]
    return policy


def training_protocol(folder: RunFolder) -> EvaluationProtocol:
    """A protocol of the whole games of the training's task: they begin, and go on after lost lives, as in the training.

    A part of the actions is random, as at the end of the training: without sticky actions, a greedy policy plays the
    same few games again and again.
    """
    options = read_options(folder)
    return EvaluationProtocol.of_task(
        options.task,
        name="training",
        source=f"games as in the training {folder.path.name}",
        epsilon=getattr(options, "epsilon", 0.0),  # PPO draws its actions
        episodes=30,
    )


class RamPolicy(ScoresPolicy):
    """A policy on the last RAM vectors of each lane.

    Args:
        scores: as of `ScoresPolicy`, of stacks (n, stack, 128).
        stack: how many vectors.
        padding: what fills a stack at the start of an episode, "zero" or "reset", the first vector.
        **facts: as of `ScoresPolicy`.
    """

    def __init__(self, scores: Any, stack: int, padding: str = "reset", **facts: Any) -> None:
        super().__init__(scores, **facts)
        self._stacks = RamStack(0, stack, padding)
        self._started = np.zeros(0, np.bool_)

    def begin(self, game: str, actions: Sequence[str], lanes: npt.NDArray[np.int64], seeds: npt.NDArray[Any]) -> None:
        """Begin the stacks of some lanes anew, of new games."""
        super().begin(game, actions, lanes, seeds)
        count = max(len(self._started), int(lanes.max()) + 1)
        self._stacks.resize(count)
        self._started = np.concatenate([self._started, np.ones(count - len(self._started), np.bool_)])
        self._started[lanes] = True

    def begin_episodes(self, lanes: npt.NDArray[np.int64]) -> None:
        """Begin the stacks of some lanes anew, after a lost life."""
        self._started[lanes] = True

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
        """The actions (n,) for RAM (n, 128) of some lanes."""
        stacks = self._stacks.push(observations, self._started[lanes], lanes)
        self._started[lanes] = False
        return super().__call__(stacks, lanes)

    def state(self) -> Any:
        """The generators and the stacks."""
        return super().state(), self._stacks.rows, self._started

    def restore(self, state: Any) -> None:
        """Continue with the generators and the stacks of `state`."""
        generators, self._stacks.rows, self._started = state
        super().restore(generators)
