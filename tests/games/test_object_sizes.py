"""Sizes of objects, measured on the screen: an object that is moved leaves one place and appears at another."""

from typing import Any

import numpy as np
import pytest

import atari
from atari import Action
from atari.games.objects import GameObject
from atari.lab import Ram

GAMES = (
    "alien", "bank_heist", "boxing", "carnival", "demon_attack", "fishing_derby", "freeway", "galaxian", "montezuma_revenge",
    "pong", "riverraid", "space_invaders", "star_gunner", "tennis", "venture",
)  # fmt: skip

SHIFTS = (-40, 40, 56)


def runs(lines: Any) -> list[tuple[int, int]]:
    """First and last of each run of lines that are true; gaps of up to two lines are within a run."""
    found: list[tuple[int, int]] = []
    for line in map(int, np.flatnonzero(lines)):
        if found and line - found[-1][1] <= 3:
            found[-1] = (found[-1][0], line)
        else:
            found.append((line, line))
    return found


def moved(core: Any, state: Any, unchanged: Any, thing: GameObject, x: int) -> tuple[int, int] | None:
    """Width and height of what the next frame draws elsewhere if x is another; None if other things differ too."""
    core.restore_state(state)
    try:
        Ram(core)[f"{thing.name}_x"] = x
    except ValueError:  # no byte has this value
        return None
    core.act(Action.NOOP)
    differs = core.screen() != unchanged
    columns, rows = runs(differs.any(axis=0)), runs(differs.any(axis=1))
    starts = sorted((int(thing.x or 0), x))
    if len(columns) != 2 or len(rows) != 1:
        return None
    if any(abs(first - start) > 4 for (first, _), start in zip(columns, starts, strict=True)):
        return None
    return max(last - first + 1 for first, last in columns), rows[0][1] - rows[0][0] + 1


@pytest.mark.parametrize("game", GAMES)
def test_sizes_are_those_on_the_screen(game: str) -> None:
    env = atari.AtariEnv(game, frameskip=1, repeat_action_probability=0.0)
    env.reset(seed=0)
    env.action_space.seed(2)
    core, ram = env.core, Ram(env)
    cases: dict[str, list[bool]] = {}
    for _ in range(60):
        things, state = ram.objects(), core.clone_state(include_rng=True)
        core.act(Action.NOOP)
        unchanged = core.screen()
        for thing in things:
            if thing.width is None or thing.x is None or f"{thing.name}_x" not in core.game.ram_labels:
                continue
            for shift in SHIFTS:
                size = moved(core, state, unchanged, thing, thing.x + shift) if 0 <= thing.x + shift < 130 else None
                if size is not None:
                    fits = abs(size[0] - thing.width) <= 2 and abs(size[1] - (thing.height or size[1])) <= 2
                    cases.setdefault(thing.name, []).append(fits)
        core.restore_state(state)
        action = env.action_space.sample()
        for _ in range(12):
            *_, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
    assert sum(map(len, cases.values())) >= 20
    for name, fits in cases.items():
        assert len(fits) < 8 or np.mean(fits) >= 0.5, (name, np.mean(fits), len(fits))
    env.close()
