"""`play_games`: the games of an evaluation, every step of them, and the states of their steps."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from atari.learning import PROTOCOLS, EvaluationProtocol, Result, ScoresPolicy, evaluate, load_policy
from atari.learning.diagnosis.plays import Plays, play_games
from atari.learning.evaluation.evaluate import episode_seed
from atari.learning.evaluation.played import played_task, resolve_games
from atari.policy import LoadedPolicy
from atari.policy.watched import WatchedPolicy


class At:
    """A step of a game."""

    def __init__(self, play: int, step: int) -> None:
        self.play, self.step = play, step


def short(name: str, frames: int, **changes: Any) -> EvaluationProtocol:
    return replace(PROTOCOLS[name], name=f"short {name}", max_frames=frames, **changes)


def both(policy: Any, game: str, protocol: EvaluationProtocol, games: int) -> tuple[Plays, Result]:
    """The plays of a policy, and its evaluation."""
    loaded = load_policy(policy)
    task = played_task(resolve_games(game)[0], protocol, loaded)
    result = evaluate(policy, game, protocol, episodes=games, seed=3)
    return play_games(loaded, task, games, 3, epsilon=protocol.epsilon), result


def scores_of(observations: Any) -> Any:
    """Scores of four actions that depend on the pixels."""
    means = observations.reshape(len(observations), -1).mean(1)
    return np.stack([np.sin(means * (17 + 3 * action)) for action in range(4)], 1)


@pytest.mark.parametrize("lives", ["continue", "fire"])
def test_the_games_are_those_of_an_evaluation(lives: Any) -> None:
    protocol = short("dopamine", 1200, epsilon=0.1, lives=lives)
    plays, result = both(ScoresPolicy(scores_of), "breakout", protocol, 5)
    assert tuple(plays.scores) == result["breakout"].scores
    assert tuple(play.frames for play in plays) == result["breakout"].frames
    assert tuple(play.truncated for play in plays) == result["breakout"].truncated
    assert tuple(play.seed for play in plays) == result["breakout"].seeds
    assert plays[1].seed == episode_seed(3, "breakout", 1)
    assert any(play.resets for play in plays) == (lives == "fire")
    for play in plays:
        assert play.first_lives == 5
        assert play.score == play.rewards.sum() == play.totals[-1]
        assert [step for step in range(len(play)) if play.lives[step] < play.lives_before[step]][
            : len(play.resets)
        ] == [*play.resets]
        assert play.rams.shape == (len(play), 128)
        assert plays.labels.evaluate(play.rams)[0].shape == (len(plays.labels.names), len(play))


def test_more_games_than_lanes_stand_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    every = both("random", "breakout", short("dopamine", 400), 7)[0]
    monkeypatch.setattr("atari.learning.diagnosis.plays._MOST_LANES", 3)
    monkeypatch.setattr("atari.learning.diagnosis.plays._BLOCK", 16)
    again = both("random", "breakout", short("dopamine", 400), 7)[0]
    for one, other in zip(every, again, strict=True):
        assert one.seed == other.seed
        for name in ("actions", "rewards", "lives", "rams"):
            assert np.array_equal(getattr(one, name), getattr(other, name))
            assert getattr(one, name).dtype == getattr(other, name).dtype


@pytest.mark.parametrize("lives", ["continue", "fire"])
def test_a_state_is_reached_again(lives: Any) -> None:
    plays, _ = both("random", "breakout", short("dopamine", 1600, lives=lives), 3)
    rng = np.random.default_rng(0)
    moments = [At(play, int(rng.integers(len(plays[play])))) for play in (2, 0, 1, 2, 0)]
    moments += [At(1, -1), At(1, len(plays[1]) - 1), *(At(0, step) for step in plays[0].resets[:2])]
    states = plays.states(moments)
    envs = plays.player.make(len(moments))
    envs.reset(seed=77)
    envs.restore(None, states)
    for ram, moment in zip(envs.ram(), moments, strict=True):
        if moment.step >= 0:
            assert (ram == plays[moment.play].rams[moment.step]).all()
    envs.restore([0], [states[5]])  # the beginning: the recorded actions lead through the recorded states
    for step in range(20):
        envs.step([plays[1].actions[step]], env_id=[0])
        assert (envs.ram()[0] == plays[1].rams[step]).all()


def test_a_state_that_does_not_exist_is_refused() -> None:
    plays, _ = both("random", "breakout", short("dopamine", 200), 2)
    assert plays.states([]) == []
    for wrong in (At(2, 0), At(-1, 0), At(0, -2), At(0, len(plays[0]))):
        with pytest.raises(IndexError, match="there is no step"):
            plays.states([At(0, 0), wrong])


def test_scores_stand_at_the_actions_of_the_task() -> None:
    own = ScoresPolicy(scores_of, environment={"actions": ["NOOP", "FIRE", "RIGHT", "LEFT"]})
    plays, _ = both(own, "breakout", short("machado2018", 200, epsilon=0.0), 2)
    assert len(plays.actions) == 18
    columns = [plays.actions.index(name) for name in ("NOOP", "FIRE", "RIGHT", "LEFT")]
    for play in plays:
        assert play.scores is not None
        assert play.scores.dtype == np.float32
        assert (play.scores.argmax(1) == play.actions).all()
        assert np.isfinite(play.scores[:, columns]).all()
        assert np.isneginf(np.delete(play.scores, columns, 1)).all()


def test_a_policy_that_returns_actions_has_no_scores() -> None:
    plays, _ = both(lambda observations: [1] * len(observations), "breakout", short("dopamine", 200), 1)
    assert plays[0].scores is None
    assert "FIRE" in plays.actions


def test_the_policy_is_not_changed() -> None:
    policy = ScoresPolicy(scores_of, sample=True, name="mine")
    watched = WatchedPolicy(LoadedPolicy(policy))
    watched.begin("breakout", ["NOOP", "FIRE", "RIGHT", "LEFT"], np.zeros(1, np.int64), np.zeros(1, np.int64))
    watched(np.zeros((1, 4, 84, 84), np.uint8), np.zeros(1, np.int64))
    assert watched.last_scores is not None
    assert watched.name == "mine"
    assert policy.state() == {}
    assert policy._scores is scores_of


@pytest.mark.parametrize("wrong", [{"games": 0}, {"seed": -1}])
def test_wrong_numbers_are_refused(wrong: dict[str, int]) -> None:
    task = played_task(resolve_games("breakout")[0], PROTOCOLS["dopamine"], load_policy("noop"))
    with pytest.raises(ValueError, match=next(iter(wrong))):
        play_games(load_policy("noop"), task, **{"games": 1, "seed": 0, **wrong})


def test_progress_counts_the_games() -> None:
    seen: list[tuple[int, int]] = []
    task = played_task(resolve_games("breakout")[0], short("dopamine", 100), load_policy("noop"))
    play_games(load_policy("noop"), task, 2, 0, progress=lambda *numbers: seen.append(numbers))
    assert seen == [(1, 2), (2, 2)]
