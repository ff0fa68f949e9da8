"""ale-py, whose interface `atari.ale_py` has: by the imported package alone, never by its source."""

from functools import partial
from typing import Any

import atari.ale_py
from interfaces import live
from interfaces.compare import Ours
from interfaces.facts import Versions


def _env(kind: Any) -> Any:
    env = kind("pong")
    env.reset(seed=0)
    env.step(0)
    return env


def _vector(kind: Any) -> Any:
    envs = kind("pong", 2)
    envs.reset(seed=0)
    envs.step(envs.action_space.sample())
    return envs


_ENVS, _VECTORS = (
    ("ale_py.AtariEnv", "ale_py.env.AtariEnv"),
    ("ale_py.AtariVectorEnv", "ale_py.vector_env.AtariVectorEnv"),
)

OURS = Ours(
    {"ale_py": "atari.ale_py"},
    {
        **dict.fromkeys(_ENVS, partial(_env, atari.ale_py.AtariEnv)),
        **dict.fromkeys(_VECTORS, partial(_vector, atari.ale_py.AtariVectorEnv)),
    },
)


def facts() -> Versions:
    """The facts of the installed version."""
    live.require("ale_py", "ale-py")
    import ale_py

    found = set()
    for module in ("ale_py", "ale_py.env", "ale_py.registration", "ale_py.roms", "ale_py.vector_env"):
        found |= set(live.module_facts(module, "ale_py"))
    for path in _ENVS:
        found |= set(live.class_facts(path, _env(ale_py.AtariEnv)))
    for path in _VECTORS:
        found |= set(live.class_facts(path, _vector(ale_py.AtariVectorEnv)))
    return live.versions(found, ale_py.__version__)
