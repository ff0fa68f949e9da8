"""Observers of an `AtariEnv` receive every frame, and `make_sound` changes no result."""

import copy
import pickle

from env_tools import over, play, started

from atari import Action, AtariEnv


class Watcher:
    """Records the calls that an observer receives."""

    def __init__(self, env: AtariEnv) -> None:
        self.env, self.received = env, []  # type: ignore[var-annotated]

    def game_begun(self) -> None:
        self.received.append(("begun", self.env.core.frame_number))

    def frame_played(self, action: int, reward: int) -> None:
        self.received.append((action, reward, self.env.core.frame_number))


def test_observers_receive_every_frame() -> None:
    env = AtariEnv("breakout", frameskip=3, repeat_action_probability=0.0)
    watcher = Watcher(env)
    env.driver.observers.append(watcher)
    env.reset(seed=0)
    first = env.core.frame_number
    env.core.set_ram(0x4D, 0x25)
    env.step(1)
    env.driver.play_frames(Action.LEFT, frames=2)
    assert watcher.received == [
        ("begun", first),
        (1, 25, first + 1),
        (1, 0, first + 2),
        (1, 0, first + 3),
        (4, 0, first + 4),
        (4, 0, first + 5),
    ]


def test_observers_receive_only_played_frames() -> None:
    env = started(frameskip=4)
    watcher = Watcher(env)
    env.driver.observers.append(watcher)
    over(env)
    assert len(watcher.received) == 1
    env.driver.observers.clear()
    env.reset()
    env.step(0)
    assert len(watcher.received) == 1


def test_making_sound_changes_nothing_else() -> None:
    env, silent = started("seaquest"), started("seaquest")
    env.driver.make_sound()
    assert play(env, 30) == play(silent, 30)
    assert env.core.audio().min() >= 128
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert other.core.sound
        assert play(other, 20) == play(copy.deepcopy(env), 20)
