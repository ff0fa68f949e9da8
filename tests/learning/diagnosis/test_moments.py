"""`moments_of` and `groups`: the moments of games, what is common in them, and the sentences about them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.lab.labels import labels_of
from atari.learning import PROTOCOLS, load_policy
from atari.learning.diagnosis.facts import Fact
from atari.learning.diagnosis.groups import Group, Losses, groups, words
from atari.learning.diagnosis.moments import Moment, last_chance, moments_of, unusual_steps
from atari.learning.diagnosis.plays import Play, Plays, play_games
from atari.learning.evaluation.played import played_task, resolve_games

EXAMPLES = Path(__file__).parents[3] / "examples"
LIVES = 73  # the byte of the lives of Space Invaders


def game(lives: list[int], first: int = 3, rewards: Any = (), truncated: bool = False, byte: Any = None) -> Play:
    """A game of Space Invaders from the lives after each step, the steps of its rewards, and its byte of the lives."""
    steps = len(lives)
    paid = np.zeros(steps, np.int32)
    paid[list(rewards)] = 10
    rams = np.zeros((steps, 128), np.uint8)
    rams[:, LIVES] = lives if byte is None else byte
    score = float(paid.sum())
    actions, own = np.zeros(steps, np.uint8), np.array(lives, np.int16)
    return Play(0, score, 4 * steps, truncated, first, actions, paid, own, rams, None, ())


def made(*games: Play) -> Plays:
    definition = atari.games["space_invaders"]
    names = tuple(action.name for action in definition.minimal_actions)
    fields: Any = {"task": None, "policy": None, "player": None}
    return Plays(actions=names, labels=labels_of(definition), epsilon=0.0, seed=0, games=games, **fields)


def kinds(*games: Play) -> list[tuple[int, int, str]]:
    return [(one.play, one.step, one.kind) for one in moments_of(made(*games))]


def played(source: Any, name: str, games: int, **changes: Any) -> Plays:
    policy, protocol = load_policy(source), replace(PROTOCOLS["dopamine"], name="mine", **changes)
    return play_games(policy, played_task(resolve_games(name)[0], protocol, policy), games, 0, epsilon=protocol.epsilon)


def test_lost_lives_and_the_end() -> None:
    assert kinds(game([3, 3, 2, 2, 1, 1, 0])) == [(0, 2, "life"), (0, 4, "life"), (0, 6, "end")]


def test_a_game_that_ends_with_lives_to_spare() -> None:
    assert kinds(game([3, 3, 2, 2, 0]), game([3, 2, 1, 0])) == [
        (0, 2, "life"),
        (0, 4, "spare"),
        (1, 1, "life"),
        (1, 2, "life"),
        (1, 3, "end"),
    ]


def test_the_games_own_byte_tells_that_the_last_life_is_not_lost() -> None:
    lost, kept = game([1, 1, 0], 1), game([1, 1, 0], 1, byte=[1, 1, 1])
    assert [kind for *_, kind in kinds(lost, kept)] == ["end", "spare"]
    assert [kind for *_, kind in kinds(kept, kept)] == ["end", "end"]  # it never changes at an end
    restarted = game([1, 1, 0], 1, byte=[1, 1, 3])  # a press has begun the next game
    assert [kind for *_, kind in kinds(lost, restarted)] == ["end", "end"]


def test_a_game_that_counts_lives_from_another_number() -> None:
    """As Amidar, whose lives are 11 down to 8, and 0 after a reset."""
    assert [kind for *_, kind in kinds(*[game([11, 10, 9, 8, 0], 0)] * 2)] == ["life", "life", "life", "end"] * 2


def test_a_game_without_lives_ends() -> None:
    assert kinds(game([0, 0, 0], 0)) == [(0, 2, "end")]


def test_the_limit_of_frames() -> None:
    assert kinds(game([3, 3, 3], truncated=True)) == [(0, 2, "limit")]


def test_a_plateau_is_longer_than_usual() -> None:
    usual = game([3] * 600 + [0], rewards=range(0, 600, 10))
    still = game([3] * 400 + [0], rewards=[*range(0, 100, 10), 350])
    plays = made(usual, still)
    assert unusual_steps(plays) == 100
    assert [one for one in moments_of(plays) if one.kind == "plateau"] == [Moment(1, 190, "plateau")]
    assert unusual_steps(made(game([3] * 40))) == 250  # without rewards
    dying = game([3] * 180 + [2] * 90 + [1] * 90 + [0], rewards=range(0, 100, 10))  # deaths are no stand-still
    assert "plateau" not in [one.kind for one in moments_of(made(usual, dying))]


def test_the_last_chance_comes_before_the_ball_is_out() -> None:
    plays = played("random", "breakout", 6)
    moments = [one for one in moments_of(plays) if one.kind in ("life", "end")]
    assert 2 <= last_chance(plays, moments) <= 64
    assert last_chance(plays, moments) == last_chance(plays, moments)


def test_the_groups_of_a_policy_that_does_nothing() -> None:
    plays = played("noop", "breakout", 8, max_frames=4 * 300, epsilon=0.0)
    found = groups(plays)
    assert [(one.kind, one.games, one.share, one.median) for one in found] == [
        ("limit", 8, 1.0, 0.0),
        ("plateau", 8, 1.0, 0.0),
    ]
    assert words(found[0], plays.labels.game) == "8 of 8 games reach the limit of frames, most at 0 points."
    assert words(found[1], plays.labels.game).startswith("8 of 8 games have no reward for 30")


def test_every_moment_is_in_one_group() -> None:
    plays = played("random", "space_invaders", 5)
    found = groups(plays)
    assert sorted((moment for group in found for moment in group.moments), key=str) == sorted(
        moments_of(plays), key=str
    )
    for group in found:
        assert {moment.kind for moment in group.moments} == {group.kind}
        assert group.games == len({moment.play for moment in group.moments})
        assert group.of_moments == sum(len(one.moments) for one in found if one.kind == group.kind)
        assert group.low <= group.median <= group.high or len(group.moments) > 2
        assert len(group.facts) <= 3
    assert found == groups(plays)


def test_what_the_policy_of_qbert_meets() -> None:
    pytest.importorskip("torch")
    plays = played(EXAMPLES / "qbert-pqn", "qbert", 6)
    end = groups(plays)[0]
    assert (end.kind, end.games) == ("end", 6)
    assert 8_000 <= end.low <= end.median <= end.high <= 8_300
    assert end.losses is not None
    assert end.losses.games >= 5
    assert end.losses.lives == 4
    assert end.losses.scores[0] >= 7_900
    assert end.losses.gained[1] <= 150
    assert 150 <= end.losses.steps[0] <= end.losses.steps[1] <= 400


def test_what_the_policy_of_space_invaders_meets() -> None:
    pytest.importorskip("torch")
    plays = played(EXAMPLES / "space_invaders-pqn", "space_invaders", 24)
    found = groups(plays)
    assert found[0].kind == "spare"
    assert found[0].share > 0.5
    facts = {fact.name: fact for fact in found[0].facts}
    assert 1 <= facts["invaders_left_count"].low <= facts["invaders_left_count"].high <= 6
    assert facts["invaders_left_count"].there > 0.6


def test_words_of_each_kind() -> None:
    space, breakout = atari.games["space_invaders"], atari.games["breakout"]
    moments = (Moment(0, 9, "life"), Moment(1, 9, "life"))
    fact = Fact("enemies_y", 131, 161, 0.85, 0.08)
    numbers = (2, 2, 10, 1175.0, 570.0, 1435.0)
    scores = "at 1,175 points (median; 80 % of them at 570 to 1,435)"

    def of(kind: Any, game: Any = space, **more: Any) -> str:
        return words(Group(kind, moments, *numbers, **more), game)

    assert of("spare", lives=((3, 1), (1, 1))) == (
        f"2 of 10 games end although the last life is not lost (1 with 3 lives, 1 with 1 life), {scores}."
    )
    assert of("end", before=1, facts=(fact,)) == (
        f"2 of 10 games end with the last life, {scores}; "
        "1 step before, enemies_y (top of the top row) is 131 to 161 in 85 % (elsewhere in 8 %)."
    )
    assert of("end", atari.games["pong"]).startswith("2 of 10 games end, at")
    losses = Losses(2, 4, (245, 325), (8025, 8050), (25, 25))
    assert of("end", losses=losses).endswith(
        "; in 2 of them no life is lost before 8,025 to 8,050 points, and then all 4 within 245 to 325 steps, for 25 points."
    )
    assert of("life") == f"2 lives before the last one are lost, in 2 of 10 games, {scores}."
    assert of("plateau", steps=(755, 14080)) == (f"2 of 10 games have no reward for 755 to 14,080 steps, {scores}.")
    one = Group("life", moments, 5, 2, 10, 3e6, 3e6, 3e6, before=8, facts=(Fact("ball_x", None, None, 1, 0, False),))
    assert words(one, breakout) == (
        "2 of 5 lives before the last one are lost like this, in 2 of 10 games, most at 3,000,000 points; "
        "8 steps before, ball_x is not visible in 100 % (elsewhere in 0 %)."
    )
    assert "2 of 5 lives before the last one are lost otherwise," in words(replace(one, facts=()), breakout)
