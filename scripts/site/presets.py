"""The comparison of the presets: a table from the package's own data, and pictures of the observations in each."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from page import Page
from pictures import png, strip

import atari
from atari.task import PRESETS

GAME = "breakout"

Fields = Mapping[str, Any]


def _noops(fields: Fields) -> str:
    low, high = fields.get("noops", (0, 0))
    return f"{low} to {high}" if high else "none"


def _fire(fields: Fields) -> str:
    words = {"never": "never", "before_noops": "at each reset, before the no-ops", "after_noops": "at each reset"}
    return words[fields.get("fire", "never")] + (", then action 2" if fields.get("third_action") else "")


def _after_life(fields: Fields) -> str:
    if not fields["episodic_life"]:
        return "the episode goes on"
    words = {"noop": "episode ends; the game goes on after a NOOP", "continue": "episode ends; the game goes on",
             "new_game": "episode ends; a new game"}  # fmt: skip
    return words[fields["on_reset"]]


def _limit(fields: Fields) -> str:
    frames = fields.get("max_num_frames_per_episode") or fields.get("max_frames")
    return f"{frames:,} frames" if frames else "as made"


_END = {
    "last": "the last frame",
    "gymnasium": "the step before, or its maximum with the last frame but one",
    "baselines": "the last frame if it is one of the step's last two, pooled with what the other buffer has",
    "envpool": "the last frame if it is one of the step's last two, else the step before",
}

ROWS: dict[str, Callable[[Fields], str]] = {
    "sticky actions": lambda fields: str(fields.get("repeat_action_probability", "as made")),
    "actions": lambda fields: "all 18" if fields.get("actions") == "full" else "those of the game",
    "frames a step": lambda fields: str(fields["frameskip"]),
    "no-ops at the start": _noops,
    "FIRE": _fire,
    "a lost life": _after_life,
    "rewards": lambda fields: "clipped to -1, 0, 1" if fields["reward_clipping"] else "as the game gives them",
    "two frames become one": lambda fields: "maximum of " + ("RGB, then gray" if fields.get("pool_rgb") else "gray"),
    "the stack begins with": lambda fields: {"zero": "black", "reset": "the first image"}[fields["padding"]],
    "an end inside a step shows": lambda fields: _END[fields["end_frames"]],
    "longest episode": _limit,
}  # fmt: skip


def table() -> str:
    """A row for each choice, a column for each preset."""
    lines = [f"| | {' | '.join(f'`{name}`' for name in PRESETS)} |", "|---" * (len(PRESETS) + 1) + "|"]
    for label, cell in ROWS.items():
        lines.append(f"| **{label}** | {' | '.join(cell(preset.fields) for preset in PRESETS.values())} |")
    return '<div class="wide" markdown>\n\n' + "\n".join(lines) + "\n\n</div>"


def sources() -> str:
    """A line for each preset: the publication or implementation that it follows."""
    return "\n".join(f"- `{name}`: {preset.source}" for name, preset in PRESETS.items())


MOMENTS = {"first": "first observation", "later": "15 steps later", "life": "after a lost life"}


def views() -> str:
    """A row of pictures for each preset."""
    heads = "".join(f"<span>{words}</span>" for words in MOMENTS.values())
    parts = [f'<div class="views" markdown>\n<div class="moments">{heads}</div>\n']
    for name in PRESETS:
        parts.append(f"<figure markdown><figcaption><code>{name}</code></figcaption>\n")
        for moment, words in MOMENTS.items():
            parts.append(f"![{name}, {words}](assets/presets/{name}-{moment}.png){{ title='{words}' }}\n")
        parts.append("</figure>\n")
    return "\n".join([*parts, "</div>"])


def pages() -> Iterator[Page]:
    """The pictures of `views`."""
    for name in PRESETS:
        for moment, observation in _moments(name).items():
            yield Page(f"assets/presets/{name}-{moment}.png", png(strip(list(observation))))


def _moments(name: str) -> dict[str, Any]:
    """Observations of a preset: the first, one 15 steps later, and the first after a lost life or the game's end."""
    env = atari.make(GAME, preset=name)
    first, info = env.reset(seed=2)
    moments = {"first": first}
    fire, noop = env.unwrapped.get_action_meanings().index("FIRE"), 0
    for step in range(1, 1000):
        observation, _, ended, _, info = env.step(fire if step % 20 == 1 else noop)
        if step == 15:
            moments["later"] = observation
        if step > 15 and (ended or info["lives"] < 5):
            moments["life"] = env.reset()[0] if ended else env.step(noop)[0]
            break
    env.close()
    return moments
