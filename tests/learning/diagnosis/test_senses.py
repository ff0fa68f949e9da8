"""Findings from changed observations: late answers, and objects that are not seen."""

from functools import partial
from typing import Any, ClassVar

import numpy as np
import pytest

from atari import Task, games
from atari.lab.labels import labels_of
from atari.learning import ScoresPolicy, load_policy
from atari.learning.diagnosis.plays import Plays, play_games
from atari.learning.diagnosis.senses import _paint, delayed_actions, unseen_objects

LABELS = labels_of(games["pong"])
TASK = Task.of("pong", obs_type="ram", max_num_frames_per_episode=6000)
IMAGES = Task.of("pong", preset="dqn2015", max_num_frames_per_episode=6000)
NOOP, RIGHT, LEFT = 0, 2, 3


def follow(observations: Any, ball: bool = True) -> Any:
    """Scores of Pong's actions: follow the ball, or the other player."""
    values, _ = LABELS.evaluate(np.ascontiguousarray(observations.reshape(-1, 128)))
    see = dict(zip(LABELS.names, values, strict=True))
    above = see["player_y"] + 8 - (see["ball_y"] if ball else see["enemy_y"])
    scores = np.full((len(observations), 6), -1e3)
    scores[:, NOOP], scores[:, RIGHT], scores[:, LEFT] = 6, above, -above
    return scores


def follow_image(observations: Any, ball: bool = True) -> Any:
    """Scores of Pong's actions from the newest image: follow the ball, or the other player by its own gray."""
    court = observations[:, -1, 13:77].astype(int)
    followed = (np.abs(court[:, :, 12:70] - 87) > 20) if ball else court[:, :, 9:10] == 148
    places = [
        (seen.sum(2) * np.arange(64)).sum(1) / np.maximum(seen.sum((1, 2)), 1)
        for seen in (followed, court[:, :, 74:75] == 163)
    ]
    scores = np.full((len(observations), 6), -1e3)
    scores[:, NOOP], scores[:, RIGHT], scores[:, LEFT] = 1, places[1] - places[0], places[0] - places[1]
    return scores


class Late:
    """Plays each action some steps after it was chosen."""

    environment: ClassVar = {"obs_type": "ram"}

    def __init__(self, delay: int) -> None:
        self.delay = delay
        self.queues: dict[int, list[int]] = {}

    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        self.queues |= {lane: [NOOP] * self.delay for lane in lanes.tolist()}

    def __call__(self, observations: Any, lanes: Any) -> Any:
        for lane, action in zip(lanes.tolist(), follow(observations).argmax(1).tolist(), strict=True):
            self.queues[lane].append(action)
        return np.array([self.queues[lane].pop(0) for lane in lanes.tolist()])


def played(policy: Any) -> Plays:
    return play_games(load_policy(policy), TASK, 3, seed=1)


def scored(scores: Any) -> Any:
    return ScoresPolicy(scores, environment={"obs_type": "ram"})


@pytest.mark.parametrize("delay", [1, 7])
def test_a_delay_is_counted(delay: int) -> None:
    finding = delayed_actions(played(Late(delay)))
    assert finding is not None
    assert (finding.kind, finding.number) == ("delayed actions", delay)
    assert finding.place == ("1 step" if delay == 1 else "7 steps")


@pytest.mark.parametrize("policy", [Late(0), "random", scored(follow)], ids=["at once", "random", "scores"])
def test_answers_at_once_or_none_are_no_delay(policy: Any) -> None:
    assert delayed_actions(played(policy)) is None


def test_a_delay_of_the_task_is_said() -> None:
    task = Task.of("pong", action_delay=(2, 8), max_num_frames_per_episode=2000)
    finding = delayed_actions(play_games(load_policy("noop"), task, 1, seed=1))
    assert finding is not None
    assert finding.place == "8 frames"
    assert "2 to 8 frames" in finding.text


def test_the_ball_is_not_seen() -> None:
    (finding,) = unseen_objects(played(scored(lambda observations: follow(observations, ball=False))))
    assert (finding.kind, finding.place) == ("unseen object", "ball")


def test_an_object_that_is_seen_is_not_named() -> None:
    assert unseen_objects(played(scored(follow))) == ()


@pytest.mark.parametrize(("ball", "unseen"), [(False, ["ball"]), (True, [])])
def test_the_ball_is_or_is_not_seen_in_images(ball: bool, unseen: list[str]) -> None:
    plays = play_games(load_policy(ScoresPolicy(partial(follow_image, ball=ball))), IMAGES, 3, seed=1)
    assert [finding.place for finding in unseen_objects(plays)] == unseen


def test_nothing_is_said_of_a_policy_that_looks_at_nothing() -> None:
    assert unseen_objects(played("random")) == ()


def test_an_object_is_painted_with_what_is_around_it() -> None:
    image = np.full((84, 84), 50, np.uint8)
    image[40:44, 20:24] = 200
    other = image.copy()
    _paint(image, (40, 100), (6, 8), 210)
    assert (image == 50).all()
    _paint(other, (0, 0), (6, 8), 210)
    assert (other[40:44, 20:24] == 200).all()
    _paint(other, (-40, 300), (6, 8), 210)  # outside of the screen
    assert (other[40:44, 20:24] == 200).all()
