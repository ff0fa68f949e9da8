"""`ridge_probe`: linear regressions of the labels, as numbers and as classes, in closed form."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.extras import import_extra, pip_install
from atari.cores import ByteArray
from atari.lab.probes.data import ProbeData, check_data
from atari.lab.probes.features import Encoder, features_of
from atari.lab.probes.results import ProbeResult, result_of

Floats = npt.NDArray[Any]

PENALTIES = (1.0, 100.0, 10_000.0)


def ridge_probe(encoder: Encoder, data: ProbeData) -> ProbeResult:
    """Predict each label from the features of an encoder by ridge regression, to measure how linearly readable it is.

    R2 is that of the label as a number. For F1 the label is a class: a regression predicts 1 for its value and 0 for
    all others, and the value with the highest prediction is taken. Features are standardised. Each label has that
    penalty of 1, 100 and 10,000 that is best in validation. Nothing is drawn, and no training stops too early, so that
    encoders with thousands of features compare fairly with small ones. `probe` has F1 scores as in AtariARI's paper.

    Args:
        encoder: a function of observations (n, ...) uint8 that returns features, n rows of numbers: an array or a
            tensor, which is flattened to (n, features), such as the method `features` of a loaded policy.
        data: the result of `split_episodes`.

    Returns:
        A `ProbeResult`: `r2`, `f1` and `accuracy` of each label; and `table()`, which prints.

    Raises:
        TypeError, ValueError: `data` is something else, or the encoder returns no features.
        gymnasium.error.DependencyNotInstalled: scikit-learn is not installed.

    Example:
        >>> from atari.lab.probes import play_episodes, ridge_probe, split_episodes
        >>> episodes = play_episodes("breakout", 3000, img_height=21, img_width=21, stack_num=1)
        >>> result = ridge_probe(lambda images: images, split_episodes(episodes, "breakout"))
        >>> result.r2["player_x"] > 0.9
        True
    """
    check_data(data)
    linear, metrics, preprocessing = map(_sklearn, ("linear_model", "metrics", "preprocessing"))
    scale = preprocessing.StandardScaler()
    train = scale.fit_transform(features_of(encoder, data.train))
    validation, test = (scale.transform(features_of(encoder, split)) for split in (data.validation, data.test))
    values = [np.unique(column) for column in data.train.labels.T]
    targets = _targets(data.train.labels, values)
    r2, tested, hits, guesses = [], [], [], []
    for penalty in PENALTIES:
        fitted = linear.Ridge(penalty).fit(train, targets)
        numbers, classes = _decoded(fitted.predict(validation), values)
        r2.append(metrics.r2_score(data.validation.labels, numbers, multioutput="raw_values"))
        hits.append((classes == data.validation.labels).mean(0))
        numbers, classes = _decoded(fitted.predict(test), values)
        tested.append(metrics.r2_score(data.test.labels, numbers, multioutput="raw_values"))
        guesses.append(classes.T)
    labels = range(len(values))
    return result_of(
        data,
        np.array(guesses)[np.argmax(hits, axis=0), labels].T,
        np.array(tested)[np.argmax(r2, axis=0), labels],
    )


def _sklearn(module: str) -> Any:
    return import_extra(f"sklearn.{module}", f"ridge_probe needs scikit-learn: {pip_install('scikit-learn')}")


def _targets(labels: ByteArray, values: Sequence[ByteArray]) -> Floats:
    """The numbers that are predicted: each label, then 0 or 1 for each of its values."""
    each = [column[:, None] == own for column, own in zip(labels.T, values, strict=True)]
    return np.concatenate([labels, *each], 1, dtype=np.float32)


def _decoded(predicted: Floats, values: Sequence[ByteArray]) -> tuple[Floats, npt.NDArray[np.int64]]:
    """The labels as numbers and as classes, (n, labels) both, in predictions of `_targets`."""
    counts = [len(values), *map(len, values)]
    numbers, *each = np.split(predicted, np.cumsum(counts)[:-1], axis=1)
    classes = [own[part.argmax(1)] for own, part in zip(values, each, strict=True)]
    return numbers, np.stack(classes, 1).astype(np.int64)
