"""`Replicas`: one network in several threads."""

import copy
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Generic, TypeVar

import torch
from torch import nn

Network = TypeVar("Network", bound=nn.Module)


class Replicas(Generic[Network]):
    """Copies of a network, one for each thread. They share weights, and each has its own gradients.

    PyTorch's own threads wait for each other in every layer, and take many times as long when another process is busy.
    Here each thread computes its share of a minibatch, and the threads wait once.

    Attributes:
        networks: the copies, whose weights and buffers are the memory of `network`.
    """

    def __init__(self, network: Network, count: int) -> None:
        self.network = network
        self.networks = [copy.deepcopy(network) for _ in range(count)]
        for replica in self.networks:
            for own, common in zip(_tensors(replica), _tensors(network), strict=True):
                own.data = common.data
        self._threads = ThreadPoolExecutor(count, initializer=torch.set_num_threads, initargs=(1,))

    def map(self, function: Callable[..., Any], *arguments: Iterable[Any]) -> list[Any]:
        """Call a function for each of the arguments, in parallel, and return the results in order."""
        return list(self._threads.map(function, *arguments))

    def average_gradients(self) -> None:
        """Give `network` the mean of the replicas' gradients, added in order, so that results reproduce."""
        replicas = zip(*(replica.parameters() for replica in self.networks), strict=True)
        for parameter, own in zip(self.network.parameters(), replicas, strict=True):
            gradients = [replica.grad for replica in own if replica.grad is not None]
            parameter.grad = sum(gradients[1:], start=gradients[0]) / len(own)

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown()


def _tensors(network: nn.Module) -> list[torch.Tensor]:
    return [*network.parameters(), *network.buffers()]
