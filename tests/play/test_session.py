"""`Session`: the replay, saved states, rewind points and videos."""

import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from atari import AtariEnv
from atari.cli import main
from atari.cores import snapshot
from atari.games.actions import Action
from atari.play.base import FRAMES_PER_REWIND_POINT
from atari.play.multiplayer_session import MultiplayerSession
from atari.play.session import Session
from atari.recording import Replay, VideoWriter, video_facts
from atari.recording.episodes import facts_of_replays
from atari.task import Task


def make(folder: Path, name: str = "a.a26r", game: str = "breakout", **options: Any) -> Session:
    return Session(game, replay=folder / name, state=folder / "s" / "a.state", videos=folder / "v", **options)


def play(session: Session, frames: int, *actions: Action) -> None:
    for frame in range(frames):
        session.play((actions or (Action.FIRE, Action.LEFT))[frame // 30 % len(actions or "ab")])


def closed(session: Session, folder: Path) -> Replay:
    """The replay of a session, which ends."""
    session.close()
    return Replay.load(folder / "a.a26r")


def test_it_plays_each_frame_and_writes_a_replay(tmp_path: Path) -> None:
    session = make(tmp_path, seed=1, mode=4, difficulty=1)
    play(session, 150)
    screen = session.screen
    replay = closed(session, tmp_path)
    assert replay.frames_total == session.frames == 150
    played = {"frameskip": 1, "repeat_action_probability": 0.0, "mode": 4}
    assert {name: replay.options[name] for name in played} == played
    frames = list(replay.frames(core="ale"))
    assert [frame.action for frame in frames[:60:30]] == [Action.FIRE, Action.LEFT]
    assert np.array_equal(frames[-1].screen, screen)
    assert replay.verify("ale")


def test_rewinding_and_playing_on(tmp_path: Path) -> None:
    session = make(tmp_path, seed=1)
    screens = []
    for _ in range(100):
        play(session, 1)
        screens.append(session.screen)
    assert session.rewind()
    assert np.array_equal(session.screen, screens[4 * FRAMES_PER_REWIND_POINT - 1])
    assert session.rewind()
    assert np.array_equal(session.screen, screens[3 * FRAMES_PER_REWIND_POINT - 1])
    play(session, 30, Action.RIGHT)
    for _ in range(10):
        session.rewind()
    assert not session.rewind()
    play(session, 30, Action.RIGHT)
    replay = closed(session, tmp_path)
    assert replay.frames_total == 160
    assert replay.verify("ale")


def test_the_score_is_rewound_too(tmp_path: Path) -> None:
    session = make(tmp_path, game="ms_pacman", seed=1)
    play(session, 400, Action.UP)
    assert session.score > 0
    assert session.best == session.score
    while session.rewind():
        pass
    assert (session.score, session.best) == (0, 0)
    session.new_game()
    assert session.score == 0
    session.close()


def test_the_best_score_may_be_below_zero(tmp_path: Path) -> None:
    session = make(tmp_path, game="pong", seed=0)
    session.new_game()  # without a frame it is no game
    play(session, 400, Action.NOOP)
    lost = session.score
    assert session.best == lost < 0
    session.new_game()
    assert (session.score, session.best) == (0, lost)
    play(session, 1, Action.NOOP)
    assert session.best == 0
    session.close()


def test_a_state_is_saved_for_this_game_and_the_next(tmp_path: Path) -> None:
    session = make(tmp_path, game="ms_pacman", seed=1)
    play(session, 400, Action.UP)
    assert session.score > 0
    saved, score = session.screen, session.score
    assert session.save() == tmp_path / "s" / "a.state"
    play(session, 50)
    session.load()
    assert (np.array_equal(session.screen, saved), session.score) == (True, score)
    play(session, 20)
    assert closed(session, tmp_path).verify("ale")
    another = make(tmp_path, "b.a26r", game="ms_pacman")
    another.load()
    assert (np.array_equal(another.screen, saved), another.score) == (True, score)
    play(another, 20)
    another.close()
    assert Replay.load(tmp_path / "b.a26r").verify("native")


def test_states_of_something_else_are_refused(tmp_path: Path) -> None:
    session = make(tmp_path)
    with pytest.raises(FileNotFoundError):
        session.load()
    session.save()
    session.close()
    other = Session("pong", state=tmp_path / "s" / "a.state")
    before = other.screen
    with pytest.raises(ValueError, match="game = 'breakout', but this environment has 'pong'"):
        other.load()
    (tmp_path / "s" / "a.state").write_bytes(b"nonsense")
    with pytest.raises(ValueError, match="are not a snapshot"):
        other.load()
    facts, blobs = snapshot.unpack((other.save()).read_bytes())
    for forged in ({}, {"score": "many"}, {"score": None}, {"score": 10**30 + 0.5}):
        (tmp_path / "s" / "a.state").write_bytes(snapshot.pack({"of": "play", **forged}, blobs))
        with pytest.raises(ValueError, match="score is no whole number"):
            other.load()
    (tmp_path / "s" / "a.state").write_bytes(snapshot.pack(facts, {}))
    with pytest.raises(ValueError, match="the snapshot has no 'env'"):
        other.load()
    assert np.array_equal(other.screen, before)
    other.close()


def test_the_end_of_a_game(tmp_path: Path) -> None:
    session = make(tmp_path, seed=0)
    play(session, 3000, Action.FIRE)
    assert session.over
    frames = session.frames
    play(session, 5)
    assert session.frames == frames
    session.new_game()
    assert not session.over
    play(session, 5)
    assert [episode.end for episode in closed(session, tmp_path).episodes] == ["game over", "open"]


def test_videos(tmp_path: Path) -> None:
    session = make(tmp_path, scale=1)
    for number in (1, 2):
        assert session.toggle_video() == tmp_path / "v" / f"breakout-{number}.mp4"
        assert session.recording
        play(session, 12 * number)
        if number == 1:
            assert session.toggle_video() is None
            assert not session.recording
            play(session, 7)
    session.close()
    assert session.files == [tmp_path / "v" / "breakout-1.mp4", tmp_path / "v" / "breakout-2.mp4"]
    for number, path in enumerate(session.files, 1):
        with av.open(str(path)) as container:
            assert container.streams.video[0].frames == 12 * number
            assert len(container.streams.audio) == 1


def test_a_video_that_cannot_be_written_ends_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    session = make(tmp_path)
    session.toggle_video()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(VideoWriter, "write", fail)
    with pytest.raises(OSError, match="No space left"):
        play(session, 1)
    assert not session.recording
    play(session, 5)
    assert closed(session, tmp_path).frames_total == 6


def test_without_a_replay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    session = Session("pong")
    play(session, 30)
    session.close()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"obs_type": "ram", "sound_obs": True},
        {"max_num_frames_per_episode": 900, "core": "plain"},
        {"frameskip": (2, 5)},
    ],
)
def test_an_environment_continues_from_a_saved_state(tmp_path: Path, options: dict[str, Any]) -> None:
    session = make(tmp_path, seed=1)
    play(session, 150)
    state = session.save().read_bytes()
    env = AtariEnv("breakout", **options)
    env.restore(state)
    assert np.array_equal(env.core.screen_rgb(), session.screen)
    session.play(Action.LEFT)
    env.driver.play_frames(Action.LEFT, frames=1)
    assert env.core.frame_number == session._atari.core.frame_number
    session.close()
    _, _, _, _, info = env.step(0)
    assert info["lives"] == 5
    assert env.snapshot() != state


