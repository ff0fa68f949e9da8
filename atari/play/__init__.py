"""Playing by hand: a window with sound, keyboard and gamepad, which records a replay.

`controls` turns pygame's events into actions and commands. `session` is the game of one player with its replay,
`multiplayer_session` the game of two to four people and policies; `base` has the saved states, rewind points and videos
of both. `outputs` has the window and the sound. Controls, sessions and outputs do not import each other; `loop`
connects them.
"""

from atari.play.loop import play
from atari.play.session import Session

__all__ = ["Session", "play"]
