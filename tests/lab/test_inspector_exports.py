"""The inspector's inspection writes and opens files: replays, saved states, interventions, labels, clips."""

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from inspector_tools import LIVES, PADDLE, Sweeper, new_inspection, play, ram_at
from numpy.testing import assert_array_equal

from atari.env import AtariEnv
from atari.games.interventions import load
from atari.games.toml_file import tomllib
from atari.lab.inspector import export
from atari.lab.inspector.inspection import Inspection
from atari.lab.inspector.sources import inspection_of_replay, inspection_of_snapshot
from atari.lab.interventions import check
from atari.recording import RecordReplay, Replay
from atari.recording.replay import replay as replay_module

HOSTILE = st.text(st.characters(exclude_categories=["Cs"]), max_size=20) | st.sampled_from(
    ['"', "\\", '"""', "\n[x]\n", "\r\n", "a.b", "# c", "\x1b[0m", "']", "{}", "=", "\x7f", "\x85", "\u2028"]
)
SHARED = new_inspection()
SHARED.freeze(LIVES)
SHARED.name(3, "mine")


@pytest.fixture
def inspection() -> Inspection:
    return new_inspection()


def test_a_replay_holds_bytes_in_no_frame_before_their_freeze(inspection: Inspection, tmp_path: Path) -> None:
    play(inspection, 60)
    inspection.freeze(PADDLE, 60)
    play(inspection, 20)
    path = export.write_replay(inspection, tmp_path / "a.a26r")
    seen = [int(ram_at(inspection, frame)[PADDLE]) for frame in range(1, 81)]
    assert len(set(seen[:60])) > 1
    assert seen[60:] == [60] * 20
    replay = Replay.load(path)
    assert [int(replay.seek(frame).ram()[PADDLE]) for frame in range(1, 81)] == seen


def test_names(inspection: Inspection) -> None:
    inspection.name(70, "speed")
    for name, text in (("lives", "the name of byte 57"), ("a b", "letters, digits"), ("é", "letters")):
        with pytest.raises(ValueError, match=text):
            inspection.name(71, name)
    table = tomllib.loads(export.labels_toml(inspection))
    assert table["ram"]["speed"]["index"] == 70
    inspection.name(70, "")
    with pytest.raises(ValueError, match="no byte was named"):
        export.labels_toml(inspection)


def test_replay_of_what_was_played(inspection: Inspection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replay_module, "_CHUNKS_PER_CHECKPOINT", 1)
    with pytest.raises(ValueError, match="no frame was played"):
        export.write_replay(inspection, tmp_path / "a.a26r")
    play(inspection, 100)
    inspection.freeze(LIVES, 1)
    play(inspection, 200)
    inspection.freeze(PADDLE, 90)
    inspection.new_game()
    inspection.step(40)
    inspection.release(LIVES)
    inspection.release(PADDLE)
    inspection.poke(PADDLE, 90)
    play(inspection, 50)
    path = export.write_replay(inspection, tmp_path / "a.a26r")
    replay = Replay.load(path)
    assert replay.verify()
    again = inspection_of_replay(path)
    assert (again.at, again.main.end) == (0, inspection.main.end)
    for frame in (391, 0, 99, 101, 300, 302, 341, 342, 320):
        again.seek(frame)
        inspection.seek(frame)
        assert_array_equal(again.ram(), inspection.ram())
        assert (again.main.score, again.over) == (inspection.main.score, inspection.over)
        if frame:
            number = frame - (frame > 300)  # in a replay, a reset is no frame
            assert_array_equal(replay.seek(number).ram(), inspection.ram())
    again.release(LIVES)
    again.step(100)
    assert again.ram()[PADDLE] != 90


def test_a_replay_with_sticky_actions_seeds_and_rewinding(tmp_path: Path) -> None:
    env = AtariEnv("pong")
    recording = RecordReplay(env, tmp_path / "pong.a26r")
    recording.reset(seed=3)
    rams = []
    for step in range(60):
        recording.step(step % 6)
        if step == 20:
            saved = env.snapshot()
        if step == 40:
            env.restore(saved)
        rams.append(env.core.ram())
    recording.close()
    inspection = inspection_of_replay(tmp_path / "pong.a26r")
    assert inspection.main.end == 241
    inspection.seek(241)
    assert_array_equal(inspection.ram(), rams[-1])
    inspection.seek(1 + 4 * 21)
    assert_array_equal(inspection.ram(), rams[20])


