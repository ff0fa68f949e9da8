"""Bad input of `ReplayMemory`: errors, before anything changes."""

import multiprocessing
import os
import re
from typing import Any

import gymnasium
import numpy as np
import pytest

from atari.learning import ReplayMemory
from atari.learning.memory.batches import Batch

FRAMES = np.zeros((2, 3, 4), np.uint8)
NO = np.zeros(2, bool)


def make(**options: Any) -> ReplayMemory:
    return ReplayMemory(**{"capacity": 20, "num_envs": 2, "observation_shape": (3, 4), "seed": 0, **options})


def filled(steps: int = 5, **options: Any) -> ReplayMemory:
    memory = make(**options)
    memory.reset(FRAMES)
    for step in range(steps):
        memory.add(np.array([1, 2]), np.array([step, 1.0]), NO, NO, observations=FRAMES + step)
    return memory


@pytest.mark.parametrize(
    ("options", "error"),
    [
        *(({"capacity": wrong}, ValueError) for wrong in (0, 2**70)),
        *(({"capacity": wrong}, TypeError) for wrong in (2.5, True)),
        ({"capacity": 2**40, "observation_shape": (1000, 1000)}, ValueError),
        ({"capacity": 2**32, "observation_shape": (84, 84)}, MemoryError),
        *(({"seed": wrong}, ValueError) for wrong in (-1, 2**32)),
        *(({"num_envs": wrong}, ValueError) for wrong in (0, 2**30)),
        *(({"observation_shape": wrong}, ValueError) for wrong in ((), (0, 3), (-1, 3), {}, {1: (3,)}, (2**20, 2**20))),
        ({"observation_shape": 84}, TypeError),
        *(({"stack_num": wrong}, ValueError) for wrong in (0, 10**6, {"image": 4})),
        ({"padding": "first"}, ValueError),
        ({"autoreset_mode": "never"}, ValueError),
        *(({"action_shape": wrong}, ValueError) for wrong in ((0,), (10**6,))),
        *(({"action_dtype": wrong}, TypeError) for wrong in ("O", "no")),
        *(({"priority_exponent": wrong}, ValueError) for wrong in (-1, float("nan"))),
        ({"priority_exponent": "1"}, TypeError),
        ({"final_frames": 1, "autoreset_mode": "same_step"}, ValueError),
        ({"compressed_bytes": 10}, ValueError),
        ({"num_threads": 0}, ValueError),
        *(({"margin": wrong}, ValueError) for wrong in (-1, 10)),  # without a file
        ({"autoflush": False}, ValueError),
        ({"autoflush": "no"}, TypeError),
        ({"path": 3}, TypeError),
    ],
)
def test_options(options: dict[str, Any], error: type[Exception]) -> None:
    with pytest.raises(error) as caught:
        make(**options)
    assert error is not MemoryError or re.search(r"needs .* GB and .* are available", str(caught.value))


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"actions": np.zeros(3, int)}, ValueError),
        ({"actions": np.zeros((2, 1), int)}, ValueError),
        ({"actions": np.zeros(2)}, TypeError),
        ({"actions": [0, 1]}, TypeError),
        ({"rewards": np.zeros(3)}, ValueError),
        ({"rewards": np.array(["a", "b"])}, ValueError),
        ({"rewards": np.array([0, np.nan])}, ValueError),
        ({"terminations": np.zeros(2, int)}, ValueError),
        ({"terminations": np.zeros(1, bool)}, ValueError),
        *(({name: None}, TypeError) for name in ("actions", "rewards", "terminations", "truncations")),
        ({"observations": FRAMES[:1]}, ValueError),
        ({"observations": FRAMES.astype(float)}, ValueError),
        ({"observations": {"": FRAMES}}, TypeError),
        ({"terminations": ~NO}, ValueError),
        ({"terminations": ~NO, "info": {"final_obs": FRAMES[:1]}}, ValueError),
        ({"terminations": ~NO, "info": {"final_obs": np.array([None, None])}}, ValueError),
    ],
)
def test_add(change: dict[str, Any], error: type[Exception]) -> None:
    memory = filled(autoreset_mode="same_step")
    before = memory.observations()
    good = {"actions": np.array([1, 2]), "rewards": np.zeros(2), "terminations": NO, "truncations": NO}
    with pytest.raises(error) as caught:
        memory.add(**{**good, "observations": FRAMES, **change})
    assert "incompatible function arguments" not in str(caught.value)  # the binding's own text
    assert (memory.steps, len(memory)) == (10, 10)
    assert np.array_equal(memory.observations(), before)


