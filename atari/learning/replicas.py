"""`Replicas`: a network that learns in several threads."""

import copy
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Generic, TypeVar

import torch
from torch import nn

from atari.base.validation import check_integer
from atari.learning.options import MOST_WORKERS

Network = TypeVar("Network", bound=nn.Module)


class Replicas(Generic[Network]):
    """One network in several threads: copies that share the weights, each with gradients of its own.

    PyTorch's own threads wait for each other in every layer, so that a busy process beside them slows all.
    Here each thread computes its share of a minibatch, and the threads wait once.

    Args:
        network: the network.
        count: the number of copies, within 1..1024; a single one is the network itself, without a thread.

    Attributes:
        networks: the copies, whose weights and buffers are the memory of `network`.

    Raises:
        TypeError, ValueError: `network` is no module of PyTorch, or `count` is no integer of the range.

    Example:
        >>> import torch
        >>> from atari.learning import Replicas
        >>> replicas = Replicas(torch.nn.Linear(3, 1), 2)
        >>> shares = torch.ones(8, 3).chunk(2)
        >>> losses = replicas.map(lambda copy, share: copy(share).mean().backward(), replicas.networks, shares)
        >>> replicas.average_gradients()
        >>> replicas.network.weight.grad
        tensor([[1., 1., 1.]])
        >>> replicas.close()
    """

    def __init__(self, network: Network, count: int) -> None:
        if not isinstance(network, nn.Module):
            raise TypeError(f"network must be a torch.nn.Module, got {network!r:.80}")
        count = check_integer("count", count, 1, MOST_WORKERS)
        self.network = network
        self.networks = [network] if count == 1 else [copy.deepcopy(network) for _ in range(count)]
        for replica in self.networks:
            for own, common in zip(_tensors(replica), _tensors(network), strict=True):
                own.data = common.data
        self._threads: ThreadPoolExecutor | None = None
        if count > 1:
            self._threads = ThreadPoolExecutor(count, initializer=torch.set_num_threads, initargs=(1,))

    def __reduce__(self) -> Any:  # threads cannot be copied
        return Replicas, (self.network, len(self.networks))

    def map(self, function: Callable[..., Any], *arguments: Iterable[Any]) -> list[Any]:
        """Call a function for each of the arguments, in parallel, and return the results in order."""
        return list(map(function, *arguments) if self._threads is None else self._threads.map(function, *arguments))

    def average_gradients(self) -> None:
        """Give `network` the mean of the replicas' gradients, added in order, so that results reproduce."""
        if self._threads is None:
            return
        replicas = zip(*(replica.parameters() for replica in self.networks), strict=True)
        for parameter, own in zip(self.network.parameters(), replicas, strict=True):
            gradients = [replica.grad for replica in own if replica.grad is not None]
            parameter.grad = sum(gradients[1:], start=gradients[0]) / len(own)

    def close(self) -> None:
        """End the threads."""
        if self._threads is not None:
            self._threads.shutdown()


def _tensors(network: nn.Module) -> list[torch.Tensor]:
    return [*network.parameters(), *network.buffers()]
