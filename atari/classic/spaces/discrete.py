"""`Discrete`: one of n integers."""

import gymnasium


class Discrete(gymnasium.spaces.Discrete):
    """The integers 0 to n - 1."""

    def __init__(self, n: int) -> None:
        super().__init__(n)

    def __repr__(self) -> str:
        return f"Discrete({self.n})"
