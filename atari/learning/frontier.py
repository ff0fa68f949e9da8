"""The file of a frontier: states before the places where games are lost, from which a training restarts.

The file is a snapshot of `atari.cores.snapshot`: facts as JSON, and a compressed state of a lane for each blob. It has
a checksum, and reading it executes nothing. A state is the same for all tasks that differ only in how games begin, in
the effect of a lost life, in limits, clipping and sticky actions. So the states of an evaluation fit into a training.
"""

import math
import zlib
from collections.abc import Mapping, Sequence
from contextlib import closing
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import atari._emulator as _emulator
from atari.base import durable
from atari.base.validation import check_file
from atari.base.version import VERSION
from atari.cores.native import STATE_VERSION
from atari.cores.snapshot import pack, unpack
from atari.env.lane_snapshot import LaneSnapshot
from atari.task import Task
from atari.task.fields import GROUPS
from atari.task.json_form import identity, require_same
from atari.vector import AtariVectorEnv

MOST = 4096
"""The most states of a file."""

_MOST_BYTES = 256 << 20
_STATELESS = {
    *("repeat_action_probability", "reward_clipping", "actions"),
    *(set(GROUPS["begin"]) - {"seeding"}),
    *GROUPS["lives"],
    *GROUPS["limits"],
}
"""Fields that may differ between the task of the states and the task that goes on from them."""


class Frontier(NamedTuple):
    """States of one game.

    Attributes:
        snapshots: the states, for `AtariVectorEnv.restore`.
        scores: the score of the game in each of them, not clipped.
    """

    snapshots: tuple[LaneSnapshot, ...]
    scores: tuple[float, ...]


def write_frontier(
    path: str | PathLike[str], task: Task, snapshots: Sequence[LaneSnapshot], scores: Sequence[float]
) -> None:
    """Write states into a file, from which `atari train --restart-from` restarts.

    Args:
        path: the file; one of this name is replaced.
        task: the task of the environments that the states were taken from.
        snapshots: 1 to 4096 states, from `AtariVectorEnv.snapshot`.
        scores: the score of the game in each of them, not clipped.

    Raises:
        TypeError: `snapshots` are no snapshots of lanes.
        ValueError: there are no snapshots, too many, or not one score for each; a score is not finite; or a snapshot is
            of another task.
        OSError: the file cannot be written; one of this name is as it was.

    Example:
        >>> import atari
        >>> from atari.learning.frontier import read_frontier, write_frontier
        >>> envs = atari.AtariVectorEnv("pong", 2)
        >>> observations, info = envs.reset(seed=0)
        >>> write_frontier("pong.frontier", envs.task, envs.snapshot(), [0, 0])
        >>> read_frontier("pong.frontier", envs.task).scores
        (0.0, 0.0)
        >>> envs.close()
    """
    if not 1 <= len(snapshots) <= MOST:
        raise ValueError(f"a frontier has 1 to {MOST} snapshots, got {len(snapshots)}")
    values = [float(score) for score in scores]
    if len(values) != len(snapshots) or not all(map(math.isfinite, values)):
        raise ValueError(f"scores must be a finite number for each of {len(snapshots)} snapshots, got {scores!r:.80}")
    states: dict[str, bytes] = {}
    images = set[int]()
    for number, snapshot in enumerate(snapshots):
        if not isinstance(snapshot, LaneSnapshot):
            raise TypeError(f"snapshots must be those of AtariVectorEnv.snapshot, got {snapshot!r:.80}")
        require_same(snapshot.task, task)
        state, image = snapshot.state.__getstate__()
        states[str(number)] = zlib.compress(state, 6)
        images.add(image)
    if len(images) > 1:
        raise ValueError("the snapshots are of several ROM images; write a file for each of them")
    of = {"of": "frontier", "state version": STATE_VERSION, "package": VERSION}
    facts = {**of, "task": identity(task), "image": images.pop(), "scores": values}
    durable.write_file(Path(path), pack(facts, states))


def read_frontier(path: str | PathLike[str], task: Task) -> Frontier:
    """The states in a file, as states of environments of `task`.

    Args:
        path: a file of `write_frontier`. It may come from a stranger: nothing in it is executed.
        task: the task of the environments that go on from the states. It may differ from the task of the states in
            sticky actions, the actions, clipping, limits, lives, and how games begin.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is no file of a frontier, is damaged, or is of another game, observation or release.
    """
    facts, blobs = _read(Path(path))
    try:
        require_same(facts.get("task"), task, ignored=_STATELESS)
        scores = _checked_scores(facts.get("scores"), len(blobs))
        with closing(AtariVectorEnv(task, 1, autoreset_mode="Disabled")) as envs:
            envs.reset(seed=0)
            (own,) = envs.snapshot()
            size, image = len(own.state.__getstate__()[0]), own.state.__getstate__()[1]
            if facts.get("image") != image:
                raise ValueError("its states were taken with another ROM image of the game")
            snapshots = [_state(envs, blobs.get(str(number)), size, image) for number in range(len(blobs))]
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path} cannot be used by this task: {error}") from None
    return Frontier(tuple(snapshots), scores)


def _read(path: Path) -> tuple[dict[str, Any], Mapping[str, bytes]]:
    """The facts of a file and its compressed states."""
    check_file(path)
    if path.stat().st_size > _MOST_BYTES:
        raise ValueError(f"{path} is no frontier: it has more than {_MOST_BYTES >> 20} MiB")
    try:
        facts, blobs = unpack(path.read_bytes())
    except ValueError as error:
        raise ValueError(f"{path} is no frontier, or damaged: {error}") from None
    if facts.get("of") != "frontier" or not 1 <= len(blobs) <= MOST:
        raise ValueError(f"{path} is no frontier; `atari diagnose` and write_frontier write one")
    if facts.get("state version") != STATE_VERSION:
        raise ValueError(
            f"{path} has states of version {facts.get('state version')!r:.20}, and this release of atari-envs reads "
            f"version {STATE_VERSION}; write it again with `atari diagnose`"
        )
    return facts, blobs


def _checked_scores(scores: Any, count: int) -> tuple[float, ...]:
    sound = isinstance(scores, list) and len(scores) == count
    if not sound or not all(type(score) in (int, float) and math.isfinite(score) for score in scores):
        raise ValueError("it is damaged: it has not one score for each state")
    return tuple(map(float, scores))


def _state(envs: AtariVectorEnv, packed: bytes | None, size: int, image: int) -> LaneSnapshot:
    """The snapshot of a compressed state, after one environment has gone on from it."""
    unpacker = zlib.decompressobj()
    try:
        data = unpacker.decompress(packed or b"", size + 1)  # a byte more, so that the end of the stream is read
    except zlib.error:
        data = b""
    if len(data) != size or not unpacker.eof:
        raise ValueError("a state in it is damaged, or of another release of atari-envs")
    state = _emulator.MemberSnapshot.__new__(_emulator.MemberSnapshot)
    state.__setstate__((data, image))
    try:
        envs.restore([0], [LaneSnapshot(state, identity(envs.task))])
    except ValueError:
        raise ValueError("a state in it is damaged, or of another release of atari-envs") from None
    (snapshot,) = envs.snapshot()
    return snapshot
