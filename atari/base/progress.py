"""Progress bars on stderr."""

from typing import Any

from tqdm import tqdm


class ProgressBar(tqdm):  # type: ignore[misc]  # tqdm has no types
    """A bar that stays at 100 % when there is more than was expected: the last update or action may be a long one."""

    n: float
    total: float | None

    def update(self, n: float | None = 1) -> Any:
        """Advance by `n`."""
        if self.total is not None and n and self.n + n > self.total:
            self.total = self.n + n
        return super().update(n)
