"""EnvPool, whose interface `atari.integrations.envpool` has: by the imported package alone, never by its source."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import atari.integrations.envpool as ours
from interfaces import live
from interfaces.compare import Ours
from interfaces.facts import Fact, Versions


def _pool(kind: str, module: Any) -> Any:
    envs = module.make("Pong-v5", kind, num_envs=2)
    envs.reset()
    return envs


_MADE: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "make_spec()": ("EnvPoolSpec", lambda module: module.make_spec("Pong-v5")),
    "make_gymnasium()": ("GymnasiumEnvPool", partial(_pool, "gymnasium")),
    "make_gym()": ("GymnasiumEnvPool", partial(_pool, "gym")),
    "make_dm()": ("DMEnvPool", partial(_pool, "dm")),
}
"""Our class, and what makes an object, by the function that returns it."""

OURS = Ours(
    {
        "envpool": "atari.integrations.envpool",
        **{f"envpool.{name}": f"atari.integrations.envpool.{kind}" for name, (kind, _) in _MADE.items()},
    },
    {f"envpool.{name}": partial(make, ours) for name, (_, make) in _MADE.items()},
)


def facts() -> Versions:
    """The facts of the installed version: the names of its modules, and what its functions make."""
    live.require("envpool", "envpool")
    import envpool

    found = {Fact(f"envpool.{name}", "", "module") for name in _families(envpool)}
    for module in ("envpool", "envpool.atari", "envpool.registration"):
        found |= {fact for fact in live.module_facts(module, "envpool") if "." not in fact.name}
    for name, (_, make) in _MADE.items():
        found |= set(_instance(name, make(envpool)))
    return live.versions(found, envpool.__version__)


def _families(envpool: Any) -> list[str]:
    """The modules of the families of environments, which importing EnvPool imports."""
    names = [name for name, value in vars(envpool).items() if getattr(value, "__name__", "") == f"envpool.{name}"]
    return [name for name in names if name not in ("python", "entry")]


def _instance(name: str, instance: Any) -> Iterator[Fact]:
    """The public names of an object, and the signatures of its methods."""
    yield Fact("envpool", name, "class")
    for each in dir(instance):
        value = getattr(type(instance), each, None)
        if each.startswith("_"):
            continue
        if callable(value) and not isinstance(value, type):
            yield from live.function_facts("envpool", f"{name}.{each}", value, "method")
        else:
            yield Fact("envpool", f"{name}.{each}", "attribute")
