"""Variants of a task, which an evaluation plays beside it: other modes, difficulties, interventions and delays."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any

from atari.base.frozen import FrozenDict
from atari.base.validation import check_name
from atari.games.interventions import load
from atari.task import Task
from atari.task.fields import DEFAULTS, OF_GAME

DELAYS = (3, 6, 12)
"""The delays of variants, in emulated frames: 50, 100 and 200 milliseconds."""

AS_GIVEN = "as given"
"""The name of the task of which the others are variants."""

Changes = list[dict[str, Any]]


def _modes(task: Task) -> Changes:
    return [{"mode": mode} for mode in task.definition.modes]


def _difficulties(task: Task) -> Changes:
    return [{"difficulty": difficulty} for difficulty in task.definition.difficulties]


def _interventions(task: Task) -> Changes:
    """Each intervention of the package for the game, added to the interventions of the task."""
    others = (one for one in load(task.definition).values() if one not in task.interventions)
    return [{"interventions": (*task.interventions, one)} for one in others]


def _delays(task: Task) -> Changes:
    return [{name: frames} for name in ("action_delay", "observation_delay") for frames in DELAYS]


AXES: Mapping[str, Callable[[Task], Changes]] = FrozenDict(
    {"modes": _modes, "difficulties": _difficulties, "interventions": _interventions, "delays": _delays}
)
"""The changes of a task on each axis."""

Axes = tuple[tuple[str, ...], ...]
"""The axes of an evaluation; several in one tuple are a product."""


def find_axes(variants: str | Sequence[str]) -> Axes:
    """The axes of an argument: names of `AXES` with commas between, or a sequence of them; `*` joins a product.

    Raises:
        TypeError, ValueError: the argument is no text, an axis is not known, or one is named twice.
    """
    words = variants.split(",") if isinstance(variants, str) else variants
    if not isinstance(words, Sequence) or not words or not all(isinstance(word, str) for word in words):
        raise TypeError(f"variants must be axes, as in 'modes,difficulties' or 'modes*difficulties', got {variants!r}")
    axes: list[tuple[str, ...]] = []
    for word in words:
        names = tuple(check_name("an axis of variants", name.strip(), AXES) for name in word.split("*"))
        if len({*names}) < len(names) or {*names} in map(set, axes):
            raise ValueError(f"variants names {word.strip()!r} twice, or an axis twice in it; leave one of them out")
        axes.append(names)
    return tuple(axes)


def variants_of(task: Task, axes: Axes) -> tuple[Task, ...]:
    """The task, and its variants: one axis at a time, and products where several axes are joined; each task once.

    Raises:
        ValueError: there is no variant, two changes contradict each other, or the game has no file, so that results
            could not name their variants.
    """
    task.to_json()
    found = [task]
    for names in axes:
        for parts in product(*([{}, *AXES[name](task)] for name in names)):
            changed = task.replace(**{name: value for part in parts for name, value in part.items()})
            if changed not in found:
                found.append(changed)
    if len(found) == 1:
        listed = ", ".join("*".join(names) for names in axes)
        raise ValueError(f"{task.game} has no variants by {listed}; choose other axes of {', '.join(AXES)}")
    return tuple(found)


def variant_name(base: Mapping[str, Any], task: Mapping[str, Any]) -> str:
    """The name of a variant, such as "mode=1, difficulty=1", from both tasks as the objects of `Task.to_json`."""
    parts: list[str] = []
    for name in OF_GAME:
        own, usual = (one.get(name, DEFAULTS[name]) for one in (task, base))
        if own == usual:
            continue
        if name == "interventions" and isinstance(own, list):  # a file may have anything else
            added = [one for one in own if one not in (usual or [])]
            parts += [f"intervention={one['name'] if isinstance(one, dict) else one}" for one in added]
        else:
            parts.append(f"{name}={own}")
    return ", ".join(parts) or AS_GIVEN
