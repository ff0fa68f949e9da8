"""Replays go both ways: the core in WebAssembly plays and compares those of the package, and the package those of the page."""

import random
import zlib
from pathlib import Path
from typing import Any

import pytest
from web_tools import GAMES, image, needs_core, node, packed, unpacked

import atari
from atari.games.interventions import load
from atari.lab import Freeze, Poke
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay
from atari.recording.replay import file_format
from atari.web.table import core_text, entry

REPLAYS = Path(__file__).parent.parent.parent / "docs" / "games" / "replays"
OF_REPOSITORY = sorted(path for path in REPLAYS.glob("*.a26r") if path.stem in GAMES)


def played(game: str, *replays: dict[str, Any], players: int = 1) -> list[dict[str, Any]]:
    """What play_replay.mjs finds in replays of a game."""
    one = atari.games[game]
    core = core_text(one) if players == 1 else entry(one)["two_players"]["core"]
    found: list[dict[str, Any]] = node("play_replay.mjs", core=core, image=image(game), replays=list(replays))
    return found


def sums_at(replay: Replay, frame: int) -> list[int]:
    """Check sums of RAM, screen and sound after some frames."""
    core = replay.seek(frame, sound=True)
    return [zlib.crc32(part.tobytes()) for part in (core.ram(), core.screen(), core.audio())]


def verified(tmp_path: Path, data: bytes) -> Replay:
    """The replay of these bytes, which the package has verified."""
    file = tmp_path / "web.a26r"
    file.write_bytes(data)
    replay = Replay.load(file)
    assert replay.complete
    assert replay.verify(), replay.verify()
    return replay


@needs_core
@pytest.mark.parametrize("path", OF_REPOSITORY, ids=lambda path: path.stem)
def test_a_replay_of_the_repository(path: Path, tmp_path: Path) -> None:
    replay = Replay.load(path)
    rng = random.Random(path.stem)
    places = [rng.randrange(1, replay.frames_total + 1) for _ in range(4)]
    frame = rng.randrange(replay.frames_total)
    actions = [int(rng.choice(replay.game.minimal_actions)) for _ in range(90)]
    one = {"replay": packed(path.read_bytes()), "at": places, "goOn": {"frame": frame, "actions": actions}}
    (found,) = played(path.stem, one)
    assert (found["frames"], found["difference"]) == (replay.frames_total, None)
    assert found["at"] == [sums_at(replay, place) for place in places]
    gone_on = verified(tmp_path, unpacked(found["goneOn"]["replay"]))
    assert gone_on.frames_total <= frame + 90
    assert [one.action for one in gone_on.frames(0, frame)] == [one.action for one in replay.frames(0, frame)]
    assert [one.action for one in gone_on.frames(frame)] == actions[: gone_on.frames_total - frame]


@needs_core
def test_frames_of_a_replay_are_taken_back(tmp_path: Path) -> None:
    replay = Replay.load(REPLAYS / "seaquest.a26r")
    one = {"replay": packed(replay.path.read_bytes()), "goOn": {"frame": 700, "back": 650, "actions": [3] * 70}}
    (found,) = played("seaquest", one)
    assert found["goneOn"]["from"] == sums_at(replay, 50)
    gone_on = verified(tmp_path, unpacked(found["goneOn"]["replay"]))
    assert gone_on.frames_total == 120
    assert [one.action for one in gone_on.frames(0, 50)] == [one.action for one in replay.frames(0, 50)]


@needs_core
def test_a_difference_is_found() -> None:
    data = bytearray((REPLAYS / "pong.a26r").read_bytes())
    replay = Replay.load(REPLAYS / "pong.a26r")
    chunk = replay._content.plays[1]
    wrong = bytes(hash ^ (1 if place == 17 else 0) for place, hash in enumerate(chunk.short_hashes))
    payload = chunk._replace(short_hashes=wrong).pack()
    start = chunk.offset + 11
    data[start : start + len(payload)] = payload
    data[chunk.offset : start] = file_format._chunk(b"P", payload)[:11]
    (found,) = played("pong", {"replay": packed(bytes(data))})
    assert found["difference"] == {"frame": chunk.first + 17, "what": "RAM"}


@needs_core
def test_writes_and_restored_states(tmp_path: Path) -> None:
    env = RecordReplay(atari.make("breakout", interventions=None), tmp_path / "a.a26r")
    env.reset(seed=5)
    Poke(env, {"ball_x": 40}, frame=200)
    with Freeze(env, lives=5):
        for i in range(120):
            env.step(i % 4)
    saved = env.unwrapped.core.snapshot()
    other = atari.make("breakout")
    other.reset(seed=7)
    for i in range(50):
        env.step(i % 4)
        other.step(i % 3)
    env.unwrapped.core.restore(saved)
    for i in range(50):
        env.step(1 + i % 3)
    env.unwrapped.core.restore(other.unwrapped.core.snapshot())
    for i in range(150):
        env.step(i % 4)
    env.close()
    replay = Replay.load(tmp_path / "a.a26r")
    one = {"replay": packed((tmp_path / "a.a26r").read_bytes()), "at": [900, 100, 470, 481, 700]}
    one["goOn"] = {"frame": 1000, "actions": [1, 2, 3] * 30}
    (found,) = played("breakout", one)
    assert (found["frames"], found["difference"]) == (replay.frames_total, None)
    assert found["at"] == [sums_at(replay, place) for place in one["at"]]
    assert verified(tmp_path, unpacked(found["goneOn"]["replay"])).frames_total == 1090


