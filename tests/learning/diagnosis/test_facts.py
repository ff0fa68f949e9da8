"""`Comparison`: what is common at some steps of play, from arrays whose facts are known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import atari
from atari.base.frozen import FrozenDict
from atari.lab.labels import labels_of
from atari.learning.diagnosis.facts import Comparison, Fact
from atari.learning.diagnosis.moments import Moment
from atari.learning.diagnosis.plays import Play, Plays

INVADERS, ENEMIES_Y, ENEMIES_Y_ARI, SHOT_X, SHOT_Y, PLAYER_X, SCORE = 17, 16, 24, 83, 81, 28, 102
STEPS = 400


def made(rams: Any, rewards: Any = None, actions: Any = None, labelled: bool = True) -> Plays:
    """Games with these RAMs, (games, steps, 128), and rewards at random."""
    count, steps = rams.shape[:2]
    if rewards is None:
        rewards = np.random.default_rng(2).integers(0, 2, (count, steps)).astype(np.int32)
    plays = tuple(
        Play(
            seed=number,
            score=0.0,
            frames=4 * steps,
            truncated=False,
            first_lives=3,
            actions=np.zeros(steps, np.uint8) if actions is None else actions[number],
            rewards=rewards[number],
            lives=np.full(steps, 3, np.int16),
            rams=rams[number],
            scores=None,
            resets=(),
        )
        for number in range(count)
    )
    definition = atari.games["space_invaders"]
    if not labelled:
        definition = replace(definition, ram_labels=FrozenDict({}))
    names = tuple(action.name for action in definition.minimal_actions)
    fields: Any = {"task": None, "policy": None, "player": None}
    return Plays(actions=names, labels=labels_of(definition), epsilon=0.0, seed=0, games=plays, **fields)


def noise(games: int = 10) -> Any:
    """RAMs of uniform bytes, with a visible shot."""
    rams = np.random.default_rng(0).integers(0, 200, (games, STEPS, 128)).astype(np.uint8)
    rams[..., SHOT_Y] = 50
    return rams


def at(step: int, games: int = 10) -> list[Moment]:
    return [Moment(game, step, "end") for game in range(games)]


def found(plays: Plays, places: Any, **options: Any) -> list[Fact]:
    return list(Comparison(plays, longest=STEPS).facts(places, low_score=0.0, **options))


def test_noise_has_no_fact() -> None:
    plays = made(noise())
    for step in range(10, STEPS, 50):
        assert found(plays, at(step)) == []


def test_a_range_of_a_label() -> None:
    rams = noise()
    rams[:, 300, INVADERS] = [1, 2, 3, 4, 4, 3, 2, 1, 1, 90]
    (fact,) = found(made(rams), at(300))
    assert (fact.name, fact.low, fact.high, fact.there) == ("invaders_left_count", 1, 4, 0.9)
    assert fact.elsewhere == pytest.approx(4 / 200, abs=0.01)
    assert str(fact) == "invaders_left_count is 1 to 4 in 90 % (elsewhere in 2 %)"


def test_a_place_is_compared_at_its_own_step_and_game() -> None:
    rams = noise()
    steps = [350, 20, 80, 390, 5, 111, 222, 333, 44, 99]
    for game, step in enumerate(steps):
        rams[game, step, INVADERS] = 1
    places = [Moment(game, steps[game], "life") for game in (3, 1, 9, 0, 2, 4, 8, 7, 6, 5)]
    assert [fact.name for fact in found(made(rams), places)] == ["invaders_left_count"]
    assert found(made(rams), [Moment(one.play, one.step + 1, "life") for one in places]) == []


def test_a_second_name_of_a_thing_is_no_second_fact() -> None:
    rams = noise()
    rams[:, 300, ENEMIES_Y] = rams[:, 300, ENEMIES_Y_ARI] = 60
    assert [fact.name for fact in found(made(rams), at(300))] == ["enemies_y"]


def test_what_an_earlier_fact_implies_is_no_fact_but_for_a_count() -> None:
    rams = noise()
    low = rams[..., ENEMIES_Y] < 20
    rams[low, INVADERS] = 3  # few are left wherever they stand low
    rams[low, PLAYER_X] = 77
    rams[:, 300, ENEMIES_Y], rams[:, 300, INVADERS], rams[:, 300, PLAYER_X] = 10, 3, 77
    facts = found(made(rams), at(300))
    assert facts[0].name == "enemies_y"
    assert "player_x" not in [fact.name for fact in facts]
    assert "invaders_left_count" in [fact.name for fact in facts] or facts[0].elsewhere > 0.05


def test_a_distance_from_the_player() -> None:
    rams = noise()
    rams[:, 300, SHOT_X] = rams[:, 300, PLAYER_X] + 3
    names = [fact.name for fact in found(made(rams), at(300))]
    assert names[:1] == ["enemy_shot_0_x - player_x"]


def test_a_thing_that_is_not_visible() -> None:
    rams = noise()
    rams[:, 300, SHOT_Y] = 0
    (fact,) = found(made(rams), at(300))
    assert not fact.visible
    assert str(fact).startswith("enemy_shot_0_")
    assert str(fact).endswith("is not visible in 100 % (elsewhere in less than 1 %)")


def test_an_action_that_follows() -> None:
    actions = np.random.default_rng(1).integers(0, 6, (10, STEPS)).astype(np.uint8)
    actions[:, 301] = 3
    (fact,) = found(made(noise(), actions=actions), at(300))
    assert fact.text == "the next action is LEFT"


def test_a_long_time_without_a_reward() -> None:
    rewards = np.zeros((10, STEPS), np.int32)
    rewards[:, :240:10] = 5
    plays = made(noise(), rewards=rewards)
    (fact,) = found(plays, at(300))
    assert fact.text == "the last reward is 70 steps ago"
    assert found(plays, at(300), waits=False) == []


def test_bytes_that_show_only_the_progress_are_no_facts() -> None:
    rewards = np.ones((10, STEPS), np.int32)
    rams = noise()
    rams[:, 280:, PLAYER_X] = 5
    plays = made(rams, rewards=rewards)
    assert [fact.name for fact in found(plays, at(300))] == ["player_x"]
    assert Comparison(plays, longest=STEPS).facts(at(300), low_score=285.0) == ()


def test_a_game_without_labels_has_bytes() -> None:
    rams = noise()
    rams[:, 300, 17] = 250
    rewards = np.ones((10, STEPS), np.int32)
    rewards[:, ::2] = 0
    rams[..., 90] = np.cumsum(rewards, axis=1) // 50  # a byte of the score
    rams[:, 300, 90] = 99
    plays = made(rams, rewards, labelled=False)
    assert not plays.labels.names
    assert [fact.name for fact in found(plays, at(300))] == ["byte 17"]


def test_places_of_two_kinds_are_told_apart() -> None:
    rams = noise(20)
    rams[:9, 300, INVADERS] = 1
    holds = Comparison(made(rams), longest=STEPS).cluster(at(300, 20), low_score=0.0)
    assert holds is not None
    assert holds.tolist() == [True] * 9 + [False] * 11
    rams[9:, 300, INVADERS] = 1
    assert Comparison(made(rams), longest=STEPS).cluster(at(300, 20), low_score=0.0) is None


def test_steps_that_stand_still_are_left_out() -> None:
    rams = noise()
    rams[:, 100:, INVADERS] = 7
    plays = made(rams, rewards=np.eye(1, STEPS, 0, dtype=np.int32).repeat(10, 0))
    assert [fact.name for fact in Comparison(plays, longest=90).facts(at(300), low_score=0.0, waits=False)] == [
        "invaders_left_count"
    ]
    assert found(plays, at(300), waits=False) == []


@pytest.mark.parametrize(
    ("fact", "text"),
    [
        (Fact("ball_x", 3, 3, 1.0, 0.0), "ball_x is 3 in 100 % (elsewhere in 0 %)"),
        (Fact("ball_x", None, None, 0.999, 0.001), "ball_x is visible in 99 % (elsewhere in less than 1 %)"),
        (Fact("byte 17", 1000, 2000, 0.5, 0.25), "byte 17 is 1,000 to 2,000 in 50 % (elsewhere in 25 %)"),
    ],
)
def test_words(fact: Fact, text: str) -> None:
    assert str(fact) == text
