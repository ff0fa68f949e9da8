"""Progress bars on stderr."""

from tqdm import tqdm


class ProgressBar(tqdm):  # type: ignore[type-arg]  # it has no type parameter at run time
    """A bar that stays at 100 % when there is more than was expected: the last update or action may be a long one."""

    def update(self, n: float | None = 1) -> bool | None:
        """Advance by `n`."""
        if self.total is not None and n and self.n + n > self.total:
            self.total = self.n + n
        return super().update(n)
