"""The exploration phase of Go-Explore (Ecoffet et al. 2021) on Montezuma's Revenge, over workers of Ray.

    python examples/go_explore_ray.py --minutes 20 --workers 2 -o best.a26r
    python examples/go_explore_ray.py --minutes 20 --workers 200 --address auto    # a cluster that runs already

The archive is an actor. For each cell, such as (level, room, items, x / 16, y / 16), it has the snapshot of the best
known way there: the highest score, then the fewest steps. A worker restores snapshots that any worker has taken, plays
random actions from there, and returns the cells that it has seen. Needs the extra `ray`, no GPU and no network.
"""

import argparse
import json
import random
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import ray

import atari
from atari.env import AtariEnv
from atari.recording import RecordReplay

CELL = "level,room,inventory_bits,inventory_count,player_x/16,player_y/16"
SKIP = 4  # frames of a step; a core plays one at a time
DOOMED = 15  # steps before the loss of a life that make no cells: there the fall or the touch has begun already

Cell = tuple[int, ...]


@dataclass
class Start:
    """Where a worker begins: a state, how it was reached, and what the game was then."""

    node: int
    snapshot: bytes
    score: int
    steps: int


@dataclass
class Found:
    """A cell that a worker has seen. `snapshot` is None if the worker knows a way there that is as good."""

    cell: Cell
    score: int
    steps: int
    actions: int
    snapshot: bytes | None


@dataclass
class Trip:
    """What a worker has played from a start, and the cells on the way."""

    start: int
    actions: bytes
    found: list[Found]


def make_env(game: str) -> AtariEnv:
    """The environment of workers and of the replay: no sticky actions, so that actions repeat a game."""
    return AtariEnv(game, obs_type="ram", frameskip=SKIP, repeat_action_probability=0.0, full_action_space=True)


class Archive:
    """The cells, and the tree of trips that led to them.

    `nodes` is append-only: (parent, actions) of each state that is or was the best of a cell. So the actions of a cell
    stay known when the cells on its way get better ones.
    """

    def __init__(self, start: bytes, cell: Cell, room: int, seed: int) -> None:
        self.nodes: list[tuple[int, bytes]] = [(-1, b"")]
        self.starts = [Start(0, start, 0, 0)]
        self.index = {cell: 0}
        self.visits = [1]
        self.room = room
        self.frames = self.trips = 0
        self.seconds: dict[int, float] = {}
        self.generator = np.random.default_rng(seed)

    def select(self, count: int) -> list[tuple[Cell, Start]]:
        """Cells to begin from; one that few trips have seen is more likely."""
        weights = 1 / np.sqrt(self.visits)
        chosen = self.generator.choice(len(weights), count, p=weights / weights.sum())
        cells = list(self.index)
        return [(cells[number], self.starts[number]) for number in chosen]

    def add(self, worker: int, trips: list[Trip], frames: int, seconds: float, count: int) -> list[tuple[Cell, Start]]:
        """Take in what a worker has played, and return its next starts."""
        for trip in trips:
            for found in trip.found:
                self._add(trip, found)
        self.trips += len(trips)
        self.frames += frames
        self.seconds[worker] = seconds
        return self.select(count)

    def _add(self, trip: Trip, found: Found) -> None:
        number = self.index.get(found.cell)
        known = None if number is None else self.starts[number]
        if found.snapshot is not None and (known is None or (found.score, -found.steps) > (known.score, -known.steps)):
            self.nodes.append((trip.start, trip.actions[: found.actions]))
            start = Start(len(self.nodes) - 1, found.snapshot, found.score, found.steps)
            if number is None:
                self.index[found.cell] = len(self.starts)
                self.starts.append(start)
                self.visits.append(1)
                return
            self.starts[number] = start
            self.visits[number] = 0  # a better way there is worth new trips
        if number is not None:
            self.visits[number] += 1

    def facts(self) -> dict[str, Any]:
        """How far the exploration is."""
        return {
            "frames": self.frames,
            "trips": self.trips,
            "cells": len(self.starts),
            "rooms": len({(cell[0], cell[self.room]) for cell in self.index}),
            "score": max(start.score for start in self.starts),
            "worker_cpu_seconds": round(sum(self.seconds.values()), 1),
        }

    def best(self) -> tuple[int, bytes]:
        """The highest score, and the actions that lead there from the reset."""
        start = max(self.starts, key=lambda start: (start.score, -start.steps))
        parts, node = [], start.node
        while node >= 0:
            node, actions = self.nodes[node]
            parts.append(actions)
        return start.score, b"".join(reversed(parts))


