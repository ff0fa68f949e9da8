"""`ReplayMemory` returns the same bits as a memory of whole stacks."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from memory_cases import compare, play
from memory_streams import everything, same

from atari.learning import ReplayMemory

SHAPES = [(5, 6), (1, 4, 7), (3, 4, 3), (9,)]


@st.composite
def cases(draw: st.DrawFn) -> dict:
    return {
        "lanes": draw(st.integers(1, 4)),
        "capacity": draw(st.integers(1, 60)),
        "shape": draw(st.sampled_from(SHAPES)),
        "stack": draw(st.integers(1, 5)),
        "padding": draw(st.sampled_from(["zero", "reset"])),
        "mode": draw(st.sampled_from(["next_step", "same_step", "disabled"])),
        "compress": draw(st.booleans()),
        "ends": draw(st.sampled_from([0.0, 0.03, 0.2, 0.7])),
        "steps": draw(st.integers(1, 90)),
        "resets": draw(st.sampled_from([0.0, 0.0, 0.1])),
        "copied": draw(st.booleans()),
        "threads": draw(st.integers(1, 2)),
        "seed": draw(st.integers(0, 2**20)),
    }


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(case=cases(), n=st.sampled_from([1, 2, 3, 7, 40]), data=st.data())
def test_transitions(case: dict, n: int, data: st.DataObject) -> None:
    memory, naive, _ = play(case)
    assert np.array_equal(memory.observations().reshape(naive.observations().shape), naive.observations())
    stack = data.draw(st.integers(1, case["stack"]))
    compare(memory, naive, n, stack)


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(case=cases(), length=st.integers(1, 12))
def test_sequences(case: dict, length: int) -> None:
    memory, naive, _ = play(case)
    if not memory.count(length):
        return
    batch = memory.sample_sequences(20, length)
    known = {row["indices"] for row in naive.transitions(length, 1.0, 1)}
    for i, index in enumerate(batch.indices):
        assert index in known
        wanted = naive.sequence(int(index), length, case["stack"])
        same({name: getattr(batch, name)[i] for name in wanted}, wanted)


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(case=cases(), margin=st.integers(0, 40), n=st.sampled_from([1, 3]))
def test_a_file_has_the_state_of_its_last_flush(
    case: dict, margin: int, n: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("memory") / "replay"
    memory, naive, stream = play(case, path=path, margin=margin)
    memory.flush()
    flushes = memory.flushes
    wanted = naive.transitions(n, 0.9, case["stack"])
    present = memory.observations()
    for _ in range(margin // case["lanes"]):
        stream.step(memory)
    later = memory.flushes
    memory.close()
    reopened = ReplayMemory.open(path)
    if later == flushes:
        assert np.array_equal(reopened.observations(), present)
        assert reopened.count(n) == len(wanted)
        found = everything(reopened, n=n, gamma=0.9) if wanted else {}
        for row in wanted:
            same(found[row["indices"]], row)
    reopened.close()
    Path(path).unlink()
