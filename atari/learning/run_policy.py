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
from atari.wrappers.presets import preset_protocol


def run_policy(path: Path, sample: bool) -> ScoresPolicy:
    """The newest weights of a run folder as a policy; nothing in the folder is executed.

    Args:
        path: of the folder.
        sample: draw the actions of agents whose actions are drawn in training.

    Raises:
        FileNotFoundError, ValueError: it is no run folder, damaged, or of another version.
    """
    folder = RunFolder.open(path)
    options = read_options(folder)
    sees, weights = folder.config["policy"], folder.load_weights()
    agent = find_agent(folder.config["agent"])
    ram = sees.get("obs_type") == "ram"
    shape = (sees["ram_stack"], 128) if ram else (sees["stack_num"], sees["img_height"], sees["img_width"])
    network = agent.make_network(options, shape, len(sees["actions"]))
    try:
        network.load_state_dict(weights)
    except RuntimeError as error:
        raise ValueError(f"{path / 'policy.pt'} has weights of another network: {error}") from None
    rows = folder.rows()
    facts: dict[str, Any] = {
        "name": f"{folder.config['agent']} ({path.name})",
        "training_frames": int(rows[-1]["frames"]) if rows else None,
        "environment": {"preset": options.protocol, **{key: sees[key] for key in sees if key != "ram_stack"}},
        "sample": sample or agent.sample,
    }

    def scores(observations: Any) -> npt.NDArray[np.float32]:
        with torch.no_grad():
            values: npt.NDArray[np.float32] = network.scores(torch.from_numpy(observations)).numpy()
        return values

    torch.set_num_threads(1)
    policy = RamPolicy(scores, sees["ram_stack"], **facts) if ram else ScoresPolicy(scores, **facts)
    policy.game = options.game
    policy.protocol = training_protocol(folder)  # type: ignore[attr-defined]
    return policy


def training_protocol(folder: RunFolder) -> EvaluationProtocol:
    """A protocol whose games begin and end as in the training.

    A part of the actions is random, as at the end of the training: without sticky actions, a greedy policy plays the
    same few games again and again.
    """
    options = read_options(folder)
    played = preset_protocol(options.protocol, episodic_life=options.episodic_life)
    sticky = played.repeat_action_probability if options.sticky is None else options.sticky
    return EvaluationProtocol(
        name="training",
        source=f"games as in the training: preset {options.protocol}",
        repeat_action_probability=sticky,
        full_action_space=played.full_action_space,
        noop_min=played.noops[0],
        noop_max=played.noops[1],
        max_frames=108_000,
        epsilon=getattr(options, "epsilon", 0.0),  # PPO draws its actions
        episodes=30,
        preset=options.protocol,
        lives="preset" if played.episodic_life else "continue" if played.fire == "never" else "fire",
    )


class RamPolicy(ScoresPolicy):
    """A policy on the last RAM vectors of each lane."""

    def __init__(self, scores: Any, stack: int, **facts: Any) -> None:
        super().__init__(scores, **facts)
        self._size = stack
        self._stacks = RamStack(0, stack)
        self._started = np.zeros(0, np.bool_)

    def begin(self, game: str, actions: Sequence[str], lanes: npt.NDArray[np.int64], seeds: npt.NDArray[Any]) -> None:
        """Forget the vectors of some lanes."""
        super().begin(game, actions, lanes, seeds)
        count = max(len(self._started), int(lanes.max()) + 1)
        self._stacks.resize(count)
        self._started = np.concatenate([self._started, np.ones(count - len(self._started), np.bool_)])
        self._started[lanes] = True

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
        """The actions (n,) for RAM (n, 128) of some lanes."""
        stacks = self._stacks.push(observations, self._started[lanes], lanes)
        self._started[lanes] = False
        return super().__call__(stacks, lanes)
