"""Observers of an `AtariEnv` receive every frame, and `make_sound` changes no result."""

import copy
import pickle

from env_tools import Observer, over, play, started

from atari import Action, AtariEnv


def watched(env: AtariEnv) -> Observer:
    """Keeps the calls that an observer receives, with the number of the frame at which they come."""
    return Observer(env, lambda *frame: (*frame, env.core.frame_number), lambda: ("begun", env.core.frame_number))


def test_observers_receive_every_frame() -> None:
    env = AtariEnv("breakout", frameskip=3, repeat_action_probability=0.0)
    watcher = watched(env)
    env.reset(seed=0)
    first = env.core.frame_number
    env.core.set_ram(0x4D, 0x25)
    env.step(1)
    env.driver.play_frames(Action.LEFT, frames=2)
    assert watcher.seen == [
        ("begun", first),
        (1, 25, first + 1),
        (1, 0, first + 2),
        (1, 0, first + 3),
        (4, 0, first + 4),
        (4, 0, first + 5),
    ]


def test_observers_receive_only_played_frames() -> None:
    env = started(frameskip=4)
    watcher = watched(env)
    over(env)
    assert len(watcher.seen) == 1
    env.driver.observers.clear()
    env.reset()
    env.step(0)
    assert len(watcher.seen) == 1


def test_making_sound_changes_nothing_else() -> None:
    env, silent = started("seaquest"), started("seaquest")
    env.driver.make_sound()
    assert play(env, 30) == play(silent, 30)
    assert env.core.audio().min() >= 128
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert other.core.sound
        assert play(other, 20) == play(copy.deepcopy(env), 20)
