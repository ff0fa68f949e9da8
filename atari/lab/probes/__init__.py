"""Linear probes: the part of a game's state that one linear map reads from the features of an encoder.

The benchmark is AtariARI's (Anand et al. 2019, "Unsupervised State Representation Learning in Atari"). Played episodes
are split into training, validation and test; for each label, a linear classifier of 256 classes predicts its byte from
the features; the result is the F1 score of each label, and the mean of each category.
"""

from atari.lab.probes.data import play_episodes, split_episodes
from atari.lab.probes.probe import majority, probe

__all__ = ["majority", "play_episodes", "probe", "split_episodes"]
