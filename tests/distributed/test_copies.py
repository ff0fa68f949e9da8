"""`GameScores` can be copied, as RLlib does; `RolloutActors` own processes and refuse."""

import copy
import pickle
from typing import Any

import pytest

pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = pytest.mark.ray

from atari.integrations.ray import GameScores, RolloutActors  # noqa: E402


def test_game_scores() -> None:
    for other in (copy.deepcopy(GameScores()), pickle.loads(pickle.dumps(GameScores()))):
        assert type(other) is GameScores


def test_actors_refuse(cluster: Any) -> None:
    with RolloutActors("pong", 1, 1, "noop", steps=4) as actors:
        for duplicate in (copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError, match="RolloutActors own processes on a cluster and cannot be copied"):
                duplicate(actors)
