"""Several players: sessions without a window, shared controls, the window, and the command line."""

import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pygame
import pytest
from cli_tools import Capture, refused

from atari.cli import main
from atari.games.actions import PLAYER_ACTIONS, Action
from atari.multiplayer import MultiplayerCore
from atari.play.base import FRAMES_PER_REWIND_POINT
from atari.play.controls import HELP, HELP_SEVERAL, LEFT_KEYS, RIGHT_KEYS, Command, SharedControls
from atari.play.loop import Loop
from atari.play.multiplayer_session import MultiplayerSession
from atari.play.outputs import GameWindow
from atari.recording import Replay
from atari.task import Task

POLICY = """
import numpy as np

seen = []

def up(observations, lanes):
    seen.append((observations.shape, int(lanes[0])))
    return np.array([1])

def wrong(observations):
    return [18]

def fails(observations):
    raise ValueError("no idea")
"""

event = pygame.event.Event

pytestmark = pytest.mark.usefixtures("display")


@pytest.fixture(autouse=True)
def policies(display: None) -> None:
    Path("policies_of_two.py").write_text(POLICY)


def test_a_session_is_the_core_with_each_players_actions() -> None:
    session = MultiplayerSession("combat", seed=5)
    core = MultiplayerCore("combat", seed=5)
    core.reset()
    random = np.random.default_rng(0)
    scores = np.zeros(2, int)
    for _ in range(600):
        actions = [PLAYER_ACTIONS[i] for i in random.integers(18, size=2)]
        session.play(*actions)
        scores += core.act_players([int(action) for action in actions])
    assert np.array_equal(session.screen, core.screen_rgb())
    assert np.array_equal(session.core.ram(), core.ram())
    assert session.scores == scores.tolist()
    assert session.frames == 600
    assert session.samples.shape == (512,)


def test_a_policy_plays_player_2() -> None:
    calls: list[Any] = []
    begun: list[Any] = []

    class Policy:
        task = Task.of("pong", players=2, actions="full", frameskip=1, obs_type="ram")

        def begin(self, *facts: Any) -> None:
            begun.append(facts)

        def __call__(self, observations: Any, lanes: Any) -> Any:
            calls.append((observations, lanes))
            return [int(Action.RIGHTFIRE)]

    session = MultiplayerSession("pong", seed=1, policies={1: Policy})
    core = MultiplayerCore("pong", seed=1)
    core.reset()
    assert session.humans == (0,)
    for _ in range(700):
        session.play(Action.LEFT)
        core.act_players([int(Action.LEFT), int(Action.RIGHTFIRE)])
    assert np.array_equal(session.core.ram(), core.ram())
    assert session.scores != [0, 0]
    assert len(calls) == 700
    observations, lanes = calls[-1]
    assert (observations.shape, observations.dtype, lanes.tolist()) == ((1, 128), np.uint8, [1])
    session.new_game()
    session.play(Action.LEFT)
    ((game, actions, lanes, first), (_, _, _, second)) = begun
    assert (game, actions, lanes.tolist()) == ("pong", tuple(action.name for action in PLAYER_ACTIONS), [1])
    assert first != second


def test_a_policy_says_what_it_observes() -> None:
    shapes: dict[int, Any] = {}

    class Sees:
        def __init__(self, **attributes: Any) -> None:
            vars(self).update(attributes)

        def __call__(self, observations: Any, lanes: Any) -> Any:
            shapes[int(lanes[0])] = observations.shape
            return [0]

    policies = {
        0: Sees(task=Task.of("pong", players=4, obs_type="grayscale")),
        1: Sees(environment={"preset": "baselines"}),
        2: Sees(task=Task.of("Pong-ram-v4")),
        3: Sees(),
    }
    MultiplayerSession("pong", players=4, policies=policies, obs_type="rgb").play()
    assert shapes == {0: (1, 210, 160), 1: (1, 4, 84, 84), 2: (1, 128), 3: (1, 210, 160, 3)}
    combat = Sees(environment={"obs_type": "ram"})
    MultiplayerSession("combat", policies={0: combat, 1: combat}).play()
    assert (shapes[0], shapes[1]) == ((1, 128), (1, 128))


@pytest.mark.parametrize(
    ("attributes", "text"),
    [
        ({"environment": {"obs_type": "colours"}}, "obs_type must be one of"),
        ({"task": Task.of("pong", players=4)}, "has players=4, and the game is played by 2"),
        ({"task": Task.of("breakout")}, "mine is a policy for breakout, not for pong"),
        ({"task": Task.of("pong", continuous=True)}, "mine has continuous=True"),
    ],
)
def test_a_policy_that_is_no_player(attributes: dict[str, Any], text: str) -> None:
    policy = type("Mine", (), {"__call__": lambda self, observations: [0], "name": "mine", **attributes})
    with pytest.raises(ValueError, match=text):
        MultiplayerSession("pong", policies={1: policy})


