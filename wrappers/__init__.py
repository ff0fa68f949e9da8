"""The classic wrappers of Atari environments, one in each file, and presets of them.

`preset(env, "baselines")` and other presets reproduce well-known implementations. `DqnPreprocessing` does the usual
preprocessing in one pass; the other wrappers are single steps to combine. All can be pickled, and
`gymnasium.make(env.spec)` makes them again.

Gymnasium has wrappers with some of these names. But its reward and image wrappers keep lambdas, which cannot be
pickled, and its stack copies each frame twice.
"""

from atari.wrappers.action_delay import ActionDelay
from atari.wrappers.clip_reward import ClipReward
from atari.wrappers.dqn_preprocessing import DqnPreprocessing
from atari.wrappers.episodic_life import EpisodicLife
from atari.wrappers.expression_reward import ExpressionReward
from atari.wrappers.fire_reset import FireReset
from atari.wrappers.frame_skip import FrameSkip
from atari.wrappers.frame_stack import FrameStack
from atari.wrappers.grayscale import Grayscale
from atari.wrappers.images import resize_image, rgb_to_gray
from atari.wrappers.life_loss_info import LifeLossInfo
from atari.wrappers.noop_reset import NoopReset
from atari.wrappers.observation_delay import ObservationDelay
from atari.wrappers.presets import preset, preset_options
from atari.wrappers.ram_observation import RamObservation
from atari.wrappers.resize import Resize
from atari.wrappers.sticky_actions import StickyActions

__all__ = [
    "ActionDelay",
    "ClipReward",
    "DqnPreprocessing",
    "EpisodicLife",
    "ExpressionReward",
    "FireReset",
    "FrameSkip",
    "FrameStack",
    "Grayscale",
    "LifeLossInfo",
    "NoopReset",
    "ObservationDelay",
    "RamObservation",
    "Resize",
    "StickyActions",
    "preset",
    "preset_options",
    "resize_image",
    "rgb_to_gray",
]
