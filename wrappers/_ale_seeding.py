"""`AleSeeding`: episodes with the seeding and the random draws of ale-py's vector environment."""

from typing import Any

import gymnasium
from gymnasium.utils import RecordConstructorArgs

from atari.cores.ale_random import AleRandom
from atari.env.restorable import Restorable
from atari.wrappers._checks import Environment, require_atari


class AleSeeding(Restorable, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """`reset(seed=...)` seeds the emulator, and the numbers of no-ops and frames, with the seed itself.

    The `AtariEnv` keeps the generator, for its snapshots and copies; this wrapper sets it, also when
    `gymnasium.make(env.spec)` makes the environment again. Seeds are below 2**31.

    Args:
        env: an `AtariEnv`, possibly wrapped.
    """

    def __init__(self, env: Environment) -> None:
        RecordConstructorArgs.__init__(self)
        super().__init__(env)
        require_atari(env, "AleSeeding").driver.ale_random = AleRandom()
