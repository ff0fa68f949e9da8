"""`resolve_with_names`: a task whose actions an agent names, with any preset."""

from collections.abc import Callable, Mapping
from typing import Any

from atari.task import Task
from atari.task.fields import check_actions


def resolve_with_names(resolve: Callable[[dict[str, Any]], Task], options: Mapping[str, Any]) -> Task:
    """The task of options, whose `actions` may be names of some that the task has otherwise.

    An agent that uses some of the actions plays the same game. So it goes with a preset that requires all of them.

    Args:
        resolve: returns the task of options.
        options: fields of `Task`.

    Raises:
        TypeError, ValueError: as `resolve`.
    """
    names = options.get("actions")
    if names is None or isinstance(names, str):
        return resolve(dict(options))
    chosen = check_actions("actions", names)
    task = resolve({name: value for name, value in options.items() if name != "actions"})
    if set(chosen) <= {action.name for action in task.action_set}:
        return task.replace(actions=chosen)
    return resolve(dict(options))
