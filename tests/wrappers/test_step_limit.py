import pytest
from gymnasium.wrappers import TimeLimit

from atari.wrappers import FrameStack
from atari.wrappers.layers import StepLimit


def ends(env, steps):
    return [env.step(0)[2:4] for _ in range(steps)]


def test_truncates_as_gymnasiums_does(scripted):
    for end in (2, 3, 9):
        env, theirs = StepLimit(scripted(ends=end), 3), TimeLimit(scripted(ends=end), 3)
        for _ in range(2):
            env.reset()
            theirs.reset()
            assert ends(env, 3) == ends(theirs, 3)


@pytest.mark.parametrize("steps", [None, 0, 3])
def test_snapshots_have_the_steps(game_env, steps):
    env, other = (StepLimit(FrameStack(game_env("pong")), 5) for _ in range(2))
    if steps is not None:
        env.reset(seed=0)
        ends(env, steps)
        other.restore(env.snapshot())
        assert ends(other, 5 - steps) == [(False, False)] * (4 - steps) + [(False, True)]
    assert StepLimit(FrameStack(game_env("pong")), 5).snapshot() != env.snapshot() or steps is None
