#!/usr/bin/env python
"""Writes the tables of the documents that the package's data decide, and the picture of the presets.

    scripts/generate/tables.py            # the documents of DOCUMENTS; docs/learning.md needs the extra `learn`
    scripts/generate/tables.py --pictures # also docs/assets/presets.png

A table stands between `<!-- table: NAME -->` and `<!-- end -->`. A test compares the files with the data.
"""

import argparse
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import atari
from atari.base import font
from atari.base.png import png
from atari.base.typed_table import in_text
from atari.policy.inside import FORMATS, METHODS, SAMPLED
from atari.task import PRESETS, fields
from atari.task.env_ids import FAMILIES, Family

DOCS = Path(__file__).resolve().parents[2] / "docs"
DOCUMENTS = ("ids.md", "presets.md", "tasks.md", "learning.md", "evaluation.md")
TABLE = re.compile(r"(<!-- table: ([\w.]+) -->\n)(.*?)(\n<!-- end -->)", re.DOTALL)

Fields = Mapping[str, Any]
Image = npt.NDArray[np.uint8]


def families() -> str:
    """A row for each family of environment IDs, with Pong's ID."""
    head = ["| ID of Pong | observation | frames a step | sticky actions | games |", "|---|---|---|---|---|"]
    return "\n".join([*head, *map(_family, FAMILIES)])


def _family(family: Family) -> str:
    observation = "RAM, (128,)" if family.ram else "RGB, (210, 160, 3)"
    skip = family.frameskip
    frames = f"{skip[0]} to {skip[1] - 1}, random" if isinstance(skip, tuple) else str(skip)
    sticky = family.repeat_action_probability or "no"
    return f"| `{family.id('pong')}` | {observation} | {frames} | {sticky} | {len(family.games())} |"


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


def presets() -> str:
    """A row for each choice, a column for each preset."""
    lines = [f"| | {' | '.join(f'`{name}`' for name in PRESETS)} |", "|---" * (len(PRESETS) + 1) + "|"]
    for label, cell in ROWS.items():
        lines.append(f"| **{label}** | {' | '.join(cell(preset.fields) for preset in PRESETS.values())} |")
    return '<div class="wide" markdown>\n\n' + "\n".join(lines) + "\n\n</div>"


def sources() -> str:
    """A line for each preset: the publication or implementation that it follows."""
    return "\n".join(f"- `{name}`: {preset.source}" for name, preset in PRESETS.items())


def task_fields(tuned: bool) -> str:
    """A row for each field of a task that users tune, or for each other field."""
    lines = ["| group | field | default | meaning |", "|---|---|---|---|"]
    for name, row in fields.ROWS.items():
        if row.tuned == tuned:
            default = "" if name == "game" else f"`{fields.DEFAULTS[name]!r}`"
            lines.append(f"| {row.group} | `{name}` | {default} | {row.says} |")
    return "\n".join(lines)


def fast() -> str:
    """A table of the options that `--fast` changes for pixels, and a sentence of those for RAM."""
    from atari.learning.agents import AGENTS, find_agent  # imports PyTorch
    from atari.learning.options import FAST_RAM

    agents = {name: find_agent(name) for name in AGENTS}
    names = list(dict.fromkeys(name for agent in agents.values() for name in agent.fast))
    lines = [f"| option | {' | '.join(f'`{name} --fast`' for name in agents)} |", "|---" * (len(agents) + 1) + "|"]
    for name in names:
        cells = [in_text(agent.fast[name]) if name in agent.fast else "" for agent in agents.values()]
        lines.append(f"| `{name}` | {' | '.join(cells)} |")
    ram = ", ".join(f"`{name}` {in_text(value)}" for name, value in FAST_RAM.items())
    return "\n".join([*lines, "", f"From RAM: {ram}."])


def inside() -> str:
    """A row for each format of policies, a column for each method that shows more than actions."""
    lines = [f"| format | {' | '.join(f'`{method}`' for method in METHODS)} |", "|---" * (len(METHODS) + 1) + "|"]
    for name, methods in FORMATS.items():
        sampled = {"probabilities": "sampled"} if name in SAMPLED else {}
        cells = ("yes" if method in methods else sampled.get(method, "") for method in METHODS)
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


TABLES: Mapping[str, Callable[[], str]] = {
    "policies.inside": inside,
    "learning.fast": fast,
    "ids.families": families,
    "presets.sources": sources,
    "tasks.fields": partial(task_fields, tuned=True),
    "tasks.resets": partial(task_fields, tuned=False),
    "presets.choices": presets,
}


def filled(text: str) -> str:
    """A document with its tables made anew.

    Raises:
        KeyError: there is no such table.
    """
    return TABLE.sub(lambda match: f"{match[1]}{TABLES[match[2]]()}{match[4]}", text)


def picture() -> Image:
    """The observations of each preset: the first, one 15 steps later, and the first after a lost life.

    Its two channels are gray and alpha: the page around it is light or dark.
    """
    rows = [_words(("first observation", "15 steps later", "after a lost life"))]
    for name in PRESETS:
        rows += [_words((name, "", "")), np.concatenate([_strip(seen) for seen in _moments(name)], 1)]
    return np.concatenate(rows)


def _words(texts: tuple[str, ...]) -> Image:
    """A line of text above the columns of observations."""
    line: Image = np.zeros((20, 4 * 87 * 3 + 24), np.uint8)
    for column, text in enumerate(texts):
        pixels = font.line(text, 2)
        line[2 : 2 + len(pixels)][:, column * (4 * 87 + 8) :][:, : pixels.shape[1]][pixels] = 255
    return np.dstack([np.full_like(line, 128), line])


def _strip(stack: Image) -> Image:
    padded = [np.pad(np.dstack([image, np.full_like(image, 255)]), ((0, 0), (0, 3), (0, 0))) for image in stack]
    return np.pad(np.concatenate(padded, 1), ((0, 0), (0, 8), (0, 0)))


def _moments(name: str) -> list[Image]:
    """Observations of a preset in Ms. Pac-Man with seed 2 and NOOP at every step."""
    env = atari.make("ms_pacman", preset=name)
    observation, info = env.reset(seed=2)
    seen, lives, ended = [observation], info["lives"], False
    while not ended and info["lives"] == lives:
        observation, _, ended, _, info = env.step(0)
        seen.append(observation)
    after = env.reset()[0] if ended else env.step(0)[0]
    env.close()
    return [seen[0], seen[15], after]


def main() -> None:
    """Write the documents, and with `--pictures` the picture."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--pictures", action="store_true", help="also draw docs/assets/presets.png")
    args = parser.parse_args()
    for name in DOCUMENTS:
        path = DOCS / name
        path.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
    if args.pictures:
        (DOCS / "assets" / "presets.png").write_bytes(png(picture()))


if __name__ == "__main__":
    main()
