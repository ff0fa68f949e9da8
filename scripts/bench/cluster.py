"""The constants of docs/scale.md, measured on this machine, and a simulation of larger clusters from them.

usage: python scripts/bench/cluster.py [--game GAME] [--seconds S] [--only-simulate]

Needs Ray (pip install '.[ray]'). Starts a cluster of this machine with an object store of 200 MB.
"""

import argparse
import heapq
import os
import pickle
import statistics
import zlib
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter, process_time
from typing import Any

import numpy as np

import atari
from atari.learning import ReplayMemory

WEIGHTS = 1_687_206  # float32 parameters of the network of Mnih et al. 2015 with 18 actions


class Random:
    """A policy that costs nearly nothing."""

    def __call__(self, observations: Any, random: np.random.Generator) -> Any:
        """Actions (n,)."""
        return random.integers(3, size=len(observations))


def per_call(call: Callable[[], Any], seconds: float, clock: Callable[[], float] = perf_counter) -> float:
    """The median of the seconds that a call takes. With `process_time`, other programs hardly matter."""
    times = []
    end = perf_counter() + seconds
    while perf_counter() < end or len(times) < 5:
        start = clock()
        call()
        times.append(clock() - start)
    return statistics.median(times)


def show(name: str, value: float, unit: str) -> None:
    """Print a constant."""
    print(f"{name:58} {value:12,.1f} {unit}", flush=True)


def measure_environments(game: str, seconds: float) -> None:
    """Steps, snapshots and compressed frames in one thread of this process."""
    envs = atari.AtariVectorEnv(game, 64, preset="dqn2015", num_threads=1)
    envs.reset(seed=0)
    random = np.random.default_rng(0)
    show(
        "environment steps, one core",
        64 / per_call(lambda: envs.step(random.integers(3, size=64)), seconds, process_time),
        "/s",
    )
    packed = zlib.compress(pickle.dumps(envs.snapshot(), 5), 1)
    show("snapshot, packed", len(packed) / 64, "bytes an environment")
    pack = per_call(lambda: zlib.compress(pickle.dumps(envs.snapshot(), 5), 1), seconds, process_time)
    show("snapshot, time to pack", pack / 64 * 1e6, "us an environment")
    single = atari.AtariVectorEnv(game, 8, preset="dqn2015", stack_num=1, num_threads=1)
    steps = []
    observations, _ = single.reset(seed=0)
    for _ in range(1000):
        actions = random.integers(3, size=8)
        after, *results = single.step(actions)
        steps.append((actions, *results, after.copy()))
    times: dict[bool, list[float]] = {False: [], True: []}
    for compress in [False, True] * 5:
        memory = ReplayMemory.for_env(single, 8000, compress=compress, seed=0)
        memory.reset(observations)
        before, start = memory.nbytes, process_time()
        for actions, *results, after in steps:
            memory.frames()[:] = after
            memory.add(actions, *results)
        times[compress].append(process_time() - start)
    show("frame, compressed", (memory.nbytes - before) / 8000, "bytes of 7056")
    show("frame, stored", min(times[False]) / 8000 * 1e6, "us")
    show("frame, compressed and stored", min(times[True]) / 8000 * 1e6, "us")


def measure_ray(game: str, seconds: float) -> None:
    """The object store, tasks, weights, and rollouts on a cluster of this machine."""
    import ray

    from atari.integrations.ray import RolloutActors

    ray.init("local", num_cpus=2, object_store_memory=200_000_000, include_dashboard=False, log_to_driver=False)
    block = np.ones(20_000_000, np.uint8)
    show("object store, put", 20 / per_call(lambda: ray.put(block), seconds), "MB/s")
    reference = ray.put(block)
    show("object store, get without a copy", per_call(lambda: ray.get(reference), seconds) * 1e6, "us for 20 MB")

    @ray.remote
    class Other:
        def nothing(self) -> None:
            return None

        def load(self, weights: Any) -> float:
            return float(weights[0][0])

    @ray.remote
    def task() -> None:
        return None

    other = Other.remote()
    ray.get([other.nothing.remote() for _ in range(100)])
    show(
        "calls of an actor",
        500 / per_call(lambda: ray.get([other.nothing.remote() for _ in range(500)]), seconds),
        "/s",
    )
    show("tasks", 200 / per_call(lambda: ray.get([task.remote() for _ in range(200)]), seconds), "/s")
    weights = [np.ones(WEIGHTS, np.float32)]
    show(
        "weights, put and read by an actor",
        per_call(lambda: ray.get(other.load.remote(ray.put(weights))), seconds) * 1e3,
        "ms for 6.7 MB",
    )
    ray.kill(other)
    with RolloutActors(game, 2, 1, Random, steps=1, in_flight=16, obs_type="ram") as actors:
        show("batches through one process", 1 / per_call(lambda: next(actors), seconds), "/s")
    for unstacked in (False, True):
        with RolloutActors(game, 1, 32, Random, steps=64, preset="dqn2015", unstacked=unstacked) as actors:
            for _ in range(2):
                rollout = next(actors)
            size = rollout.nbytes / (64 * 32)
            del rollout
            rate = 64 * 32 / per_call(lambda actors=actors: next(actors), 2 * seconds)  # type: ignore[misc]
        name = "unstacked" if unstacked else "stacked"
        show(f"rollouts of one actor, {name}", rate, "steps/s")
        show(f"a step of a rollout, {name}", size, "bytes")
    ray.shutdown()