def test_saved_states(tmp_path: Path) -> None:
    env = AtariEnv("pong", difficulty=1, interventions=["lazy_enemy"])
    env.reset(seed=1)
    for _ in range(20):
        env.step(1)
    plain = AtariEnv("seaquest")
    plain.reset(seed=1)
    path = tmp_path / "a.state"
    for data, saved in ((env.snapshot(), env), (plain.snapshot(), plain), (plain.core.snapshot(), plain)):
        path.write_bytes(data)
        inspection = inspection_of_snapshot(path)
        assert_array_equal(inspection.ram(), saved.core.ram())
        assert (inspection.game, inspection.env.task.interventions) == (saved.game, saved.task.interventions)
    path.write_bytes(b"x" * 40)
    with pytest.raises(ValueError, match=r"a\.state cannot be opened as a saved state"):
        inspection_of_snapshot(path)


def test_interventions_are_toml(inspection: Inspection) -> None:
    with pytest.raises(ValueError, match="nothing is frozen"):
        export.interventions_toml(inspection)
    inspection.freeze(LIVES)
    play(inspection, 30)
    inspection.poke(PADDLE, 80)
    table = tomllib.loads(export.interventions_toml(inspection))
    assert table["frozen_lives"]["writes"] == [{"to": LIVES, "value": 5, "when": when} for when in ("reset", "frame")]
    assert table["poke_1_player_x"]["writes"] == [{"to": PADDLE, "value": 80, "when": 30}]


@settings(max_examples=60, deadline=None)
@given(title=HOSTILE, name=HOSTILE)
def test_names_of_a_hostile_game_stay_names(title: str, name: str) -> None:
    inspection = SHARED
    inspection.game = replace(inspection.game, id=title, title=title)
    inspection.readings.names[LIVES] = [name]
    tables = tomllib.loads(export.interventions_toml(inspection))
    assert list(tables) == [f"frozen_{name}"]
    assert tables[f"frozen_{name}"]["description"] == f"{name} (byte {LIVES}) is held at 5."
    assert list(tomllib.loads(export.labels_toml(inspection))["ram"]) == ["mine"]


def test_an_environment_plays_the_exported_interventions(inspection: Inspection, tmp_path: Path) -> None:
    inspection.freeze(LIVES, 3)
    play(inspection, 30)
    inspection.poke(PADDLE, 80)
    inspection.name(PADDLE + 1, "mine")
    inspection.freeze(PADDLE + 1, 9)
    play(inspection, 60)
    path = tmp_path / "own.toml"
    path.write_text(export.interventions_toml(inspection))
    known = load("breakout", path)
    assert sorted(known) == ["frozen_lives", "frozen_mine", "poke_1_player_x"]
    passed = {name: bool(check("breakout", one)) for name, one in known.items() if one.check}
    assert passed == {"frozen_lives": True, "frozen_mine": False}  # the game does not use the byte of "mine"
    names = ("frozen_lives", "poke_1_player_x")
    items = [f"{path}#{name}" for name in names]
    options = {"frameskip": 1, "repeat_action_probability": 0.0, "full_action_space": True}
    env = AtariEnv("breakout", interventions=items, **options)
    env.reset(seed=0)
    agent = Sweeper()
    agent.begin(env.core)
    for frame in range(1, 31):
        env.step(agent.act(env.core))
        if frame < 30:
            assert_array_equal(env.core.ram(), ram_at(inspection, frame))
    assert (env.core.ram()[LIVES], env.core.ram()[PADDLE]) == (3, 80)


def test_interventions_that_are_switched_on_are_exported(tmp_path: Path) -> None:
    inspection = new_inspection("pong")
    inspection.step(60)
    inspection.intervene("slow_enemy")
    inspection.freeze(14, 3)
    inspection.step(60)
    inspection.intervene("slow_enemy", on=False)
    inspection.intervene("lazy_enemy")
    inspection.step(60)
    path = export.write_replay(inspection, tmp_path / "a.a26r")
    assert Replay.load(path).verify()
    again = inspection_of_replay(path)
    for frame in (180, 61, 121, 10, 150):
        again.seek(frame)
        assert_array_equal(again.ram(), ram_at(inspection, frame))
    own = tmp_path / "own.toml"
    own.write_text(export.interventions_toml(inspection))
    assert {*load("pong", own)} == {"lazy_enemy", "frozen_score_player"}
    assert load("pong", own)["lazy_enemy"] == load("pong")["lazy_enemy"]


def test_a_clip(inspection: Inspection, tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    play(inspection, 120)
    with pytest.raises(ValueError, match=r"a clip is within frames 0\.\.120"):
        export.write_clip(inspection, tmp_path / "a.mp4", 100, 130)
    export.write_clip(inspection, tmp_path / "a.mp4", 60, 120)
    with av.open(str(tmp_path / "a.mp4")) as container:
        assert sum(1 for _ in container.decode(video=0)) == 60
