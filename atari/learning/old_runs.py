"""The configurations of run folders of earlier releases. Each format has one function, which stays as it is."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any


def migrated(config: Mapping[str, Any]) -> dict[str, Any]:
    """The configuration of format 1 as format 2 has it.

    In format 1, `options` has the game, the preset as `protocol`, fields that replace those of the preset, and the
    network's observations. Format 2 has a task, as JSON of its format 1, and the other options.

    Raises:
        KeyError, TypeError, ValueError: the configuration is damaged.
    """
    options = dict(config["options"])
    preset = _PRESETS[options.pop("protocol")]
    task = {"format": 1, "reward_clipping": True, **_game(options.pop("game")), **preset["begin"], **preset["play"]}
    sticky, actions, episodic_life = options.pop("sticky"), options.pop("actions"), options.pop("episodic_life")
    if sticky is not None:
        task["repeat_action_probability"] = sticky
    if actions is not None:
        task["actions"] = list(actions)
    if preset["episodic_life"] if episodic_life is None else episodic_life:
        task |= {"episodic_life": True, **preset["lives"]}
    obs, size, stack = options.pop("obs"), options.pop("image_size"), options.pop("stack")
    if obs == "ram":
        task["obs_type"] = "ram"
        padding = preset["image"]["padding"] if config["agent"] == "dqn" else "reset"
        task |= {"stack_num": stack, "padding": padding}
    else:
        task |= {"obs_type": "grayscale", "img_height": size, "img_width": size, "stack_num": stack, "maxpool": True}
        task |= preset["image"]
    rest = {name: value for name, value in config.items() if name not in ("format", "policy")}
    return {**rest, "format": 2, "task": task, "options": options}


def with_stacks_in_task(config: Mapping[str, Any]) -> dict[str, Any]:
    """The configuration with the stack of RAM in the task; the first releases of format 2 had it in the options."""
    options = dict(config["options"])
    stack, padding = options.pop("ram_stack", None), options.pop("ram_padding", None)
    own = {} if stack is None else {"stack_num": stack, "padding": padding}
    return {**config, "task": {**config["task"], **own}, "options": options}


def with_flush(content: Any) -> Any:
    """The content of a checkpoint with the flush of the memory beside the state, which formats 1 and 2 had in it."""
    if not isinstance(content, dict) or content.keys() != {"agent", "scores", "games", "seconds"}:
        return content
    agent = content["agent"]
    flush = agent["memory"] if isinstance(agent.get("memory"), int) else None
    return {"step": agent["steps"], "state": content, "weights": agent["network"], "flush": flush}


def _game(game: str) -> dict[str, Any]:
    """The keys of a game, which is an id or the path of a game file."""
    return {"game": Path(game).stem, "file": game} if game.endswith(".toml") else {"game": game}


def _play(sticky: float, actions: str = "minimal", limit: int | None = 108_000) -> dict[str, Any]:
    return {"repeat_action_probability": sticky, "actions": actions, "max_num_frames_per_episode": limit}


_PRESETS: Mapping[str, Mapping[str, Any]] = {
    "dqn2015": {
        "play": _play(0.0),
        "begin": {"noops": [1, 30]},
        "episodic_life": True,
        "lives": {"on_reset": "continue", "last_life": True},
        "image": {"pool_rgb": True, "padding": "zero", "end_frames": "last"},
    },
    "machado2018": {
        "play": _play(0.25, "full"),
        "begin": {},
        "episodic_life": False,
        "lives": {"on_reset": "continue", "last_life": True},
        "image": {"padding": "zero", "end_frames": "last"},
    },
    "baselines": {
        "play": _play(0.0),
        "begin": {"noops": [1, 30], "fire": "after_noops", "third_action": True, "fire_unit": "skip"},
        "episodic_life": True,
        "lives": {"lives_unit": "skip", "on_reset": "noop"},
        "image": {"pool_rgb": True, "padding": "zero", "end_frames": "baselines"},
    },
    "gymnasium": {
        "play": _play(0.25, limit=None),
        "begin": {"noops": [1, 30]},
        "episodic_life": False,
        "lives": {"on_reset": "new_game", "last_life": True},
        "image": {"padding": "reset", "end_frames": "gymnasium"},
    },
    "dopamine": {
        "play": _play(0.25),
        "begin": {},
        "episodic_life": False,
        "lives": {"on_reset": "continue", "last_life": True},
        "image": {"padding": "zero", "end_frames": "baselines"},
    },
    "atari100k": {
        "play": _play(0.0),
        "begin": {},
        "episodic_life": True,
        "lives": {"on_reset": "continue", "last_life": True},
        "image": {"padding": "zero", "end_frames": "last"},
    },
    "envpool": {
        "play": {**_play(0.0, limit=None), "max_frames": 108_000},
        "begin": {"noops": [1, 30], "fire": "after_noops", "fire_counts": True},
        "episodic_life": False,
        "lives": {"on_reset": "continue"},
        "image": {"padding": "reset", "end_frames": "envpool"},
    },
    "ale_vector": {
        "play": {**_play(0.0, limit=None), "max_frames": 108_000},
        "begin": {"noops": [0, 29], "fire": "before_noops", "fire_counts": True},
        "episodic_life": False,
        "lives": {"on_reset": "new_game"},
        "image": {"padding": "zero", "end_frames": "gymnasium"},
    },
}
"""The presets of format 1 as fields of a task. The stack began anew after each lost life."""
