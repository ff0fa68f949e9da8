"""The common behaviour of our cores beyond `atari.testing.check_core`: the words of errors, and facts of some games.

`check_core` tries more wrong values, and asks that an error changes nothing.

A core's own test file subclasses `CoreContract` and names its class in `core_type`; pytest then runs the tests below
and in `snapshot_contract.py` on it. `tests/cores/test_contract.py` runs `check_core`.
"""

from typing import Any

import numpy as np
import pytest
from core_tools import ARRAYS, play, some_actions, unchanged, visible
from snapshot_contract import SnapshotContract

import atari

FIRE, RIGHT, LEFT = 1, 3, 4
OUT = "out must be a writable C-contiguous uint8 array of shape"


class CoreContract(SnapshotContract):
    """Subclass this with the class of a core."""

    # The options of a core.

    def test_it_knows_its_game_and_has_a_name_in_cores(self) -> None:
        core = self.make("pong")
        assert core.game is atari.games["pong"]
        assert atari.cores.CORES[core.name] is self.core_type
        assert core.sound is False

    def test_it_is_ready_when_constructed(self) -> None:
        core = self.make(reset=False)
        assert (core.lives, core.game_over, core.frame_number) == (5, False, 0)
        assert core.screen().any()
        core.act(0)
        assert core.frame_number == 1

    @pytest.mark.parametrize(
        ("option", "value", "error", "text"),
        [
            ("game", "brekout", ValueError, "there is no game 'brekout'; did you mean 'breakout'?"),
            ("game", 7, TypeError, "a game is named by a string such as 'breakout', got 7"),
            ("seed", -1, ValueError, "seed must be within 0..4294967295, got -1"),
            ("seed", 1.5, TypeError, "seed must be an integer within 0..4294967295, got 1.5"),
            ("repeat_action_probability", -0.1, ValueError, "repeat_action_probability must be within 0..1, got -0.1"),
            ("repeat_action_probability", float("nan"), TypeError, "must be a number within 0..1, got nan"),
            ("repeat_action_probability", "0.5", TypeError, "must be a number within 0..1, got '0.5'"),
            ("mode", 1, ValueError, "breakout has no mode 1; it has 0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44"),
            ("mode", "0", TypeError, "mode must be an integer or None, got '0'"),
            ("difficulty", 2, ValueError, "breakout has no difficulty 2; it has 0, 1"),
            ("difficulty", 0.0, TypeError, "difficulty must be an integer or None, got 0.0"),
            ("frame_skip", 0, ValueError, "frame_skip must be within 1..10000, got 0"),
            ("frame_skip", "4", TypeError, "frame_skip must be an integer within 1..10000, got '4'"),
            ("max_num_frames_per_episode", -1, ValueError, "must be within 0..2147483647, got -1"),
            ("max_num_frames_per_episode", 1.0, TypeError, "must be an integer within 0..2147483647, got 1.0"),
        ],
    )
    def test_a_wrong_option_is_refused(self, option: str, value: Any, error: type[Exception], text: str) -> None:
        with pytest.raises(error) as caught:
            self.make(**{option: value})
        assert text in str(caught.value)

    @pytest.mark.parametrize(
        ("options", "text"),
        [
            ({"repeat_action_probability": 1.0}, "repeat_action_probability above 0.7, got 1.0"),
            ({"max_num_frames_per_episode": 10}, "max_num_frames_per_episode below 250, got 10"),
            ({"max_num_frames_per_episode": 600, "frame_skip": 4}, "max_num_frames_per_episode below 1000, got 600"),
            ({"frame_skip": 5}, "frame_skip above 4, got 5"),
        ],
    )
    def test_options_that_would_never_let_a_reset_end_are_refused(self, options: dict[str, Any], text: str) -> None:
        with pytest.raises(ValueError, match=r"double_dunk selects its mode at reset by playing, which may") as caught:
            self.make("double_dunk", **options)
        assert str(caught.value).endswith(text)

    def test_a_mode_is_in_force_from_the_first_reset(self) -> None:
        """In Breakout this byte is the game number."""
        assert self.make(mode=8).ram()[0x32] == 8
        assert self.make().ram()[0x32] == 0

    @pytest.mark.parametrize(("difficulty", "width"), [(0, 16), (1, 12)])
    def test_a_difficulty_makes_another_game(self, difficulty: int, width: int) -> None:
        """In Breakout the difficulty is the width of the paddle, in the row between two walls of eight pixels."""
        row = self.make(difficulty=difficulty).screen()[190]
        assert np.count_nonzero(row[8:-8]) == width

    # Screens, RAM and sound.

    def test_the_gray_screen_has_the_luminance_of_the_colours(self) -> None:
        core = self.make("seaquest")
        core.act(0)
        rgb, gray = core.screen_rgb(), core.screen_grayscale()
        assert len(np.unique(gray)) > 5
        assert np.array_equal(gray, np.floor(rgb @ [0.2989, 0.587, 0.114] + 0.5).astype(np.uint8))

    def test_sound_moves_around_128(self) -> None:
        core = self.make("seaquest", sound=True)
        assert core.sound is True
        for _ in range(10):
            core.act(FIRE)
        assert core.audio().min() >= 128
        assert len(np.unique(core.audio())) > 1

    @pytest.mark.parametrize("game", ["seaquest", "adventure"])
    def test_a_core_with_sound_goes_on_where_this_is(self, game: str) -> None:
        core, ears = self.make(game, seed=3, reset=False), self.make(game, seed=3, sound=True, reset=False)
        loud = core.with_sound()
        assert loud is not core
        assert loud.sound is True
        for one in (core, loud, ears):
            one.reset()
        actions = some_actions(core, 40)
        assert play(loud, actions) == play(ears, actions)

    # Playing.

    def test_rewards_follow_the_score_in_ram(self) -> None:
        core = self.make(repeat_action_probability=0.0)
        core.set_ram(0x4D, 0x25)
        assert core.act(0) == 25
        assert core.act(0) == 0

    def test_lives_and_the_end_follow_ram(self) -> None:
        core = self.make()
        core.set_ram(0x39, 2)
        core.act(0)
        assert (core.lives, core.game_over) == (2, False)
        core.set_ram(0x39, 0)
        core.act(0)
        assert (core.lives, core.game_over, core.truncated) == (0, True, False)

    def test_nothing_happens_after_the_end_until_a_reset(self) -> None:
        core = self.make()
        core.set_ram(0x39, 0)
        core.act(0)
        before = visible(core)
        assert core.act(FIRE) == 0
        assert visible(core) == before
        core.reset()
        assert (core.lives, core.game_over, core.episode_frame_number) == (5, False, 0)
        assert core.frame_number == 1

    def test_without_a_limit_nothing_is_truncated(self) -> None:
        core = self.make("pong", frame_skip=100)
        for _ in range(5):
            core.act(0)
        assert core.truncated is False

    def test_strength_scales_the_paddle(self) -> None:
        """At half strength the paddle takes twice as long; its position is in RAM."""
        places = []
        for strength, frames in ((1.0, 8), (0.5, 16), (0.5, 8)):
            core = self.make(repeat_action_probability=0.0)
            for _ in range(frames):
                core.act(LEFT, strength)
            play(core, [0] * 10)
            places.append(int(core.ram()[72]))
        assert places[0] == places[1] < places[2]

    # Random numbers.

    def test_without_stickiness_every_action_counts(self) -> None:
        first, second = (self.make("seaquest", seed=seed, repeat_action_probability=0.0) for seed in (1, 2))
        actions = some_actions(first, 60)
        assert play(first, actions) == play(second, actions)

    def test_with_full_stickiness_no_action_counts(self) -> None:
        stuck, idle = (self.make("seaquest", repeat_action_probability=1.0) for _ in range(2))
        assert play(stuck, some_actions(stuck, 60)) == play(idle, [0] * 60)

    def test_sticky_actions_repeat_as_often_as_said(self) -> None:
        """FIRE serves the ball in Breakout, unless the no-op before it is repeated."""
        core = self.make(repeat_action_probability=0.25)
        served = 0
        for _ in range(200):
            core.reset()
            no_ball = core.ram()[101]
            core.act(FIRE)
            served += core.ram()[101] != no_ball
        assert served == pytest.approx(150, abs=28)  # four and a half standard deviations

    # States in memory.

    def test_a_cloned_state_has_the_generator_only_on_request(self) -> None:
        core = self.make("seaquest", seed=1)
        core.act(0)
        without, with_rng = core.clone_state(), core.clone_state(include_rng=True)
        traces = {}
        for name, state in (("first", with_rng), ("again", with_rng), ("goes on", without)):
            core.restore_state(state)
            # The generator decides between an action and the previous one.
            traces[name] = [(core.act(action), core.ram().tobytes()) for action in [0, *some_actions(core, 60)]]
        assert traces["first"] == traces["again"] != traces["goes on"]

    # Wrong calls.

    @pytest.mark.parametrize(
        ("method", "arguments", "error", "text"),
        [
            ("act", (18,), ValueError, "0..17"),
            ("act", (1.0,), TypeError, "0..17"),
            (
                "act",
                (RIGHT, float("nan")),
                ValueError,
                "strength must be finite and at most 1000 in magnitude, got nan",
            ),
            ("act", (RIGHT, 1e9), ValueError, "strength must be finite"),
            ("act", (RIGHT, "1"), TypeError, "strength must be a number, got '1'"),
            ("act", (RIGHT, np.ones(2)), TypeError, "strength must be a number"),
            ("set_ram", (128, 0), ValueError, "index must be within 0..127, got 128; the address $80 has the index 0"),
            ("set_ram", (0.0, 0), TypeError, "index must be an integer within 0..127, got 0.0"),
            ("set_ram", (0, 256), ValueError, "value must be within 0..255, got 256"),
            ("set_ram", (0, None), TypeError, "value must be an integer within 0..255, got None"),
            ("seed", (2**32,), ValueError, "seed must be"),
            ("seed", (0.5,), TypeError, "seed must be"),
            ("restore_state", (b"",), TypeError, "restore_state takes what clone_state returned"),
            *((array, (np.zeros(3, np.uint8),), ValueError, OUT) for array in ARRAYS),
            ("restore", (bytearray(b"ATARISNP"),), TypeError, "a snapshot is bytes as snapshot() returned them"),
        ],
    )
    def test_a_wrong_call_is_refused(
        self, method: str, arguments: tuple[Any, ...], error: type[Exception], text: str
    ) -> None:
        core = self.make()
        with unchanged(core), pytest.raises(error) as caught:
            getattr(core, method)(*arguments)
        assert text in str(caught.value)

    def test_a_state_of_another_game_is_refused(self) -> None:
        core, other = self.make(), self.make("pong")
        with unchanged(core), pytest.raises(ValueError, match="the state is of another game than"):
            core.restore_state(other.clone_state())

    def test_a_closed_core_says_so(self) -> None:
        core = self.make()
        core.close()
        with pytest.raises(RuntimeError, match="this core is closed; make a new one"):
            core.act(0)
