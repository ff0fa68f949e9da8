"""`RolloutActors`: actors of Ray that play environments and return batches of steps, for your own learners.

Every batch is delivered once, in order within its actor. When an actor is lost, another actor replaces it. The new
actor continues from the last snapshot of a delivered batch. It plays the actions of the later delivered batches
again, and then plays the batches that were in flight.
"""

import logging
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import ray
from ray.exceptions import ObjectLostError, OutOfMemoryError, RayActorError, RaySystemError

from atari.base.validation import check_integer
from atari.cores.options import SEED_LIMIT
from atari.integrations.ray.rollout import Rollout
from atari.integrations.ray.rollout_worker import Played, Position, RolloutWorker, WorkerSettings
from atari.learning.policies import load_policy
from atari.policy import makes_policy
from atari.task.task import GameLike
from atari.vector.options import OF_TASKS, resolve_lanes

_LOST = (RayActorError, ObjectLostError, OutOfMemoryError, RaySystemError)
_MOST_LOSSES = 5  # an actor is not replaced after more losses without a batch between them

_log = logging.getLogger(__name__)


@dataclass
class _Order:
    """A rollout that an actor has been ordered to play."""

    number: int
    version: int
    weights: Any
    result: Any = None


@dataclass
class _Seat:
    """The place of an actor: the present actor, its position after the last delivered batch, and its orders."""

    actor: Any
    position: Position
    orders: deque[_Order] = field(default_factory=deque)
    sent_version: int = -1
    ordered: int = 0
    losses: int = 0


