"""The policy of a run folder."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from atari.env.settings import image_shape
from atari.learning.agent import Agent, kept_agent, read_options
from atari.learning.evaluation.protocols import EvaluationProtocol
from atari.learning.hidden import last_hidden
from atari.learning.run_folder import RunFolder
from atari.policy import Accepted, ScoresPolicy


def run_policy(path: Path, sample: bool) -> ScoresPolicy:
    """The newest weights of a run folder as a policy.

    Nothing in the folder is executed, but the program of a run that has one, which the user must trust.

    Args:
        path: the path of the folder.
        sample: draw actions, as agents with `Agent.sample` do in any case.

    Raises:
        FileNotFoundError, ValueError: the folder is no run folder, damaged, or of another version.
        PermissionError: the user does not trust the run's program.
    """
    folder = RunFolder.open(path)
    agent: type[Agent] = kept_agent(folder).kind
    options = dataclasses.replace(read_options(folder, to_train=False), device="cpu")  # also if it was trained on a GPU
    weights = folder.load_weights()
    task = options.task
    size = image_shape(task) if task.kind.image else (128,)
    # Without memory before the weights are known to fit; a network of the user's may need some.
    with torch.device("meta" if isinstance(options.network, str) else "cpu"):
        shape = (task.stack_num or 1, *size)
        network = agent.make_network(options, shape, len(task.action_set))
    expected = network.state_dict()
    for name in sorted(expected.keys() | weights.keys()):
        one, other = (
            f"{found[name].dtype} {tuple(found[name].shape)}" if name in found else "nothing"
            for found in (weights, expected)
        )
        if one != other:
            raise ValueError(f"{path / 'policy.pt'} has weights of another network: {name} is {one}, not {other}")
    network.load_state_dict(weights, assign=True)
    frames = (folder.rows() or [{}])[-1].get("frames", math.nan)
    facts: dict[str, Any] = {
        "accepted": Accepted((shape,) if task.stack_num else (size, shape)),
        "name": f"{folder.config['agent']} ({path.name})",
        "training_frames": int(frames) if math.isfinite(frames) else None,
        "task": task,
        "sample": sample or agent.sample,
        "game": task.game,
        "games": [one.game for one in options.tasks],
        "protocol": training_protocol(folder),
    }

    def of_arrays(function: Any) -> Any:
        def computed(observations: Any) -> npt.NDArray[np.float32]:
            with torch.no_grad():
                result: npt.NDArray[np.float32] = function(torch.from_numpy(observations)).numpy()
            return result

        return computed

    torch.set_num_threads(1)
    scores = of_arrays(network.scores)
    values = of_arrays(network.values) if hasattr(network, "values") else None  # an agent of the user's may have none
    return ScoresPolicy(scores, values=values, features=last_hidden(network, scores), network=network, **facts)


def training_protocol(folder: RunFolder) -> EvaluationProtocol:
    """The protocol of whole games that begin, and go on after lost lives, as the games of the training.

    A part of the actions is random, as at the end of the training. Without sticky actions, a greedy policy plays the
    same few games again and again.
    """
    options = read_options(folder, to_train=False)
    return EvaluationProtocol.of_task(
        options.task,
        name="training",
        source=f"games as in the training {folder.path.name}",
        epsilon=getattr(options, "epsilon", 0.0),  # PPO draws its actions
        episodes=30,
    )
