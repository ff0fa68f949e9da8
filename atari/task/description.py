"""A `Task` in words, as a table."""

from collections.abc import Mapping
from typing import Any

from atari.base.text_table import fact_lines
from atari.games.catalog import playable_ids
from atari.games.players import rules_of
from atari.task import env_ids
from atari.task.data import TaskData
from atari.task.fields import DEFAULTS, GROUPS, ROWS, Group
from atari.task.presets import PRESETS
from atari.task.resolution import fields_of, fields_of_id


def describe(task: TaskData) -> str:
    """The nearest ID and preset in the first line, then a table of all that the task decides."""
    return "\n".join([summary(task), *(line for name, text in facts(task) for line in fact_lines(name, [text]))])


def facts(task: TaskData) -> list[tuple[str, str]]:
    """All that the task decides, by name."""
    rows = [
        ("observation", _observation(task)),
        ("frame skip", skip_text(task.frameskip)),
        ("sticky", sticky_text(task.repeat_action_probability)),
        ("actions", _actions(task)),
        ("begin", _begin(task)),
        ("lives", _lives(task)),
        ("limit", _limit(task)),
        ("reward", _reward(task)),
        ("mode", _mode(task)),
    ]
    if task.interventions:
        rows.append(("changed by", ", ".join(one.name for one in task.interventions)))
    if task.seeding == "ale":
        rows.append(("seeds", "as in ale-py's vector environment"))
    return rows


def summary(task: TaskData) -> str:
    """The task in a line: the game, the nearest ID or preset, and what differs from it.

    Example:
        >>> import atari
        >>> from atari.task.description import summary
        >>> summary(atari.Task.of("pong", preset="dqn2015", frameskip=3))
        "pong: Pong, as 'pong' with preset='dqn2015', but frameskip=3"
    """
    title = f"{task.game}: {task.definition.title}"
    if task.players > 1:
        return f"{title}, {task.players} players"
    name, near = min(_named(task).items(), key=lambda item: len(_changed(task, item[1])))
    changed = _changed(task, near)
    if "interventions" in changed:  # a user gives their names; the definitions are long
        changed["interventions"] = [one.name for one in task.interventions]
    but = ", ".join(f"{field}={value!r}" for field, value in changed.items())
    return f"{title}, as {name}" + (f", but {but}" if but else "")


def _changed(task: TaskData, other: TaskData) -> dict[str, Any]:
    """The fields that differ from another task of the game, with this task's values as a user would give them."""
    fields = task.as_options()
    return {name: fields[name] for name in fields if getattr(task, name) != getattr(other, name)}


def _named(task: TaskData) -> dict[str, TaskData]:
    """The tasks of the game that have a name: by its IDs, and by presets."""
    if task.definition.file is not None or task.game not in playable_ids():
        return {f"{task.game!r}": TaskData(**fields_of(task.definition, None, {}))}
    families = sorted(env_ids.FAMILIES, key=lambda family: -family.version)  # the newest first
    known = [family.id(task.game) for family in families if task.game in family.games()]
    named = {env_id: TaskData(**fields_of(task.definition, None, {}, fields_of_id(env_id)[1])) for env_id in known}
    for preset in PRESETS:
        try:
            named[f"{task.game!r} with preset={preset!r}"] = TaskData(**fields_of(task.definition, preset, {}))
        except ValueError:  # the game has too few actions
            continue
    return named


def _words(task: TaskData, group: Group) -> list[str]:
    """The words of the fields of a group that have words of their own and do not have their default."""
    values = {name: getattr(task, name) for name in GROUPS[group] if ROWS[name].words}
    return [ROWS[name].words.format(value) for name, value in values.items() if value != DEFAULTS[name]]


