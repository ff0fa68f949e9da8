"""Linear probes: what of a game's state can be read from the features of an encoder, by one linear map.

The benchmark is AtariARI's (Anand et al. 2019, "Unsupervised State Representation Learning in Atari"). Played episodes
are split into training, validation and test; for each label, a linear classifier of 256 classes predicts its byte from
the features; the result is the F1 score of each label, and the mean of each category.
"""

from atari.lab.probes.data import Episode, ProbeData, Split, play_episodes, split_episodes
from atari.lab.probes.probe import ProbeResult, majority, probe

__all__ = [
    "Episode",
    "ProbeData",
    "ProbeResult",
    "Split",
    "majority",
    "play_episodes",
    "probe",
    "split_episodes",
]
