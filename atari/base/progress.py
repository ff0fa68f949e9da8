"""Progress bars on stderr."""

from typing import Any

from tqdm import tqdm


class ProgressBar(tqdm):  # type: ignore[misc]  # tqdm has no types
    """A bar that stays at 100 % when there is more than was expected: the last update or action may be a long one.

    It has the width of the terminal, also after the terminal has changed, and breaks no word at the edge.
    """

    n: float
    total: float | None

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, dynamic_ncols=True, **options)

    def update(self, n: float | None = 1) -> Any:
        """Advance by `n`."""
        if self.total is not None and n and self.n + n > self.total:
            self.total = self.n + n
        return super().update(n)

    @staticmethod
    def format_meter(*args: Any, postfix: Any = None, unit: str = "it", **facts: Any) -> str:
        """The line; without `postfix` if tqdm would cut it. Where a step is slow, it has the seconds of one game."""
        line = tqdm.format_meter(*args, postfix=postfix, unit=unit, **facts)
        whole = not postfix or line.endswith("]")
        line = str(line if whole else tqdm.format_meter(*args, unit=unit, **facts))
        return line.replace(f"s/{unit}", f"s/{unit.strip().removesuffix('s')}")
