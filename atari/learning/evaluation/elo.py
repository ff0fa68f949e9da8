"""`elo_ratings`: the strength of players, from the games that they won against each other."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_POINTS = 400 / np.log(10)
"""Elo points of a factor e in the odds of winning."""


@dataclass(frozen=True)
class EloRatings:
    """Ratings of some players.

    Attributes:
        values: (players,) float64, with a mean of 0. 400 points more are odds of 10 to 1.
        errors: standard errors of the values, (players,) float64.
    """

    values: Floats
    errors: Floats


def elo_ratings(wins: npt.ArrayLike, prior: float = 0.5, iterations: int = 100) -> EloRatings:
    """Fit Bradley and Terry's model (1952), by which i beats j with the probability 1 / (1 + 10 ** ((Rj - Ri) / 400)).

    Args:
        wins: (players, players), in row i the games that player i won against each other player; a draw counts half for
            both.
        prior: draws that are added between each two players. With 0, a player with wins or losses alone has an infinite
            rating, which is an error.
        iterations: the most steps of Newton's method.

    Raises:
        ValueError: `wins` is not square, has fewer than two rows, negative or infinite entries, or entries on its
            diagonal; or the ratings are infinite, or have not converged.

    Example:
        >>> from atari.learning.evaluation.elo import elo_ratings
        >>> elo_ratings([[0, 10], [1, 0]], prior=0).values.tolist()
        [200.0, -200.0]
    """
    won = np.array(wins, np.float64)
    if won.ndim != 2 or won.shape[0] != won.shape[1] or len(won) < 2:
        raise ValueError(f"wins must be square, with two rows or more, got the shape {won.shape}")
    if not np.isfinite(won).all() or (won < 0).any() or won.diagonal().any():
        raise ValueError("wins must be finite numbers of games, 0 or more, and 0 against oneself")
    won += prior / 2 * (1 - np.eye(len(won)))
    reach = won + np.eye(len(won)) > 0
    for _ in won:
        reach = reach @ reach
    if not reach.all():  # Ford (1957): from each player a chain of wins must lead to each other
        raise ValueError("the ratings are infinite: some players have won all games against the others; give prior > 0")
    games = won + won.T
    strengths = np.zeros(len(won))
    for _ in range(iterations):
        expected = 1 / (1 + np.exp(strengths - strengths[:, None]))  # probability that i beats j, (players, players)
        information = -games * expected * expected.T
        np.fill_diagonal(information, -information.sum(1))
        # A constant added to all strengths changes nothing; the mean of the step is 0.
        inverse = np.linalg.pinv(information, hermitian=True)
        step = inverse @ (won - games * expected).sum(1)
        strengths += np.clip(step, -2, 2)
        if np.abs(step).max() < 1e-10:
            return EloRatings(np.round(strengths * _POINTS, 9), np.sqrt(inverse.diagonal()) * _POINTS)
    raise ValueError(f"the ratings have not converged in {iterations} iterations; give more")
