"""`Policy`: a function that chooses actions, and how this package calls it; `ScoresPolicy`: a policy from scores."""

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from atari.base.validation import check_integer
from atari.policy.inside import METHODS, OptionalMethod, absent
from atari.task import Task

Array = npt.NDArray[Any]
Floats = npt.NDArray[np.float32]


@runtime_checkable
class Policy(Protocol):
    """A function that chooses actions for a batch of environments, with optional attributes.

    - `name`: a string, for results.
    - `task`: the `atari.Task` of its training, which decides the policy's observations, and the meaning of its action
      indices.
    - `environment`: the same as a mapping of options, by the names of `AtariVectorEnv`: `preset` and fields of
      `atari.Task`, such as `obs_type`, `img_height`, `img_width`, `stack_num`, `maxpool`, `full_action_space`, or
      `actions`, a sequence of names such as ("NOOP", "RIGHT", "LEFT"); or `task`, a task as the object of its JSON.
      It may also have `channels_last`, `dtype` of the observations, and `rom`, even beside the attribute `task`.
      An evaluation takes sticky actions, starts, lives and limits from its protocol. It refuses a policy with
      another frame skip than the protocol, or with another mode, difficulty or interventions than the game to
      evaluate, and policies of several players or with continuous actions.
    - `game`: the id of the game of its training.
    - `games`: the ids of all games of its training; commands say so if it plays another one.
    - `protocol`: the `EvaluationProtocol` of its training, which commands play unless --protocol names another one.
    - `training_frames`: emulator frames of its training, an int.
    - `sample`: whether it draws its actions; data sets mark each action as sampled, or with False as greedy.
    - `begin(game, actions, lanes, seeds)`: called when games begin in some lanes, before their first observations.
      `game` is the game's id, `actions` the names of all its actions by index, `lanes` (n,) int64, `seeds` (n,) int64.
        A policy that draws numbers or has a memory sets them up here for these lanes; then results do not depend on the
        number of lanes.
    - `state()` and `restore(state)`: everything else that its next actions depend on, such as its generators, in a form
      that can be pickled; and `load(weights)`. `atari.integrations.ray.RolloutActors` calls them.
    - `begin_episodes(lanes)`: called where the environment begins an episode, with a new stack, in the same game after
      a lost life.
    - `scores(observations)`, `values(observations)`, `probabilities(observations)`, `features(observations)` and
      `network`: see `ScoresPolicy`. A policy that lacks one has no such attribute.

    Example:
        >>> from atari.learning import evaluate
        >>> def fire(observations):
        ...     return [1] * len(observations)
        >>> evaluate(fire, "breakout", "dopamine", episodes=1, seed=0)["breakout"].scores
        (0.0,)
    """

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> Any:
        """Actions (n,), integers, for the observations (n, ...) uint8 of the environments `lanes` (n,) int64.

        A policy may also return (actions, extras), with a mapping of arrays (n, ...), which a `Rollout` stores.
        """


def describe(observations: Any) -> str:
    """The dtype and shape of observations, for errors."""
    if isinstance(observations, Mapping):
        return ", ".join(f"{key} {describe(value)}" for key, value in observations.items())
    return f"{observations.dtype} {tuple(observations.shape)}"


