"""Environments of other packages that make an ALE ID: on this package, and on ale-py."""

from collections.abc import Iterator
from contextlib import contextmanager

import gymnasium
from gymnasium.envs.registration import EnvSpec

from atari.task import env_ids


@contextmanager
def on_ale_py(env_id: str) -> Iterator[None]:
    """Register ale-py's environment under an ID while the block runs."""
    family, game = env_ids.ids()[env_id]
    ours = gymnasium.registry[env_id]
    gymnasium.registry[env_id] = EnvSpec(id=env_id, entry_point="ale_py.env:AtariEnv", kwargs=family.options(game))
    try:
        yield
    finally:
        gymnasium.registry[env_id] = ours
