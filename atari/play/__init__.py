"""Playing by hand: a window with sound, keyboard and gamepad, that records what is played.

The parts know nothing of each other: `controls` turns events into actions and commands, `session` is the game with its
replay, its saved states and its way back, `speaker` and `window` are what is heard and seen. `loop` puts them together.
"""

from atari.play.loop import play
from atari.play.session import Session

__all__ = ["Session", "play"]
