"""Pictures of wrapped environments in a notebook.

The wrappers of Gymnasium, PettingZoo and Stable-Baselines3, and their vectors of single environments, have no picture.
IPython takes a function for a class of another package: here, one that shows the environment inside.
"""

import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import gymnasium

from atari.base.notebook import MOST_SHOWN

_CLASSES = (
    ("gymnasium.core", "Wrapper"),
    ("gymnasium.vector.vector_env", "VectorEnv"),
    ("pettingzoo.utils.env", "AECEnv"),
    ("pettingzoo.utils.env", "ParallelEnv"),
    ("stable_baselines3.common.vec_env.base_vec_env", "VecEnv"),
    ("atari.classic.core", "Wrapper"),
)
"""Modules and names of the classes, whose subclasses count too. IPython does not import them."""


def show_wrapped() -> None:
    """Let the IPython in which this program runs, if any, show wrapped environments."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell is not None:
        pages = shell.display_formatter.formatters["text/html"]
        for module, name in _CLASSES:
            pages.for_type_by_name(module, name, page_of)


def page_of(env: Any) -> str | None:
    """The HTML that an environment shows, or the environment inside its wrappers; None if neither has any."""
    inside = getattr(env, "unwrapped", env)
    for shown in (env, inside):
        own = getattr(shown, "_repr_html_", None)
        if own is not None:
            return str(page) if (page := own()) else None
    pages = _pages(inside)
    if not pages or None in pages:
        return None
    first = f", the first {MOST_SHOWN}" if len(pages) > MOST_SHOWN else ""
    shown = "".join(map(str, pages[:MOST_SHOWN]))
    count = f"{len(pages)} environment{'s' * (len(pages) > 1)}{first}"
    return f'<p>{count}</p><div style="display:flex;flex-wrap:wrap;gap:8px">{shown}</div>'


def _pages(envs: Any) -> Sequence[str | None]:
    """The HTML of each environment of a vector, also in other processes; none while these play."""
    if isinstance(envs, gymnasium.vector.AsyncVectorEnv) and hasattr(gymnasium.Env, "has_wrapper_attr"):
        with suppress(gymnasium.error.AlreadyPendingCallError, gymnasium.error.ClosedEnvironmentError):
            if all(envs.call("has_wrapper_attr", "_repr_html_")):
                return envs.call("_repr_html_")
    if hasattr(envs, "remotes") and hasattr(envs, "has_attr"):  # SubprocVecEnv
        idle = not (envs.waiting or envs.closed)
        return envs.env_method("_repr_html_") if idle and envs.has_attr("_repr_html_") else []
    single = getattr(envs, "envs", None)
    return list(map(page_of, single)) if isinstance(single, (list, tuple)) else []
