"""`TaskOptions`: the options of a task with their types, for editors and type checkers. `Task` describes each."""

from collections.abc import Sequence
from typing import Any

from atari.task.fields import SharedOptions


class TaskOptions(SharedOptions, total=False):
    """The options of `Task.of`."""

    mode: int | None
    difficulty: int | None


class VectorTaskOptions(SharedOptions, total=False):
    """The options of a task by `AtariVectorEnv`: modes and difficulties may be lists, and ale-py's names are added."""

    mode: int | Sequence[int | None] | None
    difficulty: int | Sequence[int | None] | None
    noop_max: int | None
    use_fire_reset: bool | None
    grayscale: bool | None


class MakeOptions(TaskOptions, total=False):
    """The options of `atari.make`: the options of a task, of an environment and of `gymnasium.make`."""

    render_mode: str | None
    core: str
    rom: Any
    disable_env_checker: bool | None
