"""PettingZoo's Atari environments, which `atari.multiplayer` has."""

import importlib
import pkgutil
import re
import warnings
from dataclasses import replace
from typing import Any

from interfaces import live
from interfaces.compare import Ours
from interfaces.facts import Versions

_BASE = "pettingzoo.atari.base_atari_env"
_CLASS = f"{_BASE}.ParallelAtariEnv"
_UNWRAPPED = "pettingzoo.atari.unwrapped"
"""The class of `parallel_env(...).unwrapped`."""


def _env() -> Any:
    from atari.multiplayer import parallel_env

    env = parallel_env("pong_v3").unwrapped
    env.reset(seed=0)
    return env


OURS = Ours(
    {"pettingzoo.atari": "atari.multiplayer", _UNWRAPPED: "atari.multiplayer.MultiplayerEnv"},
    {_CLASS: _env, _UNWRAPPED: _env},
)


def facts() -> Versions:
    """The facts of the installed version; its environments need Multi-Agent-ALE."""
    live.require("pettingzoo.atari", "pettingzoo")
    live.require("multi_agent_ale_py", "multi-agent-ale-py==0.1.12")
    import pettingzoo.atari

    names = [each.name for each in pkgutil.iter_modules(pettingzoo.atari.__path__) if re.search(r"_v\d+$", each.name)]
    found = set()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for module in (_BASE, *(f"pettingzoo.atari.{name}" for name in names)):
            importlib.import_module(module)
            found |= set(live.module_facts(module, "pettingzoo"))
    public = {"", "raw_env", "env", "parallel_env", *importlib.import_module(_BASE).__all__}
    found = {fact for fact in found if fact.name.partition(".")[0] in public}
    found |= set(live.attributes_of_source(_CLASS))
    of_class = [fact for fact in found if fact.path.startswith(f"{_CLASS}.") and fact.kind != "hook"]
    for fact in of_class:
        member = fact.name.partition(".")[2]
        if member not in ("__init__", "step"):  # their arguments have other names in the base class
            found.add(replace(fact, module="pettingzoo.atari", name=f"unwrapped.{member}"))
    return live.versions(found, pettingzoo.__version__)
