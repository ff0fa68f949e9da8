"""The part of `CoreContract` that concerns snapshots."""

import hashlib
import inspect
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from core_tools import ARRAYS, Maker, play, some_actions, unchanged, visible

from atari.cores import snapshot

FIRE, RIGHT = 1, 3


class SnapshotContract(Maker):
    """A snapshot taken at any time continues exactly. Any other value raises and changes nothing."""

    def test_a_snapshot_continues_exactly_in_another_process(self, tmp_path: Path) -> None:
        options: dict[str, Any] = {"sound": True, "mode": 2, "frame_skip": 2}
        core = self.make("space_invaders", seed=8, **options)
        play(core, some_actions(core, 50))
        (tmp_path / "saved").write_bytes(core.snapshot())
        actions = some_actions(core, 40, seed=1)
        program = "\n".join(
            [
                inspect.getsource(visible),
                inspect.getsource(play),
                "core = CORES[sys.argv[1]]('space_invaders', **json.loads(sys.argv[2]))",
                "core.restore(Path('saved').read_bytes())",
                "print(hashlib.sha256(repr(play(core, json.loads(sys.argv[3]))).encode()).hexdigest())",
            ]
        )
        header = (
            "import hashlib, json, sys\nfrom collections.abc import Iterable\nfrom pathlib import Path\n"
            f"from typing import Any\nfrom atari.cores import CORES, Core\nARRAYS = {ARRAYS}\n"
        )
        command = [sys.executable, "-c", header + program, core.name, json.dumps(options), json.dumps(actions)]
        result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        assert result.stdout.strip() == hashlib.sha256(repr(play(core, actions)).encode()).hexdigest()

    @pytest.mark.parametrize("phase", ["made", "reset", "poked", "paddle", "truncated", "over"])
    def test_a_snapshot_of_any_phase_continues_exactly(self, phase: str) -> None:
        core = self.make(reset=False, max_num_frames_per_episode=60, seed=1)
        if phase != "made":
            core.reset()
        if phase == "poked":
            core.set_ram(0x39, 3)
        if phase == "paddle":
            for _ in range(10):
                core.act(RIGHT, 0.3)
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

    def test_a_snapshot_cut_anywhere_is_refused(self) -> None:
        core = self.make(reset=False)
        good = core.snapshot()
        with unchanged(core):
            for length in range(len(good)):
                with pytest.raises(ValueError, match="snapshot"):
                    core.restore(good[:length])

    def test_a_snapshot_with_any_one_bit_flipped_is_refused(self) -> None:
        core = self.make(reset=False)
        core.act(FIRE)
        good = core.snapshot()
        with unchanged(core):
            for place in range(len(good)):
                bad = bytearray(good)
                bad[place] ^= 1 << place % 8
                with pytest.raises(ValueError, match="snapshot"):
                    core.restore(bytes(bad))

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