class RolloutActors:
    """Plays `num_actors` x `num_envs` environments in actors of Ray; iterating returns their batches without end.

    A batch is a `Rollout`, in `atari.integrations.ray.rollout`: `actions`, `rewards`, `terminations`, `truncations` and
    `valid` (steps, num_envs), where `valid` is false for steps that only began an episode; `observations` (steps + 1,
    num_envs, ...) and `observations_at(steps, environments)`; `extras` by name; `scores` and `lengths` of the games
    that ended; `actor`, `number`, and the `version` of the weights. Arrays are read-only views of Ray's object store.
    Batches of one actor come in order and each once, also when actors are lost. With `in_order`, each run gives the
    same batches, with any number of nodes and lost actors. This needs a policy whose actions depend only on its
    arguments, its weights and `state`, and `set_weights` after the same batches.

    Args:
        game: the game of the environments, see `AtariVectorEnv`, or a sequence of `num_envs` games.
        num_actors: the number of actors.
        num_envs: the number of environments of each actor.
        policy: a policy, see `atari.learning.load_policy`, such as a class or a function without parameters, which
            each actor calls. `policy(observations, lanes)` returns actions (num_envs,), or (actions, extras) with a
            mapping of arrays (num_envs, ...) that come with the batch, such as logits. `observations` are those of
            `AtariVectorEnv`, (num_envs, ...) uint8, valid until the next call. A policy with weights has
            `load(weights)`; a policy that draws numbers, or has a memory, has `begin`, `state()`, which returns a
            picklable object, and `restore(state)`. In the successor of a lost actor the order is: a new policy is made;
            `begin`; `restore(state)`; `load(weights)` with the weights of the next batch; that batch. So `restore` must
            not need weights, and `load` must not change what `state` saves: it may be called again with weights that
            the lost actor had.
        steps: the steps of each environment in a batch.
        seed: environment j of actor i has seed + i * num_envs + j.
        in_flight: batches of each actor in progress or waiting for delivery: no more are played until the
            learner takes one. With 2, an actor plays while the learner learns.
        snapshot_every: batches between two snapshots of an actor's environments. A lost actor's successor plays the
            batches since the last snapshot again.
        in_order: deliver batches of actors 0, 1, ... in turn; otherwise in the order in which they are ready.
        unstacked: store each frame of stacked images once, in a quarter of the bytes.
        actor_options: options of Ray's actors, such as {"num_cpus": 2, "scheduling_strategy": "SPREAD"}; the default
            is one CPU each.
        **options: options of `AtariVectorEnv`; `num_threads` is 1 by default. The autoreset mode is NEXT_STEP.

    Raises:
        TypeError, ValueError, FileNotFoundError: an argument is of the wrong kind or out of range, or there is no ROM
            file; nothing has started.

    Example:
        >>> with RolloutActors("breakout", 2, 8, "random", steps=32) as actors:  # doctest: +SKIP
        ...     rollout = next(actors)
        ...     rollout.observations.shape
        (33, 8, 4, 84, 84)
    """

    def __init__(
        self,
        game: GameLike | Sequence[GameLike],
        num_actors: int,
        num_envs: int,
        policy: Any,
        *,
        steps: int = 64,
        seed: int = 0,
        in_flight: int = 2,
        snapshot_every: int = 8,
        in_order: bool = False,
        unstacked: bool = True,
        actor_options: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> None:
        num_actors = check_integer("num_actors", num_actors, 1, 100_000)
        num_envs = check_integer("num_envs", num_envs, 1, 100_000)
        self._in_flight = check_integer("in_flight", in_flight, 1, 1000)
        self._snapshot_every = check_integer("snapshot_every", snapshot_every, 1, 100_000)
        self._in_order = in_order
        seed = check_integer("seed", seed, 0, SEED_LIMIT - 1)
        steps = check_integer("steps", steps, 1, 1_000_000)
        if not makes_policy(policy):
            load_policy(policy)  # raises its errors here
        fields = {name: options.pop(name) for name in OF_TASKS if name in options}
        tasks, _ = resolve_lanes(game, num_envs, options.pop("preset", None), fields)
        self._settings = WorkerSettings(tasks, steps, seed, unstacked, options)
        self._settings.make().close()  # raises its errors here
        self._policy = policy
        self._worker = ray.remote(RolloutWorker).options(
            **{"num_cpus": 1, **(actor_options or {}), "max_restarts": 0, "max_task_retries": 0}
        )
        self._version = 0
        self._weights: Any = None  # a reference in the object store
        self._turn = 0
        self.lost = 0
        """Actors that were lost and replaced so far."""
        self._seats = [_Seat(self._hire(index, Position()), Position()) for index in range(num_actors)]
        for index in range(num_actors):
            self._order(index)

    def set_weights(self, weights: Any) -> int:
        """Set the policies' weights for the batches ordered from now on; returns their version.

        They are put into the object store once, and each node fetches them once. Batches in flight keep the weights
        with which they were ordered: `Rollout.version` has their version.

        Args:
            weights: the argument of the policy's `load`: NumPy arrays in any structure; `load` gets read-only views.
        """
        self._version += 1
        self._weights = ray.put(weights)
        return self._version

    def __iter__(self) -> Iterator[Rollout]:
        return self

    def __next__(self) -> Rollout:
        """Wait for a batch, and order the next one of its actor.

        Raises:
            RuntimeError: an actor was lost again and again without playing a batch; or these actors are closed.
            ray.exceptions.RayTaskError: the policy has raised an error; the text has its traceback.
        """
        if not self._seats:
            raise RuntimeError("these actors are closed")
        while True:
            index = self._next_ready()
            try:
                played: Played = ray.get(self._seats[index].orders[0].result)
            except _LOST as error:
                self._replace(index, error)
                continue
            self._deliver(index, played)
            self._order(index)
            return played.rollout

    def close(self) -> None:
        """Stop the actors; existing batches stay readable."""
        for seat in self._seats:
            ray.kill(seat.actor)
        self._seats = []

    def __getstate__(self) -> dict[str, Any]:
        raise TypeError(
            "RolloutActors own processes on a cluster and cannot be copied or pickled; make new ones with the same "
            "arguments"
        )

    def __enter__(self) -> "RolloutActors":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _next_ready(self) -> int:
        count = len(self._seats)
        turns = [(self._turn + step) % count for step in range(count)]
        if self._in_order:
            return turns[0]
        heads = {self._seats[index].orders[0].result: index for index in turns}
        (ready,), _ = ray.wait(list(heads), num_returns=1)
        return heads[ready]

    def _deliver(self, index: int, played: Played) -> None:
        seat = self._seats[index]
        number = seat.orders.popleft().number
        if played.rollout.number != number:
            raise RuntimeError(f"actor {index} played batch {played.rollout.number} instead of {number}")
        kept = (*seat.position.actions, played.rollout.actions.copy())  # a view would hold the batch in the store
        if played.environments is None:
            seat.position = replace(seat.position, number=number + 1, actions=kept, policy=played.policy)
        else:
            seat.position = Position(number + 1, played.environments, (), played.policy)
        seat.losses = 0
        self._turn = (index + 1) % len(self._seats)

    def _order(self, index: int) -> None:
        seat = self._seats[index]
        while len(seat.orders) < self._in_flight:
            order = _Order(seat.ordered, self._version, self._weights)
            seat.ordered += 1
            seat.orders.append(order)
            self._send(seat, order)

    def _send(self, seat: _Seat, order: _Order) -> None:
        weights = order.weights if order.version != seat.sent_version else None
        take_snapshot = order.number % self._snapshot_every == self._snapshot_every - 1
        order.result = seat.actor.play.remote(weights, order.version, take_snapshot)
        seat.sent_version = order.version

    def _hire(self, index: int, position: Position) -> Any:
        return self._worker.remote(self._settings, index, self._policy, position)

    def _replace(self, index: int, error: Exception) -> None:
        """Replace a lost actor by a new one, and order the batches that were in flight again."""
        seat = self._seats[index]
        seat.losses += 1
        self.lost += 1
        if seat.losses > _MOST_LOSSES:
            raise RuntimeError(f"actor {index} was lost {seat.losses} times without playing a batch") from error
        replayed = len(seat.position.actions)
        _log.warning(
            "actor %d was lost (%s); batches %d to %d (%d steps each) had not been delivered and are played again; its "
            "environments continue from %s, with the actions of %d delivered batches after it",
            index,
            str(error).splitlines()[0] if str(error) else type(error).__name__,
            seat.orders[0].number,
            seat.orders[-1].number,
            self._settings.steps * self._settings.num_envs,
            "their reset"
            if seat.position.environments is None
            else f"the snapshot after batch {seat.position.number - replayed - 1}",
            replayed,
        )
        ray.kill(seat.actor)  # the actor may be alive although its batch was lost
        seat.actor = self._hire(index, seat.position)
        seat.sent_version = -1
        for order in seat.orders:
            self._send(seat, order)