@dataclass(frozen=True)
class Cluster:
    """The assumptions of the simulation.

    Attributes:
        step_rate: environment steps a second of a core, as rollouts.
        cores: actors of a node.
        batch: steps of a batch.
        step_bytes: bytes of a step of a rollout, over the network.
        driver_seconds: seconds of the learner's process for a batch.
        network: bytes a second into the learner's node.
    """

    step_rate: float = 25_000
    cores: int = 16
    batch: int = 4096
    step_bytes: float = 8_100
    driver_seconds: float = 0.002
    network: float = 1.25e9


def simulate(nodes: int, cluster: Cluster, in_flight: int = 2, seconds: float = 4.0) -> tuple[float, str]:
    """Delivered steps a second, and the part of the cluster that was busy all the time.

    Actors play batches whose durations vary by a fifth. The network and the learner's process serve batches one by one,
    in the order in which they were played. Batch n + in_flight of an actor begins after batch n was delivered.
    """
    random = np.random.default_rng(0)
    actors = nodes * cluster.cores
    play, transfer = cluster.batch / cluster.step_rate, cluster.batch * cluster.step_bytes / cluster.network
    events = [(float(start) + play, actor) for actor, start in enumerate(random.uniform(0, play, actors))]
    heapq.heapify(events)
    delivered = [deque([0.0] * in_flight, in_flight) for _ in range(actors)]
    link = driver = 0.0
    count = 0
    while events[0][0] < seconds:
        played, actor = heapq.heappop(events)
        link = max(link, played) + transfer
        driver = max(driver, link) + cluster.driver_seconds
        count += seconds / 2 < driver <= seconds
        delivered[actor].append(driver)
        begin = max(played, delivered[actor][0])
        heapq.heappush(events, (begin + play * random.uniform(0.8, 1.2), actor))
    rate = count * cluster.batch / (seconds / 2)
    limits = {
        "actors": actors * cluster.step_rate,
        "network": cluster.network / cluster.step_bytes,
        "learner's process": cluster.batch / cluster.driver_seconds,
    }
    return rate, min(limits, key=lambda name: limits[name])


def show_simulation(cluster: Cluster) -> None:
    """Print delivered steps for 10, 100 and 1000 nodes, by the data that cross the network."""
    print(f"\nsimulated: {cluster}")
    print(f"{'':34}" + "".join(f"{nodes:>25} nodes" for nodes in (10, 100, 1000)))
    cases = {
        "stacked": replace(cluster, step_bytes=28_700),
        "unstacked": cluster,
        "unstacked, 100 Gbit/s": replace(cluster, network=12.5e9),
        "compressed": replace(cluster, step_bytes=320),
        "compressed, batches of 512": replace(cluster, step_bytes=320, batch=512),
        "compressed, 8 learners": replace(cluster, step_bytes=320 / 8, driver_seconds=cluster.driver_seconds / 8),
    }
    for name, case in cases.items():
        cells = (simulate(nodes, case) for nodes in (10, 100, 1000))
        print(f"{name:34}" + "".join(f"{rate / 1e6:9.2f} M/s {limit:>17}" for rate, limit in cells), flush=True)


def main() -> None:
    """Measure, then simulate."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--game", default="breakout")
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--only-simulate", action="store_true")
    args = parser.parse_args()
    print(f"load {os.getloadavg()[0]:.1f}, {os.cpu_count()} CPUs")
    if not args.only_simulate:
        measure_environments(args.game, args.seconds)
        measure_ray(args.game, args.seconds)
    show_simulation(Cluster())


if __name__ == "__main__":
    main()
