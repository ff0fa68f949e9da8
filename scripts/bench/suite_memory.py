"""The suite `memory` of `bench.py`: `ReplayMemory` beside the replay buffers of other packages, on the same stream.

Peers that are not installed are left out. All have 20,000 steps of 8 environments; the peers get whole stacks of four,
as their own examples give them, and `ReplayMemory` gets single frames.
"""

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from time import perf_counter, process_time
from typing import Any

import gymnasium
import numpy as np
from comparison import Comparison, Contestant, Run

import atari
from atari.learning import ReplayMemory

LANES, BATCH = 8, 32
STEPS = 20_000
ALPHA, BETA = 0.6, 0.4
MILLION, MANY = 1_000_000, 1000  # steps and environments of memories without frames


@dataclass
class Stream:
    """The results of environments with stacks of four, row by row: (rows, lanes, ...)."""

    stacks: np.ndarray
    actions: np.ndarray
    rewards: np.ndarray
    ended: np.ndarray

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """Observation, next observation, action, reward, end."""
        for row in range(len(self.actions)):
            yield self.stacks[row], self.stacks[row + 1], self.actions[row], self.rewards[row], self.ended[row]


@functools.lru_cache(maxsize=1)
def stream_of(game: str) -> Stream:
    """The stream of a random policy."""
    rows = STEPS // LANES
    envs = atari.AtariVectorEnv(game, LANES)
    random = np.random.default_rng(0)
    stacks = np.empty((rows + 1, LANES, 4, 84, 84), np.uint8)
    actions = random.integers(0, envs.single_action_space.n, (rows, LANES))
    rewards, ended = np.empty((rows, LANES), np.float32), np.empty((rows, LANES), bool)
    stacks[0], _ = envs.reset(seed=0)
    for row in range(rows):
        stacks[row + 1], rewards[row], terminated, truncated, _ = envs.step(actions[row])
        ended[row] = terminated | truncated
    return Stream(stacks, actions, rewards, ended)


def filled_memory(game: str, **options: Any) -> ReplayMemory:
    """A `ReplayMemory` with the stream."""
    stream = stream_of(game)
    memory = ReplayMemory(STEPS, LANES, (1, 84, 84), seed=0, **options)
    memory.reset(stream.stacks[0][:, 3:])
    for _, after, action, reward, ended in stream.rows():
        memory.add(action, reward, ended, np.zeros_like(ended), observations=after[:, 3:])
    return memory