@pytest.mark.parametrize("answer", [[18], [-1], ["JUMP"], None, [True], [1.5], [], 1])
def test_an_answer_that_is_no_action_is_named(answer: Any) -> None:
    session = MultiplayerSession("pong", policies={1: lambda observations: answer})
    with pytest.raises(RuntimeError, match=r"the policy of player 2 failed: ValueError: policy .* (must )?return"):
        session.play(Action.NOOP)
    assert session.frames == 0


def test_games_of_random_policies_differ() -> None:
    def game(session: MultiplayerSession) -> list[bytes]:
        frames = []
        for _ in range(120):
            session.play()
            frames.append(session.core.ram().tobytes())
        return frames

    one, other = (MultiplayerSession("pong", seed=1, policies={0: "random", 1: "random"}) for _ in range(2))
    first = game(one)
    assert first == game(other)
    one.new_game()
    assert first != game(one)


def test_rewind_save_load_new_game_and_video() -> None:
    session = MultiplayerSession("pong", seed=1, state=Path("a.state"), videos=Path("v"), scale=1)
    for _ in range(700):
        session.play(Action.LEFT, Action.RIGHTFIRE)
    saved, scores = session.screen, session.scores
    assert scores != [0, 0]
    session.save()
    path = session.toggle_video()
    for _ in range(2 * FRAMES_PER_REWIND_POINT):
        session.play(Action.RIGHT, Action.LEFT)
    assert session.toggle_video() is None
    session.rewind()
    assert session.rewind()
    assert np.array_equal(session.screen, saved)
    session.new_game()
    assert session.scores == [0, 0]
    session.load()
    assert (np.array_equal(session.screen, saved), session.scores) == (True, scores)
    with pytest.raises(ValueError, match="mode"):
        _load(MultiplayerSession("pong", players=4, state=Path("a.state")))
    session.close()
    with av.open(str(path)) as container:
        assert container.streams.video[0].frames == 2 * FRAMES_PER_REWIND_POINT
        assert container.streams.audio


def _load(session: MultiplayerSession) -> None:
    with pytest.raises(ValueError, match="from a game of 2 players, not of 4"):
        session.load()
    two = MultiplayerSession("pong", mode=10, state=Path("a.state"))
    before = two.core.ram()
    try:
        two.load()
    finally:
        assert np.array_equal(two.core.ram(), before)


def test_each_player_has_keys_that_do_not_clash() -> None:
    controls = SharedControls(pygame, [1, 2])
    assert controls.handle(event(pygame.KEYDOWN, key=pygame.K_w)) is None
    controls.handle(event(pygame.KEYDOWN, key=pygame.K_SPACE))
    controls.handle(event(pygame.KEYDOWN, key=pygame.K_LEFT))
    assert controls.actions(PLAYER_ACTIONS) == [Action.UPFIRE, Action.LEFT]
    controls.handle(event(pygame.KEYDOWN, key=pygame.K_RCTRL))
    controls.handle(event(pygame.KEYUP, key=pygame.K_w))
    assert controls.actions(PLAYER_ACTIONS) == [Action.FIRE, Action.LEFTFIRE]
    assert controls.handle(event(pygame.KEYDOWN, key=pygame.K_F1)) == Command.HELP
    keys = [key for layout in (LEFT_KEYS, RIGHT_KEYS) for names in layout.values() for key in names]
    commands = [command.value for command in Command]
    assert len({*keys, *commands, "f1", "backspace"}) == len(keys) + len(commands) + 2
    for key in ("left shift", "right ctrl", "right shift", "return"):
        assert key in HELP_SEVERAL


def test_gamepads_go_to_players_in_the_order_in_which_they_are_found() -> None:
    controls = SharedControls(pygame, [1, 2])
    assert [controls.add_gamepad(gamepad) for gamepad in (7, 3, 9)] == [
        "gamepad: player 1", "gamepad: player 2", "every player has a gamepad",
    ]  # fmt: skip
    controls.handle(event(pygame.JOYAXISMOTION, axis=0, value=1.0, instance_id=3))
    controls.handle(event(pygame.JOYBUTTONDOWN, button=0, instance_id=7))
    controls.handle(event(pygame.JOYBUTTONDOWN, button=0, instance_id=9))
    assert controls.actions(PLAYER_ACTIONS) == [Action.FIRE, Action.RIGHT]
    controls.handle(event(pygame.JOYDEVICEREMOVED, instance_id=3))
    assert controls.actions(PLAYER_ACTIONS) == [Action.FIRE, Action.NOOP]
    assert controls.add_gamepad(11) == "gamepad: player 2"


