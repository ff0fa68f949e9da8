"""The rules for fields of a `Task` that have an effect only together.

A field without effect beside another one is an error if a user gave it, and takes its default if it comes from a
preset, an ID or another task. So tasks that differ in such fields alone are equal.
"""

from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from atari.games.game import Game
from atari.task.checks import NO_LIMIT
from atari.task.fields import DEFAULTS
from atari.task.observation_kinds import kind_of

Fields = Mapping[str, Any]


class _Need(NamedTuple):
    """`fields` have an effect only if `holds` is true; `because` says why, and how to give them an effect."""

    fields: tuple[str, ...]
    holds: Callable[[Fields], bool]
    because: str


class _Clash(NamedTuple):
    """Fields that contradict each other if `holds` is true; `text` is the error, with fields in braces.

    `definition` is a field, too: the game.
    """

    holds: Callable[[Fields], bool]
    text: str


def _has_several(task: Fields) -> bool:
    return bool(task["players"] > 1)


_NEEDS = (
    _Need(
        ("on_reset", "lives_unit", "seamless_lives"),
        lambda task: task["episodic_life"],
        "no lost life ends an episode; add episodic_life=True",
    ),
    _Need(
        ("last_life",),
        lambda task: task["episodic_life"] or task["life_loss_info"],
        "no lost life has an effect; add episodic_life=True or life_loss_info=True",
    ),
    _Need(
        ("fire_counts", "third_action", "fire_unit"),
        lambda task: task["fire"] != "never",
        "FIRE is never pressed; add fire='after_noops'",
    ),
    _Need(
        ("fire_again",),
        lambda task: task["fire"] == "before_noops" and task["noops"][1] > 0,
        "no no-ops follow FIRE; add fire='before_noops' and noops=(1, 30)",
    ),
    _Need(
        ("continuous_action_threshold",),
        lambda task: task["continuous"],
        "actions are not continuous; add continuous=True",
    ),
    _Need(
        ("img_height", "img_width", "maxpool", "pool_rgb", "end_frames"),
        lambda task: kind_of(task["obs_type"]).image is not None,
        "obs_type='ram' has no image; use obs_type='dict' for both",
    ),
    _Need(("padding",), lambda task: task["stack_num"] is not None, "there is no stack to fill; add stack_num=4"),
    _Need(
        ("max_frames",),
        lambda task: (
            task["max_frames"] is None or task["max_frames"] <= (task["max_num_frames_per_episode"] or NO_LIMIT)
        ),
        "max_num_frames_per_episode ends episodes earlier; make that None",
    ),
    _Need(
        ("pool_rgb",),
        lambda task: kind_of(task["obs_type"]).pixels == "gray" and task["maxpool"],
        "no colours are pooled for a gray image; use obs_type='grayscale' with maxpool=True",
    ),
    _Need(("agent_indicator", "zero_sum"), _has_several, "one player plays; add players=2"),
)
"""A rule may depend on fields of earlier rules."""


def _one_player(name: str) -> _Clash:
    text = f"{name}={{{name}!r}} is for one player; leave it or players={{players}} out"
    return _Clash(lambda task: _has_several(task) and task[name] != DEFAULTS[name], text)


_CLASHES = (
    _Clash(
        lambda task: (
            isinstance(task["repeat_action_probability"], tuple)
            and len(task["repeat_action_probability"]) != task["players"]
        ),
        "repeat_action_probability must be a number, or one for each of {players} players, "
        "got {repeat_action_probability}",
    ),
    _Clash(
        lambda task: task["agent_indicator"] and kind_of(task["obs_type"]).is_gray and task["stack_num"] is None,
        "agent_indicator=True adds channels, and a gray image without a stack has none; add stack_num=1",
    ),
    _Clash(
        lambda task: task["fire"] == "before_noops" and task["fire_unit"] == "skip",
        "fire='before_noops' presses FIRE before single frames, and fire_unit='skip' for a whole step after them; "
        "use fire='after_noops' or fire_unit='frame'",
    ),
    _Clash(
        lambda task: task["third_action"] and task["continuous"],
        "third_action=True plays the action with index 2, and continuous=True has no such action; "
        "leave one of them out",
    ),
    _Clash(
        lambda task: task["episodic_life"] and task["life_loss_info"],
        "episodic_life=True ends an episode with a lost life, and life_loss_info=True goes on; leave one of them out",
    ),
    _Clash(
        lambda task: task["seamless_lives"] and "skip" in (task["lives_unit"], task["fire_unit"]),
        "seamless_lives=True keeps a skip whole in which a life is lost, and with lives_unit='skip' or "
        "fire_unit='skip' all are; use 'frame' for both, or seamless_lives=False",
    ),
    _Clash(
        lambda task: task["pool_rgb"] and task["end_frames"] not in ("last", "baselines"),
        "pool_rgb=True has no meaning for end_frames={end_frames!r}, which only gray images have; "
        "use end_frames='last' or 'baselines'",
    ),
    _Clash(
        lambda task: task["img_height"] is not None and task["img_height"] > task["definition"].screen.height,
        "img_height must be at most {definition.screen.height}, the rows of {definition.id}'s screen, got {img_height}",
    ),
    _Clash(
        lambda task: (task["img_height"] is None) != (task["img_width"] is None),
        "img_height and img_width go together, got {img_height} and {img_width}; give both, or leave both out",
    ),
    _Clash(
        lambda task: _has_several(task) and (task["episodic_life"] or task["life_loss_info"]),
        "episodic_life and life_loss_info are for one player, because players lose lives at different times; "
        "leave them or players={players} out",
    ),
    *map(_one_player, ("fire", "reward", "sound_obs", "continuous")),
    _Clash(
        lambda task: task["sound_obs"] and kind_of(task["obs_type"]).is_dict,
        "sound_obs=True makes a dict of image and sound, and obs_type={obs_type!r} one of image and RAM; "
        "leave one of them out",
    ),
)
"""The first that holds is reported."""


def default_ineffective(fields: dict[str, Any], given: Collection[str]) -> None:
    """Set the fields without effect to their defaults, in place.

    Raises:
        ValueError: a user gave one of them.
    """
    if fields["continuous"] and isinstance(fields["actions"], str):
        fields["actions"] = "full"  # the stick reaches all of them
    for need in _NEEDS:
        if need.holds(fields):
            continue
        for name in need.fields:
            if name in given and fields[name] != DEFAULTS[name]:
                raise ValueError(f"{name}={fields[name]!r} has no effect, because {need.because}, or leave {name} out")
            fields[name] = DEFAULTS[name]


def check_together(task: Fields, game: Game) -> None:
    """Refuse combinations that have no meaning.

    Raises:
        ValueError: two fields contradict each other; the message names both and a way out.
    """
    fields = {**task, "definition": game}
    for clash in _CLASHES:
        if clash.holds(fields):
            raise ValueError(clash.text.format(**fields))
