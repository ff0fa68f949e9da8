"""`Dict`: elements of several spaces, by name."""

from typing import Any

import gymnasium


class Dict(gymnasium.spaces.Dict):
    """Dictionaries with an element of each space; the spaces are given as a dictionary, as pairs, or by keyword."""

    def __init__(self, spaces: Any = None, seed: Any = None, **spaces_kwargs: gymnasium.Space[Any]) -> None:
        super().__init__(spaces_kwargs if spaces is None else spaces, seed)

    def __repr__(self) -> str:
        return f"Dict({', '.join(f'{name}:{space}' for name, space in self.spaces.items())})"
