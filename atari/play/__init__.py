"""Playing by hand: a window with sound, keyboard and gamepad, which records a replay.

`controls` turns pygame's events into actions and commands. `session` is the game of one player with its replay,
`multiplayer_session` the game of two to four people and policies; `base` has the saved states, rewind points and videos
of both. `speaker` and `window` output sound and frames. Controls, sessions and output do not import each other;
`loop` connects them.
"""

from atari.play.loop import play
from atari.play.session import Session

__all__ = ["Session", "play"]