class Explorer:
    """A worker: plays random trips from the archive's states until its time is over."""

    def __init__(self, number: int, args: argparse.Namespace) -> None:
        self.number, self.args = number, args
        self.random = random.Random(f"{args.seed} {number}")
        self.core = make_env(args.game).core
        self.places = places(args.game, args.cell)
        self.best: dict[Cell, tuple[int, int]] = {}  # the best way to a cell that this worker has seen
        self.frames = 0

    def run(self, archive: Any) -> None:
        """Explore, with the archive's next starts under way while this worker plays."""
        end = time.monotonic() + 60 * self.args.minutes
        starts = ray.get(archive.select.remote(self.args.batch))
        pending = archive.select.remote(self.args.batch)
        while time.monotonic() < end:
            trips = [self.explore(cell, start) for cell, start in starts]
            starts = ray.get(pending)
            pending = archive.add.remote(self.number, trips, self.frames, time.process_time(), self.args.batch)
            self.frames = 0
        ray.get(pending)

    def explore(self, cell: Cell, start: Start) -> Trip:
        """Play random actions from a state; each goes on with a probability of 1 - 1 / repeat."""
        core, action = self.core, 0
        core.restore(start.snapshot)
        before, score, lives = core.episode_frame_number, start.score, core.lives
        actions = bytearray()
        seen: dict[Cell, Found] = {cell: Found(cell, start.score, start.steps, 0, None)}
        self.best[cell] = max(self.best.get(cell, (-1, 0)), (start.score, -start.steps))
        while len(actions) < self.args.steps:
            if not actions or self.random.random() * self.args.repeat < 1:
                action = self.random.randrange(18)
            score += sum(core.act(action) for _ in range(SKIP))
            actions.append(action)
            if core.lives < lives or core.game_over:
                break
            cell = cell_of(core.ram(), self.places)
            steps = start.steps + len(actions)
            if cell not in seen or score > seen[cell].score:
                new = (score, -steps) > self.best.get(cell, (-1, 0))
                seen[cell] = Found(cell, score, steps, len(actions), core.snapshot() if new else None)
        self.frames += core.episode_frame_number - before
        lost = core.lives < lives or core.game_over
        found = [one for one in seen.values() if not lost or one.actions < len(actions) - DOOMED]
        for one in found:
            self.best[one.cell] = max(self.best.get(one.cell, (-1, 0)), (one.score, -one.steps))
        return Trip(start.node, bytes(actions), found)


def places(game: str, cell: str) -> list[tuple[int, int]]:
    """The bytes of RAM that a cell is made of, and their divisors, of text such as "room,player_x/16"."""
    labels = atari.games[game].ram_labels
    parts = [part.partition("/") for part in cell.split(",")]
    return [(labels[name].index, int(divisor or 1)) for name, _, divisor in parts]


def cell_of(ram: Any, places: list[tuple[int, int]]) -> Cell:
    """The cell of a state."""
    return tuple(ram.item(index) // divisor for index, divisor in places)


def write_replay(path: str, game: str, seed: int, actions: bytes) -> int:
    """Play actions from the reset, record them in a replay, and return the score."""
    env = RecordReplay(make_env(game), path)
    env.reset(seed=seed)
    score = sum(int(env.step(action)[1]) for action in actions)
    env.close()
    return score


def main() -> None:
    """Explore for some minutes, and print how far it is every 30 seconds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--game", default="montezuma_revenge")
    parser.add_argument("--cell", default=CELL, help=f"labels of RAM with divisors (default: {CELL})")
    parser.add_argument("--room", default="room", help="the label of which different values are counted as rooms")
    parser.add_argument("--minutes", type=float, default=20)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--address", default="local", help="of a cluster, such as auto (default: starts one here)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=100, help="most steps of a trip")
    parser.add_argument("--repeat", type=float, default=20, help="mean number of steps of an action")
    parser.add_argument("--batch", type=int, default=32, help="trips between two calls of the archive")
    parser.add_argument("-o", "--output", help="write the best trajectory as a replay (.a26r)")
    args = parser.parse_args()

    local = {"num_cpus": args.workers, "object_store_memory": 200_000_000, "include_dashboard": False}
    ray.init(args.address, **(local if args.address == "local" else {}), log_to_driver=False)
    env, layout = make_env(args.game), places(args.game, args.cell)
    ram, _ = env.reset(seed=args.seed)
    room = [part.partition("/")[0] for part in args.cell.split(",")].index(args.room)
    archive = ray.remote(Archive).options(num_cpus=0).remote(env.core.snapshot(), cell_of(ram, layout), room, args.seed)
    workers = [ray.remote(Explorer).options(num_cpus=1).remote(number, args) for number in range(args.workers)]
    began, running = time.monotonic(), [worker.run.remote(archive) for worker in workers]
    while running:
        done, running = ray.wait(running, num_returns=len(running), timeout=30)
        ray.get(done)  # raises the error of a worker
        seconds = time.monotonic() - began
        facts = ray.get(archive.facts.remote())
        rate = round(facts["frames"] / seconds)
        print(json.dumps({"seconds": round(seconds), "frames_per_second": rate, **facts}), flush=True)
    score, actions = ray.get(archive.best.remote())
    if args.output:
        played = write_replay(args.output, args.game, args.seed, actions)
        print(f"{args.output}: {len(actions)} steps, score {played}; the archive has {score}")
    ray.shutdown()


if __name__ == "__main__":
    main()
