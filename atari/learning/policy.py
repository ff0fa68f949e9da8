"""`Policy`: what chooses actions; and policies made of a function that gives scores of actions."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from atari.task import Task

Array = npt.NDArray[Any]


@runtime_checkable
class Policy(Protocol):
    """What chooses actions for a batch of environments: a function of two arrays, with optional attributes.

    - `name`: a string, for results.
    - `task`: the `atari.Task` that it was trained on. It says which observations the policy needs, and which actions
      the indices are.
    - `environment`: the same as a mapping of options, by the names of `AtariVectorEnv`: `preset` and fields of
      `atari.Task`, such as `obs_type`, `img_height`, `img_width`, `stack_num`, `maxpool`, `full_action_space`, or
      `actions`, a sequence of names such as ("NOOP", "RIGHT", "LEFT"); or `task`, a task as the object of its JSON.
      Beside either, and beside the attribute `task`, it may have `channels_last` and `dtype` of the observations, and
      `rom`.
      An evaluation plays sticky actions, beginnings, lives and limits as its protocol says. It refuses a policy of
      another frame skip than the protocol's, or of another mode, difficulty or interventions than those of the game to
      evaluate, and policies of several players or of continuous actions.
    - `game`: the id of the game that it was trained on.
    - `protocol`: the `EvaluationProtocol` of its training, which commands play unless --protocol names another one.
    - `training_frames`: emulator frames of its training, an int.
    - `begin(game, actions, lanes, seeds)`: called when games begin in some lanes, before their first observations.
      `game` is the game's id, `actions` the names of all its actions in the order of indices, `lanes` (n,) int64,
      `seeds` (n,) int64. A policy that draws numbers or has a memory sets them up here for these lanes; then results
      do not depend on the number of lanes.
    - `begin_episodes(lanes)`: called where the environment begins an episode in the same game, after a lost life, and a
      new stack of images.

    Example:
        >>> from atari.learning import evaluate
        >>> def fire(observations):
        ...     return [1] * len(observations)
        >>> evaluate(fire, "breakout", "dopamine", episodes=1, seed=0)["breakout"].scores
        (0.0,)
    """

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> Any:
        """Actions (n,), integers, for the observations (n, ...) uint8 of the environments `lanes` (n,) int64."""


def as_policy(policy: Any) -> Policy:
    """`policy`, or a policy of a function of observations alone.

    Raises:
        TypeError: it cannot be called with observations, nor with observations and lanes.
    """
    found: Policy = policy
    if not callable(policy):
        raise TypeError(f"a policy is a function of observations and lanes, got {policy!r}")
    try:
        signature = inspect.signature(policy)
    except (TypeError, ValueError):  # a builtin
        return found
    # A second argument with a default is something else, unless its name is `lanes`.
    for count in (2, 1, 2)["lanes" not in signature.parameters :]:
        try:
            signature.bind(*[None] * count)
        except TypeError:
            continue
        return found if count == 2 else _OfObservations(policy)
    raise TypeError(f"a policy takes (observations, lanes) or (observations), got {policy!r} with {signature}")


class _OfObservations:
    """A policy of a function that takes no lanes. It has those of a policy's attributes that the function has."""

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self._function = function
        self.name = getattr(function, "__qualname__", type(function).__name__)
        for name in ("name", "task", "environment", "game", "protocol", "training_frames", "begin", "begin_episodes"):
            if hasattr(function, name):
                setattr(self, name, getattr(function, name))

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> Any:
        return self._function(observations)


class ScoresPolicy:
    """A policy of a function that gives a score for each action: action values, or logits.

    Args:
        scores: a function of observations (n, ...) uint8 that returns scores (n, actions), or actions (n,), integers.
        sample: whether actions are drawn with the probabilities softmax(scores), with a generator for each game;
            otherwise the action with the highest score is taken.
        name, task, environment, training_frames, game: as of `Policy`.

    Example:
        >>> import numpy as np
        >>> from atari.learning import ScoresPolicy, evaluate
        >>> policy = ScoresPolicy(lambda observations: np.eye(4)[[1] * len(observations)], name="fire")
        >>> evaluate(policy, "breakout", "dopamine", episodes=1, seed=0)["breakout"].scores
        (0.0,)
    """

    def __init__(
        self,
        scores: Callable[[Any], Array],
        *,
        sample: bool = False,
        name: str = "",
        task: Task | None = None,
        environment: Mapping[str, Any] | None = None,
        training_frames: int | None = None,
        game: str | None = None,
    ) -> None:
        self._scores = scores
        self._sample = sample
        self._generators: dict[int, np.random.Generator] = {}
        self.name = name
        self.task = task
        self.environment = dict(environment or {})
        self.training_frames = training_frames
        self.game = game

    def begin(self, game: str, actions: Sequence[str], lanes: npt.NDArray[np.int64], seeds: Array) -> None:
        """Set up the generators of some lanes."""
        for lane, seed in zip(lanes.tolist(), seeds.tolist(), strict=True):
            self._generators[lane] = np.random.default_rng(seed)

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> Array:
        """The actions (n,) for observations (n, ...) of some lanes.

        Raises:
            ValueError: the function returns neither scores nor actions.
        """
        scores = np.asarray(self._scores(observations))
        if scores.ndim == 1 and scores.dtype.kind in "iu":
            return scores
        if scores.ndim != 2 or scores.dtype.kind != "f":
            raise ValueError(
                f"{self.name or 'the policy'} must return scores (n, actions), floats, or actions (n,), integers; "
                f"got {scores.dtype} {scores.shape}"
            )
        if np.isnan(scores).any():
            raise ValueError(f"{self.name or 'the policy'} returned a score that is no number (NaN)")
        if self._sample:  # the highest of scores with Gumbel noise is a draw of softmax
            scores = scores + np.stack([self._generators[lane].gumbel(size=scores.shape[1]) for lane in lanes.tolist()])
        best: Array = scores.argmax(1)
        return best
