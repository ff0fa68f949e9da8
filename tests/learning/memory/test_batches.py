"""The arrays of batches of `ReplayMemory`: reused memory, and shared frames."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

from atari.learning import ReplayMemory

SHAPE = {"image": (1, 8, 9), "ram": (128,)}
STACKS = {"image": 4, "ram": 1}


def filled(shape: Any = (1, 8, 9), **options: Any) -> ReplayMemory:
    memory = ReplayMemory(100, 2, shape, seed=0, **options)
    random, no = np.random.default_rng(0), np.zeros(2, bool)

    def frames() -> Any:
        if isinstance(shape, dict):
            return {name: random.integers(0, 256, (2, *part)).astype(np.uint8) for name, part in shape.items()}
        return random.integers(0, 256, (2, *shape)).astype(np.uint8)

    memory.reset(frames())
    for _ in range(40):
        memory.add(np.zeros(2, np.int64), np.ones(2), random.random(2) < 0.1, no, observations=frames())
    return memory


def copied(batch: Any) -> dict[str, Any]:
    return {name: np.copy(value) for name, value in vars(batch).items() if isinstance(value, np.ndarray)}


@pytest.mark.parametrize("length", [0, 5])
def test_a_batch_stays_as_it_is_while_any_array_of_it_is_held(length: int) -> None:
    memory = filled()

    def sample() -> Any:
        return memory.sample_sequences(8, length) if length else memory.sample(8)

    held = [sample() for _ in range(5)]
    expected = [copied(batch) for batch in held]
    views = [(batch.observations[1:3, ..., ::2], np.copy(batch.observations[1:3, ..., ::2])) for batch in held]
    for _ in range(5):
        sample()
    for batch, values in zip(held, expected, strict=True):
        for name, value in values.items():
            assert np.array_equal(getattr(batch, name), value), name
    del held, batch
    for _ in range(5):
        sample()
    for view, value in views:
        assert np.array_equal(view, value)


def test_memory_of_batches_is_used_again() -> None:
    memory = filled()
    places = set()
    for _ in range(20):
        batch = memory.sample(8)
        places.add(batch.observations.ctypes.data)
    assert len(places) <= 2


def test_threads_get_batches_of_their_own() -> None:
    memory = filled()

    def sample(_: int) -> bool:
        batch = memory.sample(64)
        before = copied(batch)
        memory.sample(64)
        return all(np.array_equal(getattr(batch, name), value) for name, value in before.items())

    with ThreadPoolExecutor(4) as threads:
        assert all(threads.map(sample, range(200)))


def test_a_batch_outlives_its_memory() -> None:
    memory = filled()
    batch = memory.sample(8)
    before = copied(batch)
    memory.close()
    del memory
    for name, value in before.items():
        assert np.array_equal(getattr(batch, name), value)


@pytest.mark.parametrize("compress", [False, True])
def test_shared_frames_of_dicts(compress: bool) -> None:
    memory = filled(SHAPE, stack_num=STACKS, compress=compress)
    shared, state = memory.make_batch(50, share=True), memory.state()
    memory.sample(50, out=shared)
    memory.restore(state)
    plain = memory.sample(50)
    assert np.array_equal(shared.indices, plain.indices)
    assert shared.frames["image"].shape == (50, 5, 8, 9)
    assert shared.frames["ram"].shape == (50, 2, 128)
    for name in SHAPE:
        assert shared.observations[name].shape == plain.observations[name].shape
        assert np.array_equal(shared.observations[name], plain.observations[name])
        assert np.array_equal(shared.next_observations[name], plain.next_observations[name])
        assert np.shares_memory(shared.frames[name], shared.next_observations[name])


def test_shared_frames_are_for_one_step() -> None:
    memory = filled()
    with pytest.raises(ValueError, match="n=1, not 3"):
        memory.sample(8, n=3, out=memory.make_batch(8, share=True))


def test_shared_tensors() -> None:
    torch = pytest.importorskip("torch")
    memory = filled()
    batch = memory.make_batch(8, torch=True, share=True)
    memory.sample(8, out=batch)
    assert isinstance(batch.observations, torch.Tensor)
    assert torch.equal(batch.frames[:, :4], batch.observations)
    assert torch.equal(batch.frames[:, 1:], batch.next_observations)
    flat = batch.observations.view(8, -1)
    assert flat.shape == (8, 4 * 72)


@pytest.mark.parametrize("torch", [False, True])
@pytest.mark.parametrize(("shape", "stack"), [((1, 8, 9), 4), (SHAPE, STACKS)])
@pytest.mark.parametrize("length", [0, 5])
def test_arrays_that_are_given_get_what_new_ones_have(length: int, shape: Any, stack: Any, torch: bool) -> None:
    if torch:
        pytest.importorskip("torch")
    memory, other = (filled(shape, stack_num=stack) for _ in range(2))
    if length:
        out: Any = memory.make_sequences(8, length, torch=torch)
        batch, expected = memory.sample_sequences(8, length, out=out), other.sample_sequences(8, length)
    else:
        out = memory.make_batch(8, torch=torch)
        batch, expected = memory.sample(8, out=out), other.sample(8)
    assert batch is out
    names = "observations actions rewards terminations truncations indices env_id".split()
    for name in (*names, *(["mask"] if length else ["next_observations", "discounts", "weights"])):
        given, wanted = getattr(batch, name), getattr(expected, name)
        for key in wanted if isinstance(wanted, dict) else ("",):
            one, other_one = (given[key], wanted[key]) if key else (given, wanted)
            assert np.array_equal(np.asarray(one), other_one), (name, key)


def test_sequences_of_another_length_are_refused() -> None:
    memory = filled(stack_num=4)
    with pytest.raises(ValueError, match="observations of out must be uint8"):
        memory.sample_sequences(8, 4, out=memory.make_sequences(8, 5))
    with pytest.raises(ValueError, match="observations of out must be uint8"):
        memory.sample_sequences(7, 5, out=memory.make_sequences(8, 5))