def test_players_without_keys_get_gamepads_first() -> None:
    controls = SharedControls(pygame, [1, 2, 3, 4])
    assert controls.note == "player 3 and 4: connect a gamepad"
    assert [controls.add_gamepad(gamepad)[-1] for gamepad in range(4)] == ["3", "4", "1", "2"]
    assert controls.note == ""


def test_a_single_human_has_all_keys_and_gamepads() -> None:
    controls = SharedControls(pygame, [1])
    assert controls.help == HELP
    for key in (pygame.K_w, pygame.K_RIGHT):
        controls.handle(event(pygame.KEYDOWN, key=key))
    assert controls.actions(PLAYER_ACTIONS) == [Action.UPRIGHT]
    assert {controls.add_gamepad(gamepad) for gamepad in (0, 1)} == {"gamepad: player 1"}


def test_the_window_plays_both_players() -> None:
    session = MultiplayerSession("combat", seed=1)
    window = GameWindow(pygame, session.game, 1)
    pygame.joystick.init()
    loop = Loop(pygame, session, window, None)
    before = session.core.ram().copy()
    for key in (pygame.K_w, pygame.K_UP, pygame.K_RCTRL, pygame.K_h):
        pygame.event.post(event(pygame.KEYDOWN, key=key))
    assert all(loop.tick() for _ in range(60))
    core = MultiplayerCore("combat", seed=1)
    core.reset()
    for _ in range(60):
        core.act_players([int(Action.UP), int(Action.UPFIRE)])
    assert np.array_equal(session.core.ram(), core.ram())
    assert not np.array_equal(before, core.ram())
    assert pygame.display.get_caption()[0] == "Combat   player 1: 0   player 2: 0"
    assert "first player        W A S D" in loop._text()
    surface = pygame.display.get_surface()
    assert surface is not None
    assert (pygame.surfarray.array3d(surface)[:, -160:] == 255).any()


@pytest.mark.parametrize(
    ("policies", "keys", "actions"),
    [
        ({}, [pygame.K_s, pygame.K_UP], (Action.LEFT, Action.RIGHT)),
        ({0: "noop"}, [pygame.K_UP], (Action.NOOP, Action.RIGHT)),
        ({1: "noop"}, [pygame.K_s], (Action.LEFT, Action.NOOP)),
    ],
)
def test_up_and_down_turn_the_paddles_of_people(
    policies: dict[int, str], keys: list[int], actions: tuple[Action, ...]
) -> None:
    session = MultiplayerSession("pong", players=2, seed=1, policies=policies, replay=Path("a.a26r"))
    loop = Loop(pygame, session, GameWindow(pygame, session.game, 1), None)
    for key in keys:
        pygame.event.post(event(pygame.KEYDOWN, key=key))
    loop.tick()
    session.close()
    assert [frame.actions for frame in Replay.load("a.a26r").frames()] == [actions]


def test_policies_alone_do_not_wait_for_a_key() -> None:
    session = MultiplayerSession("pong", seed=1, policies={0: "noop", 1: "noop"})
    loop = Loop(pygame, session, GameWindow(pygame, session.game, 1), None)
    loop.tick()
    assert session.frames == 1