def test_a_limit_of_the_environment_holds_after_a_saved_state(tmp_path: Path) -> None:
    session = make(tmp_path, seed=1)
    play(session, 150)
    env = AtariEnv("breakout", frameskip=1, max_num_frames_per_episode=200)
    env.restore(session.save().read_bytes())
    session.close()
    steps = 1
    while not env.step(0)[3]:
        steps += 1
    assert 150 + steps <= 200 == env.core.episode_frame_number


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"game": "pong"}, "taken with game = 'breakout', but this environment has 'pong'"),
        ({"mode": 4}, "taken with mode = None, but this environment has 4"),
        ({"core": "ale"}, "taken with core = 'native', but this environment has 'ale'"),
    ],
)
def test_a_saved_state_of_another_game_is_refused(tmp_path: Path, options: dict[str, Any], text: str) -> None:
    session = make(tmp_path, seed=1)
    state = session.save().read_bytes()
    session.close()
    env = AtariEnv(**{"game": "breakout", **options})
    env.reset(seed=0)
    before = env.snapshot()
    with pytest.raises(ValueError, match=text):
        env.restore(state)
    for blobs in ({}, {"env": b"x"}, {"env": snapshot.pack({"of": "AtariEnv"}, {"core": b"x"})}):
        with pytest.raises(ValueError, match="snapshot"):
            env.restore(snapshot.pack({"of": "play", "score": 0}, blobs))
    assert env.snapshot() == before


