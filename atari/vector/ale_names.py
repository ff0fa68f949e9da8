"""The option names and defaults of ale-py's `AtariVectorEnv`, as fields of a `Task`."""

from collections.abc import Mapping
from typing import Any

from atari.base.frozen import FrozenDict
from atari.base.validation import check_integer, check_name
from atari.task.checks import NO_LIMIT, check_bool
from atari.task.observation_kinds import KINDS, with_image
from atari.task.presets import PRESETS

_ONE_PLAYER: Mapping[str, Any] = FrozenDict({**PRESETS["ale_vector"].fields, "fire_again": False, "seeding": "ale"})
_SEVERAL_PLAYERS: Mapping[str, Any] = FrozenDict({**PRESETS["multiplayer_dqn"].fields, "padding": "zero"})
"""ale-py's has one player. The fields for several are those without FIRE, no-ops and lost lives."""

NAMES = ("noop_max", "use_fire_reset", "grayscale")
"""ale-py's names of options that have other names in a `Task`."""


def ale_defaults(options: Mapping[str, Any], several: bool = False) -> Mapping[str, Any]:
    """The defaults of ale-py's vector environment, which a game's name has without a preset.

    `several` says that the name is of a game for several players; the option `players` says so, too.
    """
    return _SEVERAL_PLAYERS if several or options.get("players") not in (None, 1) else _ONE_PLAYER


def as_task_options(options: Mapping[str, Any], base: Mapping[str, Any], obs_type: str) -> dict[str, Any]:
    """The options with a task's names.

    Args:
        options: the user's options.
        base: `ale_defaults`, if they apply. Then `max_num_frames_per_episode` limits the frames after the beginning, as
            in ale-py.
        obs_type: the kind of observations without an option and a default for it.

    Raises:
        TypeError, ValueError: an option is of the wrong kind, or given under two names.
    """
    fields = {name: value for name, value in options.items() if name not in NAMES}
    if options.get("noop_max") is not None:
        _refuse_both(options, "noop_max", "noops")
        fields["noops"] = (0, max(check_integer("noop_max", options["noop_max"], 0, 1_000_000), 1) - 1)
    if options.get("use_fire_reset") is not None:
        _refuse_both(options, "use_fire_reset", "fire")
        fires = check_bool("use_fire_reset", options["use_fire_reset"])
        fields |= {"fire": "before_noops", "fire_counts": True} if fires else {"fire": "never"}
    if base and "max_num_frames_per_episode" in options:
        _refuse_both(options, "max_num_frames_per_episode", "max_frames")
        limit = fields.pop("max_num_frames_per_episode")
        name = "max_num_frames_per_episode"
        fields["max_frames"] = None if limit is None else check_integer(name, limit, 1, NO_LIMIT)
    if options.get("grayscale") is not None:
        chosen = options.get("obs_type") or base.get("obs_type", obs_type)
        fields["obs_type"] = _obs_type(chosen, check_bool("grayscale", options["grayscale"]), "obs_type" in options)
    return fields


def _obs_type(obs_type: Any, grayscale: bool, given: bool) -> str:
    """The kind of observations with the colours of the option `grayscale`."""
    kind = KINDS[check_name("obs_type", obs_type, KINDS)]
    if not kind.image:
        raise ValueError(f"grayscale={grayscale} has no effect on obs_type={obs_type!r}; leave one of them out")
    if given and not kind.ram and kind.is_gray != grayscale:
        raise ValueError(f"obs_type={obs_type!r} contradicts grayscale={grayscale}; leave one of them out")
    return str(obs_type) if kind.is_gray == grayscale else with_image(gray=grayscale, ram=kind.ram)


def _refuse_both(options: Mapping[str, Any], name: str, other: str) -> None:
    if other in options:
        raise TypeError(f"{name} and {other} say the same in two ways; give one of them")