def timed(sample: Callable[[], Any]) -> Run:
    """Seconds for a number of sampled transitions, in batches."""

    def run(count: int) -> float:
        start = perf_counter()
        for _ in range(-(-count // BATCH)):
            sample()
        return (perf_counter() - start) / (-(-count // BATCH) * BATCH) * count

    return run


def ours(game: str, share: bool = False, **options: Any) -> Run:
    """Uniform sampling from `ReplayMemory`."""
    memory = filled_memory(game, **options)
    batch = memory.make_batch(BATCH, share=share)
    return timed(lambda: memory.sample(BATCH, out=batch))


def ours_new(game: str) -> Run:
    """Uniform sampling from `ReplayMemory` without `out`."""
    memory = filled_memory(game)
    return timed(lambda: memory.sample(BATCH))


def drawn_by_priority(memory: ReplayMemory, share: bool = False) -> Run:
    """Sampling by priority from a `ReplayMemory`, with an update."""
    batch, errors = memory.make_batch(BATCH, share=share), np.random.default_rng(0).random(BATCH)

    def sample() -> None:
        memory.sample(BATCH, beta=BETA, out=batch)
        memory.update_priorities(batch.indices, errors)

    return timed(sample)


def ours_by_priority(game: str, share: bool = False, **options: Any) -> Run:
    """Sampling by priority from `ReplayMemory`, with an update."""
    return drawn_by_priority(filled_memory(game, priority_exponent=ALPHA, **options), share)


def ours_without_frames(game: str) -> Run:
    """A draw by priority with an update, of a million steps with frames of one byte."""
    del game
    memory = ReplayMemory(MILLION, MANY, (1,), stack_num=1, priority_exponent=ALPHA, seed=0)
    memory.reset(np.zeros((MANY, 1), np.uint8))
    zeros, no = np.zeros(MANY, np.int64), np.zeros(MANY, bool)
    for _ in range(MILLION // MANY):
        memory.add(zeros, zeros, no, no, observations=np.zeros((MANY, 1), np.uint8))
    memory.update_priorities(np.arange(MILLION), np.random.default_rng(0).random(MILLION))
    return drawn_by_priority(memory)


def cpprb_without_frames(game: str) -> Run:
    """`ours_without_frames` with cpprb."""
    del game
    import cpprb

    frame = {"shape": (1,), "dtype": np.uint8}
    fields = {"obs": frame, "next_obs": frame, "act": {"dtype": np.int64}, "rew": {}, "done": {}}
    buffer = cpprb.PrioritizedReplayBuffer(MILLION, fields, alpha=ALPHA)
    zeros, frames = np.zeros(MANY, np.int64), np.zeros((MANY, 1), np.uint8)
    for _ in range(MILLION // MANY):
        buffer.add(obs=frames, next_obs=frames, act=zeros, rew=zeros, done=zeros)
    buffer.update_priorities(np.arange(MILLION), np.random.default_rng(0).random(MILLION))
    return cpprb_drawn_by_priority(buffer)


def cpprb_drawn_by_priority(buffer: Any) -> Run:
    """Sampling by priority from a buffer of cpprb, with an update."""
    errors = np.random.default_rng(0).random(BATCH)

    def sample() -> None:
        batch = buffer.sample(BATCH, beta=BETA)
        buffer.update_priorities(batch["indexes"], errors)

    return timed(sample)


def sb3(game: str, optimize: bool) -> Run:
    """Stable-Baselines3's buffer; CleanRL has a copy of it, which it uses with one stack for both observations."""
    import torch
    from stable_baselines3.common.buffers import ReplayBuffer

    torch.set_num_threads(1)  # all have one core
    stream = stream_of(game)
    space = gymnasium.spaces.Box(0, 255, (4, 84, 84), np.uint8)
    buffer = ReplayBuffer(
        STEPS,
        space,
        gymnasium.spaces.Discrete(18),
        "cpu",
        n_envs=LANES,
        optimize_memory_usage=optimize,
        handle_timeout_termination=not optimize,
    )
    infos: list[dict[str, Any]] = [{}] * LANES
    for before, after, action, reward, ended in stream.rows():
        buffer.add(before, after, action, reward, ended, infos)
    return timed(lambda: buffer.sample(BATCH))


def cpprb_buffer(game: str, by_priority: bool) -> Run:
    """The buffer of cpprb with whole stacks."""
    import cpprb

    names = {"shape": (4, 84, 84), "dtype": np.uint8}
    fields = {"obs": names, "next_obs": names, "act": {"dtype": np.int64}, "rew": {}, "done": {}}
    if by_priority:
        buffer = cpprb.PrioritizedReplayBuffer(STEPS, fields, alpha=ALPHA)
    else:
        buffer = cpprb.ReplayBuffer(STEPS, fields)
    for before, after, action, reward, ended in stream_of(game).rows():
        buffer.add(obs=before, next_obs=after, act=action, rew=reward, done=ended)
    return cpprb_drawn_by_priority(buffer) if by_priority else timed(lambda: buffer.sample(BATCH))


def torchrl_buffer(game: str, by_priority: bool) -> Run:
    """The buffer of TorchRL with whole stacks in tensors."""
    import torch
    from tensordict import TensorDict
    from torchrl.data import LazyTensorStorage, TensorDictPrioritizedReplayBuffer, TensorDictReplayBuffer

    torch.set_num_threads(1)
    storage = LazyTensorStorage(STEPS)
    if by_priority:
        buffer = TensorDictPrioritizedReplayBuffer(alpha=ALPHA, beta=BETA, storage=storage, batch_size=BATCH)
    else:
        buffer = TensorDictReplayBuffer(storage=storage, batch_size=BATCH)
    for before, after, action, reward, ended in stream_of(game).rows():
        parts = {"pixels": before, "next_pixels": after, "action": action, "reward": reward, "done": ended}
        tensors = {name: torch.from_numpy(np.ascontiguousarray(part)) for name, part in parts.items()}
        buffer.extend(TensorDict(tensors, batch_size=[LANES]))
    if not by_priority:
        return timed(buffer.sample)
    errors = torch.rand(BATCH)

    def sample() -> None:
        batch = buffer.sample()
        batch.set("td_error", errors)
        buffer.update_tensordict_priority(batch)

    return timed(sample)


def torchrl_has_trees() -> bool:
    """Whether TorchRL's extension module, which has its sum tree, fits the PyTorch that is installed."""
    try:
        from torchrl._torchrl import SumSegmentTreeFp32
    except (ImportError, OSError, RuntimeError):
        return False
    return SumSegmentTreeFp32 is not None


def dopamine_buffer(game: str, by_priority: bool) -> Run:
    """Dopamine's buffer, with its compressed stacks."""
    from dopamine.jax.replay_memory import accumulator, elements, replay_buffer, samplers

    if by_priority:
        sampler: Any = samplers.PrioritizedSamplingDistribution(0, priority_exponent=ALPHA, max_capacity=STEPS)
    else:
        sampler = samplers.UniformSamplingDistribution(seed=0)
    collect = accumulator.TransitionAccumulator(stack_size=4, update_horizon=1, gamma=0.99)
    buffer = replay_buffer.ReplayBuffer(collect, sampler, batch_size=BATCH, max_capacity=STEPS)
    keywords = {"priority": 1.0} if by_priority else {}
    stream = stream_of(game)
    for lane in range(LANES):  # one environment after the other, because the buffer serves one
        for row in range(len(stream.actions)):
            frame, ended = stream.stacks[row, lane, 3], bool(stream.ended[row, lane])
            reward = float(stream.rewards[row, lane])
            element = elements.TransitionElement(frame, int(stream.actions[row, lane]), reward, ended, ended)
            buffer.add(element, **keywords)
    if not by_priority:
        return timed(buffer.sample)
    errors = np.random.default_rng(0).random(BATCH)

    def sample() -> None:
        _, found = buffer.sample(BATCH, with_sample_metadata=True)
        buffer.update(found.keys, priorities=errors)

    return timed(sample)


def environment_steps(game: str, options: dict[str, Any] | None) -> Run:
    """Processor time of steps of the environments, with `add` to a full memory of these options, or without one."""
    envs = atari.AtariVectorEnv(game, LANES, stack_num=1, num_threads=1)
    actions = np.random.default_rng(0).integers(0, envs.single_action_space.n, (997, LANES))
    observations, _ = envs.reset(seed=0)
    memory = None if options is None else ReplayMemory.for_env(envs, STEPS, seed=0, **options)
    if memory is not None:
        memory.reset(observations)
        no = np.zeros(LANES, bool)
        for _ in range(STEPS // LANES + 100):
            memory.add(actions[0], np.zeros(LANES), no, no, observations=observations)
        memory.reset(observations)

    def run(count: int) -> float:
        envs.reset(seed=1)
        rows = -(-count // LANES)
        start = process_time()
        for row in range(rows):
            chosen = actions[row % len(actions)]
            if memory is None:
                envs.step(chosen)
            else:
                _, *results = envs.step(chosen, out=memory.frames())
                memory.add(chosen, *results)
        return (process_time() - start) / rows / LANES * count

    return run


def comparisons() -> Iterator[Comparison]:
    """Sampling from a replay memory, and adding to it; the fastest peer is the last where it is known."""

    def present(*peers: tuple[str, str, Callable[[str], Run]]) -> list[Contestant]:
        return [(name, prepare) for name, package, prepare in peers if find_spec(package)]

    yield Comparison(
        "a transition, drawn uniformly",
        [
            ("ReplayMemory", ours),
            ("shared frames", partial(ours, share=True)),
            ("without out", ours_new),
            ("compressed", partial(ours, compress=True)),
            ("compressed, shared", partial(ours, share=True, compress=True)),
            *present(
                ("Dopamine", "etils", partial(dopamine_buffer, by_priority=False)),
                ("TorchRL", "torchrl", partial(torchrl_buffer, by_priority=False)),
                ("CleanRL (SB3 copy)", "stable_baselines3", partial(sb3, optimize=True)),
                ("cpprb", "cpprb", partial(cpprb_buffer, by_priority=False)),
                ("SB3", "stable_baselines3", partial(sb3, optimize=False)),
            ),
        ],
    )
    yield Comparison(
        "a transition, drawn by priority, with an update",
        [
            ("ReplayMemory", ours_by_priority),
            ("shared frames", partial(ours_by_priority, share=True)),
            ("compressed", partial(ours_by_priority, compress=True)),
            ("compressed, shared", partial(ours_by_priority, share=True, compress=True)),
            *present(
                ("Dopamine", "etils", partial(dopamine_buffer, by_priority=True)),
                *([("TorchRL", "torchrl", partial(torchrl_buffer, by_priority=True))] if torchrl_has_trees() else []),
                ("cpprb", "cpprb", partial(cpprb_buffer, by_priority=True)),
            ),
        ],
    )
    yield Comparison(
        "a draw by priority of a million steps, with an update, without frames",
        [("ReplayMemory", ours_without_frames), *present(("cpprb", "cpprb", cpprb_without_frames))],
        10.0,
    )
    yield Comparison(
        "processor time of a step of 8 environments",
        [
            ("and add", partial(environment_steps, options={})),
            ("and add compressed", partial(environment_steps, options={"compress": True})),
            ("without", partial(environment_steps, options=None)),
        ],
        0.5,
    )


def bytes_table(games: list[str]) -> str:
    """Gigabytes for a million steps by game, plain and compressed, with all tables."""
    lines = ["GB for a million steps of 84x84: ReplayMemory, compressed"]
    compressed = []
    for game in games:
        memory = filled_memory(game, compress=True)
        compressed.append(memory.nbytes / STEPS / 1e3)
        plain = ReplayMemory(10**6, LANES, (1, 84, 84)).nbytes / 1e9
        lines.append(f"{game:20} {plain:6.2f} {compressed[-1]:6.2f}")
        stream_of.cache_clear()
    lines.append(f"{'mean':20} {plain:6.2f} {float(np.mean(compressed)):6.2f}")
    return "\n".join(lines)