@needs_core
@pytest.mark.parametrize("name", ["pong", "breakout", "montezuma_revenge"])
def test_a_recording_of_the_page(name: str, tmp_path: Path) -> None:
    """With writes, another mode, snapshots, and play that is taken back."""
    game = atari.games[name]
    rng = random.Random(name)
    actions = [["act", int(rng.choice(game.minimal_actions)), 0, rng.choice([1, 1, 0.5])] for _ in range(300)]
    kept = [call for action in actions[:100] for call in (["remember"], action)]
    calls = [
        ["record", "0.0.1"],
        ["reset"],
        *kept,
        *[["goBack"]] * 40,
        *actions[100:150],
        ["poke", 40, 3],
        ["addWrite", '{"to": 12, "value": 7, "when": "held"}', True],
        *actions[150:200],
        ["snapshot"],
        ["remember"],
        ["removeWrite", 0],
        ["mode", game.modes[-1]],
        ["reset"],
        ["replay"],
        *actions[200:250],
        ["goBack"],
        *actions[250:],
        ["replay"],
    ]
    options = {"seed": 11, "difficulty": game.difficulties[-1]}
    seen = node("play_calls.mjs", core=core_text(game), image=image(name), options=options, calls=calls)
    early = verified(tmp_path, unpacked(seen[calls.index(["replay"])]))
    assert [one.end for one in early.episodes] == ["open", "open"]
    assert early.frames_total == 160
    replay = verified(tmp_path, unpacked(seen[-1]))
    assert replay.frames_total == 210
    assert [one.end for one in replay.episodes] == ["open"]
    assert sums_at(replay, 210) == seen[-2][:3]


@needs_core
def test_a_recording_that_begins_with_a_state(tmp_path: Path) -> None:
    core = atari.cores.NativeCore("seaquest", seed=3, sound=True)
    core.reset()
    for i in range(500):
        core.act(i % 18)
    calls = [["restore", packed(core.snapshot())], ["record", "0.0.1"], *([["act", 4]] * 100), ["replay"]]
    game = atari.games["seaquest"]
    seen = node("play_calls.mjs", core=core_text(game), image=image("seaquest"), options={"sound": True}, calls=calls)
    assert verified(tmp_path, unpacked(seen[-1])).frames_total == 100


@needs_core
def test_two_players(tmp_path: Path) -> None:
    core = RecordReplay(MultiplayerCore("pong", seed=9), tmp_path / "a.a26r")
    core.reset()
    rng = random.Random(2)
    for _ in range(700):
        core.act_players([rng.randrange(18), rng.randrange(18)])
    core.close()
    one = {"replay": packed((tmp_path / "a.a26r").read_bytes()), "goOn": {"frame": 600, "actions": [2, 3] * 20}}
    (found,) = played("pong", one, players=2)
    assert (found["frames"], found["difference"]) == (700, None)
    assert verified(tmp_path, unpacked(found["goneOn"]["replay"])).frames_total == 640


@needs_core
def test_two_players_of_the_page(tmp_path: Path) -> None:
    two = entry(atari.games["pong"])["two_players"]
    options = {"mode": two["default_mode"], "seed": 5, "repeat_action_probability": [0.25, 0]}
    core = MultiplayerCore("pong", seed=5, repeat_action_probability=(0.25, 0.0), sound=True)
    core.reset()
    for i in range(90):
        core.act_players([i % 18, (i * 7) % 18])
    calls = [["record", "0.0.1"], ["reset"], *[["act", i % 18, (i * 7) % 18] for i in range(90)]]
    calls += [["snapshot"], ["replay"], ["restore", packed(core.snapshot())]]
    *_, saved, recorded, restored = node(
        "play_calls.mjs", core=two["core"], image=image("pong"), options=options, calls=calls
    )
    assert verified(tmp_path, unpacked(recorded)).players == 2
    before = core.save()
    core.act_players([1, 1])
    core.restore(unpacked(saved))
    assert core.save() == before
    assert restored[0] == zlib.crc32(core.ram().tobytes())


@needs_core
def test_a_recording_with_interventions(tmp_path: Path) -> None:
    game = atari.games["breakout"]
    names = list(load(game))[:2]
    calls = [["record", "0.0.1"], ["reset"], *[["act", 1 + i % 3] for i in range(150)], ["snapshot"], ["replay"]]
    *_, saved, recorded = node(
        "play_calls.mjs",
        core=core_text(game),
        image=image("breakout"),
        options={"seed": 2, "sound": True, "interventions": names},
        calls=calls,
    )
    replay = verified(tmp_path, unpacked(recorded))
    assert [one.name for one in replay.task.interventions] == names
    core = atari.cores.NativeCore("breakout", sound=True, interventions=replay.task.interventions)
    core.restore(unpacked(saved))
    assert core.save() == replay.seek(150, sound=True).save()
    (found,) = played("breakout", {"replay": recorded})  # the header has the definitions
    assert found["difference"] is None


@needs_core
def test_replays_that_are_refused(tmp_path: Path) -> None:
    pong = (REPLAYS / "pong.a26r").read_bytes()
    for data, message in [
        (b"", "no replay"),
        (pong[:40], "ends within its header"),
        (pong[:100] + b"x" + pong[101:], "damaged at offset 8: a chunk does not match its checksum"),
        ((REPLAYS / "breakout.a26r").read_bytes(), "of breakout, not of pong"),
    ]:
        (found,) = played("pong", {"replay": packed(data)})
        assert message in found["error"]
