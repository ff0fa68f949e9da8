"""OCAtari in vision mode: it finds objects in the screen that `env.unwrapped.ale` returns."""

import warnings
from typing import Any

import numpy as np
import pytest
from on_ale_py import on_ale_py

from atari.task import env_ids

pytestmark = pytest.mark.peers

FRAMES = 40


def games() -> list[str]:
    """The games of OCAtari that ale-py has and whose screens OCAtari 2.2.1 reads."""
    core = pytest.importorskip("ocatari.core")
    ids = env_ids.ids()
    return [name for name in core.AVAILABLE_GAMES if f"ALE/{name}-v5" in ids]


def seen(env_id: str) -> tuple[list[Any], str]:
    """All that OCAtari returns of a game, with the objects; and the error that ended it, from its tables of some games."""
    from ocatari.core import OCAtari

    found: list[Any] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            env = OCAtari(env_id, mode="vision", hud=True, obs_mode="ori", render_mode="rgb_array")
            found.append(env.reset(seed=1))
            env.action_space.seed(1)
            for _ in range(FRAMES):
                result = env.step(env.action_space.sample())
                objects = [(each.category, tuple(each.xywh)) for each in env.objects if each]
                found.append((*result, objects, env.getScreenRGB()))
            env.close()
        except Exception as error:
            return found, repr(error)
    return found, ""


def equal(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(equal, one, other))
    return bool(one == other)


def test_each_game_is_seen_as_on_ale_py() -> None:
    raised = []
    for game in games():
        env_id = f"ALE/{game}-v5"
        ours = seen(env_id)
        with on_ale_py(env_id):
            assert equal(ours, seen(env_id)), game
        if ours[1]:
            raised.append((game, ours[1]))
    assert len(games()) >= 60
    assert len(raised) <= 12, raised
