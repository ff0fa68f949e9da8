"""Playing by hand: a window with sound, keyboard and gamepad, which records a replay.

`controls` turns pygame's events into actions and commands. `session` is the game with its replay, saved states, rewind
points and videos. `speaker` and `window` output sound and frames. These modules do not import each other; `loop`
connects them.
"""

from atari.play.loop import play
from atari.play.session import Session

__all__ = ["Session", "play"]
