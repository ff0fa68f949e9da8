"""Trainings in several games: one network, and scores by game."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from small_trainings import make_options  # noqa: E402

from atari.learning import PROTOCOLS, Training, TrainingEnvironments, evaluate, load_policy  # noqa: E402
from atari.learning.agents import AGENTS  # noqa: E402

THREE = {"more_games": "freeway, breakout", "actions": "full", "num_envs": 6, "minibatch": 32, "horizon": 16}


def options(agent: str = "ppo", **given: Any) -> Any:
    own = {name: value for name, value in THREE.items() if agent != "dqn" or name not in ("minibatch", "horizon")}
    return make_options(agent, **{**own, "workers": 1, **given})


@pytest.mark.parametrize("agent", AGENTS)
def test_a_resumed_training_ends_with_the_same_weights(agent: str, tmp_path: Path) -> None:
    steps = 1200 if agent == "dqn" else 192
    ends = []
    for parts in ([steps], [steps // 2, steps]):
        folder = tmp_path / str(len(parts))
        training = Training.begin(agent, options(agent, total_steps=steps), folder)
        for until in parts:
            while training.agent.steps < until:
                training.agent.update()
            training.save()
            training.close()
            training = Training.resume(folder)
        ends.append({name: value.clone() for name, value in training.agent.network.state_dict().items()})
        training.close()
    assert all(torch.equal(ends[0][name], ends[1][name]) for name in ends[0])


def test_the_log_has_a_score_for_each_game(tmp_path: Path) -> None:
    given = options(max_frames=80, total_steps=192, episodic_life=False)
    with closing(Training.begin("ppo", given, tmp_path / "run")) as training:
        training.run()
    row = training.folder.rows()[-1]
    scores = [row[f"score_{game}"] for game in ("pong", "freeway", "breakout")]
    assert np.isfinite(scores).all()
    assert row["score"] == pytest.approx(np.mean(scores))
    assert set(training.scores) == {"pong", "freeway", "breakout"}
    protocol = replace(PROTOCOLS["machado2018"], name="short", max_frames=400)
    result = evaluate(load_policy(tmp_path / "run"), ["pong", "breakout"], protocol, episodes=1)
    assert [one.game for one in result.games] == ["pong", "breakout"]


def test_environments_play_the_games_in_turn() -> None:
    environments = TrainingEnvironments(options(max_frames=40, episodic_life=False), 6)
    environments.reset(0)
    ended: list[tuple[str, float, int]] = []
    while len(ended) < 6:
        environments.step(np.zeros(6, np.int64))
        ended += environments.take_games()
    assert [game for game, _, _ in ended[:6]] == ["pong", "freeway", "breakout"] * 2
    environments.close()


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"actions": "minimal"}, "freeway has other actions than pong, .*; add actions='full'"),
        ({"more_games": "breakuot"}, "there is no game 'breakuot'; did you mean 'breakout'"),
        ({"more_games": ""}, "there is no game ''"),
        ({"more_games": "freeway,freeway"}, "freeway is named twice in more_games='freeway,freeway' and the task"),
        ({"more_games": "pong"}, "pong is named twice"),
        ({"num_envs": 8}, "num_envs must be a multiple of workers times games, got 8, 1 and 3"),
        ({"reward": "reward - 0.1 * player_speed"}, "player_speed"),
    ],
)
def test_games_that_cannot_be_played_together_are_refused(given: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        options(**given)