def test_a_step_is_held_and_shown_frame_by_frame(tmp_path: Path) -> None:
    session = make(tmp_path, game="breakout", seed=1, frameskip=4, noops=(5, 5))
    screens = []
    for frame in range(5 + 40):
        session.play(Action.FIRE if frame % 4 == 1 else Action.LEFT)  # FIRE is pressed in the first frame of each step
        screens.append(session.screen)
    replay = closed(session, tmp_path)
    frames = list(replay.frames())
    assert (len(frames), session.frames) == (45, 45)
    assert [frame.action for frame in frames] == [Action.NOOP] * 5 + [Action.FIRE] * 40
    assert [frame.ends_step for frame in frames[5:]] == [False, False, False, True] * 10
    for frame, screen in zip(frames, screens, strict=True):
        assert np.array_equal(frame.screen, screen)
    assert (replay.task.frameskip, replay.task.noops) == (4, (5, 5))
    assert replay.verify("ale")


@pytest.mark.parametrize("preset", ["baselines", "dqn2015", "envpool", "ale_vector"])
def test_a_game_goes_on_after_a_lost_life(preset: str, tmp_path: Path) -> None:
    session = make(tmp_path, seed=1, preset=preset, episodic_life=True)
    lives = set()
    while not session.over:
        session.play(Action.FIRE)
        lives.add(session._atari.core.lives)
        assert session.frames < 6000
    goes_on = preset != "ale_vector"  # whose resets begin a new game
    assert (len(lives), session._atari.core.game_over) == ((6, True) if goes_on else (2, False))
    session.new_game()
    session.play(Action.NOOP)
    assert not session.over
    assert session._atari.core.lives == 5
    assert closed(session, tmp_path).verify()


def test_states_and_rewinding_within_a_skip(tmp_path: Path) -> None:
    session = make(tmp_path, game="ms_pacman", seed=1, preset="dqn2015")
    play(session, 302, Action.UP)
    session.save()  # the step is shown to its end at once
    score, ram = session.score, session._atari.core.ram()
    play(session, 61, Action.LEFT)
    session.load()
    assert (session.score, session._atari.core.ram().tolist()) == (score, ram.tolist())
    play(session, 61, Action.LEFT)
    assert session.rewind()
    play(session, 30, Action.LEFT)
    replay = closed(session, tmp_path)
    assert replay.verify()
    assert replay.episodes[0].score >= score > 0


def test_a_session_of_a_task_or_an_id() -> None:
    assert Session("Pong-ram-v4").task == Task.of("Pong-v4")
    assert Session(Task.of("pong", preset="dqn2015")).task.stack_num is None
    for options, error, text in (
        ({"stack_num": 4}, TypeError, "Session has no option 'stack_num': it shows the screen"),
        ({"continuous": True}, ValueError, "one person plays with a stick, got continuous=True; leave it out"),
        ({"frame_skip": 4}, TypeError, "frameskip"),
    ):
        with pytest.raises(error, match=text):
            Session("pong", **options)


