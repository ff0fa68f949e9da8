"""Interventions: described changes of a game through its RAM, and the checks that prove their effects.

The option `interventions` of `AtariEnv` and `AtariVectorEnv` applies them; `atari.games.interventions` has the files.
"""

from atari.games.interventions import load
from atari.lab.interventions.check import check

__all__ = ["check", "load"]
