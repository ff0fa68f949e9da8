"""`Graph`: graphs with elements of two spaces at their nodes and edges."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import GraphInstance, Space
from gymnasium.vector.utils import batch_space

__all__ = ["Graph", "GraphInstance"]


class Graph(gymnasium.spaces.Graph):
    """Graphs, as tuples `GraphInstance` of nodes, edges and the two nodes of each edge."""

    def sample(  # type: ignore[override]
        self, mask: Any = None, num_nodes: int = 10, num_edges: int | None = None, probability: Any = None
    ) -> GraphInstance:
        """Draw a graph.

        Args:
            mask: masks of the node space and the edge space, for spaces that have masks.
            num_nodes: the number of nodes, 1 or more.
            num_edges: the number of edges; None draws it.
            probability: probabilities of the elements of both spaces, instead of masks.
        """
        if mask is not None or probability is not None:
            options = {} if probability is None else {"probability": probability}  # before 1.0 there were none
            return super().sample(mask=mask, num_nodes=num_nodes, num_edges=num_edges, **options)
        if num_nodes < 1:
            raise ValueError(f"a graph has 1 node or more, got num_nodes={num_nodes}")
        most = num_nodes * (num_nodes - 1)
        count = num_edges if num_edges is not None else int(self.np_random.integers(most)) if most else 0
        nodes: Any = self._generate_sample_space(self.node_space, num_nodes)
        edges = self._generate_sample_space(self.edge_space, count)
        return GraphInstance(
            nodes.sample(),
            None if edges is None else edges.sample(),
            None if edges is None else self.np_random.integers(0, num_nodes, (count, 2), np.int32),
        )

    def _generate_sample_space(self, base_space: Space[Any] | None, num: int) -> Space[Any] | None:
        """The space of `num` elements; None for none."""
        if base_space is None or num == 0:
            return None
        space = batch_space(base_space, num)
        space.seed(int(self.np_random.integers(2**31)))  # else all graphs had the same nodes
        return space
