"""`behaviour` names faults that are put into an agent, and nothing in the agent itself. The lane is in faults.py."""

from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from learning.diagnosis.faults import KINDS, Faults, agent, play

from atari.learning.diagnosis.behaviour import behaviour
from atari.learning.diagnosis.findings import Finding

GAME = "phoenix"


@lru_cache
def faults() -> Faults:
    whole = agent(GAME, Path())
    return Faults(whole, play(whole.policy(), GAME, 8, 1000))


def test_an_agent_without_a_fault_has_no_finding() -> None:
    assert behaviour(faults().plays) == ()


@pytest.mark.parametrize("kind", KINDS)
def test_a_fault_is_named(kind: str) -> None:
    fault = faults().draw(kind, np.random.default_rng(1000))
    assert fault is not None
    assert fault.kind == kind
    findings = behaviour(play(fault.policy, GAME, 8, 1001))
    assert fault.found(findings), findings


def test_a_wrong_place_is_not_right() -> None:
    fault = faults().draw("delayed actions", np.random.default_rng(1000))
    assert fault is not None
    right = Finding("delayed actions", fault.place, fault.number, 1.0, "")
    assert fault.found([right])
    assert not fault.found([])
    assert not fault.found([Finding("delayed actions", "99 steps", 99, 1.0, "")])
    assert not fault.found([Finding("loop", fault.place, fault.number, 1.0, ""), right])
