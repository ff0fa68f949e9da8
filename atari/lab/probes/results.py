"""`ProbeResult`: the scores of a probe by label and category; `probe_table` puts several beside each other."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.text_table import Table
from atari.lab.atari_ari import CATEGORIES, categories
from atari.lab.probes.data import ProbeData

Scores = Mapping[str, float]


@dataclass(frozen=True)
class ProbeResult:
    """The scores on the test states by label.

    Attributes:
        f1, accuracy: of the classifiers, 0..1; F1 is weighted over the values.
        r2: R2 of the regressions, at most 1, and 0 for one that always predicts the mean; empty without regressions.
        left_out: the labels without scores, because their bytes hardly change.
    """

    f1: Scores
    accuracy: Scores
    r2: Scores = field(default_factory=dict)
    left_out: tuple[str, ...] = ()

    @property
    def category_f1(self) -> dict[str, float]:
        """The mean of the F1 scores of the labels in each of AtariARI's categories that has any."""
        return _by_category(self.f1)

    @property
    def mean_f1(self) -> float:
        """The mean over the categories."""
        return _mean(self.f1)

    def table(self) -> Table:
        """R2 and the F1 score of each label and category; it prints, and shows in notebooks."""
        return probe_table({"": self})

    def __str__(self) -> str:
        return str(self.table())

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


def probe_table(results: Mapping[str, ProbeResult]) -> Table:
    """R2 and the F1 scores of several encoders beside each other, by label and category.

    Args:
        results: results of `ridge_probe`, `probe` or `majority` on the same data, by a name for each encoder.

    Returns:
        A table, which prints, and shows in notebooks. A line below it names the labels that were left out.

    Raises:
        ValueError: there is no result, or the results are of different labels.

    Example:
        >>> from atari.lab.probes import majority, play_episodes, probe_table, split_episodes
        >>> episodes = play_episodes("breakout", 3000, img_height=21, img_width=21, stack_num=1)
        >>> result = majority(split_episodes(episodes, "breakout"))
        >>> probe_table({"one": result, "other": result}).columns
        ('label', 'category', 'F1 one', 'F1 other')
    """
    labels = [tuple(one.f1) for one in results.values()]
    if not labels or labels.count(labels[0]) < len(labels):
        raise ValueError(f"results must be of the same data, and at least one, got the labels {labels!r:.200}")
    columns = {f"R2 {name}".strip(): one.r2 for name, one in results.items() if one.r2}
    columns |= {f"F1 {name}".strip(): one.f1 for name, one in results.items()}
    rows: list[tuple[Any, ...]] = [
        (name, ", ".join(categories(name)), *(f"{scores[name]:.3f}" for scores in columns.values()))
        for name in labels[0]
    ]
    means = [{**_by_category(scores), "all categories": _mean(scores)} for scores in columns.values()]
    rows += [("mean", category, *(f"{mean[category]:.3f}" for mean in means)) for category in means[0]]
    left_out = ", ".join(next(iter(results.values())).left_out)
    note = f"left out, because their bytes hardly change: {left_out}" if left_out else ""
    return Table.of(("label", "category", *columns), rows, note)


def result_of(data: ProbeData, predicted: npt.NDArray[Any], r2: npt.NDArray[Any] | None = None) -> ProbeResult:
    """The scores of predicted labels (n, labels) in the test, and R2 (labels,)."""
    columns = list(zip(data.names, predicted.T, data.test.labels.T, strict=True))
    return ProbeResult(
        f1={name: weighted_f1(guesses, truth.astype(np.int64)) for name, guesses, truth in columns},
        accuracy={name: float((guesses == truth).mean()) for name, guesses, truth in columns},
        r2={} if r2 is None else dict(zip(data.names, r2.tolist(), strict=True)),
        left_out=tuple(name for name in data.entropies if name not in data.names),
    )


def weighted_f1(predicted: npt.NDArray[Any], truth: npt.NDArray[Any]) -> float:
    """The F1 scores of the classes 0..255, weighted by how often each is true."""
    counts = [np.bincount(x, minlength=256) for x in (predicted[predicted == truth], predicted, truth)]
    hits, guesses, support = counts
    scores = 2 * hits / np.maximum(guesses + support, 1)
    return float((scores * support).sum() / support.sum())


def _by_category(scores: Scores) -> dict[str, float]:
    """The mean over the labels of each category that has any."""
    found = {category: [scores[name] for name in scores if category in categories(name)] for category in CATEGORIES}
    return {category: float(np.mean(own)) for category, own in found.items() if own}


def _mean(scores: Scores) -> float:
    """The mean over the categories; over the labels if none has a category."""
    return float(np.mean(list(_by_category(scores).values()) or list(scores.values())))
