"""A program of a user with types, which mypy reads in scripts/test. It does not run.

Each wrapper that takes environments and vectors has the type of its kind, and mypy finds wrong arguments.
"""

from pathlib import Path

from typing_extensions import assert_type

import atari
from atari.lab import RamLabels, Watch
from atari.lab.ram_labels import VectorRamLabels
from atari.lab.watch import VectorWatch
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, RecordVideo
from atari.recording.replay.players import RecordMatch
from atari.recording.replay.record_replay import RecordVectorReplay
from atari.recording.video.record_vector_video import RecordVectorVideo

env = atari.make("pong")
envs = atari.AtariVectorEnv("pong", 2)
core = MultiplayerCore("pong")

assert_type(RecordReplay(env, "game.a26r"), RecordReplay)
assert_type(RecordReplay(envs, Path("third.a26r"), index=1), RecordVectorReplay)
assert_type(RecordReplay(core, "match.a26r"), RecordMatch)
assert_type(RecordVideo(env, "videos", video_length=10, scale=1), RecordVideo)
assert_type(RecordVideo(envs, "videos", record_first_only=True, index=1), RecordVectorVideo)
assert_type(Watch(env, "lives", 0x80, each="frame"), Watch)
assert_type(Watch(envs, "lives", index=1), VectorWatch)
assert_type(RamLabels(env, ["lives"]), RamLabels)
assert_type(RamLabels(envs, names="atari_ari"), VectorRamLabels)

RecordReplay(env, "game.a26r", index=1)  # type: ignore[call-overload]
RecordVideo(env, "videos", frames=1)  # type: ignore[call-overload]
Watch(env, "lives", each="game")  # type: ignore[call-overload]
RamLabels(envs, names="ocatari")  # type: ignore[call-overload]
