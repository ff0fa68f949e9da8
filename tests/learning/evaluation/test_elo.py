"""Elo ratings against known values."""

from typing import Any

import numpy as np
import pytest

from atari.learning.evaluation.elo import elo_ratings


def test_two_players_have_the_odds_of_their_games() -> None:
    ratings = elo_ratings([[0, 10], [1, 0]], prior=0)
    assert ratings.values == pytest.approx([200, -200])
    # The variance of the difference of the logits is 1 / 10 + 1 / 1.
    assert ratings.errors == pytest.approx([0.5 * 1.1**0.5 * 400 / np.log(10)] * 2)


def test_expected_numbers_of_games_give_the_ratings_back() -> None:
    known = np.array([300.0, 50.0, -120.0, -230.0])
    chances = 1 / (1 + 10 ** ((known - known[:, None]) / 400))
    games = np.array([[0, 40, 8, 8], [40, 0, 90, 2], [8, 90, 0, 10], [8, 2, 10, 0]])
    assert elo_ratings(games * chances, prior=0).values == pytest.approx(known)


def test_draws_are_half_wins_and_equal_players_are_equal() -> None:
    assert elo_ratings([[0, 4, 4], [4, 0, 4], [4, 4, 0]]).values == pytest.approx([0, 0, 0])
    one, two = elo_ratings([[0, 2.5], [1.5, 0]], prior=0).values
    assert one - two == pytest.approx(400 * np.log10(2.5 / 1.5))


def test_the_prior_makes_ratings_finite() -> None:
    values = elo_ratings([[0, 10, 10], [0, 0, 10], [0, 0, 0]]).values
    assert np.isfinite(values).all()
    assert values[0] > values[1] > values[2] == -values[0]
    with pytest.raises(ValueError, match="infinite"):
        elo_ratings([[0, 10], [0, 0]], prior=0)
    pairs = np.kron(np.eye(2), [[0, 3], [2, 0]])
    for unlinked in (pairs, pairs + 4 * np.eye(4, k=3)):  # no game between two pairs, or wins of one pair only
        with pytest.raises(ValueError, match="infinite"):
            elo_ratings(unlinked, prior=0)
    assert np.isfinite(elo_ratings(pairs).values).all()


@pytest.mark.parametrize(
    "wins", [[], [[0]], [[0, 1]], [1, 2], [[1, 2], [3, 0]], [[0, -1], [1, 0]], [[0, float("nan")], [1, 0]]]
)
def test_what_is_no_table_of_wins(wins: Any) -> None:
    with pytest.raises(ValueError, match="wins must be"):
        elo_ratings(wins)