def _observation(task: TaskData) -> str:
    rows, columns = task.definition.screen.shape
    shape = (task.img_height or rows, task.img_width or columns, *task.kind.colours)
    array = f"{task.kind.pixels} {'screen' if task.img_height is None else 'image'} {shape}"
    words = [f"{array if task.kind.image else 'the 128 bytes of RAM'}, uint8"]
    if task.stack_num is not None:
        padding = (_PADDING if task.kind.image else _PADDING_OF_RAM)[task.padding]
        words.append(f"a stack of {task.stack_num}, which begins with {padding}")
    if not task.kind.image:
        return "; ".join([*words, *_words(task, "observation")])
    if task.maxpool:
        words.append("the maximum of two frames" + (", of their colours" if task.pool_rgb else ""))
    if task.end_frames != "last":
        words.append(f"ends inside a skip as in {task.end_frames}")
    if task.kind.is_dict:
        words.append("and the 128 bytes of RAM")
    return "; ".join([*words, *_words(task, "observation")])


_PADDING: Mapping[str, str] = {"zero": "black images", "reset": "copies of the first image"}
_PADDING_OF_RAM: Mapping[str, str] = {"zero": "zeros", "reset": "copies of the first RAM"}


def skip_text(frameskip: int | tuple[int, int]) -> str:
    """A frame skip in words."""
    if isinstance(frameskip, tuple):
        low, high = frameskip
        return f"random, {low} to {high - 1} frames a step"
    return "none, 1 frame a step" if frameskip == 1 else f"{frameskip} frames a step"


def sticky_text(probability: float | tuple[float, ...]) -> str:
    """Sticky actions in words."""
    if isinstance(probability, tuple):
        return f"the previous action of each player repeats with probability {', '.join(map(str, probability))}"
    return f"the previous action repeats with probability {probability} each frame" if probability else "no"


def _actions(task: TaskData) -> str:
    if task.continuous:
        words = f"continuous: radius, angle, fire; threshold {task.continuous_action_threshold}"
    else:
        names = " ".join(action.name for action in task.action_set)
        kind = {"minimal": ", those the game uses", "full": ", all legal ones"}.get(str(task.actions), "")
        words = f"{len(task.action_set)}{kind}: {names}"
    return "; ".join([words, *_words(task, "play")])


def _begin(task: TaskData) -> str:
    low, high = task.noops
    noops = f"{low} to {high} no-ops" + (", FIRE among them" if task.fire_counts else "") if high else ""
    unit = " for a whole step" if task.fire_unit == "skip" else ""
    fire = "" if task.fire == "never" else f"FIRE{unit}" + (", then action 2" if task.third_action else "")
    order = [fire, noops] if task.fire == "before_noops" else [noops, fire]
    start = ", then ".join(part for part in order if part) or "the emulator's reset alone"
    return "; ".join([start, *_words(task, "begin")])


_ON_RESET: Mapping[str, str] = {
    "noop": "continues the game with a NOOP",
    "continue": "continues the game",
    "new_game": "begins a new game",
}


def _lives(task: TaskData) -> str:
    if task.life_loss_info:
        return "a lost life is reported as a termination; the episode goes on"
    if not task.episodic_life:
        return "a lost life does not end an episode"
    end = f"a lost life ends an episode; the reset after it {_ON_RESET[task.on_reset]}"
    return "; ".join([end, *_words(task, "lives")])


def _limit(task: TaskData) -> str:
    limits = {name: getattr(task, name) for name in GROUPS["limits"]}
    words = [ROWS[name].words.format(number) for name, number in limits.items() if number is not None]
    return "truncated after " + " or ".join(words) if words else "none"


def _reward(task: TaskData) -> str:
    score = [] if task.reward is not None or task.reward_clipping else ["the change of the score"]
    return ", ".join([*score, *_words(task, "reward")])


def _mode(task: TaskData) -> str:
    game = task.definition
    modes, difficulties = game.modes, game.difficulties
    if task.players > 1:
        rules = rules_of(game)
        modes, difficulties = rules.modes[task.players], rules.difficulties
    return (
        f"{task.mode} of {', '.join(map(str, modes))}; "
        f"difficulty {task.difficulty} of {', '.join(map(str, difficulties))}"
    )
