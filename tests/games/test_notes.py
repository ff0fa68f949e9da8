"""What the notes of games say of scores that wrap, Breakout's end and Pac-Man's ghosts."""

import numpy as np
import pytest

import atari
from atari.cores import NativeCore
from atari.lab import Ram


@pytest.mark.parametrize("game", ["up_n_down", "asterix", "frostbite", "video_pinball"])
def test_a_score_past_six_digits_begins_again(game: str) -> None:
    core = NativeCore(game, repeat_action_probability=0.0, seed=1)
    random = np.random.default_rng(0)
    actions = [int(action) for action in core.game.minimal_actions]

    def play(frames: int) -> list[int]:
        return [core.act(actions[random.integers(len(actions))] if number % 8 else 0) for number in range(frames)]

    core.reset()
    play(100)
    ram = Ram(core)
    ram["score_10000"], ram["score_100"], ram["score_1"] = 990_000, 9_900, 50
    core.act(0)
    assert min(play(8000)) < -990_000
    manual = atari.games[game].manual
    assert manual is not None
    assert any("begins again at 0" in note for note in manual.notes)


def test_breakout_stops_after_65_536_frames() -> None:
    core = NativeCore("breakout", repeat_action_probability=0.0, seed=1)
    core.reset()
    balls = []
    for _ in range(66_500):
        ram = core.ram()
        paddle, ball = int(ram[72]) + 8, int(ram[99])
        core.act(1 if ram[101] == 0 else 3 if ball > paddle + 2 else 4 if ball < paddle - 2 else 0)
        balls.append(int(core.ram()[101]))
    assert max(balls[64_000:65_500]) > 0
    assert max(balls[65_600:]) == 0
    assert core.lives > 0
    assert not core.game_over


def test_pacman_draws_one_ghost_a_frame() -> None:
    core = NativeCore("pacman", repeat_action_probability=0.0, seed=1)
    core.reset()
    ram = Ram(core)
    for _ in range(300):
        core.act(0)
    moved = [0, 0, 0, 0]
    for _ in range(1000):
        before = [(ram[f"enemy_{ghost}_x"], ram[f"enemy_{ghost}_y"]) for ghost in range(4)]
        core.act(0)
        after = [(ram[f"enemy_{ghost}_x"], ram[f"enemy_{ghost}_y"]) for ghost in range(4)]
        changed = [ghost for ghost in range(4) if before[ghost] != after[ghost]]
        assert len(changed) in (0, 1, 4)  # a ghost moves when it is drawn; all four go home after a lost life
        moved = [count + (ghost in changed) for ghost, count in enumerate(moved)]
    assert min(moved) > 5