@pytest.mark.parametrize(
    ("dtype", "actions", "match"),
    [
        ("int8", [3, 300], "environment 1 is 300, and action_dtype int8"),
        ("int8", [-129, 0], "environment 0 is -129, and action_dtype int8"),
        ("int32", [2**31, 0], "environment 0 is 2147483648"),
        ("float32", [0.0, 1e300], r"environment 1 is 1e\+300, and action_dtype float32"),
        ("float32", [0.0, np.nan], "environment 1 is nan"),
        ("float64", [np.inf, 0.0], "environment 0 is inf"),
        ("float16", [70000.0, 0.0], r"environment 0 is 70000\.0"),
    ],
)
def test_actions_that_the_dtype_cannot_store(dtype: str, actions: list[float], match: str) -> None:
    memory = make(action_dtype=dtype)
    memory.reset(FRAMES)
    with pytest.raises(ValueError, match=match):
        memory.add(np.array(actions), np.zeros(2), NO, NO, observations=FRAMES)
    assert (memory.steps, len(memory)) == (0, 0)
    memory.add(np.array([2, 100], np.array(actions).dtype), np.zeros(2), NO, NO, observations=FRAMES)
    assert set(memory.sample(50).actions) == {2, 100}


@pytest.mark.parametrize(("reward", "match"), [(1e300, r"1 is 1e\+300"), (np.nan, "1 is nan"), (-np.inf, "1 is -inf")])
def test_rewards_that_are_not_finite_as_float32(reward: float, match: str) -> None:
    memory = filled()
    with pytest.raises(ValueError, match=f"the reward of environment {match}"):
        memory.add(np.array([1, 2]), np.array([0.0, reward]), NO, NO, observations=FRAMES)
    assert memory.steps == 10


def test_order_of_calls() -> None:
    memory, step = make(), (np.array([1, 2]), np.zeros(2), NO, NO)
    for given in ({"observations": FRAMES}, {}):
        with pytest.raises(gymnasium.error.ResetNeeded):
            memory.add(*step, **given)
    for call, text in (
        (memory.observations, "reset"),
        (lambda: memory.sample(1), "no step to sample"),
        (lambda: memory.reset(FRAMES, ~NO), "without a mask"),
    ):
        with pytest.raises(ValueError, match=text):
            call()
    memory.reset(FRAMES)
    for prepare in (
        lambda: None,
        memory.frames,  # and nothing is written there, as by envs.step(actions) without out=
        lambda: (np.copyto(memory.frames(), FRAMES), memory.add(*step), memory.reset(FRAMES)),
    ):
        prepare()
        before = len(memory)
        with pytest.raises(ValueError, match=r"observations of this step are missing: pass add\(..., observations="):
            memory.add(*step)
        assert len(memory) == before
    with pytest.raises(ValueError, match="autoreset_mode"):
        memory.reset(FRAMES, ~NO)
    with pytest.raises(ValueError, match="mask"):
        memory.reset(FRAMES, np.ones(2))
    memory.close()
    memory.close()
    with pytest.raises(ValueError, match="closed"):
        memory.frames()


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"batch_size": 0}, ValueError),
        ({"batch_size": 2**40}, ValueError),
        ({"batch_size": 1.5}, TypeError),
        ({"n": 0}, ValueError),
        ({"n": 6}, ValueError),
        ({"gamma": 1.5}, ValueError),
        ({"gamma": float("nan")}, ValueError),
        ({"gamma": "a"}, (TypeError, ValueError)),
        ({"beta": 0.5}, ValueError),
        ({"stack_num": 5}, ValueError),
        ({"stack_num": {"a": 1}}, ValueError),
        ({"out": 3}, TypeError),
        ({"batch_size": 3, "out": 4}, ValueError),
    ],
)
def test_sample(options: dict[str, Any], error: Any) -> None:
    memory = filled()
    if options.get("out") == 4:
        options = {**options, "out": memory.make_batch(4)}
    with pytest.raises(error):
        memory.sample(**{"batch_size": 4, **options})


