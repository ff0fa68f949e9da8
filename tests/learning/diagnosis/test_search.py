"""Searches: what passes, that a search is always the same, its limit, and replays of what it finds."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.learning import load_policy
from atari.learning.diagnosis import search as module
from atari.learning.diagnosis.moments import Moment
from atari.learning.diagnosis.plays import Plays, play_games
from atari.learning.diagnosis.search import Part, Saved, record_parts, search, steps_of
from atari.recording import Replay

STEPS, MARGIN = 12_000, 40


@pytest.fixture(scope="module", autouse=True)
def margin() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "MARGIN", MARGIN)
        yield


class Still:
    """A policy of Breakout that serves and never moves, so that it loses each ball."""

    name = "still"

    def __call__(self, observations: Any, lanes: Any) -> Any:
        return np.full(len(lanes), 1)


@pytest.fixture(scope="module")
def plays() -> Plays:
    task = atari.Task.of("breakout", obs_type="ram", max_num_frames_per_episode=4000)
    return play_games(load_policy(Still()), task, games=1, seed=0)


@pytest.fixture(scope="module")
def life(plays: Plays) -> Moment:
    """The first lost life."""
    return Moment(0, int(np.argmax(plays[0].lives < plays[0].lives_before)), "life")


@pytest.fixture(scope="module")
def saved(plays: Plays, life: Moment) -> Saved:
    found = search(plays, life, steps=STEPS, seed=0)
    assert found is not None
    return found


def outcome(plays: Plays, parts: Sequence[Part]) -> tuple[int, int, int]:
    """Steps, points and lost lives of parts that are played one after the other."""
    envs = plays.player.make(1)
    envs.reset(seed=5)
    steps = points = lost = 0
    lives = None
    for state, actions in parts:
        envs.restore([0], [state])
        for action in actions.tolist():
            lives = envs.lanes[0].lives
            info = envs.step(np.array([action]))[4]
            steps, points = steps + 1, points + int(info["reward"][0])
            lost += int(info["lives"][0] < lives)
    envs.close()
    return steps, points, lost


def test_a_continuation_survives_where_the_game_was_lost(plays: Plays, life: Moment, saved: Saved) -> None:
    assert outcome(plays, saved.parts) == (saved.ahead + MARGIN, saved.gained, 0)
    assert len(saved.actions) == saved.ahead + MARGIN
    play, first = plays[0], life.step - saved.ahead + 1
    assert saved.chosen == plays.actions[play.actions[first]] == "FIRE"
    assert saved.value is None  # the policy gives actions alone
    assert saved.score == play.totals[first - 1]
    assert saved.recorded == play.rewards[first : life.step + 1].sum()
    assert outcome(plays, [Part(plays.states([Moment(0, first - 1, "life")])[0], play.actions[first : life.step + 1])])[
        2
    ]


def test_it_begins_at_the_states_of_the_game(plays: Plays, life: Moment, saved: Saved) -> None:
    """The first part begins where the game was; only the generators are others."""
    envs = plays.player.make(1)
    envs.reset(seed=5)
    envs.restore([0], [saved.state])
    assert envs.ram()[0].tobytes() == plays[0].rams[life.step - saved.ahead].tobytes()
    envs.close()


def test_a_search_is_always_the_same(plays: Plays, life: Moment, saved: Saved) -> None:
    again, other = (search(plays, life, steps=STEPS, seed=seed) for seed in (0, 1))
    assert again is not None
    assert other is not None
    assert str(again) == str(saved)
    assert again.actions.tobytes() == saved.actions.tobytes() != other.actions.tobytes()


def test_the_numbers_of_tries(saved: Saved) -> None:
    assert 0 <= saved.passed <= saved.tries <= len(module._TRIED) - saved.own_tries
    assert saved.own_passed == 0  # a paddle that never moves passes nothing
    assert f"Of {saved.tries} tries with random actions {saved.passed} pass, and 0 of" in str(saved)


def test_a_search_plays_no_more_steps_than_it_may(plays: Plays, life: Moment, monkeypatch: pytest.MonkeyPatch) -> None:
    played = 0
    step = atari.AtariVectorEnv.step

    def counted(envs: Any, actions: Any, *args: Any, **more: Any) -> Any:
        nonlocal played
        played += len(actions)
        return step(envs, actions, *args, **more)

    plays.states([life])
    own = plays.states
    monkeypatch.setattr(Plays, "states", lambda self, moments: found)
    found = own([Moment(0, life.step - ahead, "life") for ahead in module._begins(plays, life)])
    monkeypatch.setattr(atari.AtariVectorEnv, "step", counted)
    for most in (1, 500, 3000):
        played = 0
        search(plays, life, steps=most)
        assert most - 6 * 2 * module.LANES <= played <= most


def test_what_cannot_be_passed_is_none(plays: Plays, life: Moment, monkeypatch: pytest.MonkeyPatch) -> None:
    """A step before the lost life, the ball is below the paddle."""
    monkeypatch.setattr(module, "AHEAD", (1, 2))
    assert search(plays, life, steps=4000) is None


def test_a_plateau_is_passed_by_points(plays: Plays, life: Moment) -> None:
    """The game won nothing until its end; a paddle that moves hits a brick, and the continuation ends there."""
    saved = search(plays, Moment(0, life.step - 2, "plateau"), steps=STEPS)
    assert saved is not None
    assert saved.gained > 0 == saved.recorded
    steps, points, lost = outcome(plays, saved.parts)
    assert (points, lost) == (saved.gained, 0)
    assert steps == len(saved.actions) <= saved.ahead + MARGIN
    early = [
        Part(state, actions[:-1] if part == len(saved.parts) - 1 else actions)
        for part, (state, actions) in enumerate(saved.parts)
    ]
    assert outcome(plays, early)[1] == 0


def test_a_search_does_not_begin_before_the_life(plays: Plays) -> None:
    lost = np.flatnonzero(plays[0].lives < plays[0].lives_before).tolist()
    for before, step in zip([-2, *lost], lost, strict=False):
        begins = module._begins(plays, Moment(0, step, "life"))
        assert begins
        assert all(step - ahead > before for ahead in begins)
    assert module._begins(plays, Moment(0, 0, "life")) == [1]


def test_a_replay_verifies_and_shows_the_continuation(plays: Plays, saved: Saved, tmp_path: Path) -> None:
    path = tmp_path / "saved.a26r"
    saved.write(path, plays.player)
    replay = Replay.load(path)
    assert replay.verify()
    assert replay.complete
    assert replay.steps == len(saved.actions)
    assert sum(frame.reward for frame in replay.frames()) == saved.gained
    assert replay.game.id == "breakout"


def test_a_replay_of_recorded_steps(plays: Plays, life: Moment, tmp_path: Path) -> None:
    """The steps of the game itself, from a state of `Plays.states`, lose the life in the replay, too."""
    path, first = tmp_path / "lost.a26r", life.step - 20
    (state,) = plays.states([Moment(0, first, "life")])
    record_parts(path, plays.player, [Part(state, plays[0].actions[first + 1 : life.step + 1])])
    replay = Replay.load(path)
    assert replay.verify()
    frames = list(replay.frames())
    assert frames[-1].lives == frames[0].lives - 1
    with pytest.raises(ValueError, match="no steps"):
        record_parts(path, plays.player, [])


def test_arguments(plays: Plays, life: Moment) -> None:
    assert steps_of(2) == 2 * module.STEPS_A_SECOND
    for bad in (0, -1, float("nan"), 10**6):
        with pytest.raises(ValueError, match="seconds must be above 0"):
            steps_of(bad)
    with pytest.raises(ValueError, match="steps"):
        search(plays, life, steps=0)
    with pytest.raises(IndexError, match="there is no step 5 of game 3"):
        search(plays, Moment(3, 5, "life"))


def test_tries_are_counted_only_if_all_have_ended() -> None:
    task = atari.Task.of("breakout", obs_type="ram", max_num_frames_per_episode=4000)
    plays = play_games(load_policy("random"), task, games=1, seed=0)
    found = [search(plays, Moment(0, 100, "plateau"), steps=steps, seed=0) for steps in range(1800, 3400, 200)]
    counts = {(one.tries, one.own_tries): str(one) for one in found if one is not None}
    assert counts.keys() == {(0, 0), (32, 8)}
    assert "tries" not in counts[0, 0]
