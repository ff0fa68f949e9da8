"""`Spec`: the fields of a registry entry."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, repr=False)
class Spec:
    """The fields of a registry entry; `EnvSpec` adds `make`.

    `max_episode_steps` is the time limit, None if there is none. `reward_threshold` is the mean return from which the
    task counts as solved, None if unknown. `nondeterministic` says whether episodes differ despite equal seeds.
    """

    id: str
    entry_point: str | Callable[..., Any] | None = None
    reward_threshold: float | None = None
    nondeterministic: bool = False
    max_episode_steps: int | None = None
    kwargs: dict[str, Any] = field(default_factory=dict, compare=False)

    @property
    def timestep_limit(self) -> int | None:
        """`max_episode_steps` under its name of 2016."""
        return self.max_episode_steps

    @property
    def tags(self) -> dict[str, Any]:
        """The time limit in the form that scripts of 2016 read."""
        return {"wrapper_config.TimeLimit.max_episode_steps": self.max_episode_steps}

    @property
    def _kwargs(self) -> dict[str, Any]:  # `kwargs` and `entry_point` under their names until 2019
        return self.kwargs

    @property
    def _entry_point(self) -> "str | Callable[..., Any] | None":
        return self.entry_point

    def __repr__(self) -> str:
        return f"EnvSpec({self.id})"