class LoadedPolicy:
    """The form of a policy that this package calls: with a name, all methods, and checked actions.

    Other attributes are read from the policy itself.

    Args:
        policy: a function of observations and lanes, or of observations alone, with the attributes of `Policy`.

    Raises:
        TypeError, ValueError: it is no such function, or its `training_frames` is no such number.
    """

    def __init__(self, policy: Any) -> None:
        self._policy = policy
        self._takes_lanes = takes_lanes(policy)
        self._names: tuple[str, ...] | None = None
        self._game = ""
        named = getattr(policy, "name", "") or getattr(policy, "__qualname__", "") or type(policy).__name__
        self.name = str(named)
        frames = getattr(policy, "training_frames", None)
        self.training_frames = None if frames is None else check_integer("training_frames", frames, 0, 10**15)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # a copy without attributes yet, or a special method of Python
            raise AttributeError(name)
        if name in METHODS and not hasattr(self._policy, name):
            raise absent(self.name, name)
        return getattr(self._policy, name)

    def begin(self, game: str, actions: Sequence[str], lanes: npt.NDArray[np.int64], seeds: Array) -> None:
        """Begin games in some lanes, see `Policy`."""
        self._game, self._names = game, tuple(actions)
        begin = getattr(self._policy, "begin", None)
        if begin is not None:
            begin(game, self._names, lanes, seeds)

    def begin_episodes(self, lanes: npt.NDArray[np.int64]) -> None:
        """Begin episodes in some lanes, whose games continue, see `Policy`."""
        begin = getattr(self._policy, "begin_episodes", None)
        if begin is not None:
            begin(lanes)

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64] | None = None) -> npt.NDArray[np.int64]:
        """The actions (n,) for observations (n, ...) of some lanes; None are lanes 0 to n - 1.

        Raises:
            ValueError: the policy returns no such actions.
        """
        lanes = np.arange(len(observations)) if lanes is None else lanes
        return self.checked(self.choose(observations, lanes)[0], lanes)

    def checked(self, actions: Array, lanes: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """The actions that `choose` has returned, checked to be one action of the game for each lane.

        Raises:
            ValueError: the actions are anything else.
        """
        if actions.dtype.kind not in "iu" or actions.shape != (len(lanes),):
            got = f"{actions!r:.60}" if actions.dtype.kind == "O" else f"{actions.dtype} {actions.shape}"
            raise ValueError(
                f"policy {self.name} must return integers of shape ({len(lanes)},), one for each observation, got "
                f"{got}; a policy is a function of observations (n, ...), and returns n actions; wrap a function that "
                "returns scores in atari.learning.ScoresPolicy"
            )
        if self._names is not None and ((actions < 0) | (actions >= len(self._names))).any():
            wrong = actions[(actions < 0) | (actions >= len(self._names))][0]
            raise ValueError(
                f"policy {self.name} returned action {wrong}; in {self._game} it has {len(self._names)} actions, "
                f"0..{len(self._names) - 1} ({', '.join(self._names)})"
            )
        return actions.astype(np.int64)

    def choose(self, observations: Any, lanes: npt.NDArray[np.int64]) -> tuple[Array, Mapping[str, Any]]:
        """The values that the policy returns, unchecked: actions, and extras by name.

        Raises:
            ValueError: the policy returns no array.
        """
        returned = self._policy(observations, lanes) if self._takes_lanes else self._policy(observations)
        extras: Mapping[str, Any] = {}
        if isinstance(returned, tuple) and len(returned) == 2 and isinstance(returned[1], Mapping):
            returned, extras = returned
        try:
            return np.asarray(returned), extras
        except ValueError as error:
            raise ValueError(
                f"policy {self.name} must return actions, or (actions, extras) with a mapping of arrays, got "
                f"{returned!r:.80}"
            ) from error


def is_network(policy: Any) -> bool:
    """Whether a policy is a network of PyTorch. PyTorch is not imported for this."""
    torch = sys.modules.get("torch")
    return torch is not None and isinstance(policy, torch.nn.Module)


def makes_policy(source: Any) -> bool:
    """Whether an object makes a policy: a class, or a function without parameters."""
    if isinstance(source, type) or not callable(source) or is_network(source):
        return isinstance(source, type)
    try:
        return not inspect.signature(source).parameters
    except (TypeError, ValueError):  # a builtin
        return False


def takes_lanes(policy: Any) -> bool:
    """Whether a function takes observations and lanes, not observations alone.

    Raises:
        TypeError: the function takes neither.
    """
    if not callable(policy):
        raise TypeError(f"a policy is a function of observations and lanes, got {policy!r}")
    try:
        signature = inspect.signature(policy.forward if is_network(policy) else policy)
    except (TypeError, ValueError):  # a builtin, or a traced network
        return not is_network(policy)
    # A second argument with a default is not the lanes, unless its name is `lanes`.
    for count in (2, 1, 2)["lanes" not in signature.parameters :]:
        try:
            signature.bind(*[None] * count)
        except TypeError:
            continue
        return count == 2
    raise TypeError(f"a policy takes (observations, lanes) or (observations), got {policy!r} with {signature}")


@dataclass(frozen=True)
class Accepted:
    """The observations that a network can be computed on.

    Attributes:
        shapes: the shapes of one observation.
        dtype: the name of the only dtype, such as "uint8"; "" is every number.
    """

    shapes: tuple[tuple[int, ...], ...]
    dtype: str = "uint8"

    def check(self, name: str, observations: Any, count: int) -> None:
        """Refuse everything but an array of `count` such observations.

        Raises:
            TypeError: it is no array, or one of another dtype.
            ValueError: the array has another shape.
        """
        shapes = " or ".join(str((count, *shape)) for shape in self.shapes)
        wanted = f"{name or 'the policy'} takes observations {self.dtype or 'of numbers'} {shapes}"
        if not isinstance(observations, np.ndarray):
            raise TypeError(f"{wanted}, a NumPy array, got {type(observations).__name__}; {_CAUSE}")
        if observations.dtype != self.dtype if self.dtype else observations.dtype.kind not in "biuf":
            raise TypeError(f"{wanted}, got {describe(observations)}; {_CAUSE}")
        if observations.shape not in [(count, *shape) for shape in self.shapes]:
            raise ValueError(f"{wanted}, got {describe(observations)}; {_CAUSE}")


_CAUSE = "make the environment with the policy's task or environment, and give a row for each lane"

NO_ENVIRONMENT = (
    "; it does not say which observations it needs, so an evaluation gives it images: a network says it by its "
    "attribute `environment`, a TorchScript file by environment.json"
)
"""The end of an error of a policy without `task` and `environment`, which may have got the wrong observations."""


class ScoresPolicy:
    """A policy from a function that returns a score for each action: action values, or logits.

    The methods `scores`, `values`, `probabilities` and `features` compute observations (n, ...) uint8, as the policy's
    task gives them, of any number of environments at once, and change no state. A policy without the functions that a
    method needs lacks the attribute, and `hasattr` is false.

    Args:
        scores: a function of observations (n, ...) uint8 that returns scores (n, actions), or actions (n,), integers.
        sample: whether actions are drawn with the probabilities softmax(scores), with a generator for each game;
            otherwise the action with the highest score is taken.
        accepted: the observations that the functions take; None leaves the check to the functions.
        logits: whether the scores are logits even if actions are not drawn, so that there are `probabilities`.
        values, features: functions of observations for the methods of these names.
        network: the network of all these functions.
        name, task, environment, training_frames, game, games, protocol: see `Policy`.

    Example:
        >>> import numpy as np
        >>> from atari.learning import ScoresPolicy, evaluate
        >>> policy = ScoresPolicy(lambda observations: np.eye(4)[[1] * len(observations)], name="fire")
        >>> evaluate(policy, "breakout", "dopamine", episodes=1, seed=0)["breakout"].scores
        (0.0,)
        >>> policy.scores(np.zeros((1, 4, 84, 84), np.uint8)), hasattr(policy, "values")
        (array([[0., 1., 0., 0.]], dtype=float32), False)
    """

    def __init__(
        self,
        scores: Callable[[Any], Array],
        *,
        sample: bool = False,
        accepted: Accepted | None = None,
        logits: bool = False,
        values: Callable[[Any], Array] | None = None,
        features: Callable[[Any], Array] | None = None,
        network: Any = None,
        name: str = "",
        task: Task | None = None,
        environment: Mapping[str, Any] | None = None,
        training_frames: int | None = None,
        game: str | None = None,
        games: Sequence[str] = (),
        protocol: Any = None,
    ) -> None:
        self._scores = scores
        self.sample = sample
        self._accepted = accepted
        self._values, self._features, self._network = values, features, network
        given = {"values": values, "probabilities": sample or logits or None, "features": features, "network": network}
        self._methods = {"scores", *(method for method, one in given.items() if one is not None)}
        self._generators: dict[int, np.random.Generator] = {}
        self._begun: tuple[str, tuple[str, ...]] | None = None
        self.name = name
        self.task = task
        self.environment = dict(environment or {})
        self.training_frames = training_frames
        self.game = game
        self.games = tuple(games)
        self.protocol = protocol

    def begin(self, game: str, actions: Sequence[str], lanes: npt.NDArray[np.int64], seeds: Array) -> None:
        """Set up the generators of some lanes."""
        self._begun = game, tuple(actions)
        for lane, seed in zip(lanes.tolist(), seeds.tolist(), strict=True):
            self._generators[lane] = np.random.default_rng(seed)

    def generator(self, lane: int) -> np.random.Generator:
        """The generator of a lane.

        Raises:
            ValueError: no game has begun in the lane.
        """
        if lane not in self._generators:
            raise ValueError(
                f"{self.name or 'the policy'} draws numbers, and no game has begun in lane {lane}; call "
                "begin(game, actions, lanes, seeds) before the first observations"
            )
        return self._generators[lane]

    def state(self) -> Any:
        """The generators."""
        return self._generators

    def restore(self, state: Any) -> None:
        """Continue with the generators of `state`."""
        self._generators = state

    @OptionalMethod
    def scores(self, observations: Any) -> Floats:
        """A score of each action, (n, actions) float32: action values, or logits.

        Raises:
            TypeError, ValueError: the observations are not as the task gives them; or the policy returns actions.
        """
        return self._computed(self._scores, observations, ("n", "actions"))

    @OptionalMethod
    def values(self, observations: Any) -> Floats:
        """The value of each state, (n,) float32: the critic's, or the highest action value.

        It is in the units of the training: of clipped rewards, discounted.

        Raises:
            AttributeError, TypeError, ValueError: the policy has no values; or see `scores`.
        """
        return self._computed(self._values, observations, ("n",))

    @OptionalMethod
    def probabilities(self, observations: Any) -> Floats:
        """The probability of each action, (n, actions) float32: softmax(scores), with which a policy draws.

        Action values are no logits, so a policy that takes the highest action value has no probabilities.

        Raises:
            AttributeError, TypeError, ValueError: the policy has no probabilities; or see `scores`.
        """
        scores = self.scores(observations)
        powers = np.exp(scores - scores.max(1, keepdims=True))
        return np.asarray(powers / powers.sum(1, keepdims=True))

    @OptionalMethod
    def features(self, observations: Any) -> Floats:
        """The last hidden layer, (n, width) float32: the input of the linear layer that gives the scores.

        Raises:
            AttributeError, TypeError, ValueError: the policy has no features; or see `scores`.
        """
        return self._computed(self._features, observations, ("n", "width"))

    @property
    def network(self) -> Any:
        """The `torch.nn.Module` itself, not a copy: new weights of it are the policy's.

        Raises:
            AttributeError: the policy has none.
        """
        if "network" not in self._methods:
            raise absent(self.name or type(self).__name__, "network")
        return self._network

    def _computed(self, function: Callable[[Any], Array] | None, observations: Any, axes: tuple[str, ...]) -> Floats:
        """The result of a function of the policy, checked to have a row for each observation."""
        assert function is not None  # an `OptionalMethod` calls this
        part = next(iter(observations.values())) if isinstance(observations, Mapping) else observations
        count = next(iter(np.shape(part)), 0)
        if self._accepted is not None:
            self._accepted.check(self.name, observations, count)
        result = np.asarray(function(observations))
        if result.dtype.kind != "f" or result.ndim != len(axes) or len(result) != count:
            raise ValueError(
                f"{self.name or 'the policy'} must return floats ({', '.join(axes)}) here, for {count} observations, "
                f"got {result.dtype} {result.shape}"
            )
        return result.astype(np.float32)

    def __call__(self, observations: Any, lanes: npt.NDArray[np.int64]) -> Array:
        """The actions (n,) for observations (n, ...) of some lanes.

        Raises:
            TypeError: the observations are no array, or have another dtype than the function takes.
            ValueError: the observations have another shape; or the function returns neither scores nor actions, or
                scores for another number of actions.
        """
        if self._accepted is not None:
            self._accepted.check(self.name, observations, len(lanes))
        scores = np.asarray(self._scores(observations))
        if scores.ndim == 1 and scores.dtype.kind in "iu":
            return scores
        if scores.ndim != 2 or scores.dtype.kind != "f":
            raise ValueError(
                f"{self.name or 'the policy'} must return scores (n, actions), floats, or actions (n,), integers; "
                f"got {scores.dtype} {scores.shape}{'' if self.task or self.environment else NO_ENVIRONMENT}"
            )
        if np.isnan(scores).any():
            raise ValueError(f"{self.name or 'the policy'} returned a score that is no number (NaN)")
        if self._begun is not None and scores.shape[1] != len(self._begun[1]):
            game, names = self._begun
            raise ValueError(
                f"{self.name or 'the policy'} gives scores of {scores.shape[1]} actions, and in {game} it has "
                f"{len(names)} ({', '.join(names)}); if it was trained with others, name them by index: "
                "environment={'actions': [...]}, or a task"
            )
        if self.sample:  # the highest of scores with Gumbel noise is a draw of softmax
            scores = scores + np.stack([self.generator(lane).gumbel(size=scores.shape[1]) for lane in lanes.tolist()])
        return scores.argmax(1)
