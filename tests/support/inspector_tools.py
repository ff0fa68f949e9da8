"""Sessions of the inspector for tests, and an agent that plays them."""

from atari.actions import Action
from atari.env import AtariEnv
from atari.lab.inspector.session import Session

LIVES, PADDLE, SCORE = 57, 72, 77
"""Bytes of Breakout."""


def new_session(game: str = "breakout") -> Session:
    return Session(AtariEnv(game, frameskip=1, repeat_action_probability=0.0, full_action_space=True), seed=0)


class Sweeper:
    """Fires, and moves left and right."""

    name = "sweeper"

    def begin(self, core: object) -> None:
        self.frames = 0

    def act(self, core: object) -> int:
        self.frames += 1
        return int((Action.FIRE, Action.LEFT, Action.NOOP, Action.RIGHT)[self.frames // 16 % 4])


def play(session: Session, frames: int) -> None:
    session.agent = session.agent or Sweeper()
    session.let_agent_play(True)
    session.step(frames)
