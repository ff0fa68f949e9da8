"""The part of `CoreContract` that concerns snapshots."""

from typing import Any

import pytest
from core_tools import Maker, play, some_actions, unchanged, visible

from atari.cores import snapshot


class SnapshotContract(Maker):
    """A snapshot taken at any time continues exactly. Any other value raises and changes nothing."""

    @pytest.mark.parametrize("phase", ["truncated", "over"])
    def test_a_snapshot_of_an_ended_game_continues_exactly(self, phase: str) -> None:
        core = self.make(max_num_frames_per_episode=60, seed=1)
        if phase == "truncated":
            play(core, [0] * 70)
        if phase == "over":
            core.set_ram(0x39, 0)
            play(core, [0] * 5)
        saved = core.snapshot()
        expected = play(core, some_actions(core, 20))
        core.restore(saved)
        assert play(core, some_actions(core, 20)) == expected

    def test_a_snapshot_has_the_mode_and_the_difficulty_that_were_set(self) -> None:
        core, other = self.make("pong"), self.make("pong")
        core.set_mode(1)
        core.set_difficulty(2)
        other.restore(core.snapshot())
        assert (other.mode, other.difficulty) == (1, 2)
        core.seed(3)
        other.seed(3)
        core.reset()
        other.reset()
        assert visible(core)[:4] == visible(other)[:4]

    @pytest.mark.parametrize(
        ("game", "options", "text"),
        [
            ("pong", {}, "taken with game = 'pong', but this environment has 'breakout'"),
            ("breakout", {"mode": 4}, "taken with mode = 4, but this environment has None"),
            ("breakout", {"difficulty": 1}, "taken with difficulty = 1"),
            ("breakout", {"frame_skip": 2}, "taken with frame_skip = 2"),
            ("breakout", {"sound": True}, "taken with sound = True"),
            ("breakout", {"repeat_action_probability": 0.0}, "taken with repeat_action_probability = 0.0"),
            ("breakout", {"max_num_frames_per_episode": 99}, "taken with max_num_frames_per_episode = 99"),
        ],
    )
    def test_a_snapshot_of_another_game_or_other_options_is_refused(
        self, game: str, options: dict[str, Any], text: str
    ) -> None:
        core, other = self.make(), self.make(game, **options)
        with (
            unchanged(core),
            pytest.raises(ValueError, match="restore it into one made with the same options") as error,
        ):
            core.restore(other.snapshot())
        assert text in str(error.value)

    def test_a_snapshot_of_another_core_is_refused(self) -> None:
        core = self.make()
        facts, blobs = snapshot.unpack(core.snapshot())
        with unchanged(core), pytest.raises(ValueError, match="taken with core = 'another'"):
            core.restore(snapshot.pack({**facts, "core": "another"}, blobs))

    def test_a_snapshot_of_another_format_version_is_refused(self, monkeypatch: pytest.MonkeyPatch) -> None:
        core = self.make()
        with monkeypatch.context() as patch:
            patch.setattr(snapshot, "VERSION", 999)
            future = core.snapshot()
        with unchanged(core), pytest.raises(ValueError, match=r"format version 999, this release .* reads version 1"):
            core.restore(future)