def test_several_players_or_policies_make_a_session_of_players() -> None:
    for game, options in (
        ("combat", {"players": 2}),
        ("combat", {"players": None}),
        ("pong", {"policies": {1: "random"}}),
        (Task.of("pong", players=2), {}),
    ):
        session = Session(game, **options)
        assert isinstance(session, MultiplayerSession)
        assert len(session.scores) == 2
        session.close()
    assert len(Session("pong", players=1).scores) == 1
    with pytest.raises(ValueError, match="'pong_v3' is a game of 2 players; give players=2"):
        Session("pong_v3")


def test_a_video_says_what_was_played(tmp_path: Path) -> None:
    session = make(tmp_path, game="pong", seed=1, frameskip=2)
    path = session.toggle_video()
    assert path is not None
    play(session, 4)
    session.close()
    assert video_facts(path)["task"]["frameskip"] == 2


@pytest.mark.parametrize(
    ("actions", "error", "text"),
    [
        (("FIRE",), ValueError, "an action is one of Action.NOOP, Action.FIRE, .* got 'FIRE'"),
        ((99,), ValueError, "got 99"),
        ((), TypeError, "an action of each of 1 human players, got 0"),
    ],
)
def test_what_is_no_action(actions: Any, error: type[Exception], text: str, tmp_path: Path) -> None:
    session = make(tmp_path)
    with pytest.raises(error, match=text):
        session.play(*actions)
    assert session.frames == 0
    session.close()


def test_interventions_are_switched_and_stay_so_after_going_back(tmp_path: Path) -> None:
    options = {"state": tmp_path / "a.state", "replay": tmp_path / "a.a26r", "seed": 0, "interventions": ["wind"]}
    session = Session("breakout", **options)
    assert "wind" not in session.interventions
    with pytest.raises(ValueError, match="intervention must be one of 'bricks_return'"):
        session.toggle_intervention("wind")
    assert not any(session.interventions.values())
    session.save()
    session.toggle_intervention("one_row")
    for _ in range(40):
        session.play(Action.FIRE)
    session.load()
    session.play(Action.NOOP)
    assert session.interventions["one_row"]
    assert session._atari.core.ram()[1] == 0  # bricks of another row
    session.toggle_intervention("one_row")
    session.load()
    for _ in range(40):
        session.play(Action.RIGHT)
    assert not session.interventions["one_row"]
    assert session._atari.core.ram()[1] == 63
    assert closed(session, tmp_path).verify()
    assert not Session("tetris").interventions


def test_what_was_switched_on_is_a_fact(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    session = make(tmp_path, seed=0, interventions=["wind"])
    session.toggle_intervention("one_row")
    own = session.toggle_video()
    play(session, 40)
    session.toggle_intervention("one_row")
    replay = closed(session, tmp_path)
    assert replay.switched_on == ("one_row",)
    assert own is not None
    for video in (own, replay.render(tmp_path / "a.mp4", stop=10)):
        facts = video_facts(video)
        assert facts["switched_on"] == ["one_row"]
        assert [one["name"] for one in facts["task"]["interventions"]] == ["wind"]
        assert main(["info", str(video)]) == 0
        assert "  switched on   one_row\n" in capsys.readouterr().out
    assert main(["replay", "show", str(tmp_path / "a.a26r")]) == 0
    assert "  changed   by one_row, switched on during the game\n" in capsys.readouterr().out
    assert main(["replay", "show", str(tmp_path / "a.a26r"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["switched_on"] == ["one_row"]
    assert facts_of_replays([replay])["switched_on"] == ["one_row"]


def test_an_intervention_without_room_changes_nothing() -> None:
    session = Session("breakout", interventions=["one_row"])
    session.toggle_intervention("invisible_bricks")
    before = session.interventions
    with pytest.raises(ValueError, match="at most 64 writes"):
        session.toggle_intervention("bricks_return")
    assert session.interventions == before
