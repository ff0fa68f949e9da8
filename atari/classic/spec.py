"""`Spec`: the fields of a registry entry."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar


@dataclass(frozen=True, repr=False)
class Spec:
    """The fields of a registry entry; `EnvSpec` adds `make`.

    `max_episode_steps` is the time limit, None if there is none. `reward_threshold` is the mean return from which the
    task counts as solved, None if unknown. `nondeterministic` says whether episodes differ despite equal seeds.
    `order_enforce` has no effect: a step before the first reset is always an error.
    """

    id: str
    entry_point: str | Callable[..., Any] | None = None
    reward_threshold: float | None = None
    nondeterministic: bool = False
    max_episode_steps: int | None = None
    order_enforce: bool = True
    kwargs: dict[str, Any] = field(default_factory=dict, compare=False)

    autoreset: ClassVar[bool] = False
    """The fields of Gym 0.26 and 0.7 that no environment here has."""
    apply_api_compatibility: ClassVar[bool] = False
    disable_env_checker: ClassVar[bool] = False
    max_episode_seconds: ClassVar[float | None] = None
    trials: ClassVar[int] = 100

    @property
    def namespace(self) -> str | None:
        """The part of the ID before a slash; None if there is none."""
        return self.id.rpartition("/")[0] or None

    @property
    def name(self) -> str:
        """The ID without namespace and version."""
        return self.id.rpartition("/")[2].rpartition("-v")[0]

    @property
    def version(self) -> int:
        """The number after "-v"."""
        return int(self.id.rpartition("-v")[2])

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
