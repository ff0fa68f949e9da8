"""HackAtari's modifications: each plays on this package what it plays on ale-py."""

import importlib
import pkgutil
import random
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from on_ale_py import on_ale_py

from atari.task import env_ids

pytestmark = pytest.mark.peers

STEPS = 40


class WideRam:
    """An `ale` whose RAM is of integers: OCAtari's sums are those of NumPy 1, in which a byte had no overflow."""

    def __init__(self, ale: Any) -> None:
        self._ale = ale

    def __getattr__(self, name: str) -> Any:
        return getattr(self._ale, name)

    def getRAM(self) -> Any:
        return self._ale.getRAM().astype(np.int64)


def modifications() -> dict[str, list[str]]:
    """The modifications of HackAtari by the ID of their game."""
    package = pytest.importorskip("hackatari.games")
    ids = {
        env_id.removeprefix("ALE/").removesuffix("-v5").lower(): env_id
        for env_id in env_ids.ids()
        if env_id[:4] == "ALE/"
    }
    found = {}
    for module in pkgutil.iter_modules(package.__path__):
        source = Path(package.__path__[0], f"{module.name}.py").read_text(encoding="utf-8")
        found[ids[module.name]] = re.findall(r'^ *"(\w+)": ', source, re.MULTILINE)
    return found


def played(env_id: str, modification: str) -> tuple[list[Any], str]:
    """All that is seen of a game with a modification, and the error that ended it: some of 0.0.6 raise their own."""
    core = importlib.import_module("hackatari.core")
    random.seed(1)
    np.random.seed(1)
    seen: list[Any] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            env = core.HackAtari(env_id, [modification], obs_mode="dqn", hud=True, dopamine_pooling=True)
            inner = env._env.unwrapped
            inner.ale = env._ale = WideRam(inner.ale)
            seen += env.reset(seed=1)
            env.action_space.seed(1)
            for _ in range(STEPS):
                seen += [*env.step(env.action_space.sample()), inner.ale.getRAM(), env.getScreenRGB()]
            env.close()
        except Exception as error:
            return [*map(comparable, seen)], repr(error)
    return [*map(comparable, seen)], ""


def comparable(part: Any) -> Any:
    return part.tobytes() if isinstance(part, np.ndarray) else part


def test_each_modification_plays_the_same() -> None:
    listed = modifications()
    raised, count = [], 0
    for env_id, names in listed.items():
        for name in names:
            ours = played(env_id, name)
            with on_ale_py(env_id):
                assert ours == played(env_id, name), (env_id, name)
            count += 1
            if ours[1]:
                raised.append((env_id, name, ours[1]))
    assert count >= 150
    assert len(raised) <= 8, raised
