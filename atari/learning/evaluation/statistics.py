"""Summaries of scores over games and runs, with bootstrap intervals (Agarwal et al. 2021, arXiv 2108.13264).

Scores are a mapping from game to the normalised scores of its runs, (runs,) float64. Games may have different numbers
of runs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from atari.learning.evaluation.published import read_table

Floats = npt.NDArray[np.float64]
Scores = Mapping[str, Floats]
References = Mapping[str, tuple[float, float]]
"""By game, the score of random play and of a human."""


@dataclass(frozen=True)
class Estimate:
    """A number with the limits of its interval of 95 %, None where there are too few scores to draw from."""

    value: float
    low: float | None = None
    high: float | None = None

    def __str__(self) -> str:
        return format(self, ".3f")

    def __format__(self, spec: str) -> str:
        """The number and its limits, each by the format of a number."""
        interval = "" if self.low is None or self.high is None else f" [{self.low:{spec}}, {self.high:{spec}}]"
        return f"{self.value:{spec}}{interval}"


def mean_estimate(values: Sequence[float] | Floats, repetitions: int = 2000, seed: int = 0) -> Estimate:
    """The mean of values, with the interval of a bootstrap; there is none for one value."""
    every = np.asarray(values, np.float64)
    if len(every) < 2:
        return Estimate(float(every.mean()))
    drawn = _means_drawn_again(every, repetitions, np.random.default_rng(seed))
    return Estimate(float(every.mean()), *map(float, np.percentile(drawn, (2.5, 97.5))))


def human_normalised(scores: Scores, references: References) -> dict[str, Floats]:
    """Human-normalised scores by game: random play is 0, a human 1."""
    return {game: (scores[game] - random) / (human - random) for game, (random, human) in references.items()}


def interquartile_mean(values: Floats) -> Floats:
    """The mean of the middle half of the last axis, without floor(n / 4) values at either end, as SciPy's trim_mean."""
    cut = values.shape[-1] // 4
    return np.sort(values, axis=-1)[..., cut : values.shape[-1] - cut].mean(-1)


def summaries(means: Floats, pooled: Floats) -> dict[str, Floats]:
    """Median and mean over games (..., games), and the interquartile mean over games and runs (..., all runs)."""
    return {"median": np.median(means, -1), "mean": means.mean(-1), "iqm": interquartile_mean(pooled)}


def estimate_of_runs(scores: Scores, repetitions: int, seed: int) -> dict[str, Estimate]:
    """Median, mean and IQM of several runs. The bootstrap, stratified by game, draws runs again for the intervals.

    There are no intervals if no game has two runs.
    """
    generator = np.random.default_rng(seed)
    drawn = [runs[generator.integers(len(runs), size=(repetitions, len(runs)))] for runs in scores.values()]
    return _estimates(list(scores.values()), drawn if _several(scores) else None)


def estimate_of_episodes(episodes: Scores, repetitions: int, seed: int) -> dict[str, Estimate]:
    """Median, mean and IQM over games of one run, from its episodes by game, which the bootstrap draws again.

    The intervals are about this policy, not about another training. There are none if no game has two episodes.
    """
    generator = np.random.default_rng(seed)
    drawn = [_means_drawn_again(scores, repetitions, generator) for scores in episodes.values()]
    return _estimates(
        [scores.mean(keepdims=True) for scores in episodes.values()], drawn if _several(episodes) else None
    )


def _several(scores: Scores) -> bool:
    return any(len(values) > 1 for values in scores.values())


_MOST_DRAWN = 1 << 20
"""Values that are drawn at a time."""


def _means_drawn_again(values: Floats, repetitions: int, generator: np.random.Generator) -> Floats:
    """Means of drawings with replacement of all values, (repetitions, 1)."""
    means = np.empty((repetitions, 1))
    rows = max(1, _MOST_DRAWN // len(values))
    for first in range(0, repetitions, rows):  # not all at once: there may be a million episodes
        part = means[first : first + rows]
        part[:, 0] = values[generator.integers(len(values), size=(len(part), len(values)))].mean(-1)
    return means


def _estimates(runs: list[Floats], drawn: list[Floats] | None) -> dict[str, Estimate]:
    """Estimates from the runs of each game, (runs,), with intervals from the drawn runs, (repetitions, runs)."""
    values = summaries(np.array([one.mean() for one in runs]), np.concatenate(runs))
    if drawn is None:
        return {name: Estimate(float(value)) for name, value in values.items()}
    again = summaries(np.stack([one.mean(-1) for one in drawn], -1), np.concatenate(drawn, -1))
    limits = {name: np.percentile(several, (2.5, 97.5)) for name, several in again.items()}
    return {name: Estimate(float(value), *map(float, limits[name])) for name, value in values.items()}


def atari5_estimate(scores: Scores) -> float:
    """The median over 57 games that Atari-5 predicts from its five (Aitchison et al. 2023, arXiv 2210.02019).

    The model is linear in logarithms of percent, without an intercept; its relative error is about 10 %.
    """
    coefficients: Mapping[str, float] = read_table("atari5")
    logarithms = (
        weight * np.log10(1 + 100 * max(0.0, float(scores[game].mean()))) for game, weight in coefficients.items()
    )
    return float(10 ** sum(logarithms) - 1) / 100


def profile(scores: Scores, thresholds: Floats) -> Floats:
    """The fraction of runs, each game with the same weight, whose score is above each threshold, (thresholds,)."""
    return np.mean([(runs[:, None] > thresholds).mean(0) for runs in scores.values()], axis=0)
