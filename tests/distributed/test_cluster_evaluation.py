"""`evaluate` on a cluster: the same numbers to the bit as in this process, for any number of workers."""

import os
import signal
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from atari.learning import PROTOCOLS, evaluate

ray = pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = pytest.mark.ray

PROTOCOL = replace(PROTOCOLS["machado2018"], name="short", max_frames=800)
GAMES = ["breakout", "ms_pacman", "pong"]


def sums(observations: Any) -> Any:
    """Actions that depend on every pixel."""
    return observations.reshape(len(observations), -1).sum(1, dtype=np.int64) % 18


@pytest.mark.parametrize("policy", ["random", sums])
@pytest.mark.parametrize("parts", [1, 4])
def test_the_result_is_that_of_one_process(cluster: Any, policy: Any, parts: int) -> None:
    if policy is sums:
        ray.cloudpickle.register_pickle_by_value(sys.modules[__name__])
    here = evaluate(policy, GAMES, PROTOCOL, episodes=6, seed=2)
    assert evaluate(policy, GAMES, PROTOCOL, episodes=6, seed=2, workers="ray", parts=parts) == here


def test_a_network_gives_the_result_of_one_process(cluster: Any) -> None:
    """To the bit: the batches are the same."""
    torch = pytest.importorskip("torch")
    torch.manual_seed(0)
    network = torch.nn.Sequential(
        torch.nn.Conv2d(4, 16, 8, 4), torch.nn.ReLU(), torch.nn.Flatten(), torch.nn.Linear(6400, 18)
    )

    def scores(observations: Any) -> Any:
        with torch.no_grad():
            return network(torch.from_numpy(observations).float() / 255).argmax(1).numpy()

    here = evaluate(scores, GAMES, PROTOCOL, episodes=6, seed=2)
    assert evaluate(scores, GAMES, PROTOCOL, episodes=6, seed=2, workers="ray") == here


def test_a_killed_worker_changes_nothing(cluster: Any, tmp_path: Any) -> None:
    def deadly(observations: Any) -> Any:
        """Kills the first process that it plays in, in the middle of a game."""
        deadly.calls += 1  # type: ignore[attr-defined]
        if deadly.calls == 30 and os.getpid() != driver and not (tmp_path / "killed").exists():  # type: ignore[attr-defined]
            (tmp_path / "killed").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return [1] * len(observations)

    deadly.calls, driver = 0, os.getpid()  # type: ignore[attr-defined]
    here = evaluate(deadly, GAMES, PROTOCOL, episodes=2)
    deadly.calls = 0  # type: ignore[attr-defined]
    assert evaluate(deadly, GAMES, PROTOCOL, episodes=2, workers="ray") == here
    assert (tmp_path / "killed").exists()


def test_an_error_of_the_policy_is_raised(cluster: Any) -> None:
    driver = os.getpid()

    def broken(observations: Any) -> Any:
        raise ZeroDivisionError(f"of the policy, here: {os.getpid() == driver}")

    with pytest.raises(ZeroDivisionError, match="here: False"):
        evaluate(broken, GAMES, PROTOCOL, episodes=2, workers="ray")