def test_the_command_plays_and_prints_both_scores(end_after: Any, capsys: Capture) -> None:
    end_after(30)
    assert main(["play", "combat", "--players", "2", "--scale", "1", "--no-sound"]) == 0
    assert capsys.readouterr().out == "combat: Combat, 2 players\nCombat   player 1: 0   player 2: 0   (30 frames)\n"
    words = "pong_v3 --players 4 --opponent random --opponent policies_of_two:up --obs-type ram".split()
    assert main(["play", *words, "--json", "--scale", "1", "--no-sound", "--seed", "3"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["players"], result["mode"], len(result["scores"])) == (4, 6, 4)
    from policies_of_two import seen  # type: ignore[import-not-found]

    assert {*seen} == {((1, 128), 2)}
    assert sorted(path.name for path in Path().iterdir() if path.suffix) == ["policies_of_two.py"]


def test_the_mode_says_how_many_players_there_are(end_after: Any, capsys: Capture) -> None:
    end_after(3)
    opponents = [word for _ in range(3) for word in ("--opponent", "noop")]
    assert main(["play", "pong", "--mode", "6", *opponents, "--json", "--scale", "1", "--no-sound"]) == 0
    assert json.loads(capsys.readouterr().out)["scores"] == [0] * 4


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["breakout", "--players", "2"], "there is no game of several players named 'breakout'"),
        (["combat", "--players", "3"], "combat is for 2 players, got players=3"),
        (["pong_v3", "--players", "3"], "pong is for 2 or 4 players, got players=3"),
        (["boxing_v2", "--players", "4"], "boxing is for 2 players, got players=4"),
        (["combat"], "without single-player rules, so there is no environment of one player; players=2, or --pl"),
        (["combat", "--players", "2", "--mode", "99"], "mode of combat for 2 players must be one of 1, 2, "),
        (["combat", "--players", "2", "--difficulty", "9"], "difficulty must be within 0..3, got 9"),
        (["pong", "--players", "2", "--replay", "a.mp4"], "the name of a replay must end in"),
        (["pong", "--opponent", "policies_of_two.py"], "policies_of_two.py is no policy: give a run folder"),
        (["pong", "--opponent", "best"], "there is no file best"),
        (["pong", "--opponent", "policies_of_two:none"], "cannot be imported"),
        (["pong", "--opponent", "noop", "--opponent", "noop"], "give --opponent at most 1 times, got 2"),
        (["pong", "--opponent", "policies_of_two:wrong"], "policy wrong returned action 18; in pong it has"),
        (["pong", "--opponent", "policies_of_two:fails"], "the policy of player 2 failed: ValueError: no idea"),
    ],
)
def test_wrong_words_are_one_line(words: list[str], text: str, end_after: Any, capsys: Capture) -> None:
    end_after(3)
    refused(capsys, ["play", *words, "--scale", "1", "--no-sound"], text)


def test_a_match_of_policies_is_recorded(capsys: Capture) -> None:
    words = ["record", "combat", "--players", "2", "--seconds", "2", "-o", "match.mp4", "--scale", "1", "--json"]
    assert main([*words, "--policy", "random", "--policy", "noop"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["players"], result["policies"], result["scores"]) == (2, ["random", "noop"], [[0, 0]])
    with av.open("match.mp4") as container:
        assert container.streams.video[0].frames == result["frames"] > 90
        assert container.streams.audio


def test_replays_of_several_players_are_recorded_shown_and_rendered(capsys: Capture) -> None:
    words = "record pong --players 4 --seconds 1 -o a.a26r -o a.mkv --scale 1 --json".split()
    assert main([*words, "--seed", "3"]) == 0
    frames = json.loads(capsys.readouterr().out)["frames"]
    assert main(["replay", "verify", "a.a26r"]) == 0
    assert f"a.a26r: equal, {frames} frames" in capsys.readouterr().out
    assert main(["replay", "show", "a.a26r"]) == 0
    shown = capsys.readouterr().out
    assert "players=4" in shown
    assert "0, 0, 0, 0" in shown
    assert main(["replay", "render", "a.a26r", "-o", "b.mkv", "--scale", "1"]) == 0
    with av.open("a.mkv") as one, av.open("b.mkv") as two:
        for left, right in zip(one.decode(video=0), two.decode(video=0), strict=True):
            assert np.array_equal(left.to_ndarray(format="rgb24"), right.to_ndarray(format="rgb24"))


def test_a_game_played_by_hand_is_recorded_with_its_rewinds(tmp_path: Path) -> None:
    session = MultiplayerSession("combat", seed=1, replay=tmp_path / "a.a26r", state=tmp_path / "a.state")
    for index in range(150):
        session.play(Action(2 + index // 40), Action.UPFIRE)
    session.rewind()
    session.save()
    for _ in range(20):
        session.play(Action.DOWN, Action.DOWN)
    session.load()
    session.play(Action.DOWN, Action.NOOP)
    ram = session.core.ram()
    session.close()
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    *_, last = replay.frames()
    assert np.array_equal(last.ram, ram)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["pong", "--players", "2", "--preset", "dqn2015"], "preset 'dqn2015' is for one player"),
        (["pong", "--players", "2", "--sticky", "0.25"], "without repeat_action_probability, got 0.25; leave it out"),
        (["pong", "--players", "2", "--noops", "1,30"], "without noops, got (1, 30); leave it out"),
        (["pong_v3", "--players", "4", *["--policy", "noop"] * 2], "give --policy once, or 4 times, got 2"),
        (["pong", "--policy", "noop", "--policy", "noop"], "a second --policy needs --players"),
    ],
)
def test_matches_that_cannot_be_recorded(words: list[str], text: str, capsys: Capture) -> None:
    refused(capsys, ["record", *words], text)
