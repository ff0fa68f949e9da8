"""Linear probes: the part of a game's state that one linear map reads from the features of an encoder.

The benchmark is AtariARI's (Anand et al. 2019, "Unsupervised State Representation Learning in Atari"). Played episodes
are split into training, validation and test; for each label, a linear classifier of 256 classes predicts its byte from
the features; the result is the F1 score of each label, and the mean of each category. `ridge_probe` is a faster probe
of the same splits, in closed form, with R2 of the byte as a number beside F1.
"""

from atari.lab.probes.data import play_episodes, split_episodes
from atari.lab.probes.probe import majority, probe
from atari.lab.probes.results import probe_table
from atari.lab.probes.ridge import ridge_probe

__all__ = ["majority", "play_episodes", "probe", "probe_table", "ridge_probe", "split_episodes"]
