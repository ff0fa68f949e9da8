"""Random tasks for Hypothesis: every field, in combinations that `Task` accepts, from the ranges of the fields' checks."""

import random

from field_values import seconds_of_step, task_with
from hypothesis import assume
from hypothesis import strategies as st

from atari.games.catalog import games as known_games
from atari.task import Task

_SECONDS = 0.02
"""The most seconds that a step may take, so that a test plays many tasks."""


@st.composite
def tasks(draw: st.DrawFn, games: tuple[str, ...]) -> Task:
    """A random task of one of these games."""
    game = known_games[draw(st.sampled_from(games))]
    # A generator of Hypothesis' own would need a hundred draws for a task, and is slow.
    source = random.Random(draw(st.integers(0, 2**32 - 1)))
    task = task_with(source, game, {})
    assume(task is not None and seconds_of_step(task) < _SECONDS)
    assert task is not None
    return task