def test_arrays_of_your_own() -> None:
    memory, twin = filled(), filled()
    good = memory.make_batch(4)
    fields = {name: getattr(good, name) for name in Batch.__dataclass_fields__ if name != "_target"}
    mine = Batch(**fields)
    assert memory.sample(4, out=mine) is mine
    assert np.array_equal(mine.observations, twin.sample(4).observations)
    read_only = np.zeros(4, np.float32)
    read_only.flags.writeable = False
    for name, array in (
        ("observations", np.zeros((4, 4, 3, 5), np.uint8)),
        ("observations", np.zeros((4, 4, 3, 4), np.int8)),
        ("observations", np.zeros((4, 4, 3, 8), np.uint8)[..., ::2]),
        ("next_observations", np.zeros((4, 3, 3, 4), np.uint8)),
        ("actions", np.zeros(4, np.int32)),
        ("rewards", np.zeros(4)),
        ("rewards", read_only),
        ("indices", [0, 0, 0, 0]),
    ):
        with pytest.raises((TypeError, ValueError)):
            memory.sample(4, out=Batch(**{**fields, name: array}))


def test_a_batch_of_another_memory() -> None:
    small, large = filled(), ReplayMemory(20, 2, (30, 40), seed=0)
    large.reset(np.zeros((2, 30, 40), np.uint8))
    large.add(np.array([1, 2]), np.zeros(2), NO, NO, observations=np.zeros((2, 30, 40), np.uint8))
    batch = small.make_batch(4)
    small.sample(4, out=batch)
    with pytest.raises(ValueError, match="observations"):
        large.sample(4, out=batch)


def test_resizing_an_array_of_a_batch_is_refused() -> None:
    memory = filled()
    batch = memory.make_batch(4)
    memory.sample(4, out=batch)
    with pytest.raises(ValueError, match="resize"):
        batch.rewards.resize(1, refcheck=False)
    memory.sample(4, out=batch)


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"torch": "cuda"}, TypeError),
        ({"pin_memory": "yes"}, TypeError),
        ({"pin_memory": True}, ValueError),  # without tensors
        ({"share": "no"}, TypeError),
    ],
)
def test_options_of_a_batch(options: dict[str, Any], error: type[Exception]) -> None:
    with pytest.raises(error):
        filled().make_batch(4, **options)


def test_tensors_of_torch() -> None:
    torch = pytest.importorskip("torch")
    memory, twin = filled(), filled()
    batch = memory.make_batch(6, torch=True, pin_memory=True)
    assert memory.sample(6, n=2, out=batch) is batch
    other = twin.sample(6, n=2)
    assert batch.observations.dtype == torch.uint8
    for name in ("observations", "next_observations", "actions", "rewards", "discounts", "truncations"):
        assert np.array_equal(getattr(batch, name).numpy(), getattr(other, name))
    memory.add(torch.tensor([1, 2]), torch.zeros(2), torch.zeros(2, dtype=torch.bool), NO, observations=FRAMES)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_process_is_refused() -> None:
    memory = filled()

    def child(pipe: Any) -> None:
        try:
            memory.sample(1)
        except RuntimeError as error:
            pipe.send(str(error))

    receiver, sender = multiprocessing.Pipe()
    process = multiprocessing.get_context("fork").Process(target=child, args=(sender,))
    process.start()
    assert receiver.poll(20)
    assert "forked" in receiver.recv()
    process.join()
