"""`probe`: AtariARI's training of the linear classifiers."""

from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.extras import import_extra, install_extra
from atari.base.validation import check_integer
from atari.lab.probes.data import ProbeData, check_data
from atari.lab.probes.features import Encoder, features_of
from atari.lab.probes.results import ProbeResult, result_of

CLASSES = 256
_BATCH = 256


def probe(
    encoder: Encoder,
    data: ProbeData,
    *,
    epochs: int = 100,
    patience: int = 15,
    batch_size: int = 64,
    learning_rate: float = 5e-4,
    seed: int = 0,
) -> ProbeResult:
    """Train a linear classifier for each label on the features of an encoder, and test it.

    Each classifier is trained by Adam on the cross entropy. It keeps the weights of the epoch with the best accuracy in
    validation, and stops after `patience` epochs without a better one, or after `epochs`. The encoder is not trained.

    Args:
        encoder: a function of observations (n, ...) uint8 that returns features, n rows of numbers: an array or a
            tensor, which is flattened to (n, features).
        data: the result of `split_episodes`.
        epochs, patience, batch_size, learning_rate: options of the training; the defaults are AtariARI's.
        seed: seed of the weights and the batches; equal seeds give equal results on one machine.

    Returns:
        A `ProbeResult`: `f1` and `accuracy` of each label, 0..1, weighted over its values; `category_f1`, the mean of
        each of AtariARI's categories; `mean_f1`, the mean over the categories; and `table()`, which prints.

    Raises:
        TypeError, ValueError: a number is out of range, or the encoder returns no features.
        gymnasium.error.DependencyNotInstalled: PyTorch is not installed.

    Example:
        >>> from atari.lab.probes import play_episodes, probe, split_episodes
        >>> episodes = play_episodes("breakout", 3000, img_height=21, img_width=21, stack_num=1)
        >>> data = split_episodes(episodes, "breakout")
        >>> result = probe(lambda images: images.mean(axis=2) / 255, data, epochs=1)
        >>> 0 <= result.mean_f1 <= 1
        True
    """
    check_data(data)
    for name, value in (("epochs", epochs), ("patience", patience), ("batch_size", batch_size)):
        check_integer(name, value, 1, 2**31)
    torch = import_extra("torch", f"probes need PyTorch: {install_extra('learn')}")
    features = [torch.from_numpy(features_of(encoder, split)) for split in (data.train, data.validation, data.test)]
    generator = torch.Generator().manual_seed(seed)
    training = _Training(torch, features[0].shape[1], len(data.names), learning_rate, generator)
    inputs, targets = features[0], torch.from_numpy(data.train.labels).long()
    for _ in range(epochs):
        for rows in torch.randperm(len(inputs), generator=generator).split(batch_size):
            training.step(inputs[rows], targets[rows])
        accuracy = (training.predict(features[1]) == data.validation.labels).mean(0)
        if not training.keep_best(accuracy, patience):
            break
    training.restore_best()
    return result_of(data, training.predict(features[2]))


def majority(data: ProbeData) -> ProbeResult:
    """The `ProbeResult` of predicting the most frequent value in training, whatever the observation.

    Example:
        >>> from atari.lab.probes import majority, play_episodes, split_episodes
        >>> episodes = play_episodes("breakout", 3000, img_height=21, img_width=21, stack_num=1)
        >>> data = split_episodes(episodes, "breakout")
        >>> 0 < majority(data).mean_f1 < 1
        True
    """
    check_data(data)
    most = [np.bincount(column, minlength=CLASSES).argmax() for column in data.train.labels.T]
    return result_of(data, np.tile(np.array(most), (len(data.test), 1)))


class _Training:
    """The classifiers of all labels in one linear layer. Adam treats each weight alone, so they do not mix."""

    def __init__(self, torch: Any, width: int, labels: int, learning_rate: float, generator: Any) -> None:
        self._torch, self._labels = torch, labels
        bound = width**-0.5
        self._weight = ((torch.rand(labels * CLASSES, width, generator=generator) * 2 - 1) * bound).requires_grad_()
        self._bias = ((torch.rand(labels * CLASSES, generator=generator) * 2 - 1) * bound).requires_grad_()
        self._optimizer = torch.optim.Adam([self._weight, self._bias], lr=learning_rate, eps=1e-5)
        self._best = self._weight.detach().clone(), self._bias.detach().clone()
        self._accuracy = np.full(labels, -1.0)
        self._waited = np.zeros(labels, np.int64)
        self._stopped = np.zeros(labels, np.bool_)

    def logits(self, features: Any) -> Any:
        product = self._torch.nn.functional.linear(features, self._weight, self._bias)
        return product.reshape(len(features), self._labels, CLASSES)

    def step(self, features: Any, targets: Any) -> None:
        loss = self._torch.nn.functional.cross_entropy(self.logits(features).flatten(0, 1), targets.flatten())
        self._optimizer.zero_grad()
        loss.backward()
        self._optimizer.step()

    def predict(self, features: Any) -> npt.NDArray[np.int64]:
        with self._torch.no_grad():
            parts = [self.logits(part).argmax(2) for part in features.split(_BATCH)]
        return self._torch.cat(parts).numpy()

    def keep_best(self, accuracy: npt.NDArray[np.float64], patience: int) -> bool:
        """Keep the weights of labels with a better accuracy; return whether a label is still trained."""
        better = ~self._stopped & (accuracy > self._accuracy)
        self._accuracy[better] = accuracy[better]
        self._waited = np.where(better, 0, self._waited + 1)
        self._stopped |= self._waited >= patience
        rows = self._torch.from_numpy(better).repeat_interleave(CLASSES)
        for best, now in zip(self._best, (self._weight, self._bias), strict=True):
            best[rows] = now.detach()[rows]
        return not self._stopped.all()

    def restore_best(self) -> None:
        self._weight, self._bias = self._best
